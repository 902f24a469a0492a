"""What files of meshes lack: uv, and normals, which Mitsuba has of faces that share a number, not a place."""

from __future__ import annotations

import copy
import re
from pathlib import Path
from typing import Any, Final

import msgspec
import numpy as np

from clrt.base import notices
from clrt.base.files import read_bytes
from clrt.base.limits import Limits
from clrt.base.places import At
from clrt.meshfiles.file import broken_said, open_mesh
from clrt.meshfiles.parts import smooth_normals, vertex_normals
from clrt.meshfiles.ply import header
from clrt.scene.mesh import Mesh, MeshData
from clrt.scene.scene import Scene

_NEAR: Final = 1e-6
_STATED: Final = {".obj": re.compile(rb"(?:^|[\r\n])[ \t]*vn[ \t]"), ".ply": re.compile(rb"\snx[ \t]*[\r\n]")}
_UV: Final = {  # signs of it, all of which are there
    ".obj": (re.compile(rb"(?:^|[\r\n])[ \t]*f[ \t]+-?[0-9]+/-?[0-9]"),),
    ".ply": tuple(re.compile(rb"\s(?:texture_)?%b[ \t]*[\r\n]" % name) for name in (b"[us]", b"[vt]")),
}
_USEMTL: Final = re.compile(rb"(?:(?<=[\r\n])|\A)[ \t]*usemtl\b[^\r\n]*")


def by_number(scene: Scene) -> Scene:
    """The scene with meshes in place of files whose smooth normals are others there.

    A cube of which each side has vertices of its own is flat.
    """
    found: dict[str, MeshData | None] = {}
    shapes: list[Any] = []
    for shape in scene.shapes:
        if isinstance(shape, Mesh) and shape.file is not None and shape.smooth:
            if shape.file not in found:
                found[shape.file] = _numbered(shape, scene)
            data = found[shape.file]
            shapes.append(shape if data is None else _given(shape, data))
        else:
            shapes.append(shape)
    if not any(found.values()):
        return scene
    other = copy.copy(scene)
    msgspec.structs.force_setattr(other, "shapes", tuple(shapes))
    return other


def leans(mesh: Mesh, flipped: bool, limits: Limits) -> bool:
    """Whether green of a normal map leans the other way on some of a mesh's file: there it is across the
    normal and u, here up in the picture. flipped: `flip_normals` is true there."""
    data = mesh.data()
    if data.uv is None:
        return False
    faces = np.asarray(data.faces)
    side = -_turns(data.uv[faces])  # of v downwards
    if _keeps_normals(mesh, limits):
        side *= -_along(data) if _mirrored(mesh) else _along(data)
    return bool(((side > 0) if flipped else (side < 0)).any())


def fronts_differ(mesh: Mesh, flipped: bool, limits: Limits) -> bool:
    """Whether the front of a mesh's file there is its back here: normals that are computed there go with the
    faces where these are mirrored."""
    return flipped != (_mirrored(mesh) and not _keeps_normals(mesh, limits))


def inside_out(mesh: Mesh, flipped: bool, limits: Limits) -> bool:
    """Whether what is inside a mesh's file there is outside here, where its faces tell.

    There normals that it states do, wherever a mirror puts them, else the faces as a mirror leaves them.
    """
    keeps = _keeps_normals(mesh, limits)
    return flipped != (bool(_along(mesh.data()).sum() < 0) if keeps else _mirrored(mesh))


def _mirrored(mesh: Mesh) -> bool:
    return bool(np.linalg.det(mesh.matrix[:3, :3]) < 0)


def _along(data: MeshData) -> np.ndarray:
    """How far normals (n,) of a mesh that has some go with its triangles."""
    assert data.normals is not None
    faces = np.asarray(data.faces)
    a, b, c = (data.vertices[faces[:, k]] for k in range(3))
    along: np.ndarray = np.einsum("ij,ikj->i", np.cross(b - a, c - a), data.normals[faces])
    return along


def _keeps_normals(mesh: Mesh, limits: Limits) -> bool:
    """Whether the normals of a mesh's file are those that it states."""
    path: Path = mesh.__dict__["_path"]
    smooth = mesh.smooth and mesh.data().normals is not None
    return bool(smooth) and _states_normals(path, read_bytes(path, limits))


def _turns(uv: np.ndarray) -> np.ndarray:
    """Twice the areas (n,) of triangles (n, 3, 2), of those that turn from u to v above 0."""
    (x, y), (u, v) = (uv[:, 1] - uv[:, 0]).T, (uv[:, 2] - uv[:, 0]).T
    area: np.ndarray = x * v - y * u
    return area


def has_uv(path: Path, limits: Limits) -> bool:
    """Whether faces of an OBJ or vertices of a PLY have uv; those of a file of another name may."""
    suffix = path.suffix.lower()
    if suffix not in _UV:
        return True
    text = read_bytes(path, limits)  # of which nothing is known yet
    end = text.find(b"end_header") if suffix == ".ply" else -1
    return all(sign.search(text, 0, end if end >= 0 else len(text)) for sign in _UV[suffix])


def _states_normals(path: Path, text: bytes) -> bool:
    suffix = path.suffix.lower()
    return _STATED[suffix].search(header(text) if suffix == ".ply" else text) is not None


def _numbered(mesh: Mesh, scene: Scene) -> MeshData | None:
    """A mesh with Mitsuba's normals; None where they are those of the file, or as those over places."""
    path, data = mesh.__dict__["_path"], mesh.data()
    suffix, text = path.suffix.lower(), read_bytes(path, scene.limits)
    if data.normals is None or _states_normals(path, text):
        return None
    vertices, faces, uv, usual = data.vertices, np.asarray(data.faces), data.uv, data.normals
    if suffix == ".obj" and b"usemtl" in text:  # it was read apart by material, and is one mesh there
        with broken_said(path, At(scene.source)), notices.without(""):  # all was said
            placed = open_mesh(_USEMTL.sub(b"", text), path, At(scene.source), scene.limits)
            vertices, faces, _, uv = placed.joined(False)
            usual = smooth_normals(vertices, faces)
    normals = vertex_normals(vertices, faces)
    if np.abs(normals - usual).max() < _NEAR:
        return None
    for array in (vertices, faces, normals, *([] if uv is None else [uv])):
        array.flags.writeable = False
    return MeshData(vertices, faces, normals, uv)


def _given(mesh: Mesh, data: MeshData) -> Mesh:
    arrays = {name: getattr(data, name) for name in ("vertices", "faces", "normals", "uv")}
    given = msgspec.structs.replace(mesh, file=None, smooth=None, **arrays)
    given.__dict__["_data"] = data
    return given
