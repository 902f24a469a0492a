"""The film of a tile: the picture and its layers as planes of sums on the device."""

from __future__ import annotations

import re
from collections.abc import Iterable
from difflib import get_close_matches
from typing import Any, Final

import numpy as np

from clrt import layout, passes
from clrt.device import Device
from clrt.errors import ClrtError
from clrt.queues import Feelers, Hits, Lit, Queue
from clrt.world import World

# layers of radiance: all generations, rays whose path word & mask == value
_BY_PATH: Final = {
    "direct": (layout.PATH["PATH_ROUTE"], 0),
    "reflection": (layout.PATH["PATH_ROUTE"], 1),
    "transmission": (layout.PATH["PATH_ROUTE"], 2),
    "ambient": (layout.PATH["PATH_GATHERED_FIRST"], layout.PATH["PATH_GATHERED_FIRST"]),
}
# terms of the local light of generation 0
_BY_TERM: Final = {
    name: layout.TERMS[f"TERM_{name.upper()}"] for name in ("emission", "ambient", "diffuse", "highlight")
}
GEOMETRY: Final = ("depth", "position", "normal", "shape")
_GENERATION = re.compile(r"generation_(\d+)")


def check_layers(layers: Iterable[str], max_depth: int) -> tuple[str, ...]:
    """The names, each once. ClrtError names an unknown one and its nearest neighbour."""
    names = tuple(dict.fromkeys(layers))
    known = (*_BY_PATH, *_BY_TERM, *GEOMETRY, *(f"generation_{g}" for g in range(max_depth + 1)))
    for name in names:
        if name not in known:
            near = get_close_matches(name, known, n=1)
            hint = f"did you mean {near[0]!r}?" if near else "known: " + ", ".join(dict.fromkeys(known))
            raise ClrtError(f"layers: {name!r} is not a layer; {hint}")
    return names


class Film:
    """Planes of (pixels, bands) sums on the device: the picture, then a plane a layer of radiance."""

    def __init__(self, device: Device, pixels: int, layers: tuple[str, ...]) -> None:
        self.device = device
        self.pixels = pixels
        self.planes = ("image", *(name for name in layers if name not in GEOMETRY))
        self.nbytes = 4 * len(self.planes) * pixels * device.bands
        self.sums: Any = device.buffer(self.nbytes)
        device.fill_zero(self.sums, self.nbytes)

    def add(self, queue: Queue, lit: Lit, feelers: Feelers, generation: int) -> None:
        """Add what a queue brings to its pixels, to the picture and to every layer it belongs to."""
        for plane, name in enumerate(self.planes):
            numbered = _GENERATION.fullmatch(name)
            mask, value = _BY_PATH.get(name, (0, 0))
            if name == "image" or name in _BY_PATH or (numbered and int(numbered.group(1)) == generation):
                passes.gather(self.device, queue, lit, feelers, self.sums, plane, self.pixels, mask, value)

    def add_terms(self, world: World, queue: Queue, hits: Hits, last: bool) -> None:
        """For layers of one term of generation 0: the passes of local light again, with that term only."""
        for plane, name in enumerate(self.planes):
            if name in _BY_TERM:
                lit = passes.light(self.device, world, queue, hits, last, _BY_TERM[name])
                feelers = passes.feelers(self.device, world, queue, hits, lit, _BY_TERM[name])
                passes.gather(self.device, queue, lit, feelers, self.sums, plane, self.pixels)

    def develop(self, samples: int) -> np.ndarray:
        """Means over the samples of each pixel: float32 (planes, pixels, bands)."""
        values = len(self.planes) * self.pixels * self.device.bands
        self.device.launch("resolve", values, np.uint32(values), np.float32(samples), self.sums)
        return self.device.read(
            self.sums, np.empty((len(self.planes), self.pixels, self.device.bands), np.float32)
        )
