"""Meshes from OBJ, PLY, glTF and STL files, through trimesh (the optional dependency `clrt[mesh]`)."""

from __future__ import annotations

import io
import re
import warnings
from pathlib import Path
from typing import Any

import numpy as np

from clrt.errors import ClrtError, ClrtWarning, located
from clrt.files import read_bytes, resolve
from clrt.limits import Limits
from clrt.places import At

MESH_SUFFIXES = (".obj", ".ply", ".glb", ".gltf", ".stl")
_MATERIALS = re.compile(rb'^\s*usemtl\b|"materials"\s*:', re.MULTILINE)


def read_mesh_file(
    path: Path, at: At, limits: Limits, smooth: bool | None
) -> tuple[np.ndarray, np.ndarray, np.ndarray | None]:
    """Vertices (n, 3) float64, triangles (m, 3) int and vertex normals (n, 3) or None for a flat mesh.

    All nodes are joined in world space. `smooth` None follows the file: its own normals where it has some,
    else flat; True computes normals that the file lacks, over all vertices at one position (files split
    them at seams). Materials and textures are left out, with a warning.
    """
    suffix = path.suffix.lower()
    if suffix not in MESH_SUFFIXES:
        raise at.error(path.name, f"a mesh file must end in one of {', '.join(MESH_SUFFIXES)}")
    data = read_bytes(path, limits)
    parts = _parse(data, path, at, limits)
    if _MATERIALS.search(data) or any(part.visual.defined for part, _ in parts):
        text = f"{path.name}: its materials and colours are ignored; the shape's material holds for all of it"
        warnings.warn(located(at.source, at.path, text), ClrtWarning, stacklevel=2)
    limits.check("vertices", sum(len(part.vertices) for part, _ in parts), at.source, at.path)
    own = smooth is not False and any(_has_normals(part) for part, _ in parts)
    pieces = [_piece(part, matrix, own, smooth) for part, matrix in parts]
    starts = np.cumsum([0] + [len(vertices) for vertices, _, _ in pieces[:-1]])
    vertices = np.concatenate([vertices for vertices, _, _ in pieces])
    faces = np.concatenate([faces + start for (_, faces, _), start in zip(pieces, starts, strict=True)])
    if own:
        return vertices, faces, np.concatenate([normals for _, _, normals in pieces])
    return vertices, faces, smooth_normals(vertices, faces) if smooth else None


def smooth_normals(vertices: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """`vertex_normals` with all vertices at one position taken as one."""
    places, place = np.unique(vertices, axis=0, return_inverse=True)
    place = place.reshape(-1)
    return vertex_normals(places, place[faces])[place]


def vertex_normals(vertices: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Unit normals (n, 3), the mean of the adjoining triangles' weighted by area; z where that vanishes."""
    normals = np.zeros_like(vertices)
    a, b, c = (vertices[triangles[:, corner]] for corner in range(3))
    across = np.cross(b - a, c - a)
    for corner in range(3):
        np.add.at(normals, triangles[:, corner], across)
    length = np.linalg.norm(normals, axis=1, keepdims=True)
    return np.where(length > 0, normals / np.where(length > 0, length, 1.0), (0.0, 0.0, 1.0))


def _parse(data: bytes, path: Path, at: At, limits: Limits) -> list[tuple[Any, np.ndarray]]:
    """The file's meshes (trimesh.Trimesh), each with its (4, 4) matrix to world space."""
    try:
        import trimesh
    except ImportError:
        raise at.says(
            f"reading {path.name} needs trimesh; install it with: pip install 'clrt[mesh]'"
        ) from None

    class Beside(trimesh.resolvers.Resolver):
        """Finds the files that a glTF names, in the mesh's own folder only."""

        def __init__(self) -> None: ...

        def get(self, name: str) -> bytes:
            return read_bytes(resolve(name, path.parent, at), limits)

        def write(self, name: str, data: Any) -> None:
            raise at.error(name, "reading a mesh writes nothing")

        def namespaced(self, namespace: str) -> Beside:
            return self

        def keys(self) -> list[str]:
            return []

    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            scene = trimesh.load_scene(
                io.BytesIO(data),
                path.suffix[1:].lower(),
                resolver=Beside(),
                process=False,
                skip_materials=True,
            )
            placed = [scene.graph[node] for node in scene.graph.nodes_geometry]
            found = [(scene.geometry[name], np.asarray(matrix, np.float64)) for matrix, name in placed]
    except ClrtError:
        raise
    except Exception as error:  # a broken file can fail anywhere inside a parser
        raise at.says(f"{path.name} cannot be read as a mesh: {type(error).__name__}: {error}") from None
    parts = [
        (part, matrix) for part, matrix in found if isinstance(part, trimesh.Trimesh) and len(part.faces)
    ]
    if not parts:
        raise at.says(f"{path.name} has no faces")
    return parts


def _has_normals(part: Any) -> bool:
    """Whether the file gave normals: only these are in trimesh's cache before anyone has asked for some."""
    return "vertex_normals" in part._cache.cache


def _piece(
    part: Any, matrix: np.ndarray, own: bool, smooth: bool | None
) -> tuple[np.ndarray, np.ndarray, Any]:
    """One node in world space, with normals if the whole mesh has some (`own`)."""
    vertices, faces = np.array(part.vertices, np.float64), np.array(part.faces, np.int64)
    normals = None
    if own and _has_normals(part):
        normals = np.array(part.vertex_normals, np.float64)
    elif own and smooth:
        normals = smooth_normals(vertices, faces)
    elif own:  # flat among smooth: every triangle has corners of its own
        vertices, faces = vertices[faces.reshape(-1)], np.arange(faces.size).reshape(-1, 3)
        normals = vertex_normals(vertices, faces)
    linear = matrix[:3, :3]
    if normals is not None:
        cofactors = np.cross(
            linear[[1, 2, 0]], linear[[2, 0, 1]]
        )  # the inverse transpose, times the determinant
        normals = normals @ cofactors.T * (-1.0 if np.linalg.det(linear) < 0 else 1.0)
        length = np.linalg.norm(normals, axis=1, keepdims=True)
        normals = np.where(length > 0, normals / np.where(length > 0, length, 1.0), (0.0, 0.0, 1.0))
    if np.linalg.det(linear) < 0:
        faces = faces[:, ::-1]
    return vertices @ linear.T + matrix[:3, 3], faces, normals
