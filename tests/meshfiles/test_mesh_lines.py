"""Faces of OBJ and PLY files that trimesh alone would take for others, or pass over."""

from __future__ import annotations

import struct
from pathlib import Path

import numpy as np
import pytest

from clrt.base.errors import SceneError
from clrt.base.limits import Limits
from clrt.base.places import At
from clrt.meshfiles.file import read_mesh_file

POINTS = np.random.default_rng(3).integers(-99, 99, (8, 3)).astype(float)


def corners(path: Path) -> list[list[list[float]]]:
    vertices, faces, _, _ = read_mesh_file(path, At(path="mesh"), Limits(), False)
    return vertices[faces].tolist()


def obj(path: Path, text: str, vertices: str = "v {} {} {}\n") -> Path:
    """An OBJ file; `text` follows its vertices."""
    path.write_text("".join(vertices.format(*point) for point in POINTS) + text, newline="")
    return path


def test_numbers_below_zero_count_back_from_their_line(tmp_path: Path) -> None:
    lines = ["v {} {} {}\n".format(*point) for point in POINTS]
    text = "".join(lines[:3]) + "f -3 -2 -1\n" + "".join(lines[3:6]) + "f -1 -3 1\n" + "".join(lines[6:])
    (tmp_path / "a.obj").write_text(text)
    assert corners(tmp_path / "a.obj") == [POINTS[[0, 1, 2]].tolist(), POINTS[[5, 3, 0]].tolist()]
    normals = "vn 1 0 0\nvn 0 1 0\nvn 0 0 1\nf 1//-3 2//-2 3//-1\nvn 0 0 -1\nf 1//-1 2//-1 3//-1\n"
    path = obj(tmp_path / "b.obj", normals)
    vertices, faces, found, _ = read_mesh_file(path, At(path="mesh"), Limits(), None)
    assert found is not None
    assert found[faces].tolist() == [[[1, 0, 0], [0, 1, 0], [0, 0, 1]], [[0, 0, -1]] * 3]
    assert vertices[faces].tolist() == [POINTS[:3].tolist()] * 2


@pytest.mark.parametrize(
    "line",
    ["  f 4 5 6\n", "\tf 4 5 6\n", "f\t4\t5 6\n", "f 4 5 6 # 7\n", "f 4 5 6# -7\n", "f 4 \\\n 5 6\n",
     "\rf 4 5 6\r", "f 04 +5 6\n", "   \no a#b\nf -5 -4 -3 \n"],
)  # fmt: skip
def test_no_line_is_passed_over(tmp_path: Path, line: str) -> None:
    expected = [POINTS[:3].tolist(), POINTS[3:6].tolist(), POINTS[5:].tolist()]
    assert corners(obj(tmp_path / "a.obj", f"f 1 2 3\n{line}f 6 7 8\n")) == expected


def test_vertices_in_odd_lines_count(tmp_path: Path) -> None:
    for line in ("v\t{} {} {}\n", " v {} {} {}\n", "v {} {} {} # v 1 2 3\n"):
        path = obj(tmp_path / "a.obj", "f 1 2 3\nf -1 -2 -3\n", line)
        assert corners(path) == [POINTS[:3].tolist(), POINTS[:4:-1].tolist()]


@pytest.mark.parametrize("corner", ["0", "-9", "x-0", "-x", "1/-1", "1/0"])
def test_numbers_of_no_vertex_are_refused(tmp_path: Path, corner: str) -> None:
    with pytest.raises(SceneError, match=r"a\.obj cannot be .*: a face names (vt? -?\d+ after|'.*')"):
        corners(obj(tmp_path / "a.obj", f"f 1 2 3\nf -1 2 {corner}\n"))


def test_lists_of_different_lengths_are_refused(tmp_path: Path) -> None:
    head = (
        "ply\nformat binary_little_endian 1.0\nelement vertex 8\nproperty float x\nproperty float y\n"
        "property float z\nelement face 3\nproperty list uchar int vertex_indices\nend_header\n"
    )
    points = POINTS.astype("<f4").tobytes()

    def write(*faces: list[int]) -> Path:
        rows = b"".join(struct.pack(f"<B{len(face)}i", len(face), *face) for face in faces)
        (tmp_path / "a.ply").write_bytes(head.encode() + points + rows)
        return tmp_path / "a.ply"

    assert len(corners(write([0, 1, 2, 3], [2, 3, 4, 5], [4, 5, 6, 7]))) == 6
    with pytest.raises(SceneError, match="its lists of a face differ in length; save it as text"):
        corners(write([0, 1, 2, 3], [2, 3, 4], [0, 1, 2, 3, 4]))
