"""What files of meshes are read as: triangles that stand alone, each with its own three corners.

A reader says Unreadable of what it does not know for certain, so that nobody is told of another mesh.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

Array = np.ndarray
_ROUNDING = 1e-9  # of a face's squared area
_CANCELLED = 1e-6  # of the squares of its triangles' areas


class Unreadable(ValueError):
    """What stands in a file of a mesh and is not read here."""


@dataclass(frozen=True, eq=False)
class Patch:
    """`corners` (m, 3, 3) of triangles, in world space, outer sides counter-clockwise.

    `normals` (m, 3, 3), `uv` (m, 3, 2), v = 0 at the top row of a picture, `colors` of corners (m, 3, 3) or
    faces (m, 3), linear; None where the file has none.
    """

    corners: Array
    normals: Array | None = None
    uv: Array | None = None
    colors: Array | None = None

    @property
    def form(self) -> tuple[bool, bool]:
        """Whether it has normals, and uv."""
        return self.normals is not None, self.uv is not None


@dataclass(frozen=True, eq=False)
class Patches:
    """What is in a file. Those of one `part` have one number; `untold` says why they cannot be numbered."""

    found: Sequence[tuple[int, Patch]]
    untold: str = ""

    def of(self, part: int | None) -> list[Patch]:
        """Those of a part; None: all."""
        if part is None:
            return [patch for _, patch in self.found]
        if self.untold:
            raise Unreadable(f"which part {part} is: {self.untold}")
        chosen = [patch for number, patch in self.found if number == part]
        if not chosen:
            raise Unreadable(f"it has no part {part}")
        return chosen


def fans(points: Array, faces: Iterable[Sequence[int]]) -> Array:
    """Faces as triangles (m, 3) about their first corner, of numbers among `points` (n, 3).

    Each face's stand together. Unreadable where they would cover more than the face.
    """
    listed = [np.asarray(face, np.int64) for face in faces]
    sizes = np.array([len(face) for face in listed], np.int64)
    parts: list[Array] = [np.zeros((0, 3), np.int64)]
    owners: list[Array] = [np.zeros(0, np.int64)]
    for size in np.unique(sizes[sizes > 2]):
        rows = np.flatnonzero(sizes == size)
        corners = np.array([listed[row] for row in rows])
        if size > 3 and dented(points[corners]).any():
            row = rows[np.argmax(dented(points[corners]))]
            raise Unreadable(f"face {row} (from 0) of {size} corners is dented, or crosses itself")
        middle = np.arange(1, size - 1)
        cut = np.stack([np.zeros_like(middle), middle, middle + 1], axis=1)
        parts.append(corners[:, cut].reshape(-1, 3))
        owners.append(np.repeat(rows, size - 2))
    order = np.argsort(np.concatenate(owners), kind="stable")
    return np.concatenate(parts)[order]


def dented(points: Array) -> Array:
    """Which faces (m, n, 3) triangles about their first corner do not cover alone."""
    local = points - points[:, :1]
    each = np.cross(local[:, 1:-1], local[:, 2:])
    whole = each.sum(axis=1)
    area, squares = (whole * whole).sum(axis=1), (each * each).sum(axis=(1, 2))
    least = np.einsum("mtk,mk->mt", each, whole).min(axis=1)
    return np.asarray((least < -_ROUNDING * area) | (area < _CANCELLED * squares))


def finite(array: Array, what: str) -> Array:
    """The array; Unreadable where it has numbers that are none."""
    if not np.isfinite(array).all():
        raise Unreadable(f"{what} that are not finite")
    return array


def linear(values: Array) -> Array:
    """Light that colours of 0 to 1 stand for, by the sRGB curve of IEC 61966-2-1."""
    return np.where(values <= 0.04045, values / 12.92, ((values + 0.055) / 1.055) ** 2.4)
