"""Meshes, given in a scene or by a file that trimesh reads, and their normals."""

from __future__ import annotations

from dataclasses import dataclass
from importlib import import_module
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

Array = np.ndarray


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
    lengths = {len(face) for face in faces}
    corners: Any = [np.asarray(face, int) for face in faces]
    if lengths <= {3}:
        corners = np.asarray(faces, int).reshape(-1, 3)
    places = None if uv is None else np.asarray(uv, float)
    if normals is not None and smooth is not False:
        return Surface(points, corners, np.asarray(normals, float), places)
    return Surface(points, corners, area_weighted(points, corners) if smooth else None, places)


def read(path: Path, smooth: bool | None) -> Surface:
    """A mesh file, all of its parts in world space."""
    scene = import_module("trimesh").load_scene(path, process=False, skip_materials=True)
    colors = _colors(scene) if path.suffix.lower() == ".ply" else None
    parts = []
    texcoords: list[Any] = []
    for node in scene.graph.nodes_geometry:
        matrix, name = scene.graph[node]
        part = scene.geometry[name]
        own = np.array(part.vertex_normals) if "vertex_normals" in part._cache.cache else None
        faces = part.faces if np.linalg.det(matrix[:3, :3]) > 0 else part.faces[:, ::-1]
        if own is not None:
            own = own @ np.linalg.inv(matrix[:3, :3])
            own = own / np.linalg.norm(own, axis=1, keepdims=True)
        texcoords.append(getattr(part.visual, "uv", None))
        parts.append((part.vertices @ matrix[:3, :3].T + matrix[:3, 3], faces, own))
    starts = np.cumsum([0, *(len(vertices) for vertices, _, _ in parts)])
    vertices = np.concatenate([vertices for vertices, _, _ in parts])
    faces = np.concatenate([faces + start for (_, faces, _), start in zip(parts, starts[:-1], strict=True)])
    uv = None
    if all(each is not None for each in texcoords):
        uv = np.concatenate(texcoords) * (1, -1) + (0, 1)
    if smooth is not False and all(own is not None for _, _, own in parts):
        return Surface(vertices, faces, np.concatenate([own for _, _, own in parts if own is not None]), uv,
                       colors)  # fmt: skip
    if not smooth:
        return Surface(vertices, faces, None, uv, colors)
    places, place = np.unique(vertices, axis=0, return_inverse=True)  # files split vertices at seams
    return Surface(vertices, faces, area_weighted(places, place.ravel()[faces])[place.ravel()], uv, colors)


def _colors(scene: Any) -> Array | None:
    """The colours of a PLY's only part, by the sRGB curve of IEC 61966-2-1."""
    (part,) = scene.geometry.values()
    kind = part.visual.kind
    if kind not in ("vertex", "face"):
        return None
    stated = np.asarray(getattr(part.visual, f"{kind}_colors"))[:, :3] / 255.0
    return np.where(stated <= 0.04045, stated / 12.92, ((stated + 0.055) / 1.055) ** 2.4)


def area_weighted(vertices: Array, faces: Any) -> Array:
    """Unit normals (n, 3): sums of the triangles' about each vertex, each as long as twice its area."""
    sums = np.zeros_like(vertices)
    for face in faces:
        for second, third in pairwise(face[1:]):
            corner = vertices[[face[0], second, third]]
            area = np.cross(corner[1] - corner[0], corner[2] - corner[0])
            for vertex in (face[0], second, third):
                sums[vertex] += area
    length = np.linalg.norm(sums, axis=1)
    sums[length == 0] = 0, 0, 1
    return sums / np.where(length > 0, length, 1.0)[:, None]
