"""Meshes from OBJ, PLY, glTF and STL files; all but glTF through trimesh (the optional `clrt[mesh]`)."""

from __future__ import annotations

import io
import logging
import os
import re
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any
from urllib.parse import unquote

import numpy as np

from clrt.base import notices
from clrt.base.errors import MissingPackage
from clrt.base.files import read_bytes, resolve
from clrt.base.install import pip_install
from clrt.base.limits import Limits
from clrt.base.places import At, PlacedError
from clrt.base.room import check_date
from clrt.meshfiles import SUFFIXES
from clrt.meshfiles.broken import BrokenMesh
from clrt.meshfiles.embedded import itself_of
from clrt.meshfiles.gltf.reader import read_gltf
from clrt.meshfiles.look import NONE
from clrt.meshfiles.obj.lines import check_lines, form_of, left_out, mixed_forms, plain_obj
from clrt.meshfiles.obj.materials import LIBRARY, Materials
from clrt.meshfiles.obj.mtl import text_of
from clrt.meshfiles.outlines import Outlines
from clrt.meshfiles.parts import Arrays, Part, Placed
from clrt.meshfiles.planar import folded
from clrt.meshfiles.ply import PlyColors, edges, header, newlined, plain_ply, textures
from clrt.meshfiles.plyuv import ODD, has_corners, of_vertices, taken_apart
from clrt.meshfiles.stl import plain_stl
from clrt.meshfiles.vertex_colors import spread

_MOST_GROUPS = 64  # for which trimesh's time, groups x vertices or groups squared, is of no account
# \s: each empty line anew
_MATERIALS = re.compile(rb'(?:^|\r|^\xef\xbb\xbf)[ \t]*usemtl\b|"materials"\s*:', re.MULTILINE)


def read_mesh_file(
    path: Path,
    at: At,
    limits: Limits,
    smooth: bool | None,
    vertices: int = 0,
    primitives: int = 0,
    part: int | None = None,
    opened: dict[Path, Placed] | None = None,
    times: int = 1,
) -> Arrays:
    """Vertices (n, 3) float64, triangles (m, 3) int, vertex normals (n, 3) or None for a flat mesh, and uv
    (n, 2) or None where the file has none.

    All nodes are joined in world space. `smooth` None follows the file: its own normals where it has some,
    else flat; True computes normals that the file lacks, over all vertices at one position (files split
    them at seams). Materials and textures are left out, with a warning. `vertices` and `primitives` are what
    the scene has already: LimitError when it would have too many with those that the file declares, `times`
    as many, before their arrays are made.
    `part`: only one of those that `Placed.groups` numbers; `opened` keeps what is read until all are.
    """
    if part is None:
        data = mesh_bytes(path, at, limits)
        with broken_said(path, at):
            placed = open_mesh(data, path, at, limits, primitives)
            arrays = _checked(placed, path, at, limits, smooth, (vertices, primitives), times)
        textured = path.suffix.lower() == ".ply" and textures(data)
        if _MATERIALS.search(data) or textured or any(found.colored for found in placed.parts):
            text = "its materials and colours are ignored; the shape's material holds for all of it"
            notices.warn(at.source, at.path, f"{path.name}: {text}")
    else:
        opened = {} if opened is None else opened
        with broken_said(path, at):
            if path not in opened:
                opened[path] = open_mesh(mesh_bytes(path, at, limits), path, at, limits, primitives, True)
            placed = opened[path]
            if part >= len(placed.groups):
                text = f"{path.name} has {len(placed.groups)} parts, numbered from 0"
                raise PlacedError(at, f"part {part} is not allowed; {text}")
            found = placed.only(placed.groups[part][2])
            arrays = _checked(found, path, at, limits, smooth, (vertices, primitives), times)
    if placed.left_out:
        text = f"{path.name}: its {' and '.join(placed.left_out)} are left out; save it with them applied"
        notices.warn(at.source, at.path, text)
    return arrays


