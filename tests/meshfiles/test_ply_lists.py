"""Binary PLY files with faces of different numbers of corners."""

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

POINTS = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (2, 0, 0), (2, 1, 0), (1.5, 2, 0), (0.25, 0.5, 1)]
FACES = [(0, 1, 2, 3), (0, 1, 7), (1, 4, 5, 6, 2), (2, 3, 7)]


def _mixed(form: str, wedges: bool) -> bytes:
    """Faces of 3 to 5 corners with a colour and, behind it, a second list, uv of their corners."""
    order = {"ascii": "", "binary_little_endian": "<", "binary_big_endian": ">"}[form]
    lines = [f"ply\nformat {form} 1.0", f"element vertex {len(POINTS)}"]
    lines += [f"property float {x}" for x in "xyz"]
    lines += [f"element face {len(FACES)}", "property list uchar int vertex_indices"]
    lines += [f"property uchar {name}" for name in ("red", "green", "blue")]
    lines += ["property list uchar float texcoord", "property int texnumber"] if wedges else []
    data = "\n".join([*lines, "end_header\n"]).encode()
    rows: list[list[tuple[str, Any]]] = [[("f", x) for x in point] for point in POINTS]
    for number, face in enumerate(FACES):
        color = ("B", 255), ("B", 60 * number), ("B", 0)
        row = [("B", len(face)), *(("i", corner) for corner in face), *color]
        more = [("B", 2 * len(face)), *(("f", 0.5 * k) for k in range(2 * len(face))), ("i", 0)]
        rows.append([*row, *(more if wedges else [])])
    if not order:
        return data + "\n".join(" ".join(repr(x) for _, x in row) for row in rows).encode() + b"\n"
    return data + b"".join(struct.pack(order + code, x) for row in rows for code, x in row)


@pytest.mark.parametrize("wedges", [False, True])
@pytest.mark.parametrize("form", ["binary_little_endian", "binary_big_endian"])
def test_faces_of_any_number_of_corners(form: str, wedges: bool, tmp_path: Path) -> None:
    """As Blender writes them; trimesh took the first number for all, and said that bytes are missing."""
    found = []
    for name in ("ascii", form):
        (tmp_path / f"{name}.ply").write_bytes(_mixed(name, wedges))
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", clrt.ClrtWarning)
            scene = clrt.load(tmp_path / f"{name}.ply")
        (shape,) = scene.shapes
        assert isinstance(shape, Mesh) and shape.primitives == 2 + 1 + 3 + 1
        found.append(shape.data())
    for name in ("vertices", "faces", "uv"):
        one, other = (getattr(data, name) for data in found)
        assert (one is None) == (other is None) and (one is None or np.array_equal(one, other)), name


@pytest.mark.parametrize("cut", [1, 9, 40])
def test_a_binary_file_that_is_cut_says_so(cut: int, tmp_path: Path) -> None:
    (tmp_path / "a.ply").write_bytes(_mixed("binary_little_endian", False)[:-cut])
    with pytest.raises(clrt.ClrtError, match="it is shorter than its header declares; it may be cut short"):
        clrt.load(tmp_path / "a.ply")


@pytest.mark.parametrize("rows", ["element x 1000000000000\n", "element x 4000000\nproperty uchar a\n"])
def test_rows_that_take_no_room_cost_none(rows: str, tmp_path: Path) -> None:
    """As many lines of a text would take hours, or a hundred times the file in memory."""
    whole = _mixed("binary_little_endian", False).replace(b"end_header", rows.encode() + b"end_header")
    (tmp_path / "a.ply").write_bytes(whole + bytes(4_000_000))
    started = time.process_time()
    with pytest.raises(clrt.ClrtError, match=r"a\.ply: cannot be read"):
        clrt.load(tmp_path / "a.ply")
    assert time.process_time() - started < 2


