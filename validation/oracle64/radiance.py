"""The image model, as it reads: the radiance along a ray is what its hit emits, gathers and passes on."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from clrt.scene.scene import Scene

from . import hashing, optics
from .bounce import Spawned, bounce
from .camera import Background
from .film import ROUTES, Film, Rays
from .lights import Way, ways
from .spot import Spot, spot_at, visible_hit
from .vectors import Array, dot
from .world import World, visibility

_REACH = 1 - 2.0**-14  # of the way to a light, within which something hides it


@dataclass(frozen=True)
class Job:
    """One rendering: the world, what the model reads of the scene besides, and where its sums go."""

    world: World
    scene: Scene
    background: Background
    max_depth: int
    film: Film

    @property
    def ambient(self) -> Array:
        """A (bands,)."""
        return self.world.palette.light(self.scene.ambient)



def radiance(job: Job, rays: Rays, generation: int) -> Array:
    """Radiance (n, bands) along rays; one that meets nothing brings the background, an ambient ray A."""
    met = visible_hit(job.world, rays)
    media = job.world.media
    hit, missed = met.primitive >= 0, np.flatnonzero(met.primitive < 0)
    # nothing comes through an endless medium that absorbs; inf * 0 would be NaN
    depth = media.sigma[media.top(met.before)]
    clear = np.exp(-np.where(depth > 0, depth * met.t[:, None], 0.0))
    rays = replace(rays, weight=rays.weight * clear)
    light = np.zeros((len(rays), job.world.palette.bands))
    if missed.size:
        ambient = rays.kind == "ambient"
        light[missed] = job.ambient if ambient else job.background(rays.direction[missed])
        job.film.add(rays[missed], generation, light[missed])
    job.film.count(generation, "hits", np.count_nonzero(hit))
    if generation == 0:
        job.film.count(0, "camera", len(rays))
        job.film.count(0, "camera_hits", np.count_nonzero(hit))
        job.film.note(rays.pixel[hit], job.world.shown[job.world.shape_of[met.primitive[hit]]])
    if hit.any():
        spot = spot_at(job.world, rays[hit], met[hit])
        light[hit] = shade(job, rays[hit], spot, generation)
    return light * clear


def shade(job: Job, rays: Rays, spot: Spot, generation: int) -> Array:
    """e + ka F A + the lights' share + kr M L(reflected) + kt Tt L(transmitted)."""
    emission = emitted(job, rays, spot)
    job.film.add(rays, generation, emission, "emission")
    light = emission + ambient_light(job, rays, spot, generation)
    origin = spot.start_before
    for number, source in enumerate(job.scene.lights):
        for way in ways(source, number, origin, rays):
            light += lit_by(job, number, way, rays, spot, generation)
    passed = bounce(job.world, rays, spot)
    if generation < job.max_depth:
        job.film.count(generation, "total_internal_reflection", np.count_nonzero(passed.total))
    light += follow(job, rays, generation, passed.reflection, hashing.REFLECTION)
    light += follow(job, rays, generation, passed.transmission, hashing.TRANSMISSION)
    return np.asarray(light)


def emitted(job: Job, rays: Rays, spot: Spot) -> Array:
    """e; of a light's surface its radiance, on a side that shines, and not to ambient rays."""
    emission, lamp = spot.emission, job.world.lamp[spot.shape]
    both = np.array([getattr(light, "two_sided", False) for light in job.scene.lights] + [True], bool)
    dark = (lamp >= 0) & ((~spot.enters & ~both[lamp]) | (rays.kind == "ambient"))
    return np.where(dark[:, None], 0.0, emission)


