"""In which media rays start: docs/model.md, "Media", for points in the world."""

from __future__ import annotations

from typing import Any

import numpy as np

from . import faces, forms, shapes
from .records import Scene

Array = np.ndarray
AT_A_TIME = 1 << 20  # pairs of points and triangles


State = tuple[int, ...]


def starting(scene: Scene, number: Array, points: Array) -> tuple[list[State], Array]:
    """The lists of media that rays from points (n, 3) start in, as a ray entered them: of the largest box
    first; and which of them each point has (n,). The first list is empty: the surroundings.

    number (shapes,): the medium that a shape bounds, or -1.
    """
    bounding = [i for i in range(len(scene.shapes)) if number[i] >= 0]
    bounding = [i for i in bounding if not isinstance(scene.shapes[i], (shapes.Polygon, shapes.Disk))]
    bounding.sort(key=lambda i: -_volume(scene.shapes[i]))  # equal ones stay in the order of their numbers
    if not bounding:
        return [()], np.zeros(len(points), int)
    distinct, place = np.unique(points, axis=0, return_inverse=True)
    times = np.stack([_times(scene.shapes[i], distinct) for i in bounding], axis=1)
    rows, which = np.unique(times, axis=0, return_inverse=True)
    each = [tuple(int(number[i]) for i, count in zip(bounding, row, strict=True) for _ in range(count))
            for row in rows]  # fmt: skip
    states = list(dict.fromkeys([(), *each]))
    return states, np.array([states.index(state) for state in each])[which.ravel()][place.ravel()]


def _times(shape: Any, points: Array) -> Array:
    """How often the shape is around points (n, 3): 0 or 1, but for meshes."""
    to_object = np.linalg.inv(shape.matrix)
    local = points @ to_object[:3, :3].T + to_object[:3, 3]
    if isinstance(shape, shapes.Mesh):
        return _winding(faces.triangles(shape)[0], points)
    return _is_within(shape, local).astype(int)


def _is_within(shape: Any, p: Array) -> Array:
    if isinstance(shape, shapes.Plane):
        return (p - np.array(shape.point)) @ np.array(shape.normal, float) < 0
    if isinstance(shape, shapes.Box):
        return np.all((np.array(shape.min) < p) & (p < np.array(shape.max)), axis=1)
    if isinstance(shape, shapes.Quadric):
        h = np.c_[p, np.ones(len(p))]
        below = np.einsum("ni,ij,nj->n", h, forms.matrix(shape.coefficients), h) < 0
        if shape.clip is not None:
            low, high = np.array(shape.clip, float)
            below &= np.all((low <= p) & (p <= high), axis=1)
        return np.asarray(below)
    if isinstance(shape, (shapes.Sphere, shapes.Ellipsoid)):
        radii = shape.radius if isinstance(shape, shapes.Sphere) else np.array(shape.radii)
        return np.linalg.norm((p - np.array(shape.center)) / radii, axis=1) < 1
    if isinstance(shape, shapes.Paraboloid):
        start, axis, length = shape.apex, np.array(shape.axis, float), shape.height
    else:
        start, axis = shape.p0, np.subtract(shape.p1, shape.p0)
        length = np.linalg.norm(axis)
    axis = axis / np.linalg.norm(axis)
    along = (p - np.array(start)) @ axis
    away = np.linalg.norm(np.cross(p - np.array(start), axis), axis=1)
    if isinstance(shape, shapes.Paraboloid):
        radius = np.sqrt(np.maximum(4 * shape.focal * along, 0))
    elif isinstance(shape, shapes.Cone):
        radius = shape.r0 + (shape.r1 - shape.r0) * along / length
    else:
        radius = np.full(len(p), shape.radius)
    return (along > 0) & (along < length) & (away < radius)


