"""The image model, as it reads: the radiance along a ray is what its hit emits, gathers and passes on."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from clrt.scene import PointLight, Scene, rgb

from . import hashing, optics
from .camera import Background
from .film import ROUTES, Film, Rays
from .vectors import Array, Bools, Ints, dot, unit
from .world import World, nearest_hit, visibility

# Rays leave a surface at this times the largest |coordinate| of the hit, the primitive and the ray's origin.
# A hit moved back onto its primitive is off it by about 1e-15 of these, so a ray finds its own surface behind
# it; what the offset hides is far below what float32 resolves.
OFFSET = 1e-10


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
        """A (3,)."""
        return np.array(rgb(self.scene.ambient))

    @property
    def counts_all(self) -> bool:
        """Whether rays of weight 0 are traced, as the Standard Procedural Databases' ray counts are taken."""
        return bool(self.scene.conformance == "spd")


@dataclass(frozen=True)
class Spot:
    """Where rays hit, one row a ray."""

    point: Array  # on the primitive
    outward: Array
    n: Array  # geometric normal on the ray's side
    ns: Array  # shading normal on the ray's side
    enters: Bools  # the ray comes from outside
    offset: Array
    shape: Ints
    color: Array  # F

    def leave(self, side: Array) -> Array:
        """Origins of rays that leave towards `side` (n or -n)."""
        return np.asarray(self.point + self.offset[:, None] * side)


def radiance(job: Job, rays: Rays, generation: int) -> Array:
    """Radiance (n, 3) along rays; one that meets nothing brings the background, an ambient ray A."""
    t, primitive = nearest_hit(job.world, rays.origin, rays.direction)
    hit, missed = primitive >= 0, np.flatnonzero(primitive < 0)
    light = np.zeros((len(rays), 3))
    if missed.size:
        light[missed] = job.ambient if rays.kind == "ambient" else job.background(rays.direction[missed])
        job.film.add(rays[missed], generation, light[missed])
    job.film.count(generation, "hits", np.count_nonzero(hit))
    if generation == 0:
        job.film.count(0, "camera", len(rays))
        job.film.count(0, "camera_hits", np.count_nonzero(hit))
    if hit.any():
        spot = spot_at(job.world, rays[hit], t[hit], primitive[hit])
        light[hit] = shade(job, rays[hit], spot, generation)
    return light


def spot_at(world: World, rays: Rays, t: Array, primitive: Ints) -> Spot:
    """The surface where rays hit primitives at distances t."""
    u = rays.direction
    point = rays.origin + t[:, None] * u
    outward, ns, extent = np.empty_like(point), np.empty_like(point), np.empty_like(t)
    for batch, here, rows in world.located(primitive):
        point[here] = batch.project(rows, point[here])
        outward[here] = batch.outward(rows, point[here], u[here])
        ns[here] = batch.shading_normal(rows, point[here], outward[here])
        extent[here] = batch.extent(rows)
    enters = dot(outward, u) <= 0
    n = np.where(enters[:, None], outward, -outward)
    ns = np.where(dot(ns, n)[:, None] < 0, -ns, ns)
    ns = np.where(dot(ns, u)[:, None] >= 0, n, ns)
    largest = [np.max(np.abs(rays.origin), axis=1), np.max(np.abs(point), axis=1), extent]
    shape = world.shape_of[primitive]
    color = world.surfaces.reflectance(shape, point, outward)
    return Spot(point, outward, n, ns, enters, OFFSET * np.max(largest, axis=0), shape, color)


def shade(job: Job, rays: Rays, spot: Spot, generation: int) -> Array:
    """e + ka F A + the lights' share + kr M L(reflected) + kt Tt L(transmitted)."""
    emission = job.world.surfaces.emission[spot.shape]
    job.film.add(rays, generation, emission, "emission")
    light = emission + ambient_light(job, rays, spot, generation)
    for source in job.scene.lights:
        light += lit_by(job, source, rays, spot, generation)
    passed = bounce(job, rays, spot)
    if generation < job.max_depth:
        job.film.count(generation, "total_internal_reflection", np.count_nonzero(passed.total))
    light += follow(job, rays, generation, passed.reflects, passed.reflection, hashing.REFLECTION)
    light += follow(job, rays, generation, passed.transmits, passed.transmission, hashing.TRANSMISSION)
    return np.asarray(light)


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
        flags = hashing.GATHERED | (hashing.GATHERED_FIRST if generation == 0 else 0)
        path = hashing.key(h) | parents.path & np.uint32(hashing.FLAGS) | np.uint32(flags)
        origin, weight = spot.leave(spot.n)[gathers], parents.weight * share[gathers] / samples
        for i in range(samples):
            direction = hashing.cosine_direction(h, i, ns)
            below = dot(direction, n) <= 0
            direction[below] = hashing.cosine_direction(h[below], i, n[below])
            gatherers = Rays(origin, direction, weight, path, parents.pixel, "ambient")
            seen = radiance(job, gatherers, generation + 1)
            light[gathers] += share[gathers] / samples * seen
            job.film.count(generation + 1, "ambient", len(gatherers))
    return light


