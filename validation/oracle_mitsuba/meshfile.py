"""Meshes, given in a scene or by a file, and their normals.

Files are read by readers of this side's own: they share nothing with those of the renderer, nor the package
that these ask.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from importlib import import_module
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from . import gltffile, objfile, plyfile, stlfile
from .patches import Patch, Patches, Unreadable, dented, finite

Array = np.ndarray
_BROKEN = ArithmeticError, AttributeError, LookupError, OSError, RecursionError, TypeError, ValueError
"""What reading a file that says something else than it should may raise."""


@dataclass(frozen=True, eq=False)
class Surface:
    """`vertices` (n, 3); `faces` (m, 3), or a list of arrays; `normals` (n, 3), or None where it is flat.

    `uv` (n, 2), v = 0 at the top row of a picture, or None.
    """

    vertices: Array
    faces: Any
    normals: Array | None
    uv: Array | None = None
    colors: Array | None = None  # of vertices (n, 3) or faces (m, 3), linear


def given(vertices: Any, faces: Any, normals: Any, smooth: bool | None, uv: Any = None) -> Surface:
    """A mesh whose numbers stand in the scene."""
    points = np.asarray(vertices, float).reshape(-1, 3)
    alike = isinstance(faces, np.ndarray) or {len(face) for face in faces} <= {3}
    corners: Any = [] if alike else [np.asarray(face, int) for face in faces]
    if alike:
        corners = np.asarray(faces, int).reshape(-1, 3)
    places = None if uv is None else np.asarray(uv, float)
    if smooth or places is not None or (normals is not None and smooth is not False):
        corners = corners if alike else [part for face in corners for part in _undented(points, face)]
    if normals is not None and smooth is not False:
        return Surface(points, corners, np.asarray(normals, float), places)
    return Surface(points, corners, area_weighted(points, corners) if smooth else None, places)


def _undented(points: Array, face: Array) -> list[Array]:
    """The face, or triangles where those about its first corner would cover more than it."""
    local = points[face] - points[face[0]]
    if len(face) == 3 or not dented(local[None])[0]:
        return [face]
    normal = np.cross(local, np.roll(local, -1, axis=0)).sum(axis=0)
    axis = int(np.abs(normal).argmax())  # seen along it, as clrt does: other cuts blend normals otherwise
    flat = np.ascontiguousarray(local[:, [(axis + 1) % 3, (axis + 2) % 3]])
    ears = import_module("mapbox_earcut").triangulate_float64(flat, np.array([len(face)], np.uint32))
    cut = ears.astype(int).reshape(-1, 3)
    each = np.cross(local[cut[:, 1]] - local[cut[:, 0]], local[cut[:, 2]] - local[cut[:, 0]]) @ normal
    if abs(np.abs(each).sum() - normal @ normal) > 1e-6 * (normal @ normal):  # it crosses itself
        return [face]
    return list(face[cut if each.sum() > 0 else cut[:, ::-1]])


def read(path: Path, smooth: bool | None, part: int | None = None) -> Surface:
    """A mesh file, all of its parts in world space, or one of them.

    Unreadable names what in it is not read here; then it is nobody's mesh.
    """
    try:
        status = path.stat()
        patches = _opened(path, status.st_mtime_ns, status.st_size).of(part)
        return _joined(patches, smooth)
    except Unreadable as reason:
        raise Unreadable(f"{path.name} has what is not read: {reason}") from None
    except _BROKEN as error:
        raise Unreadable(f"{path.name} is not read: {type(error).__name__}: {error}"[:200]) from None


@lru_cache(maxsize=8)
def _opened(path: Path, changed: int, size: int) -> Patches:
    """What is in a file; a scene may name one for each of its parts. changed, size: of this version of it."""
    suffix, data = path.suffix.lower(), path.read_bytes()
    if suffix in (".gltf", ".glb"):
        return gltffile.patches(data, path)
    readers = {".obj": objfile.patches, ".ply": plyfile.patches, ".stl": stlfile.patches}
    if suffix not in readers:
        raise Unreadable(f"files of the kind {suffix}")
    return readers[suffix](data)


def _joined(patches: list[Patch], smooth: bool | None) -> Surface:
    """Patches as one mesh, corners of triangles each a vertex of its own."""
    vertices = np.concatenate([np.zeros((0, 3)), *(patch.corners.reshape(-1, 3) for patch in patches)])
    faces = np.arange(len(vertices)).reshape(-1, 3)
    uv = [patch.uv.reshape(-1, 2) for patch in patches if patch.uv is not None]
    places = np.concatenate(uv) if uv and len(uv) == len(patches) else None
    colors = [patch.colors.reshape(-1, 3) for patch in patches if patch.colors is not None]
    tones = colors[0] if len(patches) == 1 and colors else None
    stated = [patch.normals.reshape(-1, 3) for patch in patches if patch.normals is not None]
    if smooth is False or not (stated or smooth):
        return Surface(vertices, faces, None, places, tones)
    if not stated:
        points, place = np.unique(vertices, axis=0, return_inverse=True)  # files split vertices at seams
        normals = area_weighted(points, place.reshape(-1)[faces])[place.reshape(-1)]
        return Surface(vertices, faces, normals, places, tones)
    if len(stated) < len(patches):
        raise Unreadable("faces with normals beside others without")
    own = finite(np.concatenate(stated), "normals")
    length = np.linalg.norm(own, axis=1, keepdims=True)
    if not length.all():
        raise Unreadable("normals of no length")
    return Surface(vertices, faces, own / length, places, tones)


def area_weighted(vertices: Array, faces: Any) -> Array:
    """Unit normals (n, 3): sums of the triangles' about each vertex, each as long as twice its area."""
    sums = np.zeros_like(vertices)
    if isinstance(faces, np.ndarray):
        a, b, c = (vertices[faces[:, k]] for k in range(3))
        for k in range(3):
            np.add.at(sums, faces[:, k], np.cross(b - a, c - a))
        faces = ()
    for face in faces:
        for second, third in pairwise(face[1:]):
            corner = vertices[[face[0], second, third]]
            area = np.cross(corner[1] - corner[0], corner[2] - corner[0])
            for vertex in (face[0], second, third):
                sums[vertex] += area
    length = np.linalg.norm(sums, axis=1)
    sums[length == 0] = 0, 0, 1
    return sums / np.where(length > 0, length, 1.0)[:, None]
