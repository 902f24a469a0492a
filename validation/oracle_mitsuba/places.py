"""Where points of shapes lie in pictures, by docs/model.md, "Images": u, v and the ways in which they grow.

The ways are taken from u and v themselves, by differences along the surface, so that no formula of theirs
stands here. Meshes have u and v of their own, which Mitsuba interpolates.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from .hashing import basis
from .shapes import Box, Cone, Cylinder, Disk, Ellipsoid, Paraboloid, Plane, Polygon, Quadric, Shape, Sphere

Array = np.ndarray
STEP = 1e-5  # of the shape's size


@dataclass(frozen=True, eq=False)
class Chart:
    """Of n points u, v, and dp/du, dp/dv (n, 3) in world space, of any length."""

    u: Array
    v: Array
    du: Array
    dv: Array


def chart(shape: Shape, point: Array, outward: Array) -> Chart:
    """Of points (n, 3) of a shape that is no mesh, with outward unit normals (n, 3)."""
    linear = shape.matrix[:3, :3]
    own = (point - shape.matrix[:3, 3]) @ np.linalg.inv(linear).T
    normal = _unit(outward @ linear)
    if isinstance(shape, Quadric):  # the sphere's, of the normal
        own = normal
    across, up = basis(normal)
    # not so long that u grows by half a turn
    step = STEP * float(np.clip(np.ptp(own, axis=0).max(initial=0.0), 1e-3, 1e3))
    u, v = _PLACES[type(shape)](shape, own, normal)
    slopes = np.empty((len(own), 2, 2))  # of u and v along the two ways
    for number, way in enumerate((across, up)):
        ahead = _PLACES[type(shape)](shape, own + step * way, normal)
        behind = _PLACES[type(shape)](shape, own - step * way, normal)
        for row, (a, b) in enumerate(zip(ahead, behind, strict=True)):
            slopes[:, row, number] = (a - b - np.round(a - b)) / (2 * step)  # over the seam, too
    ways = np.stack([across, up], axis=1)
    with np.errstate(all="ignore"):
        a, b, c, d = (slopes[:, i, j, None] for i in (0, 1) for j in (0, 1))
        area = a * d - b * c
        du, dv = (d * ways[:, 0] - c * ways[:, 1]) / area, (a * ways[:, 1] - b * ways[:, 0]) / area
    return Chart(u, v, du @ linear.T, dv @ linear.T)


def _unit(v: Array) -> Array:
    return np.asarray(v / np.linalg.norm(v, axis=-1, keepdims=True))


def _turn(x: Array, y: Array) -> Array:
    return np.asarray(np.angle(x + 1j * y) / (2 * np.pi) % 1.0)


def _globe(way: Array) -> tuple[Array, Array]:
    x, y, z = way.T
    return _turn(x, y), np.arctan2(np.hypot(x, y), z) / np.pi


def _flat(normal: Any) -> tuple[Array, Array]:
    n = _unit(np.asarray(normal, float))
    axis = np.zeros(3)
    axis[np.argmin(np.abs(n))] = 1.0
    across = _unit(axis - (axis @ n) * n)
    return across, np.cross(n, across)


def _wheel(point: Array, center: Any, across: Array, up: Array, radius: float) -> tuple[Array, Array]:
    x, y = ((point - np.asarray(center, float)) @ way / radius for way in (across, up))
    return np.hypot(x, y), _turn(x, y)


def _round(shape: Sphere | Ellipsoid, own: Array, _: Array) -> tuple[Array, Array]:
    radii = shape.radii if isinstance(shape, Ellipsoid) else (shape.radius,) * 3
    return _globe((own - np.asarray(shape.center, float)) / np.asarray(radii, float))


def _quadric(_: Quadric, own: Array, __: Array) -> tuple[Array, Array]:
    return _globe(own)


def _disk(shape: Disk, own: Array, _: Array) -> tuple[Array, Array]:
    return _wheel(own, shape.center, *_flat(shape.normal), shape.radius)


def _body(shape: Cylinder | Cone, own: Array, normal: Array) -> tuple[Array, Array]:
    p0, p1 = np.asarray(shape.p0, float), np.asarray(shape.p1, float)
    radii = (shape.r0, shape.r1) if isinstance(shape, Cone) else (shape.radius, shape.radius)
    axis = _unit(p1 - p0)
    tangent, bitangent = (way[0] for way in basis(axis[None]))
    off = own - p0
    u, v = _turn(off @ tangent, off @ bitangent), off @ axis / np.linalg.norm(p1 - p0)
    for end, radius, side in ((p0, radii[0], -1.0), (p1, radii[1], 1.0)):
        cap = side * (normal @ axis) > 1 - 1e-6
        if radius > 0:
            here = _wheel(own, end, tangent, bitangent, radius)
            u, v = np.where(cap, here[0], u), np.where(cap, here[1], v)
    return u, v


def _bowl(shape: Paraboloid, own: Array, _: Array) -> tuple[Array, Array]:
    axis = _unit(np.asarray(shape.axis, float))
    tangent, bitangent = (way[0] for way in basis(axis[None]))
    off = own - np.asarray(shape.apex, float)
    return _turn(off @ tangent, off @ bitangent), off @ axis / shape.height


def _plane(shape: Plane, own: Array, _: Array) -> tuple[Array, Array]:
    across, up = _flat(shape.normal)
    off = own - np.asarray(shape.point, float)
    return off @ across, 1 - off @ up


def _polygon(shape: Polygon, own: Array, _: Array) -> tuple[Array, Array]:
    points = np.asarray(shape.points, float)
    local = points - points[0]
    across, up = _flat(np.sum(np.cross(local, np.roll(local, -1, axis=0)), axis=0))
    spans = [((points @ way).min(), np.ptp(points @ way)) for way in (across, up)]
    return (own @ across - spans[0][0]) / spans[0][1], 1 - (own @ up - spans[1][0]) / spans[1][1]


def _box(shape: Box, own: Array, normal: Array) -> tuple[Array, Array]:
    low, high = np.asarray(shape.min, float), np.asarray(shape.max, float)
    x, y, z = ((own - low) / (high - low)).T
    axis = np.argmax(np.abs(normal), axis=1)
    plus = normal[np.arange(len(own)), axis] > 0
    sides = [axis == 0, axis == 1, axis == 2]
    u = np.select(sides, [y, np.where(plus, 1 - x, z), np.where(plus, y, 1 - y)])
    v = np.select(sides, [np.where(plus, 1 - z, z), np.where(plus, 1 - z, x), x])
    return u, v


_PLACES: dict[type[Shape], Callable[[Any, Array, Array], tuple[Array, Array]]] = {
    Sphere: _round, Ellipsoid: _round, Quadric: _quadric, Disk: _disk, Cylinder: _body, Cone: _body,
    Paraboloid: _bowl, Plane: _plane, Polygon: _polygon, Box: _box,
}  # fmt: skip
