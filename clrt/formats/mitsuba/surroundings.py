"""The indices around glass: each boundary of Mitsuba's has its own, a scene one, and solids in others."""

from __future__ import annotations

import math
from typing import Any, Final

import numpy as np

from clrt.scene.scene import Mesh, Scene
from clrt.scene.shapes import Box, Cylinder, Disk, Polygon, Sphere

NESTED: Final = "that glass within glass has another ext_ior than the int_ior around it"
_MOST: Final = 1024  # solids, the largest ones, in which others are looked for
_NEAR: Final = 1e-6


def around(outside: dict[int, float], scene: Scene, left_out: dict[str, None]) -> None:
    """Name what of the indices around glass, by numbers of shapes, the scene has otherwise."""
    inside = {number: scene.material_of(scene.shapes[number]) for number in outside}
    indices = [material.ior for material in inside.values() if isinstance(material.ior, (int, float))]
    for index in {*outside.values()}:
        if index != scene.medium_ior and not any(math.isclose(index, ior, rel_tol=_NEAR) for ior in indices):
            left_out["more than one ext_ior"] = None
    found = {number: box for number in outside if (box := _box(scene.shapes[number])) is not None}
    if len(found) < 2:
        return
    numbers, (low, high) = [*found], np.array([*found.values()]).transpose(1, 0, 2)
    said = np.array([outside[number] for number in numbers])
    size = (high - low).prod(axis=1)
    for k in np.argsort(-size)[:_MOST].tolist():
        material = inside[numbers[k]]
        if material.thin or not isinstance(material.ior, (int, float)):
            continue
        within = (low > low[k]).all(axis=1) & (high < high[k]).all(axis=1)
        if (np.abs(said[within] - material.ior) > _NEAR * said[within]).any():
            left_out[NESTED] = None
            return


def _box(shape: Any) -> tuple[np.ndarray, np.ndarray] | None:
    """Around the surface of a shape as they are made of Mitsuba's; None where it has none."""
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
    if not len(points):
        return None
    points = points @ matrix[:3, :3].T + matrix[:3, 3]
    return points.min(axis=0), points.max(axis=0)
