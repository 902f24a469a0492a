"""Checks of plane polygons, for the polygon shape and for the n-gons of flat meshes."""

from __future__ import annotations

import math
from array import array
from collections.abc import Sequence

import numpy as np

from clrt.base.hints import Rows

FLATNESS = 1e-4
"""How far a polygon's points may lie off its plane, relative to its size (MODEL.md)."""

_POINTS = 1 << 16  # looked at together: ten arrays of their size are made


def newell(corners: np.ndarray) -> np.ndarray:
    """Newell's normals of (..., n, 3) polygons: twice the area long, to where they run counter-clockwise."""
    local = corners - corners[..., :1, :]  # differences first, so that far polygons lose nothing
    return np.cross(local, np.roll(local, -1, axis=-2)).sum(axis=-2)


def same_turn(points: list[list[float]]) -> bool:
    """Whether a polygon's first corner turns the way the whole outline does.

    Formats that take the normal from the first corner mean the other side where it does not.
    """
    if len(points) == 3:
        return True
    if len(points) <= 8:  # numpy takes far longer for so few
        x0, y0, z0 = points[0]
        local = [(x - x0, y - y0, z - z0) for x, y, z in points]
        (ax, ay, az), (bx, by, bz) = local[1:3]
        turn = (ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx)
        parts = [a * b for a, b in zip(turn, _newell_of(local), strict=True)]
        if abs(sum(parts)) > 1e-6 * sum(map(abs, parts)):  # far above what rounding does
            return sum(parts) > 0
    corners = np.array(points, np.float64)
    first = np.cross(corners[1] - corners[0], corners[2] - corners[1])
    return bool(first @ newell(corners) >= 0)


def clear_turn(points: Sequence[Sequence[float]]) -> int:
    """The first of a polygon's corners that clearly turns the way the whole outline does, as a start.

    Formats take the normal from the first three points: this is the corner before the one that turns.
    """
    corners = np.array(points, np.float64)
    edges = np.roll(corners, -1, axis=0) - corners
    turns = np.cross(edges, np.roll(edges, -1, axis=0)) @ newell(corners)
    return int(np.argmax(turns > 1e-9 * turns.max()))  # far above what rounding does


def _newell_of(points: Sequence[tuple[float, float, float]]) -> tuple[float, float, float]:
    """`newell` of a few points, the first of them at the origin."""
    nx = ny = nz = 0.0
    ax, ay, az = points[-1]
    for bx, by, bz in points:
        nx += ay * bz - az * by
        ny += az * bx - ax * bz
        nz += ax * by - ay * bx
        ax, ay, az = bx, by, bz
    return nx, ny, nz


def is_sound(points: Rows) -> bool:
    """Whether a polygon of few points is clearly without the flaws below (numpy takes far longer)."""
    if len(points) > 8:
        return False
    numbers = array("f", [x for point in points for x in point])
    x0, y0, z0 = numbers[:3]
    local = [
        (numbers[i] - x0, numbers[i + 1] - y0, numbers[i + 2] - z0) for i in range(0, len(numbers), 3)
    ]
    nx, ny, nz = _newell_of(local)
    reach = max(max(map(abs, point)) for point in local)  # the size is from this to 4 times it
    area = math.sqrt(nx * nx + ny * ny + nz * nz)
    if not area > 2e-6 * reach * reach:
        return False
    most = 0.1 * FLATNESS * reach * area
    return all(abs(x * nx + y * ny + z * nz) <= most for x, y, z in local)


def flaws(corners: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Which of (m, n, 3) polygons span no area (collinear points), and which are not plane."""
    step = max(1, _POINTS // max(corners.shape[1], 1))
    parts = [_flaws(corners[start : start + step]) for start in range(0, len(corners), step)]
    none = np.zeros(0, bool)
    return np.concatenate([none, *(p[0] for p in parts)]), np.concatenate([none, *(p[1] for p in parts)])


def _flaws(corners: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    normals = newell(corners)
    area = np.linalg.norm(normals, axis=-1)
    size = np.linalg.norm(np.ptp(corners, axis=-2), axis=-1)
    flat = area > 1e-7 * size**2
    units = normals / np.where(area > 0, area, 1.0)[:, None]
    off = np.einsum("mnk,mk->mn", corners - corners.mean(axis=-2, keepdims=True), units)
    return ~flat, flat & (np.abs(off).max(axis=-1) > FLATNESS * size)


def folded(vertices: np.ndarray, faces: np.ndarray) -> bool:
    """Whether triangles (m, 3) that a quadrilateral or a fan was cut into may lie on one another.

    They do where a concave outline was cut about the wrong corner, and triangles without area may hide it.
    The two of a quadrilateral stand one after the other, or all second ones after all first ones; those
    of a fan one after the other.
    """
    half = len(faces) // 2
    firsts = [(faces[:-1], faces[1:])] + [(faces[:half], faces[half:])] * (len(faces) == 2 * half)
    return any(
        _folded(vertices, one[start : start + _POINTS], two[start : start + _POINTS])
        for one, two in firsts
        for start in range(0, len(one), _POINTS)
    )


def _folded(vertices: np.ndarray, one: np.ndarray, two: np.ndarray) -> bool:
    a, b, c = one.T
    quad = (c == two[:, 0]) & (a == two[:, 2]) & (b != two[:, 1])
    fan = (a == two[:, 0]) & (c == two[:, 1]) & (b != two[:, 2])
    with np.errstate(all="ignore"):  # what is no number is refused later
        left, right = (newell(vertices[faces[quad | fan]]) for faces in (one, two))
        return bool(np.any(np.einsum("mk,mk->m", left, right) <= 0.0))
