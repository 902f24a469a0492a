"""Triangles for what Mitsuba has no plugin for: cones, paraboloids, general quadrics, polygons of any
outline.

Curved meshes have their corners on the surface and the surface's own normals there. With n segments around, a
mesh lies within r (pi/n)^2 / 2 of a surface of radius of curvature r.
"""

from __future__ import annotations

from dataclasses import dataclass
from importlib import import_module
from itertools import accumulate
from typing import Any

import numpy as np

from .forms import Array

_TOGETHER = 256  # points that are looked at together


@dataclass(frozen=True, eq=False)
class Triangles:
    """`vertices` and `normals` (n, 3), `faces` (m, 3)."""

    vertices: Array
    faces: Array
    normals: Array
    uv: Array | None = None  # (n, 2), where it has pictures
    colors: Array | None = None  # of vertices (n, 3) or faces (m, 3), linear, where it has some


def turned(columns: int, radii: Array, heights: Array) -> tuple[Array, Array]:
    """Corners (n, 3) and outward triangles (m, 3) between circles about z, heights rising.

    The corners of circle i are i (columns + 1) to i (columns + 1) + columns, the last one where the first is.
    """
    angle = 2 * np.pi * np.arange(columns + 1) / columns
    cos, sin = np.cos(angle), np.sin(angle)
    cos[-1], sin[-1] = 1.0, 0.0  # the seam closes
    columns_of = (radii[:, None] * cos, radii[:, None] * sin, heights[:, None])
    vertices = np.stack(np.broadcast_arrays(*columns_of), -1).reshape(-1, 3)
    corner = (np.arange(len(radii) - 1)[:, None] * (columns + 1) + np.arange(columns)).ravel()
    right, up = corner + 1, corner + columns + 1
    faces = np.concatenate([np.stack([corner, right, up + 1], -1), np.stack([corner, up + 1, up], -1)])
    return vertices, spanning(vertices, faces)


def cone(r0: float, r1: float, segments: int, rows: int, margin: float) -> Triangles:
    """The lateral surface x^2 + y^2 = (r0 + (r1 - r0) z)^2 for 0 <= z <= 1.

    With a `margin` it goes as far beyond its rims, and lies around the surface.

    Where a row of quads narrows, normals that its triangles interpolate are off by a share of a segment's
    angle: radii fall by one factor from row to row.
    """
    k = r1 - r0
    heights = np.array([-margin if r0 > 0 else 0.0, 1.0 + margin if r1 > 0 else 1.0])
    if k != 0:
        apex = -r0 / k  # the margin ends there
        heights = np.clip(heights, apex, None) if apex <= 0 else np.clip(heights, None, apex)
        ends = np.maximum(r0 + k * heights, 0.0)
        first, last = np.maximum(ends, 2e-3 * ends.max())
        radii = np.geomspace(first, last, rows + 1)
        radii[0], radii[-1] = ends
        heights = (radii - r0) / k
    outside = 1 / np.cos(np.pi / segments) if margin > 0 else 1.0
    vertices, faces = turned(segments, outside * np.maximum(r0 + k * heights, 0.0), heights)
    angle = 2 * np.pi * np.arange(segments + 1) / segments
    normals = np.stack([np.cos(angle), np.sin(angle), np.full_like(angle, -k)], -1)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    return Triangles(vertices, faces, np.tile(normals, (len(heights), 1)))


