"""Rough mirrors: one ray mirrored at a facet drawn from those that are seen (GGX; Heitz 2018)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from . import hashing
from .film import Rays
from .spot import Spot
from .vectors import Array, dot, unit


@dataclass(frozen=True)
class Facets:
    """Directions (n, 3) mirrored at facets, cosines (n,) of incidence there, and shares (n,) that go on."""

    direction: Array
    cosine: Array
    passed: Array

    def take(self, rows: Any) -> Facets:
        return Facets(self.direction[rows], self.cosine[rows], self.passed[rows])


def facets(rays: Rays, spot: Spot, alpha: Array) -> Facets:
    """One for each hit; where alpha (n,) is 0 it is of no use."""
    point = hashing.concentric(*hashing.pair(hashing.combine(rays.base, 0x80000001), rays.sample))
    found = mirrored_at_facet(spot.ns, rays.direction, alpha, point)
    again = np.flatnonzero((found.passed > 0) & (dot(found.direction, spot.n) <= 0))
    there = tuple(part[again] for part in point)
    other = mirrored_at_facet(spot.n[again], rays.direction[again], alpha[again], (there[0], there[1]))
    for name in ("direction", "cosine", "passed"):
        getattr(found, name)[again] = getattr(other, name)
    return found


def mirrored_at_facet(n: Array, u: Array, alpha: Array, point: tuple[Array, Array]) -> Facets:
    """About normals n (m, 3), for directions u and points of the unit disk (m,), (m,)."""
    tangent, bitangent = hashing.frame(n)
    v = -np.stack([dot(u, tangent), dot(u, bitangent), dot(u, n)], axis=1)
    wide = np.stack([alpha, alpha, np.ones_like(alpha)], axis=1)
    top = unit(wide * v)
    across = np.hypot(top[:, 0], top[:, 1])
    straight = across == 0
    length = np.where(straight, 1.0, across)
    first = np.stack([np.where(straight, 1.0, -top[:, 1] / length), top[:, 0] / length, 0 * across], axis=1)
    a, b = point
    seen = (1 + top[:, 2]) / 2
    b = (1 - seen) * np.sqrt(np.maximum(1 - a * a, 0)) + seen * b
    along = np.sqrt(np.maximum(1 - a * a - b * b, 0))
    facet = a[:, None] * first + b[:, None] * np.cross(top, first) + along[:, None] * top
    facet[:, 2] = np.maximum(facet[:, 2], 0)
    h = unit(wide * facet)
    cosine = dot(v, h)
    r = 2 * cosine[:, None] * h - v
    with np.errstate(divide="ignore", invalid="ignore"):
        steep = (r[:, 0] ** 2 + r[:, 1] ** 2) / r[:, 2] ** 2
        passed = np.where(r[:, 2] > 0, 2 / (1 + np.sqrt(1 + alpha**2 * steep)), 0.0)
    back = r[:, :1] * tangent + r[:, 1:2] * bitangent + r[:, 2:] * n
    return Facets(unit(back), cosine, passed)
