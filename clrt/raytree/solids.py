"""Shapes as triangles, to be looked at: round ones by flat pieces, endless ones cut off."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Final

import numpy as np

from clrt.meshfiles.outlines import Outlines
from clrt.raytree.ears import clipped
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

Triangles = tuple[np.ndarray, np.ndarray]  # vertices (n, 3) float64; faces (m, 3)

FINE, COARSE = 48, 12  # pieces of a circle
_BOX: Final = np.array([[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]])
# a cell's six tetrahedra around its diagonal: corner i is at its maximum on x, y, z where bit 0, 1, 2 is set
_TETRAHEDRA: Final = np.array(
    [[0, 1, 3, 7], [0, 3, 2, 7], [0, 2, 6, 7], [0, 6, 4, 7], [0, 4, 5, 7], [0, 5, 1, 7]]
)


def triangles_of(shape: Shape, low: np.ndarray, high: np.ndarray, around: int = FINE) -> Triangles | None:
    """A shape in world space; planes and endless quadrics as far as the box from low to high (3,) reaches.

    around: how many pieces a circle has. None for a shape that has no part there, or of a kind that this
    does not know.
    """
    make = _MAKE.get(type(shape))
    if make is None:
        return None
    vertices, faces = make(shape, low, high, around)
    matrix = shape.matrix
    vertices = vertices @ matrix[:3, :3].T + matrix[:3, 3]
    faces = faces[:, ::-1] if np.linalg.det(matrix[:3, :3]) < 0 else faces  # the outer side stays so
    return (vertices, faces) if len(faces) and np.isfinite(vertices).all() else None


def _ball(center: Any, radii: Any, around: int) -> Triangles:
    turn, up = np.meshgrid(np.linspace(0, 2 * np.pi, around + 1), np.linspace(0, np.pi, around // 2 + 1))
    unit = np.stack([np.sin(up) * np.cos(turn), np.cos(up), np.sin(up) * np.sin(turn)], axis=-1)
    return np.asarray(center) + unit.reshape(-1, 3) * radii, _grid_faces(*up.shape)


def _grid_faces(rows: int, columns: int) -> np.ndarray:
    """Triangles of a grid of points in rows."""
    at = np.arange(rows * columns).reshape(rows, columns)
    a, b, c, d = at[:-1, :-1].ravel(), at[:-1, 1:].ravel(), at[1:, 1:].ravel(), at[1:, :-1].ravel()
    return np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)])


def _turned(start: Any, axis: np.ndarray, heights: np.ndarray, radii: np.ndarray, around: int) -> Triangles:
    """Circles of these radii at these heights along a unit axis, joined."""
    one = np.cross(axis, np.eye(3)[np.argmin(np.abs(axis))])
    one /= np.linalg.norm(one)
    angle = np.linspace(0, 2 * np.pi, around + 1)
    ring = np.cos(angle)[:, None] * one + np.sin(angle)[:, None] * np.cross(axis, one)
    points = np.asarray(start) + heights[:, None, None] * axis + radii[:, None, None] * ring
    return points.reshape(-1, 3), _grid_faces(len(heights), len(angle))


def _cone(shape: Any, low: np.ndarray, high: np.ndarray, around: int) -> Triangles:
    r0, r1 = (shape.r0, shape.r1) if isinstance(shape, Cone) else (shape.radius, shape.radius)
    axis = np.subtract(shape.p1, shape.p0)
    length = float(np.linalg.norm(axis))
    heights, radii = [0.0, length], [r0, r1]
    if shape.caps:
        heights, radii = [0.0, *heights, length], [0.0, *radii, 0.0]
    return _turned(shape.p0, axis / length, np.array(heights), np.array(radii), around)


def _paraboloid(shape: Any, low: np.ndarray, high: np.ndarray, around: int) -> Triangles:
    heights = shape.height * np.linspace(0, 1, around // 2) ** 2
    axis = np.asarray(shape.axis) / np.linalg.norm(shape.axis)
    return _turned(shape.apex, axis, heights, np.sqrt(4 * shape.focal * heights), around)


def _disk(shape: Any, low: np.ndarray, high: np.ndarray, around: int) -> Triangles:
    normal = np.asarray(shape.normal) / np.linalg.norm(shape.normal)
    return _turned(shape.center, normal, np.zeros(2), np.array([shape.radius, 0.0]), around)


def _plane(shape: Any, low: np.ndarray, high: np.ndarray, around: int) -> Triangles:
    """A square that is as wide as the box, below its middle."""
    normal = np.asarray(shape.normal) / np.linalg.norm(shape.normal)
    middle, size = (low + high) / 2, float(np.linalg.norm(high - low)) / 2
    middle = middle - normal * np.dot(middle - shape.point, normal)
    one = np.cross(normal, np.eye(3)[np.argmin(np.abs(normal))])
    one *= size / np.linalg.norm(one)
    other = np.cross(normal, one)
    return middle + np.stack([-one - other, one - other, one + other, other - one]), _FAN4


def _polygon(shape: Any, low: np.ndarray, high: np.ndarray, around: int) -> Triangles:
    points = np.asarray(shape.points, float)
    return points, Outlines(clipped).triangles(points, [np.arange(len(points))])


def _box(shape: Any, low: np.ndarray, high: np.ndarray, around: int) -> Triangles:
    corners = np.array([[i & 1, i >> 1 & 1, i >> 2] for i in range(8)])
    return np.where(corners, shape.max, shape.min), _BOX[:, [[0, 1, 2], [0, 2, 3]]].reshape(-1, 3)


def _mesh(shape: Any, low: np.ndarray, high: np.ndarray, around: int) -> Triangles:
    data = shape.data()
    if isinstance(data.faces, np.ndarray) and data.faces.shape[1:] == (3,):
        return data.vertices, data.faces
    return data.vertices, Outlines(clipped).triangles(data.vertices, data.faces)


def _quadric(shape: Any, low: np.ndarray, high: np.ndarray, around: int) -> Triangles:
    """Where the form is 0, by tetrahedra (Doi and Koide 1991) over its clip or the box, in its own space."""
    if shape.clip is not None:
        low, high = (np.asarray(corner, float) for corner in shape.clip)
    else:
        back = np.linalg.inv(shape.matrix)
        corners = np.array([[i & 1, i >> 1 & 1, i >> 2] for i in range(8)])
        box = np.where(corners, high, low) @ back[:3, :3].T + back[:3, 3]
        low, high = box.min(axis=0), box.max(axis=0)
    cells = 7 * around // 12  # across
    side = np.linspace(0, 1, cells + 1)
    grid = np.stack(np.meshgrid(side, side, side, indexing="ij"), axis=-1).reshape(-1, 3)
    x, y, z = (low + grid * (high - low)).T
    a, b, c, d, e, f, g, h, i, j = shape.coefficients
    form = a * x * x + b * y * y + c * z * z + 2 * (d * x * y + e * y * z + f * x * z)
    form += 2 * (g * x + h * y + i * z) + j
    step = np.array([(cells + 1) ** 2, cells + 1, 1])
    cell = np.stack(np.meshgrid(*[np.arange(cells)] * 3, indexing="ij"), -1).reshape(-1, 3) @ step
    offsets = np.array([[k & 1, k >> 1 & 1, k >> 2] for k in range(8)]) @ step
    corners4 = (cell[:, None, None] + offsets[_TETRAHEDRA]).reshape(-1, 4)
    inside = form[corners4] < 0
    place = np.take_along_axis(corners4, np.argsort(~inside, axis=1, kind="stable"), axis=1)  # inside first
    many, found = inside.sum(axis=1), []
    for count, edges in ((1, [[(0, 1), (0, 2), (0, 3)]]), (3, [[(3, 0), (3, 1), (3, 2)]]),
                         (2, [[(0, 2), (0, 3), (1, 3)], [(0, 2), (1, 3), (1, 2)]])):  # fmt: skip
        tetrahedra = place[many == count]
        for triangle in edges:
            ends = tetrahedra[:, np.array(triangle)]  # (k, 3 corners, 2 ends)
            f0, f1 = form[ends[..., 0]], form[ends[..., 1]]
            share = (f0 / (f0 - f1))[..., None]
            points = np.stack([x, y, z], axis=-1)
            found.append(points[ends[..., 0]] * (1 - share) + points[ends[..., 1]] * share)
    vertices = np.concatenate(found).reshape(-1, 3)
    return vertices, np.arange(len(vertices)).reshape(-1, 3)


_FAN4: Final = np.array([[0, 1, 2], [0, 2, 3]])
_MAKE: Final[dict[type[Shape], Callable[[Any, np.ndarray, np.ndarray, int], Triangles]]] = {
    Sphere: lambda shape, low, high, around: _ball(shape.center, shape.radius, around),
    Ellipsoid: lambda shape, low, high, around: _ball(shape.center, shape.radii, around),
    Cylinder: _cone,
    Cone: _cone,
    Paraboloid: _paraboloid,
    Disk: _disk,
    Plane: _plane,
    Polygon: _polygon,
    Box: _box,
    Mesh: _mesh,
    Quadric: _quadric,
}