def ambient_light(job: Job, rays: Rays, spot: Spot, generation: int) -> Array:
    """ka F A; with ambient samples A is what so many rays round the normal see, which gather no further."""
    share = job.world.surfaces.ka[spot.shape, None] * spot.color
    samples = job.scene.ambient_samples
    fresh = (rays.path & np.uint32(hashing.GATHERED)) == 0
    gathers = fresh & np.any(rays.weight * share != 0, axis=1) & (generation < job.max_depth and samples > 0)
    light = np.where(gathers[:, None], 0.0, share * job.ambient)
    job.film.add(rays, generation, light, "ambient")
    if gathers.any():
        parents, n, ns = rays[gathers], spot.n[gathers], spot.ns[gathers]
        h = hashing.child(parents.path, hashing.AMBIENT)
        flags: Any = hashing.GATHERED | (hashing.GATHERED_FIRST if generation == 0 else 0)
        flags = parents.path & np.uint32(hashing.FLAGS) | np.uint32(flags)
        origin, weight = spot.start_before[gathers], parents.weight * share[gathers] / samples
        for i in range(samples):
            direction = hashing.cosine_direction(h, i, ns)
            below = dot(direction, n) <= 0
            direction[below] = hashing.cosine_direction(h[below], i, n[below])
            key = hashing.key(hashing.combine(h, i))
            gatherers = replace(
                parents, origin=origin, direction=direction, weight=weight, path=key | flags, base=key,
                sample=np.zeros(len(key), int), media=spot.before[gathers], kind="ambient",
                cone=spot.cone[gathers],
            )  # fmt: skip
            seen = radiance(job, gatherers, generation + 1)
            light[gathers] += share[gathers] / samples * seen
            job.film.count(generation + 1, "ambient", len(gatherers))
    return light


def lit_by(job: Job, number: int, way: Way, rays: Rays, spot: Spot, generation: int) -> Array:
    """I f(r) [kd F (ns.l) + ks H (r.v)^m] where a light, or one of its points, is seen, else 0."""
    of, shape, source = job.world.surfaces, spot.shape, job.scene.lights[number]
    origin = spot.start_before
    direction, distance, factor = way
    cosine = dot(spot.ns, direction)
    asked = (dot(spot.n, direction) > 0) & (cosine > 0) & ((of.kd[shape] > 0) | (of.ks[shape] > 0))
    job.film.count(generation, "feelers", np.count_nonzero(asked))
    seen = np.zeros_like(spot.color)
    seen[asked] = visibility(job.world, origin[asked], direction[asked], _REACH * distance[asked], number)

    received = job.world.palette.light(source.intensity) * seen * factor[:, None]
    received = np.where(asked[:, None], received, 0.0)
    mirrored = 2 * cosine[:, None] * spot.ns - direction
    alignment = dot(mirrored, -rays.direction)
    lobe = np.where(alignment > 0, np.maximum(alignment, 0) ** of.m[shape], 0.0)
    if getattr(source, "visible", False):  # mirrors show it
        lobe = np.where(of.kr[shape] > 0, 0.0, lobe)
    highlight = spot.highlight
    highlight = np.where(of.schlick[shape, None], optics.schlick(highlight, cosine), highlight)
    diffuse = received * (of.kd[shape] * cosine)[:, None] * spot.color
    shine = received * (of.ks[shape] * lobe)[:, None] * highlight
    job.film.add(rays, generation, diffuse, "diffuse")
    job.film.add(rays, generation, shine, "highlight")
    return np.asarray(diffuse + shine)


def follow(job: Job, rays: Rays, generation: int, spawned: Spawned, number: int) -> Array:
    """What the children of `rays` return, times their share; beyond the last generation `depth_color`."""
    light = np.zeros_like(rays.weight)
    if not len(spawned.parent):
        return light
    children, share = spawned.rays, spawned.rays.weight
    parents = rays[spawned.parent]
    if generation == job.max_depth:
        returned = share * job.world.palette.light(job.scene.depth_color)
        job.film.add(parents, generation, returned)
    else:
        job.film.count(generation + 1, ROUTES[number], len(spawned.parent))
        route = parents.path & np.uint32(hashing.FLAGS)
        route = np.where(route & np.uint32(hashing.ROUTE), route, route | np.uint32(number)).astype(np.uint32)
        key = hashing.key(hashing.child(parents.path, number))
        own = {"path": key | route, "base": key, "sample": np.zeros(len(key), int)}
        traced = replace(children, weight=parents.weight * share, kind=ROUTES[number], **own)
        returned = share * radiance(job, traced, generation + 1)
    np.add.at(light, spawned.parent, returned)
    return light