def mesh_bytes(path: Path, at: At, limits: Limits) -> bytes:
    """What is in a file whose suffix is a mesh file's."""
    if path.suffix.lower() not in SUFFIXES:
        raise at.error(path.name, f"a mesh file must end in one of {', '.join(SUFFIXES)}")
    data = read_bytes(path, limits)
    return newlined(data) if path.suffix.lower() == ".ply" else data


@contextmanager
def broken_said(path: Path, at: At) -> Iterator[None]:
    """Raise what is wrong with a file as SceneError that names it."""
    try:
        with np.errstate(all="ignore"):  # what is not finite is an error later, with its place
            yield
    except BrokenMesh as error:
        name = "" if at.source == path.name and not at.path else f"{path.name} "
        raise at.says(f"{name}cannot be read as a mesh: {error}"[:300]) from None


def _checked(
    placed: Placed,
    path: Path,
    at: At,
    limits: Limits,
    smooth: bool | None,
    before: tuple[int, int],
    times: int,
) -> Arrays:
    """The arrays of all places, once it is known that they are not too large: `times` as many vertices and
    primitives, beside those of `before`."""
    if not len(placed.which):
        raise at.says(f"{path.name} has no faces")
    more = placed.sizes(smooth)
    limits.check("primitives", before[1] + times * more[1], at.source, at.path)
    limits.check("vertices", before[0] + times * more[0], at.source, at.path)
    return placed.joined(smooth)


def open_mesh(
    data: bytes, path: Path, at: At, limits: Limits, primitives: int = 0, apart: bool = False
) -> Placed:
    """The file's parts that have faces.

    apart: those of an OBJ by material, with what those are; colours of vertices where a `picture` has them.
    """
    placed = _opened(data, path, at, limits, primitives, apart)
    return replace(placed, warn=lambda text: notices.warn(at.source, at.path, f"{path.name}: {text}"))


def _opened(data: bytes, path: Path, at: At, limits: Limits, primitives: int, apart: bool) -> Placed:
    suffix = path.suffix.lower()
    if suffix == ".obj":
        return _open_obj(data, path, at, limits, apart)
    if suffix not in (".glb", ".gltf"):
        colors = None
        if suffix == ".ply":
            colors = PlyColors.of(data, apart)
            if edges(data):
                notices.warn(at.source, at.path, f"{path.name}: its edges are left out")
        placed = _parse(_prepared(data, suffix), path, at, colors=colors)
        return spread(placed) if apart else placed
    contents: dict[Path, bytes] = {}

    def fetch(uri: str) -> bytes:
        file = resolve(unquote(uri), path.parent, at)
        if file not in contents:
            contents[file] = read_bytes(file, limits)
            limits.check("file_bytes", sum(map(len, contents.values())), at.source, at.path)
        return contents[file]

    def check(faces: int) -> None:
        limits.check("primitives", primitives + faces, at.source, at.path)

    placed = read_gltf(data, suffix == ".glb", fetch, check, itself_of(path, at, limits, data), colors=apart)
    return spread(placed) if apart else placed


def _open_obj(data: bytes, path: Path, at: At, limits: Limits, apart: bool) -> Placed:
    """An OBJ's parts, with colours of vertices and materials if it is read `apart`.

    What is wrong with a line is told with its number.
    """
    try:
        plain = plain_obj(data)
        if lost := left_out(plain):
            notices.warn(at.source, at.path, f"{path.name}: its {' and '.join(lost)} are left out")
        read = _obj_apart(plain, path, at, limits) if apart else _parse(_prepared(plain, ".obj"), path, at)
    except BrokenMesh:
        check_lines(data)
        raise
    if not len(read.which):  # trimesh passes over faces where there are no vertices at all
        check_lines(data)
    return read


