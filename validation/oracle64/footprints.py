"""Footprints in pictures, in float64: how far they reach, by moving points, and the mip levels of these."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from .vectors import Array, Ints, dot, unit

STEP = 1e-5  # a point moves by so much


@dataclass(frozen=True)
class Seen:
    """How n points are seen: along which directions (n, 3), and how wide the rays' cones are there (n,)."""

    direction: Array
    width: Array

    def __getitem__(self, rows: Ints) -> Seen:
        return Seen(self.direction[rows], self.width[rows])


def reaches(place: Callable[[Array], tuple[Array, Array]], normal: Array, seen: Seen) -> Array:
    """How far footprints reach in u and v, (n, 2); `place`: u and v where points moved by vectors (n, 3)."""
    d = seen.direction
    least = np.eye(3)[np.argmin(np.abs(d), axis=1)]
    first = unit(np.cross(d, least))
    squares = np.zeros((len(d), 2))
    for beside in (first, np.cross(d, first)):
        along = beside - d * (dot(normal, beside) / dot(normal, d))[:, None]  # in the surface's plane
        length = np.sqrt(dot(along, along))
        step = along * (STEP / length)[:, None]
        ahead, back = (np.stack(place(way), axis=1) for way in (step, -step))
        moves = np.mod(ahead - back + 0.5, 1.0) - 0.5  # an angle may have gone once around
        squares += (moves / (2 * STEP) * length[:, None]) ** 2
    return np.where(seen.width[:, None] > 0, seen.width[:, None] * np.sqrt(squares), 0.0)


def pyramid(picture: Array, levels: bool) -> list[Array]:
    """A picture (h, w, 3), and its mip levels: each texel the mean of its own area of the one before."""
    found = [picture]
    while levels and max(found[-1].shape[:2]) > 1:
        rows, columns = (_areas(count) for count in found[-1].shape[:2])
        found.append(np.einsum("ij,jkc,lk->ilc", rows, found[-1], columns, optimize=True))
    return found


def _areas(count: int) -> Array:
    """The share (m, count) that each of `count` texels has in the m ones of the next level."""
    m = max(1, count // 2)
    low, high = np.arange(m)[:, None] * count / m, np.arange(1, m + 1)[:, None] * count / m
    texel = np.arange(count)
    return np.clip(np.minimum(high, texel + 1) - np.maximum(low, texel), 0, None) * m / count


def between(across: Array, most: int) -> tuple[Ints, Array]:
    """The level whose texels are just smaller than footprints of so many texels, and the next one's share."""
    fraction, exponent = np.frexp(np.clip(np.nan_to_num(across, nan=np.inf), 1.0, 2.0**most))
    return exponent - 1, 2 * fraction - 1
