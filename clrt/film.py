"""The film of a tile: the picture and its layers as planes of sums on the device."""

from __future__ import annotations

import re
from collections.abc import Iterable
from difflib import get_close_matches
from typing import Any, Final

import numpy as np

from clrt import layout, passes
from clrt.colour import thesis_finish
from clrt.device import Device
from clrt.errors import ClrtError
from clrt.queues import Hits, Lit, Queue
from clrt.tracks import Answer
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
SPECTRAL: Final = ("bands", "xyz")  # of scenes with a spectrum: the whole picture, not yet RGB
_GENERATION = re.compile(r"generation_(\d+)")


def check_layers(layers: Iterable[str], max_depth: int, spectral: bool = False) -> tuple[str, ...]:
    """The names, each once. ClrtError names an unknown one and its nearest neighbour."""
    names = tuple(dict.fromkeys(layers))
    known = (*_BY_PATH, *_BY_TERM, *GEOMETRY, *(f"generation_{g}" for g in range(max_depth + 1)))
    known += SPECTRAL if spectral else ()
    for name in names:
        if name in SPECTRAL and not spectral:
            raise ClrtError(f"layers: {name!r} is for scenes with a spectrum; this one is in RGB")
        if name not in known:
            near = get_close_matches(name, known, n=1)
            hint = f"did you mean {near[0]!r}?" if near else "known: " + ", ".join(dict.fromkeys(known))
            raise ClrtError(f"layers: {name!r} is not a layer; {hint}")
    return names


def finished(values: np.ndarray) -> np.ndarray:
    """Linear colours (..., 3) float32 of what a response gives, which is RGB or the thesis program's own."""
    if values.shape[-1] == 3:
        return values
    return np.minimum(thesis_finish(values), layout.BRIGHTEST).astype(np.float32)


class Film:
    """Planes of (pixels, bands) sums on the device: the picture, then a plane a layer of radiance."""

    def __init__(self, device: Device, pixels: int, layers: tuple[str, ...]) -> None:
        self.device = device
        self.pixels = pixels
        self.planes = ("image", *(name for name in layers if name not in GEOMETRY + SPECTRAL))
        self.nbytes = 4 * len(self.planes) * pixels * device.bands
        self.sums: Any = device.buffer(self.nbytes, "float")
        device.fill(self.sums, self.nbytes)

    def add(self, queue: Queue, lit: Lit, generation: int) -> None:
        """Add what a queue brings to its pixels, to the picture and to every layer it belongs to."""
        for plane, name in enumerate(self.planes):
            numbered = _GENERATION.fullmatch(name)
            mask, value = _BY_PATH.get(name, (0, 0))
            if name == "image" or name in _BY_PATH or (numbered and int(numbered.group(1)) == generation):
                passes.gather(self.device, queue, lit, self.sums, plane, self.pixels, mask, value)

    def add_terms(self, world: World, queue: Queue, hits: Hits, last: bool) -> None:
        """For layers of one term of generation 0: the passes of local light again, with that term only."""
        for plane, name in enumerate(self.planes):
            if name in _BY_TERM:
                lit = passes.light(self.device, world, queue, hits, last, _BY_TERM[name])
                feelers = passes.feelers(self.device, world, queue, hits, lit)
                passes.illuminate(self.device, world, queue, hits, lit, feelers, _BY_TERM[name])
                passes.gather(self.device, queue, lit, self.sums, plane, self.pixels)

    def developing(self, samples: int, response: np.ndarray | None = None) -> Answer:
        """Turn the sums into means over the samples of each pixel, once; what `reading` gives of them."""
        values = len(self.planes) * self.pixels * self.device.bands
        self.device.launch("resolve", values, np.uint32(values), np.float32(samples), self.sums)
        return self.reading(response)

    def reading(self, response: np.ndarray | None = None, planes: int | None = None) -> Answer:
        """The first `planes` planes (None: all), float32 (planes, pixels, rows of `response`).

        `response` (rows, bands) float32 is applied on the device, so that the host sees few values a pixel
        however many bands there are; without it the rows are the bands.
        """
        planes = len(self.planes) if planes is None else planes
        source, rows, n = self.sums, self.device.bands, planes * self.pixels
        if response is not None:
            rows = len(response)
            source = self.device.buffer(4 * n * rows, "float")
            matrix = self.device.upload(response, wait=False)
            self.device.launch_packets("develop", n, self.sums, np.uint32(n), matrix, np.uint32(rows), source)
        return self.device.ask(source, np.empty((planes, self.pixels, rows), np.float32))

    def develop(self, samples: int, response: np.ndarray | None = None) -> np.ndarray:
        """As `developing`, waits, and makes colours with a response: (planes, pixels, 3 or bands)."""
        values = self.developing(samples, response).wait()
        return values if response is None else finished(values)

    def read(self, response: np.ndarray | None = None, planes: int | None = None) -> np.ndarray:
        """As `reading`, and waits."""
        return self.reading(response, planes).wait()