def sphere(segments: int, around: bool = False) -> Triangles:
    """The unit sphere; `around`: the mesh lies around it and touches it."""
    angle = np.pi * np.arange(segments // 2 + 1) / (segments // 2)
    vertices, faces = turned(segments, np.where(angle < np.pi, np.sin(angle), 0.0), -np.cos(angle))
    return Triangles(vertices / np.cos(np.pi / segments) ** 2 if around else vertices, faces, vertices)


def paraboloid(segments: int, margin: float) -> Triangles:
    """x^2 + y^2 = z for 0 <= z <= 1 + margin."""
    radii = np.linspace(0.0, np.sqrt(1.0 + margin), segments // 4 + 1)
    vertices, faces = turned(segments, radii, radii**2)
    normals = 2 * vertices
    normals[:, 2] = -1.0
    return Triangles(vertices, faces, normals / np.linalg.norm(normals, axis=1, keepdims=True))


def quadric(q: Array, axes: tuple[Array, Array, Array]) -> Triangles | None:
    """p' q p = 0 by marching cubes on the grid of three increasing `axes`; None where no cell is crossed.

    Corners are exact: along the edge of a cell the form is a quadratic whose root is known.
    """
    x, y, z = np.meshgrid(*axes, indexing="ij", sparse=True)
    value = (
        q[0, 0] * x * x + q[1, 1] * y * y + q[2, 2] * z * z + 2 * (q[0, 1] * x * y + q[1, 2] * y * z)
        + 2 * (q[0, 2] * x * z + q[0, 3] * x + q[1, 3] * y + q[2, 3] * z) + q[3, 3]
    )  # fmt: skip
    if not (value.min() < 0 < value.max()):
        return None
    measure = import_module("skimage.measure")
    signs = np.where(value < 0, -1.0, 1.0)  # corners half way along edges: which edge is then certain
    places, faces, _, _ = measure.marching_cubes(signs, 0.0)
    vertices = _on_edges(q, axes, places)
    normals = 2 * (vertices @ q[:3, :3] + q[:3, 3])
    length = np.linalg.norm(normals, axis=1, keepdims=True)
    normals = np.where(length > 0, normals / np.where(length > 0, length, 1.0), (0.0, 0.0, 1.0))
    faces = spanning(vertices, np.asarray(faces))
    across = np.cross(
        vertices[faces[:, 1]] - vertices[faces[:, 0]], vertices[faces[:, 2]] - vertices[faces[:, 0]]
    )
    inverted = np.einsum("mk,mk->m", across, normals[faces].sum(axis=1)) < 0
    faces[inverted] = faces[inverted][:, ::-1]
    return Triangles(vertices, faces, normals)


def _on_edges(q: Array, axes: tuple[Array, Array, Array], places: Array) -> Array:
    """Points (n, 3) where the form vanishes on the grid edges around grid places (n, 3)."""
    axis = np.argmax(np.abs(places - np.round(places)), axis=1)
    rows = np.arange(len(places))
    first = np.round(places).astype(int)
    first[rows, axis] = np.floor(places[rows, axis]).astype(int)
    second = first.copy()
    second[rows, axis] = np.minimum(first[rows, axis] + 1, np.array([len(a) for a in axes])[axis] - 1)
    start, end = (np.stack([axes[k][corner[:, k]] for k in range(3)], -1) for corner in (first, second))
    step = end - start
    a = np.einsum("ni,ij,nj->n", step, q[:3, :3], step)
    b = 2 * np.einsum("ni,ni->n", step, start @ q[:3, :3] + q[:3, 3])
    c = np.einsum("ni,ij,nj->n", start, q[:3, :3], start) + 2 * start @ q[:3, 3] + q[3, 3]
    with np.errstate(all="ignore"):
        stable = -0.5 * (b + np.where(b < 0, -1.0, 1.0) * np.sqrt(np.maximum(b * b - 4 * a * c, 0.0)))
        roots = np.stack([stable / a, c / stable], -1)
    inside = np.isfinite(roots) & (roots >= -1e-9) & (roots <= 1 + 1e-9)
    along = np.where(inside[:, 0], roots[:, 0], np.where(inside[:, 1], roots[:, 1], 0.5))
    return np.asarray(start + np.clip(along, 0.0, 1.0)[:, None] * step)


def spanning(vertices: Array, faces: Array) -> Array:
    """The faces that have an area."""
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    across = np.cross(b - a, c - a)
    return faces[np.einsum("mk,mk->m", across, across) > 0]


def polygon(points: Array) -> tuple[Array, Array]:
    """Corners (n, 3) and triangles (m, 3) of a plane polygon (k, 3), even-odd where it crosses itself.

    Triangles run as the polygon does (counter-clockwise about Newell's normal).
    """
    local = points - points[0]
    normal = np.sum(np.cross(local, np.roll(local, -1, axis=0)), axis=0)
    normal /= np.linalg.norm(normal)
    if len(points) == 3:
        return points, np.array([[0, 1, 2]])
    across = local[np.argmax(np.linalg.norm(local, axis=1))]
    across = across - (across @ normal) * normal
    across /= np.linalg.norm(across)
    up = np.cross(normal, across)
    flat = np.stack([local @ across, local @ up], -1)
    simple, pieces = _even_odd(flat)
    ears = import_module("mapbox_earcut").triangulate_float64
    found, count = [], 0
    for rings in pieces:
        ends = np.array([*accumulate(map(len, rings))], np.uint32)
        found.append(ears(np.concatenate(rings), ends).astype(int) + count)
        count += int(ends[-1])
    plane = np.concatenate([ring for rings in pieces for ring in rings])
    triangles = np.concatenate(found).reshape(-1, 3)
    a, b, c = (plane[triangles[:, k]] for k in range(3))
    area = (b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0]
    triangles[area < 0] = triangles[area < 0][:, ::-1]
    # the polygon's own corners, bit for bit, where it has not been cut
    places = points if simple else points[0] + plane[:, :1] * across + plane[:, 1:] * up
    return places, triangles[area != 0]


def _even_odd(flat: Array) -> tuple[bool, list[list[Array]]]:
    """Whether an outline (k, 2) is simple, and its pieces: rings, the outer one first, of what is inside."""
    geometry: Any = import_module("shapely")
    ring = geometry.Polygon(flat)
    if ring.is_valid:
        return True, [[flat]]
    lines = geometry.unary_union(geometry.LineString([*flat, flat[0]]))
    cells = geometry.get_parts(geometry.polygonize([lines]))
    places = geometry.get_coordinates(geometry.point_on_surface(cells))
    rings, owner = geometry.get_rings(cells[_crossings(flat, places) % 2 == 1], return_index=True)
    corners, ring = geometry.get_coordinates(rings, return_index=True)
    outlines = np.split(corners, np.flatnonzero(np.diff(ring)) + 1)
    pieces: list[list[Array]] = [[] for _ in range(owner[-1] + 1)]
    for number, outline in zip(owner.tolist(), outlines, strict=True):
        pieces[number].append(outline[:-1])
    return False, pieces


def _crossings(flat: Array, points: Array) -> Array:
    """How many edges of the outline a ray to the right crosses, from each of the points (m, 2)."""
    (ax, ay), (bx, by) = flat.T, np.roll(flat, -1, axis=0).T
    count = np.zeros(len(points), np.int64)
    for start in range(0, len(points), _TOGETHER):
        x, y = points[start : start + _TOGETHER].T[:, :, None]
        with np.errstate(all="ignore"):
            beyond = ax + (bx - ax) * (y - ay) / (by - ay) > x
        count[start : start + _TOGETHER] = (((ay > y) != (by > y)) & beyond).sum(axis=1)
    return count
