"""Whitted's recursion, breadth first: queues of rays by generation and kind, a picture of what each added."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np

from .world import Hits, World

Array = np.ndarray
CAMERA, REFLECTION, TRANSMISSION, AMBIENT = "camera", "reflection", "transmission", "ambient"
TERMS = ("emission", "ambient", "diffuse", "highlight")


@dataclass(frozen=True, eq=False)
class Rays:
    """A queue; `weight` is what a ray's light counts for in its pixel."""

    origin: Array  # (n, 3)
    direction: Array  # (n, 3), unit
    weight: Array  # (n, 3)
    pixel: Array  # (n,)
    path: Array  # (n,) uint32: the hash word and flags
    form: Array  # (n,) int: which of the world's forms the ray starts on, or -1
    media: Array  # (n,) int: a state of media.Media
    base: Array  # (n,) uint32: the hash that numbers are drawn from: of generation 0 the pixel's
    sample: Array  # (n,): which stretch of these is the ray's: which sample of its pixel it is
    cone: Array  # (n, 2): how wide its cone is where it starts, and by how much it grows

    def take(self, rows: Array) -> Rays:
        return Rays(*(getattr(self, name)[rows] for name in self.__dataclass_fields__))

    @staticmethod
    def joined(queues: list[Rays]) -> Rays:
        names = Rays.__dataclass_fields__
        return Rays(*(np.concatenate([getattr(queue, name) for queue in queues]) for name in names))


def drawing(rays: Rays) -> Rays:
    """Rays below generation 0, which draw numbers from their own keys."""
    return replace(rays, base=rays.path & ~np.uint32(15), sample=np.zeros(len(rays.path), np.uint32))


class Shader(Protocol):
    """What surfaces do with light."""

    world: World
    max_depth: int

    def meet(self, rays: Rays) -> tuple[Rays, Hits, Array]:
        """The rays as they arrive, what they meet, and the states of media beyond (n,)."""

    def shade(self, rays: Rays, hits: Hits, beyond: Array, kind: str, last: bool) -> Shaded:
        """The rays' own light, and the rays they spawn; the last generation gets depth_color for these."""


def trace(shader: Shader, rays: Rays, pixels: int, sums: dict[str, Array]) -> Hits:
    """Add the light along camera rays and all their descendants to `sums`, by generation and kind, (pixels,
    3).

    Of generation 0 also each of TERMS, which are parts of "generation 0 camera". Returns the camera rays'
    hits.
    """
    queues = {CAMERA: rays}
    first: Hits | None = None
    for generation in range(shader.max_depth + 1):
        spawned: dict[str, list[Rays]] = {}
        for kind, queue in queues.items():
            queue, hits, beyond = shader.meet(queue)
            first = first or hits
            shaded = shader.shade(queue, hits, beyond, kind, last=generation == shader.max_depth)
            _add(sums, f"generation {generation} {kind}", queue, shaded.light, pixels)
            if generation == 0:
                for term, light in zip(TERMS, shaded.terms, strict=True):
                    _add(sums, f"generation 0 {kind} {term}", queue, light, pixels)
            for name, child in shaded.children:
                spawned.setdefault(name, []).append(child)
        queues = {name: Rays.joined(found) for name, found in spawned.items()}
        queues = {name: queue for name, queue in queues.items() if len(queue.pixel)}
    assert first is not None
    return first


def _add(sums: dict[str, Array], name: str, rays: Rays, light: Array, pixels: int) -> None:
    total = sums.setdefault(name, np.zeros((pixels, 3)))
    for band in range(3):
        total[:, band] += np.bincount(rays.pixel, rays.weight[:, band] * light[:, band], pixels)


@dataclass(frozen=True, eq=False)
class Shaded:
    """What surfaces make of a queue of n rays."""

    light: Array  # (n, 3): the rays' own
    terms: Array  # (4, n, 3): its TERMS; the rest of it is background and depth_color
    children: list[tuple[str, Rays]]  # queues of rays, by kind
