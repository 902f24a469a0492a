"""Normals and uv of PLY files stay with their corners, whatever a program wrote beside them."""

from __future__ import annotations

import struct
import time
import warnings
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import clrt
from clrt.scene.mesh import Mesh

KINDS = {"uchar": "B", "int": "i", "float": "f"}
FORMATS = ("ascii", "binary_little_endian", "binary_big_endian")
Rows = list[list[tuple[str, Any]]]


def _written(form: str, elements: dict[str, tuple[list[str], Rows]], before: str = "") -> bytes:
    """A file of elements, each with the properties that it declares and rows of pairs of type and value."""
    head = [f"ply\n{before}format {form} 1.0"]
    for name, (properties, rows) in elements.items():
        head += [f"element {name} {len(rows)}", *(f"property {words}" for words in properties)]
    data = "\n".join([*head, "end_header\n"]).encode()
    rows = [row for _, table in elements.values() for row in table]
    if form == "ascii":
        return data + b"".join(" ".join(repr(value) for _, value in row).encode() + b"\n" for row in rows)
    order = "<" if "little" in form else ">"
    return data + b"".join(struct.pack(order + KINDS[kind], value) for row in rows for kind, value in row)


def _drawn(seed: int, sizes: tuple[int, ...], uv: str, loose: int) -> tuple[Any, ...]:
    """Convex faces of so many corners, and their elements; of each corner its place, normal and uv."""
    draw = np.random.default_rng(seed)
    points = np.round(draw.uniform(-1, 1, (12 + loose, 2)), 3).astype(np.float32)
    places = np.column_stack([points, np.zeros(len(points), np.float32)])
    normals = np.round(draw.uniform(-1, 1, places.shape), 3).astype(np.float32)
    of_vertices = draw.integers(0, 8, (len(places), 2)).astype(np.float32) / 8
    faces = []
    for size in draw.choice(sizes, 9):
        face = draw.choice(12, size, replace=False)
        center = points[face].mean(axis=0)
        turn = np.argsort(np.arctan2(*(points[face] - center).T[::-1]))
        faces.append(face[turn])
    of_corners = [draw.integers(0, 2, (len(face), 2)).astype(np.float32) / 2 for face in faces]
    names = ["float x", "float y", "float z", "float nx", "float ny", "float nz"]
    table = np.column_stack([places, normals, of_vertices][: 3 if uv == "vertex" else 2])
    vertex = names + (["float s", "float t"] if uv == "vertex" else [])
    rows = [[("float", float(value)) for value in row] for row in table]
    face_rows: Rows = []
    for face, own in zip(faces, of_corners, strict=True):
        row: list[tuple[str, Any]] = [("uchar", len(face)), *(("int", int(k)) for k in face)]
        if uv == "corner":
            row += [("uchar", own.size), *(("float", float(value)) for value in own.ravel())]
        face_rows.append([*row, ("int", 7)])
    lists = ["list uchar int vertex_indices", *(["list uchar float texcoord"] if uv == "corner" else [])]
    elements = {"vertex": (vertex, rows), "face": ([*lists, "int texnumber"], face_rows)}
    corners = set()
    for face, own in zip(faces, of_corners, strict=True):
        for k, at in enumerate(face):
            pair = {"vertex": of_vertices[at], "corner": own[k], "": np.zeros(2, np.float32)}[uv]
            unit = normals[at].astype(np.float64) / np.linalg.norm(normals[at].astype(np.float64))
            corners.add(tuple(np.round([*places[at], *unit, *pair], 4) + 0.0))
    return elements, corners, sum(len(face) - 2 for face in faces)


@pytest.mark.parametrize("uv", ["", "vertex", "corner"])
@pytest.mark.parametrize("sizes", [(3,), (4,), (3, 4), (3, 4, 5, 6)])
@pytest.mark.parametrize("loose", [0, 1, 5])
def test_each_corner_has_what_the_file_gives_it(
    tmp_path: Path, uv: str, sizes: tuple[int, ...], loose: int
) -> None:
    """trimesh takes vertices apart by uv, and leaves normals in their old order, or drops them."""
    for seed, form in enumerate(FORMATS):
        elements, corners, triangles = _drawn(seed, sizes, uv, loose)
        (tmp_path / "a.ply").write_bytes(_written(form, elements))
        (shape,) = clrt.load(tmp_path / "a.ply").shapes
        assert isinstance(shape, Mesh)
        data = shape.data()
        assert len(data.faces) == triangles and data.normals is not None and (data.uv is None) == (not uv)
        pairs = np.zeros((len(data.vertices), 2)) if data.uv is None else data.uv * (1, -1) + (0, 1)
        found = np.column_stack([data.vertices, data.normals, pairs])[np.unique(data.faces)]
        assert {tuple(row) for row in np.round(found, 4) + 0.0} == corners, (form, seed)


