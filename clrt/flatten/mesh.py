"""Meshes and polygons as the device reads them, all faces of a mesh (or all polygons of a scene) at once."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np

from clrt import layout
from clrt.scene.mesh import MeshData

_ROWS: Final = 1 << 15  # triangles treated at once: what fits the cache
IDENTITY: Final = np.eye(4)
"""The matrix of what has no transform: known by what it is, for scenes of many small meshes."""


def world_points(points: np.ndarray, matrix: np.ndarray) -> np.ndarray:
    """Points (n, 3) through a (4, 4) matrix, in float64."""
    if matrix is IDENTITY:
        return points + 0.0  # -0 becomes 0, as it does below
    return points @ matrix[:3, :3].T + matrix[:3, 3]


def world_normals(normals: np.ndarray, matrix: np.ndarray) -> np.ndarray:
    """Unit normals (n, 3), through the inverse transpose: outside stays outside in mirrors; 0 stays 0."""
    turned = normals @ (matrix[:3, :3] if matrix is IDENTITY else np.linalg.inv(matrix[:3, :3]))
    length = np.linalg.norm(turned, axis=1, keepdims=True)
    return turned / np.where(length > 0, length, 1.0)


def unit(vector: Sequence[float] | np.ndarray) -> np.ndarray:
    """The vector scaled to length 1, float64."""
    return np.asarray(vector, np.float64) / np.linalg.norm(vector)


def mirrors(matrix: np.ndarray) -> bool:
    """Whether the matrix turns counter-clockwise corners clockwise."""
    return matrix is not IDENTITY and bool(np.linalg.det(matrix[:3, :3]) < 0)


def joined(faces: np.ndarray | tuple[np.ndarray, ...]) -> tuple[np.ndarray, np.ndarray]:
    """The vertex numbers of all faces in a row, and how many each face has."""
    if isinstance(faces, np.ndarray):
        return faces.reshape(-1), np.full(len(faces), faces.shape[1])
    sizes = np.fromiter(map(len, faces), np.int64, len(faces))
    return (np.concatenate(faces) if faces else np.zeros(0, np.int32)), sizes


def fans(indices: np.ndarray, sizes: np.ndarray) -> np.ndarray:
    """Every face as a fan of triangles about its first corner, (m, 3)."""
    first = starts(sizes)
    count = sizes - 2
    apex = np.repeat(first, count)
    step = np.arange(count.sum()) - np.repeat(starts(count), count)
    return np.stack([indices[apex], indices[apex + step + 1], indices[apex + step + 2]], axis=1)


def fanned(faces: np.ndarray | tuple[np.ndarray, ...]) -> np.ndarray:
    """All faces as triangles (m, 3) of vertex numbers."""
    indices, sizes = joined(faces)
    return indices.reshape(-1, 3) if isinstance(faces, np.ndarray) else fans(indices, sizes)


def starts(sizes: np.ndarray) -> np.ndarray:
    """Where each of consecutive runs of these sizes begins."""
    return np.cumsum(sizes) - sizes


def reversed_runs(sizes: np.ndarray) -> np.ndarray:
    """The order that turns each run of corners around and leaves its first corner first."""
    first, size = np.repeat(starts(sizes), sizes), np.repeat(sizes, sizes)
    place = np.arange(sizes.sum()) - first
    return first + np.where(place == 0, 0, size - place)


def mesh_triangles(
    data: MeshData, matrix: np.ndarray, triangles: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """The triangles (m, 3) of a mesh: records (dtype Triangle), float32 corner normals (3 m, 4) if smooth.

    The records' `normals` count from 0; flat ones have -1.
    """
    order = (0, 2, 1) if mirrors(matrix) else (0, 1, 2)
    vertices = np.zeros((len(data.vertices), 4), np.float32)  # as records have them: rows are copied whole
    vertices[:, :3] = world_points(data.vertices, matrix)
    out = np.zeros(len(triangles), layout.dtype("Triangle"))
    corners = vertices.view(np.complex128)[:, 0]  # numpy picks single numbers far faster than rows of four
    for start in range(0, len(triangles), _ROWS):
        part = slice(start, start + _ROWS)
        for name, corner in zip(("v0", "v1", "v2"), order, strict=True):
            out[name][part] = corners[triangles[part, corner]].view(np.float32).reshape(-1, 4)
    if data.normals is None:
        out["normals"] = -1
        return out, np.zeros((0, 4), np.float32)
    out["normals"] = 3 * np.arange(len(triangles))
    normals = np.zeros((len(triangles), 3, 4), np.float32)
    normals[:, :, :3] = world_normals(data.normals, matrix).astype(np.float32)[triangles[:, order]]
    return out, normals.reshape(-1, 4)


def triangle_boxes(triangles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Boxes low, high (3, n) float32 of triangle records."""
    a, b, c = (triangles[name].T[:3].copy() for name in ("v0", "v1", "v2"))
    return np.minimum(np.minimum(a, b), c), np.maximum(np.maximum(a, b), c)


def polygons(corners: Sequence[np.ndarray], sizes: Sequence[np.ndarray]) -> tuple[np.ndarray, ...]:
    """Polygons from chunks of world corners (k, 3) and their numbers of corners.

    Returns records (dtype Polygon), vertices (n, 4) float32, boxes low and high (float64, not padded), and
    how far each polygon's corners lie off its plane. The normal is Newell's, of the corners as float32 holds
    them; it is 0 where these span no area.
    """
    size = np.concatenate([*sizes, np.zeros(0, np.int64)]).astype(np.int64)
    first = starts(size)
    n, vertices = len(size), np.zeros((int(size.sum()), 4), np.float32)
    out = np.zeros(n, layout.dtype("Polygon"))
    out["first"], out["count"] = first, size
    low, high, off = np.zeros((n, 3)), np.zeros((n, 3)), np.zeros(n)
    if n:
        np.concatenate(corners, out=vertices[:, :3])
    start, ends = 0, first + size
    while start < n:  # few at once: each corner takes some 200 bytes meanwhile
        stop = max(start + 1, int(np.searchsorted(ends, first[start] + _ROWS, "right")))
        part = slice(start, stop)
        points = vertices[first[start] : ends[stop - 1], :3].astype(np.float64)
        low[part], high[part], off[part] = _planes(out[part], points, size[part])
        start = stop
    return out, vertices, low, high, off


def _planes(
    out: np.ndarray, points: np.ndarray, size: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Fill in the normals of some polygons; their boxes, and how far corners lie off the planes."""
    first, owner = starts(size), np.repeat(np.arange(len(size)), size)
    local = points - points[first[owner]]
    following = np.arange(len(points)) + 1
    following[first + size - 1] = first
    normal = np.add.reduceat(np.cross(local, local[following]), first)
    length = np.linalg.norm(normal, axis=1)
    normal /= np.where(length > 0, length, 1.0)[:, None]
    off = np.maximum.reduceat(np.abs(np.einsum("ni,ni->n", local, normal[owner])), first)
    low, high = np.minimum.reduceat(points, first), np.maximum.reduceat(points, first)
    out["normal"][:, :3] = normal
    out["normal"][:, 3] = np.maximum(np.abs(low), np.abs(high)).max(axis=1)
    return low, high, off
