"""`Tracer.explain`: the loop on a list of one pixel, watched, and what was seen of its rays as a tree."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Final

import numpy as np

from clrt import layout
from clrt.base.errors import LimitError
from clrt.device.device import Device
from clrt.engine.apart import LitBy
from clrt.engine.job import Job
from clrt.engine.schedule import complete
from clrt.engine.watcher import Seen, Watcher
from clrt.engine.world import World
from clrt.flatten.flatten import FlatScene
from clrt.raytree.tree import Feeler, Hit, LightShare, Numbers, Ray, RayTree
from clrt.scene.scene import Scene

MOST_LIGHTS: Final = 1000  # each is looked at by itself

Words = dict[str, np.ndarray]


def explain(
    device: Device, world: World, scene: Scene, job: Job, place: tuple[int, int], size: tuple[int, int]
) -> RayTree:
    """The rays of the pixel at `place` (x, y) in a job's picture of that size, and what they bring."""
    if world.lights > MOST_LIGHTS:
        text = f"the scene has {world.lights} lights; at most {MOST_LIGHTS} can be explained"
        raise LimitError(f"explain: {text}")
    watcher = Watcher(device, world, job.max_depth)
    pixel = np.array([place[1] * size[0] + place[0]], np.uint32)
    if job.adaptive is not None:  # the pixel's last grid is what its value is made of
        counted = complete(replace(job, layers=("samples",)).trace(device, world, pixel))
        job = job.even(math.isqrt(int(counted.layers["samples"][0])))
    tile = complete(job.trace(device, world, pixel, (watcher,)))
    device.finish()
    flat, value = job.flat, tile.layers["image"][0]
    rays = rays_of(watcher.generations, flat)
    numbers = job.samples, job.max_depth, flat.bands
    return RayTree(scene, *place, *size, *numbers, flat.response, value, rays, tuple(watcher.weights))


def rays_of(generations: list[list[Seen]], flat: FlatScene) -> tuple[Ray, ...]:
    """All rays with their children, in the order in which the film adds up what they bring."""
    first: dict[tuple[int, int], int] = {}  # number of the first ray of a queue
    count = 0
    for generation, queues in enumerate(generations):
        for number, seen in enumerate(queues):
            first[generation, number] = count
            count += seen.queue.n
    found: dict[int, Ray] = {}
    children: dict[int, list[int]] = {}
    samples: dict[int, int] = {}
    parents: dict[int, int | None] = {}
    for generation, queues in enumerate(generations):
        for number, seen in enumerate(queues):
            for i in range(seen.queue.n):
                own = first[generation, number] + i
                parents[own] = None
                if generation:
                    above, ray = seen.parents[i]
                    parent = first[generation - 1, above] + ray
                    parents[own] = parent
                    children.setdefault(parent, []).append(own)
                above_all = parents[own]
                samples[own] = i if above_all is None else samples[above_all]
    for generation in reversed(range(len(generations))):
        for number, seen in enumerate(generations[generation]):
            for i in range(seen.queue.n):
                own = first[generation, number] + i
                below = tuple(found[child] for child in children.get(own, ()))
                found[own] = _ray(seen, number, i, own, samples[own], parents[own], below, flat)
    return tuple(found[number] for number in range(count))


def _ray(
    seen: Seen, queue: int, i: int, own: int, sample: int, parent: int | None, children: tuple[Ray, ...],
    flat: FlatScene,
) -> Ray:  # fmt: skip
    carried, narrow = seen.queue.device.ray_format.carried, seen.queue.narrow
    bands = slice(0, carried)
    word = int(seen.spawn[i])
    rays, hits = seen.rays, seen.hits
    hit = _hit(hits, i, flat)
    local, nothing = _numbers(seen.local[bands, i]), (0.0,) * carried
    emission, ambient = _numbers(seen.emission[bands, i]), _numbers(seen.ambient[bands, i])
    arriving = _numbers(hits.get("weight", rays["weight"])[bands, i])
    media, medium = _media(seen, i, hit, flat)
    beyond = nothing
    if hit is not None and any(flat.materials[name][hit.material] > 0 for name in ("kr", "kt")):
        rest = seen.local[bands, i].astype(float) - seen.emission[bands, i] - seen.ambient[bands, i]
        tiny = 4 * np.finfo(np.float32).eps * np.abs(seen.local[bands, i])  # the terms are rounded, too
        beyond = _numbers(np.where(rest > tiny, rest, 0.0))
    return Ray(
        own, seen.generation, queue, seen.queue.kind, sample,
        int(rays["weight"][carried].view(np.uint32)[i]) if narrow else 0, narrow,
        _numbers(rays["origin"][:, i]), _numbers(rays["direction"][:, i]),
        _numbers(rays["weight"][bands, i]), arriving, media, medium, hit,
        emission, ambient, local if hit is None else nothing, beyond,
        tuple(_light(number, lit, i, bands) for number, lit in enumerate(seen.lights)),
        _numbers(seen.brings[bands, i]) if word & layout.SPAWN["SPAWN_LOCAL"] else None,
        bool(word & layout.SPAWN["SPAWN_TOTAL_INTERNAL"]), int(rays["path"][i]), parent, children,
    )  # fmt: skip


def _hit(hits: Words, i: int, flat: FlatScene) -> Hit | None:
    primitive = int(hits["primitive"][i])
    if primitive < 0:
        return None
    code = int(hits["code"][i])
    point, normal, shading = (_numbers(hits[name][:, i]) for name in ("point", "n", "ns"))
    return Hit(
        float(hits["t"][i]), int(flat.primitives["shape"][primitive]), primitive,
        point, normal, shading,
        bool(code & layout.SURFACE["SURFACE_INSIDE"]), code // layout.SURFACE["SURFACE_MATERIAL"],
    )  # fmt: skip


def _media(seen: Seen, i: int, hit: Hit | None, flat: FlatScene) -> tuple[tuple[int, ...], int]:
    """The media that a ray starts in, and the one that it goes through to its hit, -1 for none.

    Where rays carry no lists, the side of the surface that they hit tells (docs/design.md, "Media").
    """
    if "media" in seen.rays:
        listed = [number for number in seen.rays["media"][:, i].tolist() if number >= 0]
        crossed = [number for number in seen.hits["media"][:, i].tolist() if number >= 0]
        priority = flat.materials["priority"]
        top = max(enumerate(crossed), key=lambda at: (priority[at[1]], at[0]), default=(0, -1))[1]
        return tuple(listed), top
    medium = int(flat.materials["medium"][hit.material]) if hit is not None and hit.inside else -1
    return ((medium,) if medium >= 0 else ()), medium


def _light(number: int, lit: LitBy, i: int, bands: slice) -> LightShare:
    words = lit.feelers or {}
    feelers = tuple(_feeler(lit, words, k, bands) for k in lit.of(i))
    return LightShare(
        number, feelers, *(_numbers(values[bands, i]) for values in (lit.diffuse, lit.highlight, lit.brings))
    )


def _feeler(lit: LitBy, words: Words, k: int, bands: slice) -> Feeler:
    seen = bool(words["seen"][k])
    through = _numbers(words["filter"][bands, k]) if "filter" in words else (1.0,) * bands.stop
    return Feeler(
        _numbers(words["origin"][:, k]), _numbers(words["direction"][:, k]),
        float(words["t_max"][k]) / layout.FEELER_REACH,
        seen, lit.met[k], through if seen else (0.0,) * bands.stop,
    )  # fmt: skip


def _numbers(values: np.ndarray) -> Numbers:
    return tuple(values.tolist())