def _obj_apart(data: bytes, path: Path, at: At, limits: Limits) -> Placed:
    """An OBJ's meshes apart by material, where it has a library of them and not too many."""
    materials = Materials(data)
    if materials.many or not (materials.names and materials.libraries):
        return _parse(_prepared(data, ".obj"), path, at)
    placed = _parse(materials.lines, path, at, materials)

    def fetch(name: str) -> tuple[Path, Callable[[], bytes]] | None:
        name = name.replace("\\", "/")
        if not os.path.exists(path.parent / name):
            return None
        file = resolve(name, path.parent, at)
        return file, partial(read_bytes, file, limits, "text_bytes")

    itself = itself_of(path, at, limits, data)
    return replace(placed, look=lambda used, center, radius: materials.look(used, fetch, itself))


def _parse(
    data: bytes, path: Path, at: At, apart: Materials | None = None, colors: PlyColors | None = None
) -> Placed:
    """The meshes that trimesh finds in a file that is `_prepared`; `apart`: what its faces are apart by if it
    is an OBJ, `colors` what it declares of them if it is a PLY."""
    check_date()
    library = apart.library() if apart else b""
    try:
        import trimesh
    except ImportError:
        needs = at.says(f"reading {path.name} needs trimesh; install it with: {pip_install('trimesh')}")
        raise MissingPackage(str(needs)) from None

    class Nothing(trimesh.resolvers.Resolver):
        """Finds no other files but the library: a PLY's textures are not read."""

        def __init__(self) -> None: ...

        def get(self, name: str) -> bytes:
            if library and name == LIBRARY:
                return library
            raise at.error(name, "reading a mesh reads no other files")

        def write(self, name: str, data: Any) -> None:
            raise at.error(name, "reading a mesh writes nothing")

        def namespaced(self, namespace: str) -> Nothing:
            return self

        def keys(self) -> list[str]:
            return []

    outlines, suffix = Outlines(), path.suffix[1:].lower()

    def load(data: bytes) -> tuple[list[tuple[Part, Any]], list[str]]:
        text = io.BytesIO(_in_utf8(data, suffix))
        scene = trimesh.load_scene(
            text, suffix, resolver=Nothing(), process=False, skip_materials=not library
        )
        placed = [scene.graph[node] for node in scene.graph.nodes_geometry]
        found = [(scene.geometry[name], matrix) for matrix, name in placed]
        meshes = [(mesh, matrix) for mesh, matrix in found if isinstance(mesh, trimesh.Trimesh)]
        for mesh, _ in meshes:
            _check_lists(mesh.metadata.get("_ply_raw", {}))
        pairs = [(_part(mesh, outlines, colors), matrix) for mesh, matrix in meshes]
        names = [str(getattr(getattr(mesh.visual, "material", None), "name", None)) for mesh, _ in meshes]
        return pairs, names

    log = logging.getLogger("trimesh")  # prints tracebacks of its own for broken files
    loudness = log.level
    try:
        log.setLevel(logging.CRITICAL + 1)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            pairs, names = load(data)
            if suffix == "obj" and any(folded(*part.read()[:2]) for part, _ in pairs):
                better = outlines.obj(data)
                pairs, names = (pairs, names) if better is data else load(better)
    except BrokenMesh:
        raise
    except Exception as error:  # a broken file can fail anywhere inside a parser
        # the parser's own words help where it raises on purpose; elsewhere it stumbled over what is broken
        if isinstance(error, (ImportError, UnicodeDecodeError)):  # a package that guesses is not asked
            raise BrokenMesh("it is no text in UTF-8 where it must be") from None
        why = str(error) if isinstance(error, ValueError) and str(error) else "its contents are broken"
        raise BrokenMesh(f"{why} ({type(error).__name__})") from None
    finally:
        log.setLevel(loudness)
    uv, normals = (form_of(data) if suffix == "obj" else None) or (False, False)
    parts = [part for part, _ in pairs if part.faces]
    lacks = [
        *(["vt"] if uv and not all(part.uv for part in parts) else []),
        *(["vn"] if normals and not all(part.normals for part in parts) else []),
    ]
    if lacks:
        text = f"its faces name {' and '.join(lacks)} that are not there, and are read without"
        notices.warn(at.source, at.path, f"{path.name}: {text}")
    for text in outlines.left_over:
        notices.warn(at.source, at.path, f"{path.name}: its {text}")
    kept = [k for k, (part, _) in enumerate(pairs) if part.faces]
    numbers = np.arange(len(kept))
    matrices = np.array([pairs[k][1] for k in kept], np.float64).reshape(-1, 4, 4)
    materials = np.array([apart.material(names[k]) if apart else NONE for k in kept], np.int64)
    _, first, same = np.unique(materials, return_index=True, return_inverse=True)
    where = first[same] if apart else numbers  # of one material, in corners of more than one form: one thing
    return Placed([pairs[k][0] for k in kept], numbers, where, matrices, materials=materials)


