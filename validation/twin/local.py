"""The float32 twin's local light: the passes `shade`, `feelers` and `illuminate`, a queue at a time."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from clrt import layout
from clrt.flatten.flatten import FlatScene

from .dispersion import Groups, bounces, own_bands
from .geometry import BEFORE_ALL, NO_PRIMITIVE, Hits, Rays, nearest_hit
from .lights import light_samples
from .math import Array, larger
from .media import Crossed
from .queues import Queue
from .shading import (
    ALL,
    AMBIENT,
    Bounce,
    ambient_share,
    is_above,
    local_light,
    reflected_light,
)
from .surface import Surface, background_of, bands, surface_at

_REACH = np.float32(1 - 2.0**-14)  # of the way to a light

SPAWN = {name: np.uint32(bit) for name, bit in layout.SPAWN.items()}


@dataclass(frozen=True)
class Shaded:
    """The local light of a queue's rays (bands, n) and the packed word of what each will spawn.

    `which` are the rays that hit; `surface` and `bounce` are theirs. `groups` and `parts`: how they part into
    narrow rays, and which groups are worth a ray, (n,) bool each.
    """

    local: Array
    spawn: Array
    which: Array
    surface: Surface
    bounce: Bounce
    groups: Groups
    parts: list[Array]


@dataclass(frozen=True)
class Feelers:
    """Shadow feelers in the order of their rays, lights and their points.

    `filter` (bands, n): the share of each band that comes through. `contribution` (bands, n): what they bring
    if they arrive.
    """

    ray: Array
    rays: Rays
    seen: Array
    filter: Array
    contribution: Array


def shade(flat: FlatScene, found_at: Crossed, last: bool, terms: int = ALL) -> Shaded:
    """Local light of every ray, and what each will spawn; in the last generation `depth_color` instead."""
    info, queue, hits = flat.scene[0], found_at.queue, found_at.hits
    which = np.flatnonzero(hits.primitive >= 0)
    rays, weight = queue.rays[which], queue.weight[:, which]
    s = surface_at(flat, rays, Hits(hits.t[which], hits.primitive[which]))
    bounce, groups = bounces(flat, found_at, s, which)

    transmits = _worth_tracing(info, weight * bounce.transmit)
    parts = [
        _passes_on(info, s, weight[row : row + flat.group], part, row) & groups.dispersing
        for row, part in zip(groups.first, groups.bounces, strict=True)
    ]
    reflects = _worth_tracing(info, weight * bounce.reflect)
    if info["spd"]:
        reflects = (s.material["kr"] > 0.0) | (s.material["kt"] > 0.0)
        transmits = (s.material["kt"] > 0.0) & ~bounce.total_internal
    transmits &= ~groups.dispersing
    gathers = _any_positive(weight * ambient_share(s)) & (
        queue.path[which] & np.uint32(layout.PATH["PATH_GATHERED"]) == 0
    )
    if last or not (terms & AMBIENT and info["ambient_samples"] > 0):
        gathers = np.zeros_like(gathers)

    value = weight * local_light(flat, s, gathers, terms, ambient=queue.kind == "ambient")
    if last and terms == ALL:
        depth_color = info["depth_color"][:, None]
        value = np.where(reflects, value + weight * bounce.reflect * depth_color, value)
        goes_on = np.repeat(transmits[None], flat.bands, axis=0)
        for row, part in zip(groups.first, parts, strict=True):
            goes_on[row : row + flat.group] |= part
        value = np.where(goes_on, value + weight * bounce.transmit * depth_color, value)
    found = np.full(len(which), SPAWN["SPAWN_HIT"])
    for _, to in light_samples(_lights(flat), s.before, queue.streams[which]):
        found += is_above(s, to, terms).astype(np.uint32)
    if not last and terms == ALL:
        found |= np.where(reflects, SPAWN["SPAWN_REFLECTION"], np.uint32(0))
        found |= np.where(transmits, SPAWN["SPAWN_TRANSMISSION"], np.uint32(0))
        found += sum((part * SPAWN["SPAWN_GROUP"] for part in parts), np.uint32(0))
        found |= np.where(bounce.total_internal, SPAWN["SPAWN_TOTAL_INTERNAL"], np.uint32(0))
    found |= np.where(gathers, SPAWN["SPAWN_AMBIENT"], np.uint32(0))

    local, spawn = _of_misses(flat, queue, terms), np.zeros(len(queue), np.uint32)
    local[:, which], spawn[which] = value, found
    spawn |= np.where((local != 0.0).any(axis=0), SPAWN["SPAWN_LOCAL"], np.uint32(0))
    return Shaded(local, spawn, which, s, bounce, groups, [part & (not last) for part in parts])


def _passes_on(info: np.void, s: Surface, weight: Array, bounce: Bounce, row: int) -> Array:
    """Is the transmission of the bands from `row` on worth a ray."""
    if info["spd"]:
        return np.asarray((s.material["kt"] > 0.0) & ~bounce.total_internal)
    return _worth_tracing(info, weight * bounce.transmit[row : row + len(weight)])


def _of_misses(flat: FlatScene, queue: Queue, terms: int) -> Array:
    """Background; the constant ambient light for an ambient ray that meets nothing."""
    if terms != ALL:
        return np.zeros_like(queue.weight)
    if queue.kind == "ambient":
        return queue.weight * flat.scene["ambient"][0][:, None]
    return queue.weight * background_of(flat, queue.rays.direction)


def _worth_tracing(info: np.void, share: Array) -> Array:
    """Not black, and not under the cut-off."""
    most = np.zeros_like(share[0])
    for value in share:
        most = larger(value, most)
    return (most > 0.0) & (most >= info["min_weight"])


def _any_positive(share: Array) -> Array:
    return np.asarray((share > 0.0).any(axis=0))


def _lights(flat: FlatScene) -> Array:
    return flat.lights[: int(flat.scene["lights"][0])]


def feelers(flat: FlatScene, queue: Queue, found: Shaded, terms: int = ALL) -> Feelers:
    """One feeler to each point of a light above each hit, and which of them arrive."""
    s, direction = found.surface, queue.rays.direction[:, found.which]
    start = s.before
    found_by = list(light_samples(_lights(flat), start, queue.streams[found.which]))
    ways = [to for _, to in found_by]
    above = np.array([is_above(s, to, terms) for to in ways], bool).reshape(len(ways), len(found.which))
    radiance = [reflected_light(source, to, s, direction, terms) for source, to in found_by]
    hit, number = np.nonzero(above.T)  # by ray, then by light and its points

    def chosen(parts: list[Array], empty: tuple[int, ...]) -> Array:
        return np.stack(parts)[number, ..., hit].T if parts else np.zeros(empty, np.float32)

    rays = Rays(
        start[:, hit],
        chosen([to.direction for to in ways], (3, 0)),
        chosen([to.distance * _REACH for to in ways], (0,)),
    )
    ray, own = found.which[hit], np.array([light["surface"] for light, _ in found_by], np.int32)[number]
    contribution = queue.weight[:, ray] * chosen(radiance, (flat.bands, 0))
    through = np.ones_like(contribution)
    if flat.scene["tinted"][0]:
        seen = _tint(flat, rays, own, through)
        contribution *= through
    else:
        seen = nearest_hit(flat, rays, own=own).primitive < 0
    if queue.band is not None:
        contribution = np.where(own_bands(flat, queue.band[ray]), contribution, np.float32(0.0))
    return Feelers(ray, rays, seen.astype(np.uint32), through, contribution)


def _tint(flat: FlatScene, rays: Rays, own: Array, through: Array) -> Array:
    """Multiply by kt Tt of every surface crossed, in order, up to the first opaque one. Which get through?"""
    seen = np.ones(len(rays), bool)
    at = Hits(np.zeros(len(rays), np.float32), np.full(len(rays), BEFORE_ALL, np.int32))
    crossing = np.arange(len(rays))
    while len(crossing):
        at = nearest_hit(flat, rays[crossing], at, own[crossing])
        hit = at.primitive != NO_PRIMITIVE
        crossing, at = crossing[hit], Hits(at.t[hit], at.primitive[hit])
        material = surface_at(flat, rays[crossing], at).material
        through[:, crossing] *= material["kt"] * bands(material["tint"])
        clear = material["kt"] != 0.0
        seen[crossing[~clear]] = False
        crossing, at = crossing[clear], Hits(at.t[clear], at.primitive[clear])
    return seen
