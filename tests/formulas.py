"""Surfaces by formula: how far a point is off a shape, and the outward normal there."""

from __future__ import annotations

from typing import Any

import numpy as np

from tests.engines import unit

# corners of a box's sides -x +x -y +y -z +z: any point of the side, its outward normal
SIDES = np.concatenate([[-axis, axis] for axis in np.eye(3)])


def surface(keys: dict[str, Any], primitive: int, x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """F (n,) and its gradient (n, 3), which points outwards, at points x (n, 3) of the shape's own space."""
    kind = keys["type"]
    if kind == "sphere":
        offset = x - keys["center"]
        return _square(offset) - keys["radius"] ** 2, 2 * offset
    if kind == "ellipsoid":
        offset = (x - keys["center"]) / np.square(keys["radii"])
        return np.einsum("ni,ni->n", offset, x - np.array(keys["center"])) - 1, 2 * offset
    if kind == "quadric":
        return _form(keys["coefficients"], x)
    if kind == "paraboloid":
        h, across = _cylindrical(x, keys["apex"], unit(keys["axis"]))
        return _square(across) - 4 * keys["focal"] * h, 2 * across - 4 * keys["focal"] * unit(keys["axis"])
    if kind in ("cylinder", "cone"):
        return _cone(keys, primitive, x)
    point, normal = _plane(keys, primitive)
    return (x - point) @ unit(normal), np.broadcast_to(unit(normal), x.shape)


def _square(x: np.ndarray) -> np.ndarray:
    return np.asarray(np.einsum("ni,ni->n", x, x))


def _cylindrical(x: np.ndarray, origin: Any, axis: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Height along an axis, and the offset (n, 3) from it."""
    h = (x - origin) @ axis
    return h, x - origin - h[:, None] * axis


def _form(coefficients: Any, x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    a, b, c, d, e, f, g, h, i, j = coefficients
    q, linear = np.array([[a, d, f], [d, b, e], [f, e, c]]), np.array([g, h, i])
    return np.einsum("ni,ij,nj->n", x, q, x) + 2 * x @ linear + j, 2 * (x @ q + linear)


def _cone(keys: dict[str, Any], primitive: int, x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    p0, p1 = np.array(keys["p0"], float), np.array(keys["p1"], float)
    r0, r1 = (keys["r0"], keys["r1"]) if "r0" in keys else (keys["radius"],) * 2
    axis, slope = unit(p1 - p0), (r1 - r0) / np.linalg.norm(p1 - p0)
    if primitive > 0:
        end, normal = ((p0, -axis), (p1, axis))[primitive - 1]
        return (x - end) @ normal, np.broadcast_to(normal, x.shape)
    h, across = _cylindrical(x, p0, axis)
    radius = r0 + slope * h
    return _square(across) - radius**2, 2 * across - 2 * (slope * radius)[:, None] * axis


def _plane(keys: dict[str, Any], primitive: int) -> tuple[np.ndarray, np.ndarray]:
    """A point and the outward normal of a flat primitive."""
    if keys["type"] == "plane":
        return np.array(keys["point"], float), np.array(keys["normal"], float)
    if keys["type"] == "disk":
        return np.array(keys["center"], float), np.array(keys["normal"], float)
    if keys["type"] == "box":
        side = SIDES[primitive]
        return np.array(keys["max"] if side.sum() > 0 else keys["min"], float), side
    corners = (
        keys["points"]
        if keys["type"] == "polygon"
        else np.take(keys["vertices"], keys["faces"][primitive], 0)
    )
    a, b, c = np.asarray(corners, float)[:3]  # the first corner of each is convex
    return a, np.cross(b - a, c - a)
