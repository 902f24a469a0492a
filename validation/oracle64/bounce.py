"""What a hit passes on: the mirrored ray, and the transmitted one or one for each group of bands."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from . import optics
from .film import Rays
from .gloss import Facets, facets
from .spot import Spot
from .vectors import Array, Bools, Ints, dot
from .world import World


@dataclass(frozen=True)
class Spawned:
    """The rays that some of n rays spawn. `weight` of these is their share of what their parent returns."""

    rays: Rays
    parent: Ints  # rows of the n


@dataclass(frozen=True)
class Bounce:
    """What n rays spawn where they hit."""

    reflection: Spawned
    transmission: Spawned
    total: Bools  # (n,): a transmission is asked for and, in some band, cannot leave


@dataclass(frozen=True)
class _Passed:
    """What n rays pass on if every one of them has one index on each side."""

    direction: Array  # of the transmitted rays
    reflects: Array  # (n, bands)
    transmits: Array
    total: Bools


def bounce(world: World, rays: Rays, spot: Spot) -> Bounce:
    """Reflected and transmitted rays of hits; a ray of all bands splits at an index that is a curve.

    Where nothing is transmitted, it is reflected as a whole, of each band what that band's group says.
    """
    eta_i, eta_t, curved = indices(world, spot)
    splits = curved & (rays.group < 0)
    facet = facets(rays, spot, world.surfaces.alpha[spot.shape])
    reflects, total = np.zeros_like(rays.weight), np.zeros(len(rays), bool)
    transmitted: list[Spawned] = []
    for group in (-1, *range(world.palette.groups)):
        # what does not split, then group by group what does
        rows = np.flatnonzero(splits if group >= 0 else ~splits)
        if not rows.size:
            continue
        ours = np.full(len(rows), group) if group >= 0 else rays.group[rows]
        at = np.maximum(ours, 0)
        passed = _pass(world, rays[rows], spot.take(rows), eta_i[rows, at], eta_t[rows, at],
                       facet.take(rows))  # fmt: skip
        mine = (ours[:, None] < 0) | (world.palette.group_of == ours[:, None])
        reflects[rows] += np.where(mine, passed.reflects, 0.0)
        total[rows] |= passed.total
        share = np.where(mine, passed.transmits, 0.0)
        transmitted.append(_transmitted(world, rays, spot, rows, share, passed, ours))
    mirrored = optics.reflect(rays.direction, spot.ns)
    below = dot(mirrored, spot.n) <= 0
    mirrored = np.where(below[:, None], optics.reflect(rays.direction, spot.n), mirrored)
    rough = world.surfaces.alpha[spot.shape] > 0
    mirrored = np.where(rough[:, None], facet.direction, mirrored)
    asked = (world.surfaces.kr[spot.shape] > 0) | (world.surfaces.kt[spot.shape] > 0)
    kept = np.flatnonzero(_worth(world, rays.weight * reflects, asked))
    child = replace(
        rays, origin=spot.start_before, direction=mirrored, weight=reflects, media=spot.before,
        cone=spot.cone,
    )  # fmt: skip
    return Bounce(Spawned(child[kept], kept), _joined(transmitted), total)


def indices(world: World, spot: Spot) -> tuple[Array, Array, Bools]:
    """Indices of refraction (n, groups) before and behind each hit, and whether one of them is a curve.

    A sheet, and what lets no light through, is no medium: what holds before the surface is behind it, too.
    """
    media, of, shape = world.media, world.surfaces, spot.shape
    before, after = media.top(spot.before), media.top(spot.after)
    own = media.number[shape] < 0
    eta_i, eta_t = media.eta[before], np.where(own[:, None], of.eta[shape], media.eta[after])
    curved = media.curved[before] | np.where(own, of.curved[shape], media.curved[after])
    inside = own & ~spot.enters & ~of.thin[shape] & ~of.conductor[shape]
    return np.where(inside[:, None], eta_t, eta_i), np.where(inside[:, None], eta_i, eta_t), curved


def _pass(
    world: World, rays: Rays, spot: Spot, eta_i: Array, eta_t: Array, facet: Facets
) -> _Passed:
    of, shape, u = world.surfaces, spot.shape, rays.direction
    rough = of.alpha[shape] > 0
    cosine = np.where(rough, facet.cosine, -dot(spot.ns, u))
    thin = of.thin[shape]
    transmitted, k = optics.refract(u, spot.ns, eta_i / eta_t)
    above = (k >= 0) & (dot(transmitted, spot.n) >= 0)
    bent = np.where(above[:, None], spot.n, spot.ns)  # the normal at which light is refracted
    transmitted, k = optics.refract(u, bent, eta_i / eta_t)
    transmitted = np.where(thin[:, None], u, transmitted)

    total = (k < 0) & ~thin & (of.kt[shape] > 0)
    share = optics.fresnel(eta_i, eta_t, np.where(rough, cosine, -dot(bent, u)))
    share = np.where(thin, 2 * share / (1 + share), share)[:, None]
    metal = np.flatnonzero(of.conductor[shape])
    if metal.size:
        share = np.repeat(share, of.metal.shape[1], axis=1)
        share[metal] = optics.conductor(eta_i[metal, None], of.metal[shape[metal]], cosine[metal])
    mirror = spot.mirror
    mirror = np.where(of.schlick[shape, None], optics.schlick(mirror, cosine), mirror)
    mirror = np.where(rough, facet.passed, 1.0)[:, None] * mirror
    reflects, transmits = of.kr[shape, None] * mirror, of.kt[shape, None] * spot.tint
    by_fresnel = (of.fresnel | of.conductor)[shape, None]
    reflects, transmits = (
        np.where(by_fresnel, reflects * share, reflects + np.where(total[:, None], transmits, 0.0)),
        np.where(total[:, None], 0.0, np.where(by_fresnel, transmits * (1 - share), transmits)),
    )
    return _Passed(transmitted, reflects, transmits, total)


def _transmitted(world: World, rays: Rays, spot: Spot, rows: Ints, share: Array, passed: _Passed,
                 group: Ints) -> Spawned:  # fmt: skip
    """The transmitted rays of these rows, of a group each."""
    asked = (world.surfaces.kt[spot.shape[rows]] > 0) & ~passed.total
    kept = np.flatnonzero(_worth(world, rays.weight[rows] * share, asked))
    parent = rows[kept]
    child = replace(
        rays[parent], origin=spot.start_behind[parent], direction=passed.direction[kept],
        weight=share[kept], media=spot.after[parent], group=group[kept], cone=spot.cone[parent],
    )  # fmt: skip
    return Spawned(child, parent)


def _worth(world: World, weight: Array, asked: Bools) -> Bools:
    """Which rays are spawned: not those of weight 0 or below the cut-off.

    All of them where rays are counted as the Standard Procedural Databases' are.
    """
    if world.scene.conformance == "spd":
        return asked
    most = weight.max(axis=1)
    return np.asarray((most > 0) & (most >= world.scene.min_weight))


def _joined(spawned: list[Spawned]) -> Spawned:
    """Children of several rows, in the order of their parents."""
    parent = np.concatenate([part.parent for part in spawned])
    order = np.argsort(parent, kind="stable")
    names = ("origin", "direction", "weight", "path", "pixel", "media", "group", "base", "sample", "cone")
    joined: dict[str, Any] = {
        name: np.concatenate([getattr(part.rays, name) for part in spawned])[order] for name in names
    }
    return Spawned(replace(spawned[0].rays, **joined), parent[order])
