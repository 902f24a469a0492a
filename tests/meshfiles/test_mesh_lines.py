"""Faces of OBJ and PLY files that trimesh alone would take for others, or pass over."""

from __future__ import annotations

import struct
from pathlib import Path

import numpy as np
import pytest

from clrt.base.errors import ClrtWarning, SceneError
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


DART = [(0, 0, 0), (2, 0, 0), (0.5, 0.5, 0), (0, 2, 0)]
ELL = [(0, 0, 0), (2, 0, 0), (2, 1, 0), (1, 1, 0), (1, 2, 0), (0, 2, 0)]


@pytest.mark.parametrize(
    ("outline", "first"), [*((DART, first) for first in range(4)), *((ELL, first) for first in range(6))]
)
@pytest.mark.parametrize("kind", ["obj", "ply", "binary.ply"])
def test_concave_faces_are_covered_whatever_corner_comes_first(
    tmp_path: Path, recwarn: pytest.WarningsRecorder, outline: list[tuple[float, ...]], first: int, kind: str
) -> None:
    numbers = [(first + k) % len(outline) for k in range(len(outline))]
    # A second face, so that the halves of quadrilaterals of a PLY do not stand side by side.
    points = [*outline, *((x, y, 1.0) for x, y, _ in ((0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0.7, 0),
                                                      (0, 0.3, 0))[: len(outline)])]  # fmt: skip
    lists = [numbers, [len(outline) + k for k in range(len(outline))]]
    path = tmp_path / f"a.{kind}"
    if kind == "obj":
        lines = [f"v {x} {y} {z}" for x, y, z in points]
        path.write_text("\n".join(lines + ["f " + " ".join(str(k + 1) for k in face) for face in lists]))
    else:
        text = "ascii" if kind == "ply" else "binary_big_endian"
        head = (f"ply\nformat {text} 1.0\nelement vertex {len(points)}\nproperty float x\nproperty float y\n"
                "property float z\nelement face 2\nproperty list uchar int vertex_indices\n"
                "end_header\n")  # fmt: skip
        rows = [*points, *([len(face), *face] for face in lists)]
        body = "".join(" ".join(map(str, row)) + "\n" for row in rows).encode()
        if kind == "binary.ply":
            body = b"".join(struct.pack(">3f", *point) for point in points)
            body += b"".join(struct.pack(f">B{len(face)}i", len(face), *face) for face in lists)
        path.write_bytes(head.encode() + body)
    found = np.array(corners(path))
    area = np.linalg.norm(np.cross(found[:, 1] - found[:, 0], found[:, 2] - found[:, 0]), axis=1).sum() / 2
    whole = (1.0 if outline is DART else 3.0) + 1.0
    assert abs(area - whole) < 1e-6  # sums of a few numbers of up to 53 bits
    assert not recwarn


@pytest.mark.parametrize("kind", ["ascii", "binary_little_endian"])
@pytest.mark.parametrize("names", ["texture_u texture_v", "texture_s texture_t", "u v", "s t"])
def test_uv_of_a_ply_by_all_their_names(tmp_path: Path, kind: str, names: str) -> None:
    properties = "".join(f"property float {name}\n" for name in ["x", "y", "z", *names.split()])
    head = f"ply\nformat {kind} 1.0\nelement vertex 3\n{properties}"
    head += "element face 1\nproperty list uchar int vertex_indices\nend_header\n"
    rows = np.array([[0, 0, 0, 0.25, 1], [1, 0, 0, 0, 0.5], [0, 1, 0, 0.75, 0]], "<f4")
    body = "\n".join(" ".join(map(str, row)) for row in rows) + "\n3 0 1 2\n"
    data = rows.tobytes() + struct.pack("<B3i", 3, 0, 1, 2)
    (tmp_path / "a.ply").write_bytes(head.encode() + (body.encode() if kind == "ascii" else data))
    vertices, faces, _, uv = read_mesh_file(tmp_path / "a.ply", At(path="mesh"), Limits(), False)
    assert uv is not None and np.array_equal(vertices[faces[0]], rows[:, :3])
    assert np.array_equal(uv[faces[0]], rows[:, 3:] * [1, -1] + [0, 1])


def test_what_no_line_tells_is_told_of_the_file(tmp_path: Path) -> None:
    """Its lines are right one by one."""
    path = obj(tmp_path / "a.obj", "vt 0\nf 1/1 2/1 3/1\n")
    with pytest.raises(SceneError, match=r"a\.obj cannot be read as a mesh: uv must be 2 numbers"):
        corners(path)


def ply(faces: list[str], kind: str = "ascii") -> str:
    """The text of a PLY up to its faces, and these."""
    rows = "".join(f"{x} {y} {z}\n" for x, y, z in POINTS)
    head = f"ply\nformat {kind} 1.0\nelement vertex 8\nproperty float x\nproperty float y\nproperty float z\n"
    list_ = f"element face {len(faces)}\nproperty list uchar int vertex_indices\nend_header\n"
    return head + list_ + (rows + "".join(f"{face}\n" for face in faces) if kind == "ascii" else "")


@pytest.mark.parametrize("mark", [b"", b"\xef\xbb\xbf"])
def test_ply_of_old_line_ends(mark: bytes, tmp_path: Path) -> None:
    """As programs on old Macintoshes wrote them; of a binary file the header alone has lines."""
    text, path = ply(["3 0 1 2", "4 3 4 5 6"]).encode(), tmp_path / "a.ply"
    path.write_bytes(text)
    expected = corners(path)
    path.write_bytes(mark + text.replace(b"\n", b"\r"))
    assert len(expected) == 3 and corners(path) == expected
    rows = POINTS.astype("<f4").tobytes() + struct.pack("<B3i", 3, 0, 1, 13 % 8)
    path.write_bytes(ply(["..."], "binary_little_endian").encode().replace(b"\n", b"\r") + rows)
    assert corners(path) == [POINTS[[0, 1, 5]].tolist()]


def test_narrow_faces_of_a_ply_are_told(tmp_path: Path) -> None:
    path = tmp_path / "a.ply"
    path.write_text(ply(["3 0 1 2", "1 3", "0", "2 4 5", "4 3 4 5 6"]))
    with pytest.warns(ClrtWarning, match=r"a.ply: its faces of fewer than 3 corners are left out") as told:
        assert len(corners(path)) == 3
    assert len(told) == 1