def test_uv_that_are_not_two_numbers_a_corner_are_named(tmp_path: Path) -> None:
    """As where only a part of a model has them: each face has a list, and some are empty."""
    elements, *_ = _drawn(1, (3, 4), "corner", 0)
    row = elements["face"][1][2]
    size = row[0][1]
    row[1 + size :] = [("uchar", 0), row[-1]]
    for form in FORMATS:
        (tmp_path / "a.ply").write_bytes(_written(form, elements))
        with pytest.warns(clrt.ClrtWarning, match="its texcoord of faces that have not two numbers"):
            (shape,) = clrt.load(tmp_path / "a.ply").shapes
        assert isinstance(shape, Mesh) and shape.data().uv is None and shape.data().normals is not None


@pytest.mark.parametrize("uv", ["", "vertex", "corner"])
@pytest.mark.parametrize("form", FORMATS)
def test_a_corner_that_is_not_there_is_refused(tmp_path: Path, form: str, uv: str) -> None:
    elements, *_ = _drawn(4, (3,), uv, 0)
    for wrong in (-1, 12):
        elements["face"][1][3][1] = ("int", wrong)
        (tmp_path / "a.ply").write_bytes(_written(form, elements))
        with pytest.raises(clrt.SceneError, match="a face names a vertex that is not among the 12"):
            clrt.load(tmp_path / "a.ply")


@pytest.mark.parametrize("colored", [False, True])
@pytest.mark.parametrize("form", FORMATS)
def test_edges_are_named_and_cost_nothing(tmp_path: Path, form: str, colored: bool) -> None:
    """trimesh makes a graph of them, as many nodes as the largest number says, for a time in their square."""
    elements, *_ = _drawn(5, (3,), "", 0)
    color = [("uchar", 9)] * 3 if colored else []
    edges = [[("int", k), ("int", 3_000_000 - k), *color] for k in range(2_000)]
    names = ["int vertex1", "int vertex2", *(["uchar red", "uchar green", "uchar blue"] if colored else [])]
    (tmp_path / "a.ply").write_bytes(_written(form, elements | {"edge": (names, edges)}))
    began = time.process_time()
    with pytest.warns(clrt.ClrtWarning, match="its edges are left out$"):
        clrt.load(tmp_path / "a.ply")
    assert time.process_time() - began < 2
    (tmp_path / "a.ply").write_bytes(_written(form, elements | {"edge": (names, [])}))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        clrt.load(tmp_path / "a.ply")


@pytest.mark.parametrize("before", ["comment made by hand\n", "obj_info 3\ncomment format ascii 1.0\n", "\n"])
@pytest.mark.parametrize("form", FORMATS)
def test_the_format_stands_anywhere_in_the_header(tmp_path: Path, before: str, form: str) -> None:
    elements, *_ = _drawn(2, (3,), "vertex", 0)
    found = []
    for text in ("", before):
        (tmp_path / "a.ply").write_bytes(_written(form, elements, text))
        (shape,) = clrt.load(tmp_path / "a.ply").shapes
        assert isinstance(shape, Mesh)
        found.append(shape.data())
    for name in ("vertices", "faces", "normals", "uv"):
        assert np.array_equal(getattr(found[0], name), getattr(found[1], name)), name


@pytest.mark.parametrize("form", FORMATS)
def test_the_only_list_of_faces_is_of_corners(tmp_path: Path, form: str) -> None:
    elements, _, triangles = _drawn(3, (4,), "", 0)
    (tmp_path / "a.ply").write_bytes(_written(form, elements).replace(b"vertex_indices", b"indices"))
    (shape,) = clrt.load(tmp_path / "a.ply").shapes
    assert isinstance(shape, Mesh) and shape.primitives == triangles
