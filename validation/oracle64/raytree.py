"""The recursion's own tree: every ray of a pixel, noted as the equation comes to it."""

from __future__ import annotations

import math
from collections import Counter
from dataclasses import dataclass, field

import numpy as np

from clrt.scene.scene import Scene

from .camera import Background
from .film import Film, Rays
from .hashing import FLAGS
from .radiance import Job, radiance
from .render import _camera_block, _shifted
from .spot import visible_hit
from .vectors import Array
from .world import World

Key = tuple[int, str, int, int]  # generation, kind, path without flags, group of bands (-1: all)


@dataclass
class Ray64:
    """A ray; `weight` (bands,) is what is left of it at its hit, `terms` what it brings, weighted, by name.

    The diffuse and the highlight light of each light are terms "diffuse 0", "highlight 0", ..., and `told`
    counts how many points of lights these are of.
    """

    key: Key
    origin: Array
    direction: Array
    weight: Array
    t: float
    shape: int
    terms: dict[str, Array] = field(default_factory=dict)
    told: Counter[str] = field(default_factory=Counter)

    @property
    def brings(self) -> Array:
        """All terms together."""
        return np.sum([*self.terms.values(), np.zeros_like(self.weight)], axis=0)


class _Notes(Film):
    """A film that notes each ray as it first brings something: what it emits, or that it met nothing."""

    def __init__(self, world: World, scene: Scene) -> None:
        super().__init__(0, world.palette)
        self.rays: list[Ray64] = []
        self._world = world
        self._last: dict[Key, Ray64] = {}
        # the recursion comes to each light in turn, and to each of its points
        self._turns = [n for n, light in enumerate(scene.lights) for _ in range(getattr(light, "samples", 1))]

    def add(self, rays: Rays, generation: int, light: Array, term: str = "") -> None:
        for row in range(len(rays)):
            path, group = int(rays.path[row]) & ~FLAGS, int(rays.group[row])
            key = (generation, rays.kind, path, group)
            if term in ("", "emission"):
                met = visible_hit(self._world, rays[np.array([row])])
                hit = int(met.primitive[0])
            begins = term == "emission" or (not term and hit < 0)  # what is brought without a term by a hit
            if begins:  # stands for the generations after the last
                shape = int(self._world.shown[self._world.shape_of[hit]]) if hit >= 0 else -1
                way = rays.origin[row], rays.direction[row], rays.weight[row]
                self._last[key] = Ray64(key, *way, float(met.t[0]), shape)
                self.rays.append(self._last[key])
            found = self._last[key]
            name = term or ("background" if begins else "beyond")
            if term in ("diffuse", "highlight"):
                name = f"{term} {self._turns[found.told[term]]}"
                found.told[term] += 1
            brought = np.asarray(rays.weight[row] * light[row], float)
            found.terms[name] = found.terms.get(name, 0.0) + brought


def tree64(
    scene: Scene, x: int, y: int, width: int, height: int, spp: int = 1, max_depth: int | None = None,
    shift: tuple[float, float] = (0.0, 0.0),
) -> list[Ray64]:  # fmt: skip
    """All rays of a pixel of the scene's picture, in the order of the recursion."""
    assert scene.camera is not None
    with np.errstate(all="ignore"):
        world = World.of(scene)
        notes = _Notes(world, scene)
        depth = scene.max_depth if max_depth is None else max_depth
        job = Job(world, scene, Background(scene, world.palette), depth, notes)
        pixel, camera = np.array([y * width + x]), _shifted(scene.camera, shift, (width, height))
        for sample in range(spp):
            rays = _camera_block(world, camera, (width, height), math.isqrt(spp), sample, pixel)
            radiance(job, rays, 0)
    return notes.rays