@pytest.mark.parametrize("count", ["float", "double", "int"])
def test_lengths_that_are_none(count: str, tmp_path: Path) -> None:
    data = _mixed("binary_little_endian", False).replace(b"list uchar int", f"list {count} int".encode())
    (tmp_path / "a.ply").write_bytes(data + struct.pack("<3d", np.inf, np.nan, -1))
    with pytest.raises(clrt.ClrtError, match=r"a\.ply: (cannot be read|it has no faces)"):
        clrt.load(tmp_path / "a.ply")


def test_types_that_are_none_are_refused(tmp_path: Path) -> None:
    data = _mixed("binary_little_endian", False).replace(b"property uchar red", b"property colour red")
    (tmp_path / "a.ply").write_bytes(data)
    with pytest.raises(clrt.ClrtError, match=r"a\.ply: cannot be read"):
        clrt.load(tmp_path / "a.ply")


def test_places_in_capitals_and_vertices_without(tmp_path: Path) -> None:
    names = "property float {}\nproperty float Y\nproperty float Z\n"
    head = f"ply\nformat ascii 1.0\nelement vertex 3\n{names}element face 1\n"
    rest = "property list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n"
    (tmp_path / "a.ply").write_text(head.format("X") + rest)
    (mesh,) = clrt.load(tmp_path / "a.ply").shapes
    assert isinstance(mesh, Mesh) and mesh.data().vertices.tolist() == [[0, 0, 0], [1, 0, 0], [0, 1, 0]]
    (tmp_path / "a.ply").write_text(head.format("q") + rest)
    with pytest.raises(clrt.ClrtError, match="its vertices have no properties x, y and z, but 'Y, Z, q'"):
        clrt.load(tmp_path / "a.ply")


@pytest.mark.parametrize("types", ["uchar uchar", "uint8 int8", "char char", "ushort uint16", "int int"])
@pytest.mark.parametrize("gap", ["", "\n", " \n\t\n"])
def test_types_of_corners_in_a_text_bound_nothing(types: str, gap: str, tmp_path: Path) -> None:
    """There they take no room; numbers above 255 were taken modulo 256. Lines between may be empty."""
    n = 20
    points = [(x, y, 0) for y in range(n + 1) for x in range(n + 1)]
    corners = [y * (n + 1) + x for y in range(n) for x in range(n)]
    faces = [(a, a + 1, a + n + 2, a + n + 1) for a in corners]
    head = ["ply", "format ascii 1.0", f"element vertex {len(points)}"]
    head += [*(f"property float {x}" for x in "xyz"), f"element face {len(faces)}"]
    head += [f"property list {types} vertex_indices", "end_header\n"]
    rows = ["\n".join(" ".join(map(str, row)) for row in part) for part in (points, [(4, *f) for f in faces])]
    (tmp_path / "a.ply").write_text("\n".join(head) + gap + f"\n{gap}".join(rows) + f"\n{gap}")
    (mesh,) = clrt.load(tmp_path / "a.ply").shapes
    assert isinstance(mesh, Mesh)
    v, f = mesh.data().vertices, np.asarray(mesh.data().faces)
    area = np.linalg.norm(np.cross(v[f[:, 1]] - v[f[:, 0]], v[f[:, 2]] - v[f[:, 0]]), axis=1).sum() / 2
    assert area == n * n


def test_the_line_of_a_row_that_is_cut_is_told_among_empty_ones(tmp_path: Path) -> None:
    head = ["ply", "format ascii 1.0", "element vertex 3", *(f"property float {x}" for x in "xyz")]
    head += ["element face 1", "property list uchar uchar vertex_indices", "end_header"]
    (tmp_path / "a.ply").write_text("\n".join([*head, "", "0 0 0", "1 0 0", "", "0 1", "3 0 1 2", ""]))
    with pytest.raises(clrt.ClrtError, match=r"line 14: row 2 of 'vertex' has 2 of its 3 numbers"):
        clrt.load(tmp_path / "a.ply")