def _in_utf8(data: bytes, suffix: str) -> bytes:
    """The data with its text in UTF-8; what is none is Latin-1, as old programs wrote it.

    trimesh would ask a package that guesses, where there is one.
    """
    if suffix not in ("obj", "ply") or data.isascii():
        return data
    text = len(data) if suffix == "obj" else len(header(data))
    return text_of(data[:text]).encode() + data[text:]


def _prepared(data: bytes, suffix: str) -> bytes:
    """The file's data as trimesh understands it; of an OBJ its plain lines.

    All faces are in one group where an OBJ has many materials.
    """
    if suffix == ".obj":
        if mixed_forms(data):
            return Materials(data).lines
        return re.sub(rb"usemtl[^\n]*", b"", data) if data.count(b"usemtl") > _MOST_GROUPS else data
    if suffix == ".ply":
        return plain_ply(data)
    return plain_stl(data) if suffix == ".stl" else data


def _part(mesh: Any, outlines: Outlines, colors: PlyColors | None = None) -> Part:
    """A trimesh.Trimesh as plain arrays; ValueError where they do not fit together (trimesh may not look).

    uv have v = 0 on top, which these formats have at the bottom.
    """
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
    elements = mesh.metadata.get("_ply_raw", {})
    uv = of_vertices(elements) if elements else _uv(mesh.visual, len(vertices))
    if has_corners(elements) and len(faces):
        apart = taken_apart(elements)
        if apart is None:
            outlines.left_over[ODD] = None
        else:
            old, uv, faces = apart
            vertices, normals = vertices[old], None if normals is None else normals[old]
    uv = None if uv is None else uv * (1.0, -1.0) + (0.0, 1.0)
    faces = outlines.ply(vertices, faces, elements)
    corners: Callable[[], np.ndarray] | None = None
    if colors is None:
        colored = bool(mesh.visual.defined) and mesh.visual.kind != "texture"
    else:  # those of vertices go before those of faces; trimesh drops them where there are uv
        colored = bool(colors.types) and uv is None and len(faces) > 0
        corners = colors.corners(elements, faces) if colored else None
    return Part(
        len(vertices),
        len(faces),
        given,
        colored,
        lambda: (vertices, faces, normals, uv),
        uv is not None,
        corners=corners,
    )


def _uv(visual: Any, vertices: int) -> np.ndarray | None:
    """The uv (n, 2) of a trimesh's vertices."""
    uv = getattr(visual, "uv", None)
    if uv is None:
        return None
    found = np.array(uv, np.float64)
    if found.shape != (vertices, 2):
        raise ValueError("uv must be 2 numbers for each vertex")
    return found


def _check_lists(elements: dict[str, Any]) -> None:
    """Raise BrokenMesh where lists of a binary PLY differ in length: trimesh takes the first one's for all.

    It refuses a file of another length, but a triangle and a pentagon are as long as two quadrilaterals.
    """
    for name, element in elements.items():
        rows = element.get("data")
        for field in (rows.dtype.names or ()) if isinstance(rows, np.ndarray) else ():
            lists = rows[field]
            if lists.dtype.names and lists.size and (lists["f0"] != lists["f0"][0]).any():
                raise BrokenMesh(f"its lists of a {name} differ in length; save it as text, or in triangles")
