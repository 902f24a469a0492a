"""Vectors as the last axis of numpy float64 arrays, and affine frames."""

from __future__ import annotations

from functools import reduce
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Ints = NDArray[np.int64]
Bools = NDArray[np.bool_]
Words = NDArray[np.uint32]


def dot(a: Array, b: Array) -> Array:
    """(..., 3) and (..., 3) to (...)."""
    return np.asarray(np.einsum("...i,...i->...", a, b))


def across(operation: np.ufunc, values: Any) -> Any:
    """`operation.reduce` over a last axis (..., k), which is some ten times slower for so short a one."""
    return reduce(operation, np.moveaxis(values, -1, 0))


def unit(v: Any) -> Array:
    """`v` (..., 3) at length 1; NaN where `v` is zero or not finite."""
    v = np.asarray(v, float)
    # the largest coordinate first, so that neither 1e-200 nor 1e200 squares to nothing
    v = v / across(np.maximum, np.abs(v))[..., None]
    return np.asarray(v / np.sqrt(dot(v, v))[..., None])


def apply(matrices: Array, vectors: Array) -> Array:
    """Matrix i (n, 3, 3) times vector i (n, 3)."""
    return np.asarray(np.einsum("nij,nj->ni", matrices, vectors))


def apply_transposed(matrices: Array, vectors: Array) -> Array:
    """Transpose of matrix i times vector i."""
    return np.asarray(np.einsum("nji,nj->ni", matrices, vectors))


def transform_points(matrix: Array, points: Any) -> Array:
    """Points (..., 3) through a 4x4 affine matrix."""
    return np.asarray(np.asarray(points, float) @ matrix[:3, :3].T + matrix[:3, 3])


def transform_normals(matrix: Array, normals: Any) -> Array:
    """Normals (..., 3) through a 4x4 affine matrix: the inverse transpose, at length 1.

    It keeps the outer side of a surface outside for mirroring matrices too.
    """
    return unit(np.asarray(normals, float) @ np.linalg.inv(matrix[:3, :3]))


def box_corners(low: Array, high: Array) -> Array:
    """The 8 corners (8, 3) of a box."""
    return np.array([[(low, high)[i >> axis & 1][axis] for axis in range(3)] for i in range(8)])


def perpendicular_axes(axis: Array) -> Array:
    """Rotation (3, 3) whose columns are two unit vectors perpendicular to the unit vector `axis`, then it."""
    smallest = np.eye(3)[np.argmin(np.abs(axis))]
    x = unit(np.cross(smallest, axis))
    return np.stack([x, np.cross(axis, x), axis], axis=1)