def _winding(mesh: Any, points: Array) -> Array:
    """The winding number: solid angles of the triangles over 4 pi (van Oosterom and Strackee 1983)."""
    total = np.zeros(len(points))
    rows = max(1, AT_A_TIME // max(len(mesh.faces), 1))
    for begin in range(0, len(points), rows):
        some = slice(begin, begin + rows)
        a, b, c = (mesh.vertices[mesh.faces[:, k]] - points[some, None] for k in range(3))
        la, lb, lc = (np.linalg.norm(v, axis=2) for v in (a, b, c))
        volume = np.sum(a * np.cross(b, c), axis=2)
        rest = la * lb * lc + np.sum(a * b, 2) * lc + np.sum(a * c, 2) * lb + np.sum(b * c, 2) * la
        total[some] = np.arctan2(volume, rest).sum(axis=1) / (2 * np.pi)
    return np.maximum(np.rint(total), 0).astype(int)


def _volume(shape: Any) -> float:
    """Of the shape's box in the world; infinite where it has no end."""
    low, high = _box(shape)
    return float(np.prod(high - low))


def _box(shape: Any) -> tuple[Array, Array]:
    """Lowest and highest x, y, z of the surface."""
    matrix = shape.matrix
    if isinstance(shape, shapes.Plane):
        return np.full(3, -np.inf), np.full(3, np.inf)
    if isinstance(shape, shapes.Mesh):
        return _around(np.asarray(shape.data().vertices), matrix)
    if isinstance(shape, shapes.Box):
        return _around(_corners(shape.min, shape.max), matrix)
    if isinstance(shape, (shapes.Sphere, shapes.Ellipsoid)):
        radii = np.broadcast_to(shape.radius if isinstance(shape, shapes.Sphere) else shape.radii, 3)
        placed = matrix @ np.array([*np.c_[np.diag(radii), shape.center], [0, 0, 0, 1]])
        return _ball(placed)
    if isinstance(shape, shapes.Quadric):
        if shape.clip is not None:
            return _around(_corners(*shape.clip), matrix)
        frame = forms.ellipsoid_frame(shape.coefficients)
        return _ball(matrix @ frame[0]) if frame is not None else (np.full(3, -np.inf), np.full(3, np.inf))
    if isinstance(shape, shapes.Paraboloid):
        axis = np.array(shape.axis, float) / np.linalg.norm(shape.axis)
        rim = np.array(shape.apex) + shape.height * axis
        return _around(
            np.r_[[shape.apex], _circle(rim, axis, 2 * np.sqrt(shape.focal * shape.height))], matrix
        )
    axis = np.subtract(shape.p1, shape.p0)
    r0, r1 = (shape.r0, shape.r1) if isinstance(shape, shapes.Cone) else (shape.radius, shape.radius)
    return _around(np.r_[_circle(shape.p0, axis, r0), _circle(shape.p1, axis, r1)], matrix)


def _ball(matrix: Array) -> tuple[Array, Array]:
    """The box of the unit sphere under a matrix (4, 4)."""
    half = np.linalg.norm(matrix[:3, :3], axis=1)
    return matrix[:3, 3] - half, matrix[:3, 3] + half


def _around(points: Array, matrix: Array) -> tuple[Array, Array]:
    placed = points @ matrix[:3, :3].T + matrix[:3, 3]
    return placed.min(axis=0), placed.max(axis=0)


def _corners(low: Any, high: Any) -> Array:
    return np.array(np.meshgrid(*zip(low, high, strict=True))).reshape(3, -1).T


def _circle(center: Any, axis: Array, radius: float) -> Array:
    """Points (720, 3) on a circle."""
    z = np.asarray(axis, float) / np.linalg.norm(axis)
    x = np.cross(z, np.eye(3)[np.argmin(np.abs(z))])
    x /= np.linalg.norm(x)
    angle = np.radians(np.arange(0, 360, 0.5))[:, None]
    return np.asarray(center) + radius * (np.cos(angle) * x + np.sin(angle) * np.cross(z, x))