def lit_by(job: Job, source: Any, rays: Rays, spot: Spot, generation: int) -> Array:
    """I f(r) [kd F (ns.l) + ks H (r.v)^m] where the light is seen, else 0."""
    of, shape = job.world.surfaces, spot.shape
    origin = spot.leave(spot.n)
    if isinstance(source, PointLight):
        to_light = np.array(source.position) - origin
        distance, direction = np.sqrt(dot(to_light, to_light)), unit(to_light)
    else:
        distance = np.full(len(shape), np.inf)
        direction = np.broadcast_to(-unit(source.direction), origin.shape)
    cosine = dot(spot.ns, direction)
    asked = (dot(spot.n, direction) > 0) & (cosine > 0) & ((of.kd[shape] > 0) | (of.ks[shape] > 0))
    job.film.count(generation, "feelers", np.count_nonzero(asked))
    seen = np.zeros((len(shape), 3))
    seen[asked] = visibility(job.world, origin[asked], direction[asked], distance[asked])

    received = np.array(rgb(source.intensity)) * seen
    if isinstance(source, PointLight) and source.falloff == "inverse-square":
        received /= distance[:, None] ** 2
    received = np.where(asked[:, None], received, 0.0)
    mirrored = 2 * cosine[:, None] * spot.ns - direction
    alignment = dot(mirrored, -rays.direction)
    lobe = np.where(alignment > 0, np.maximum(alignment, 0) ** of.m[shape], 0.0)
    highlight = of.highlight[shape]
    highlight = np.where(of.schlick[shape, None], optics.schlick(highlight, cosine), highlight)
    diffuse = received * (of.kd[shape] * cosine)[:, None] * spot.color
    shine = received * (of.ks[shape] * lobe)[:, None] * highlight
    job.film.add(rays, generation, diffuse, "diffuse")
    job.film.add(rays, generation, shine, "highlight")
    return np.asarray(diffuse + shine)


@dataclass(frozen=True)
class Bounce:
    """The rays that a hit passes light on to, and how much of it."""

    reflects: Bools  # (n,): a reflection is asked for
    transmits: Bools
    reflection: Rays  # weights are those of the path
    transmission: Rays
    total: Bools  # a transmission is asked for and cannot leave


def bounce(job: Job, rays: Rays, spot: Spot) -> Bounce:
    """Mirror and transmission rays of all hits, with their shares in `weight` (n, 3)."""
    of, shape, u = job.world.surfaces, spot.shape, rays.direction
    thin, medium = of.thin[shape], np.full(len(shape), float(job.scene.medium_ior))
    enters = spot.enters | thin  # a sheet has the surrounding medium on both sides
    eta_i = np.where(enters, medium, of.eta[shape])
    eta_t = np.where(enters, of.eta[shape], medium)

    reflected = optics.reflect(u, spot.ns)
    reflected = np.where((dot(reflected, spot.n) <= 0)[:, None], optics.reflect(u, spot.n), reflected)
    transmitted, k = optics.refract(u, spot.ns, eta_i / eta_t)
    above = (k >= 0) & (dot(transmitted, spot.n) >= 0)
    bent = np.where(above[:, None], spot.n, spot.ns)  # the normal at which light is refracted
    transmitted, k = optics.refract(u, bent, eta_i / eta_t)
    transmitted = np.where(thin[:, None], u, transmitted)

    total = (k < 0) & ~thin & (of.kt[shape] > 0)
    share = optics.fresnel(eta_i, eta_t, -dot(bent, u))
    share = np.where(thin, 2 * share / (1 + share), share)[:, None]
    mirror = of.mirror[shape]
    mirror = np.where(of.schlick[shape, None], optics.schlick(mirror, -dot(spot.ns, u)), mirror)
    reflects, transmits = of.kr[shape, None] * mirror, of.kt[shape, None] * of.tint[shape]
    by_fresnel = of.fresnel[shape, None]
    reflects, transmits = (
        np.where(by_fresnel, reflects * share, reflects + np.where(total[:, None], transmits, 0.0)),
        np.where(total[:, None], 0.0, np.where(by_fresnel, transmits * (1 - share), transmits)),
    )
    asked = (of.kr[shape] > 0) | (of.kt[shape] > 0), (of.kt[shape] > 0) & ~total
    return Bounce(
        _worth(job, rays.weight * reflects, asked[0]),
        _worth(job, rays.weight * transmits, asked[1]),
        replace(rays, origin=spot.leave(spot.n), direction=reflected, weight=reflects),
        replace(rays, origin=spot.leave(-spot.n), direction=transmitted, weight=transmits),
        total,
    )


def _worth(job: Job, weight: Array, asked: Bools) -> Bools:
    """Which rays are spawned: not those of weight 0 or below the cut-off, unless all are counted."""
    most = weight.max(axis=1)
    return asked if job.counts_all else (most > 0) & (most >= job.scene.min_weight)


def follow(job: Job, rays: Rays, generation: int, spawned: Bools, children: Rays, number: int) -> Array:
    """What the children of `rays` return, times their share; beyond the last generation `depth_color`."""
    light = np.zeros((len(rays), 3))
    if not spawned.any():
        return light
    share = children.weight[spawned]
    if generation == job.max_depth:
        light[spawned] = share * np.array(rgb(job.scene.depth_color))
        job.film.add(rays, generation, light)
        return light
    job.film.count(generation + 1, ROUTES[number], np.count_nonzero(spawned))
    path = rays.path[spawned]
    route = path & np.uint32(hashing.FLAGS)
    route = np.where(route & np.uint32(hashing.ROUTE), route, route | np.uint32(number)).astype(np.uint32)
    path = hashing.key(hashing.child(path, number)) | route
    weight = rays.weight[spawned] * share
    traced = replace(children[spawned], weight=weight, path=path, kind=ROUTES[number])
    light[spawned] = share * radiance(job, traced, generation + 1)
    return light
