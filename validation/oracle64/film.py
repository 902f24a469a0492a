"""Sums by pixel and layer, and counts of rays by generation."""

from __future__ import annotations

from dataclasses import dataclass, field, fields, replace
from typing import Any

import numpy as np

from . import hashing
from .palette import Palette
from .vectors import Array, Bools, Ints, Words

ROUTES = ("direct", "reflection", "transmission")
TERMS = ("emission", "ambient", "diffuse", "highlight")  # of generation 0
COUNTS = (
    "camera", "camera_hits", "reflection", "transmission", "total_internal_reflection", "feelers",
    "ambient", "hits",
)  # fmt: skip


@dataclass(frozen=True)
class Rays:
    """n rays of a kind. `weight`: what their light counts for in their pixel; `path`: a word of `hashing`."""

    origin: Array  # (n, 3)
    direction: Array  # (n, 3), unit
    weight: Array  # (n, bands)
    path: Words  # (n,)
    pixel: Ints  # (n,)
    media: Ints  # (n, k): lists of media
    group: Ints  # (n,): the only group of bands that a ray carries; -1: all of them
    base: Words  # (n,): what numbers are drawn from: of generation 0 the pixel's hash, deeper the ray's key
    sample: Ints  # (n,): and which stretch of these is the ray's: which sample of the pixel it is, deeper 0
    cone: Array  # (n, 2): how wide it is at the origin, and what it grows by along the ray
    kind: str = "camera"  # "reflection", "transmission", "ambient"

    def __len__(self) -> int:
        return len(self.pixel)

    def __getitem__(self, index: Ints | Bools) -> Rays:
        arrays = {f.name: getattr(self, f.name)[index] for f in fields(self) if f.name != "kind"}
        return replace(self, **arrays)


@dataclass
class Film:
    """What reaches each pixel, apart by route, by generation, by kind of ray and by term of generation 0.

    The picture itself is not summed here but returned by the recursion; the layers sum to it, before they are
    developed. A film of no pixels keeps no layers.
    """

    pixels: int
    palette: Palette
    layers: dict[str, Array] = field(default_factory=dict)
    """name, "generation 2 reflection" -> (pixels, 3); bands still to be developed (pixels, bands)"""
    generations: list[dict[str, int]] = field(default_factory=list)
    met: list[tuple[Ints, Ints]] = field(default_factory=list)  # of camera rays that hit, pixel and shape

    def note(self, pixel: Ints, shape: Ints) -> None:
        """Notes that camera rays of these pixels hit shapes of these numbers."""
        if self.pixels:
            self.met.append((pixel, shape))

    def hit(self) -> Array:
        """How many samples of each pixel hit anything, (pixels,)."""
        out = np.zeros(self.pixels)
        for pixel, _ in self.met:
            np.add.at(out, pixel, 1)
        return out

    def covered(self, shapes: int) -> Array:
        """How many of each pixel's samples hit each shape, (pixels, shapes)."""
        out = np.zeros((self.pixels, shapes))
        for at in self.met:
            np.add.at(out, at, 1)
        return out

    def add(self, rays: Rays, generation: int, light: Array, term: str = "") -> None:
        """Adds radiance (n, bands) that the rays bring; `term` names the part of the local light."""
        if not self.pixels:
            return
        light = rays.weight * light
        if self.palette.linear:  # then at once: three numbers take less room than bands
            light = self.palette.developed(light)
        for number, name in enumerate(ROUTES):
            of_route = (rays.path & np.uint32(hashing.ROUTE)) == number
            self._add(name, rays.pixel[of_route], light[of_route])
        self._add(f"generation_{generation}", rays.pixel, light)
        self._add(f"generation {generation} {rays.kind}", rays.pixel, light)
        if generation == 0 and term in TERMS:
            self._add(term, rays.pixel, light)
        gathered = (rays.path & np.uint32(hashing.GATHERED_FIRST)) != 0
        self._add("ambient", rays.pixel[gathered], light[gathered])

    def _add(self, name: str, pixel: Ints, light: Array) -> None:
        layer = self.layers.setdefault(name, np.zeros((self.pixels, light.shape[1])))
        np.add.at(layer, pixel, light)

    def developed(self, layer: Array) -> Array:
        """What `layers` holds, or a mean of it, as (n, 3)."""
        return layer if self.palette.linear else self.palette.developed(layer)

    def count(self, generation: int, name: str, number: Any) -> None:
        """Adds to a count of a generation."""
        while len(self.generations) <= generation:
            self.generations.append(dict.fromkeys(COUNTS, 0))
        self.generations[generation][name] += int(number)

    @property
    def totals(self) -> dict[str, int]:
        """The counts over all generations."""
        return {name: sum(counts[name] for counts in self.generations) for name in COUNTS}
