"""How often a shape encloses points (docs/model.md, "Media"), in float64."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from clrt.flatten.mesh import fans, joined
from clrt.flatten.winding import winding_numbers
from clrt.scene.mesh import Mesh
from clrt.scene.shapes import (
    Box,
    Cone,
    Cylinder,
    Disk,
    Ellipsoid,
    Paraboloid,
    Plane,
    Polygon,
    Quadric,
    Shape,
    Sphere,
)


def count_inside(shape: Shape, points: np.ndarray) -> np.ndarray:
    """How often the shape encloses each of the points (n, 3): (n,) int, 0 or 1 but for meshes."""
    inside = _INSIDE[type(shape)]
    if inside is None:
        return np.zeros(len(points), np.int64)
    inverse = np.linalg.inv(shape.matrix)
    with np.errstate(all="ignore"):  # points that are not finite are inside of nothing
        local = np.asarray(points, np.float64) @ inverse[:3, :3].T + inverse[:3, 3]
        return np.asarray(inside(shape, local)).astype(np.int64)


def _sphere(shape: Sphere, p: np.ndarray) -> np.ndarray:
    return np.square(p - shape.center).sum(axis=1) < shape.radius**2


def _plane(shape: Plane, p: np.ndarray) -> np.ndarray:
    return np.asarray(np.subtract(p, shape.point) @ np.asarray(shape.normal, np.float64) < 0)


def _box(shape: Box, p: np.ndarray) -> np.ndarray:
    return np.asarray(((p > shape.min) & (p < shape.max)).all(axis=1))


def _ellipsoid(shape: Ellipsoid, p: np.ndarray) -> np.ndarray:
    return np.square((p - shape.center) / shape.radii).sum(axis=1) < 1


def _quadric(shape: Quadric, p: np.ndarray) -> np.ndarray:
    a, b, c, d, e, f, g, h, i, j = shape.coefficients
    x, y, z = p.T
    form = a * x * x + b * y * y + c * z * z + 2 * (d * x * y + e * y * z + f * x * z + g * x + h * y + i * z)
    inside = form + j < 0
    if shape.clip is not None:
        inside &= ((p >= shape.clip[0]) & (p <= shape.clip[1])).all(axis=1)
    return np.asarray(inside)


def _cone(shape: Cone | Cylinder, p: np.ndarray) -> np.ndarray:
    r0, r1 = (shape.r0, shape.r1) if isinstance(shape, Cone) else (shape.radius, shape.radius)
    axis = np.subtract(shape.p1, shape.p0)
    along = (p - shape.p0) @ axis / (axis @ axis)  # 0 at p0, 1 at p1
    across = np.square(p - shape.p0 - along[:, None] * axis).sum(axis=1)
    return (along > 0) & (along < 1) & (across < np.square(r0 + (r1 - r0) * along))


def _paraboloid(shape: Paraboloid, p: np.ndarray) -> np.ndarray:
    axis = np.asarray(shape.axis, np.float64) / np.linalg.norm(shape.axis)
    height = (p - shape.apex) @ axis
    across = np.square(p - shape.apex - height[:, None] * axis).sum(axis=1)
    return (height > 0) & (height < shape.height) & (across < 4 * shape.focal * height)


def _mesh(shape: Mesh, p: np.ndarray) -> np.ndarray:
    """The winding number; one that is negative counts as 0."""
    data = shape.data()
    triangles = fans(*joined(data.faces))
    out = np.zeros(len(p))
    near = ((p >= data.vertices.min(axis=0)) & (p <= data.vertices.max(axis=0))).all(axis=1)
    out[near] = winding_numbers(data.vertices, triangles, p[near])
    return np.maximum(out, 0)


# every shape that there is; None: it has no inside
_INSIDE: dict[type[Shape], Callable[[Any, np.ndarray], np.ndarray] | None] = {
    Polygon: None,
    Disk: None,
    Sphere: _sphere,
    Plane: _plane,
    Box: _box,
    Ellipsoid: _ellipsoid,
    Quadric: _quadric,
    Cylinder: _cone,
    Cone: _cone,
    Paraboloid: _paraboloid,
    Mesh: _mesh,
}
