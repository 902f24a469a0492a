"""Meshes from OBJ, PLY, glTF and STL files, through trimesh (the optional dependency `clrt[mesh]`)."""

from __future__ import annotations

import io
import logging
import re
import warnings
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from clrt import notices
from clrt.errors import ClrtError, MissingPackage
from clrt.files import read_bytes, resolve
from clrt.install import pip_install
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
    if _MATERIALS.search(data) or any(part.colored for part in parts):
        text = f"{path.name}: its materials and colours are ignored; the shape's material holds for all of it"
        notices.warn(at.source, at.path, text)
    limits.check("vertices", sum(len(part.vertices) for part in parts), at.source, at.path)
    own = smooth is not False and any(part.normals is not None for part in parts)
    with np.errstate(all="ignore"):  # what is not finite is an error later, with its place
        pieces = [_in_world(_with_normals(part, smooth) if own else part) for part in parts]
        starts = np.cumsum([0] + [len(piece.vertices) for piece in pieces[:-1]])
        vertices = np.concatenate([piece.vertices for piece in pieces])
        faces = np.concatenate([piece.faces + start for piece, start in zip(pieces, starts, strict=True)])
        if own:
            return vertices, faces, np.concatenate([piece.normals for piece in pieces])
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
    return _units(normals)


@dataclass(frozen=True, eq=False)
class _Part:
    """One node: vertices (n, 3), triangles (m, 3), normals (n, 3) or None, (4, 4) matrix to the world."""

    vertices: np.ndarray
    faces: np.ndarray
    normals: Any
    matrix: np.ndarray
    colored: bool


def _parse(data: bytes, path: Path, at: At, limits: Limits) -> list[_Part]:
    """The file's nodes that have faces."""
    try:
        import trimesh
    except ImportError:
        needs = at.says(f"reading {path.name} needs trimesh; install it with: {pip_install('trimesh')}")
        raise MissingPackage(str(needs)) from None

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

    log = logging.getLogger("trimesh")  # prints tracebacks of its own for broken files
    loudness = log.level
    try:
        log.setLevel(logging.CRITICAL + 1)
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
            found = [(scene.geometry[name], matrix) for matrix, name in placed]
            parts = [_part(mesh, matrix) for mesh, matrix in found if isinstance(mesh, trimesh.Trimesh)]
    except ClrtError:
        raise
    except Exception as error:  # a broken file can fail anywhere inside a parser
        # the parser's own words help where it raises on purpose; elsewhere it stumbled over what is broken
        why = str(error) if isinstance(error, ValueError) and str(error) else "its contents are broken"
        text = f"{path.name} cannot be read as a mesh: {why} ({type(error).__name__})"
        raise at.says(text[:300]) from None
    finally:
        log.setLevel(loudness)
    parts = [part for part in parts if len(part.faces)]
    if not parts:
        raise at.says(f"{path.name} has no faces")
    return parts


def _part(mesh: Any, matrix: Any) -> _Part:
    """A trimesh.Trimesh as plain arrays; ValueError where they do not fit together (trimesh may not look)."""
    vertices, faces = np.array(mesh.vertices, np.float64), np.array(mesh.faces, np.int64)
    # Only what the file gave is in trimesh's cache before anyone has asked for normals.
    given = "vertex_normals" in mesh._cache.cache
    normals = np.array(mesh.vertex_normals, np.float64) if given else None
    if (
        vertices.ndim != 2
        or vertices.shape[1] != 3
        or (normals is not None and normals.shape != vertices.shape)
    ):
        raise ValueError("vertices must be 3 numbers each")
    if faces.size and (faces.ndim != 2 or faces.shape[1] != 3):
        raise ValueError("faces must be triangles")
    if faces.size and (faces.min() < 0 or faces.max() >= len(vertices)):
        raise ValueError(f"a face names a vertex that is not among the {len(vertices)} of its part")
    return _Part(
        vertices, faces, normals, np.array(matrix, np.float64).reshape(4, 4), bool(mesh.visual.defined)
    )


def _with_normals(part: _Part, smooth: bool | None) -> _Part:
    """The part with normals where it has none: smooth ones, or each triangle's own on corners of its own."""
    if part.normals is not None:
        return part
    if smooth:
        return replace(part, normals=smooth_normals(part.vertices, part.faces))
    vertices, faces = part.vertices[part.faces.reshape(-1)], np.arange(part.faces.size).reshape(-1, 3)
    return replace(part, vertices=vertices, faces=faces, normals=vertex_normals(vertices, faces))


def _in_world(part: _Part) -> _Part:
    """The part moved by its matrix, its outer side still outside."""
    linear = part.matrix[:3, :3]
    mirrored = np.linalg.det(linear) < 0
    vertices = part.vertices @ linear.T + part.matrix[:3, 3]
    faces = part.faces[:, ::-1] if mirrored else part.faces
    normals = part.normals
    if normals is not None:
        cofactors = np.cross(
            linear[[1, 2, 0]], linear[[2, 0, 1]]
        )  # the inverse transpose, times the determinant
        normals = _units(normals @ cofactors.T * (-1.0 if mirrored else 1.0))
    return replace(part, vertices=vertices, faces=faces, normals=normals)


def _units(vectors: np.ndarray) -> np.ndarray:
    """(n, 3) vectors of length 1; z for those of length 0."""
    length = np.linalg.norm(vectors, axis=1, keepdims=True)
    return np.where(length > 0, vectors / np.where(length > 0, length, 1.0), (0.0, 0.0, 1.0))
