"""The film of a tile: the picture and its layers as planes of sums on the device."""

from __future__ import annotations

import re
from collections.abc import Iterable
from typing import Any, Final

import numpy as np

from clrt import layout
from clrt.base.errors import ClrtError, show
from clrt.base.suggest import nearest
from clrt.device.device import Device
from clrt.device.tracks import Answer
from clrt.engine import passes
from clrt.engine.queues import Hits, Lit, Queue
from clrt.engine.world import World
from clrt.spectra.colorimetry import thesis_finish

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
_GENERATION = re.compile(r"generation_(0|[1-9][0-9]{0,8})")
_MOST_NAMED: Final = 64  # generations that a message lists


def check_layers(layers: Iterable[str], max_depth: int, spectral: bool = False) -> tuple[str, ...]:
    """The names, each once; "all" stands for all there are. ClrtError names an unknown one and its nearest.

    A single name, or several with commas, may be one text.
    """
    listed = [name.strip() for name in layers.split(",")] if isinstance(layers, str) else layers
    known = tuple(dict.fromkeys((*_BY_PATH, *_BY_TERM, *GEOMETRY, *(SPECTRAL if spectral else ()))))
    found: dict[str, None] = {}
    for name in listed:
        if name == "all":
            found |= dict.fromkeys((*known, *(f"generation_{g}" for g in range(max_depth + 1))))
            continue
        if name in SPECTRAL and not spectral:
            raise ClrtError(f"layers: {name!r} is for scenes with a spectrum; this one is in RGB")
        if name not in known and not _generation(name, max_depth):
            numbered = tuple(f"generation_{g}" for g in range(min(max_depth, _MOST_NAMED) + 1))
            near = nearest(name, (*known, *numbered), cutoff=0.6)
            hint = f"did you mean {near!r}?" if near else "known: all, " + ", ".join((*known, *numbered))
            raise ClrtError(f"layers: {show(name)} is not a layer; {hint}")
        found[name] = None
    return tuple(found)


def _generation(name: str, max_depth: int) -> bool:
    """Whether this is the layer of a generation that there is."""
    found = _GENERATION.fullmatch(name)
    return found is not None and int(found.group(1)) <= max_depth


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

    def decoded(self, queue: Queue) -> dict[str, np.ndarray]:
        """`sums`, (planes, bands, pixels); means once it is developed."""
        size = len(self.planes), self.pixels, self.device.bands
        sums = self.device.read(self.sums, np.empty(size, np.float32))
        return {"sums": np.ascontiguousarray(sums.transpose(0, 2, 1))}

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
