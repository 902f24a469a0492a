"""The indices around glass: each boundary of Mitsuba's has its own, a scene one, and solids in others.

Whether a point is inside is asked here of the few shapes that files of Mitsuba's have: `clrt.flatten.inside`
stands above this room, and knows all.
"""

from __future__ import annotations

import math
from typing import Any, Final

import numpy as np

from clrt.scene.scene import Mesh, Scene
from clrt.scene.shapes import Box, Cylinder, Disk, Polygon, Sphere

NESTED: Final = "that glass within glass has another ext_ior than the int_ior around it"
_MOST: Final = 1024  # solids, the largest ones, in which others are looked for
_NEAR: Final = 1e-6
_WORK, _SHARE = 10_000, 256  # pairs that are looked at, for half a second; so many faces count as one


def around(outside: dict[int, float], scene: Scene, left_out: dict[str, None]) -> None:
    """Name what of the indices around glass, by numbers of shapes, the scene has otherwise."""
    inside = {number: scene.material_of(scene.shapes[number]) for number in outside}
    indices = [material.ior for material in inside.values() if isinstance(material.ior, (int, float))]
    for index in {*outside.values()}:
        if index != scene.medium_ior and not any(math.isclose(index, ior, rel_tol=_NEAR) for ior in indices):
            left_out["more than one ext_ior"] = None
    if len(outside) < 2:
        return
    numbers = [*outside]
    low, high = np.array([_box(scene.shapes[number]) for number in numbers]).transpose(1, 0, 2)
    said = np.array([outside[number] for number in numbers])
    size = (high - low).prod(axis=1)
    around_it: dict[int, int] = {}  # the smallest solid that a shape lies in
    left = _WORK
    for k in np.argsort(-size)[:_MOST].tolist():
        if inside[numbers[k]].thin or scene.shapes[numbers[k]].is_open:
            continue
        within = np.flatnonzero((low > low[k]).all(axis=1) & (high < high[k]).all(axis=1))
        for other in within.tolist():
            left -= 1 + scene.shapes[numbers[k]].primitives // _SHARE
            if left < 0:  # of more nobody is told
                return
            if _encloses(scene.shapes[numbers[k]], _point(scene.shapes[numbers[other]])):
                around_it[other] = k
    for other, k in around_it.items():
        there = inside[numbers[k]].ior
        if isinstance(there, (int, float)) and not math.isclose(said[other], there, rel_tol=_NEAR):
            left_out[NESTED] = None
            return


def _encloses(shape: Any, point: np.ndarray) -> bool:
    """Whether a point of the world is within a solid."""
    if isinstance(shape, Mesh):
        matrix = np.asarray(shape.matrix, np.float64)
        corners = shape.data().vertices @ matrix[:3, :3].T + matrix[:3, 3] - point
        return _turns(corners[np.asarray(shape.data().faces)]) > 0.5
    x = (np.linalg.inv(np.asarray(shape.matrix, np.float64)) @ [*point, 1.0])[:3]
    if isinstance(shape, Sphere):
        return bool(np.linalg.norm(x - np.array(shape.center)) < shape.radius)
    assert isinstance(shape, Box)
    return bool((x > shape.min).all() and (x < shape.max).all())


def _turns(corners: np.ndarray) -> float:
    """How often triangles (n, 3, 3) are around the origin, whichever side is out: their solid angles over
    4 pi (van Oosterom and Strackee, 1983)."""
    a, b, c = corners.transpose(1, 0, 2)
    x, y, z = (np.linalg.norm(corner, axis=1) for corner in (a, b, c))
    volume = np.einsum("ij,ij->i", a, np.cross(b, c))
    rest = x * y * z + np.einsum("ij,ij->i", a, b) * z + np.einsum("ij,ij->i", b, c) * x
    rest += np.einsum("ij,ij->i", c, a) * y
    return float(abs(np.arctan2(volume, rest).sum())) / (2 * math.pi)


def _point(shape: Any) -> np.ndarray:
    """One of its surface, in the world."""
    matrix = np.asarray(shape.matrix, np.float64)
    if isinstance(shape, Mesh):
        local = np.asarray(shape.data().vertices[np.asarray(shape.data().faces)[0]]).mean(axis=0)
    elif isinstance(shape, (Sphere, Disk)):
        local = np.array(shape.center, np.float64)
        local += (shape.radius, 0.0, 0.0) if isinstance(shape, Sphere) else (0.0, 0.0, 0.0)
    elif isinstance(shape, Box):
        local = np.array([shape.max[0], shape.min[1], shape.min[2]], np.float64)
    else:
        points = [shape.p0] if isinstance(shape, Cylinder) else shape.points
        local = np.array(points, np.float64).mean(axis=0)
    placed: np.ndarray = matrix[:3, :3] @ local + matrix[:3, 3]
    return placed


def _box(shape: Any) -> tuple[np.ndarray, np.ndarray]:
    """Around the surface of a shape as they are made of Mitsuba's."""
    matrix = np.asarray(shape.matrix, np.float64)
    if isinstance(shape, Mesh):
        points = np.asarray(shape.data().vertices, np.float64)
    elif isinstance(shape, Box):
        points = np.array(np.meshgrid(*zip(shape.min, shape.max, strict=True))).reshape(3, -1).T
    elif isinstance(shape, Polygon):
        points = np.asarray(shape.points, np.float64)
    elif isinstance(shape, (Sphere, Disk)):
        half = np.linalg.norm(matrix[:3, :3], axis=1) * shape.radius
        middle = matrix[:3, :3] @ np.asarray(shape.center, np.float64) + matrix[:3, 3]
        return middle - half, middle + half
    else:
        assert isinstance(shape, Cylinder)
        ends = np.array([shape.p0, shape.p1], np.float64) @ matrix[:3, :3].T + matrix[:3, 3]
        half = np.linalg.norm(matrix[:3, :3], axis=1) * shape.radius
        return ends.min(axis=0) - half, ends.max(axis=0) + half
    points = points @ matrix[:3, :3].T + matrix[:3, 3]
    return points.min(axis=0), points.max(axis=0)
