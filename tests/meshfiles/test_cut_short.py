"""Files that end too early are refused, with the line; they were read as smaller meshes without a word."""

from __future__ import annotations

import struct
from pathlib import Path

import pytest

import clrt
from clrt.base.errors import SceneError
from clrt.scene.scene import Mesh

PLY = (
    "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
    "element face 3\nproperty list uchar int vertex_indices\nproperty uchar flag\nend_header\n"
    "0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 1 2 7\n4 0 1 3 2 7\n3 1 2 3 7\n"
)
SOLID = (
    "solid {0}\n  facet normal 0 0 1\n    outer loop\n      vertex 0 0 {1}\n      vertex 1 0 {1}\n"
    "      vertex 0 1 {1}\n    endloop\n  endfacet\nendsolid {0}\n"
)
TWO = SOLID.format("one", 1) + SOLID.format("two", 2)
OBJ = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nf 1 2 3\nf 1/1 2/1 3/1\n"


def faces(folder: Path, suffix: str, text: str) -> int:
    (folder / f"a{suffix}").write_text(text, newline="")
    (shape,) = clrt.load(folder / f"a{suffix}").shapes
    assert isinstance(shape, Mesh)
    return len(shape.data().faces)


@pytest.mark.parametrize(
    ("suffix", "text", "end", "says"),
    [
        (".ply", PLY, "3 1 2 3 7\n", r"it ends in line 16: it has 2 of the 3 rows of 'face'"),
        (".ply", PLY, " 2 3 7\n", r"line 17: row 2 of 'face' has 2 of its 5 numbers"),
        (".ply", PLY, " 7\n", r"line 17: row 2 of 'face' has 4 of its 5 numbers"),
        (".ply", PLY, PLY[PLY.index("1 0 0\n"):], r"it ends in line 11: it has 1 of the 4 rows of 'vertex'"),
        (".ply", PLY.replace("\n1 0 0", "\n\n1 0 0"), "3 1 2 3 7\n", r"it ends in line 17: it has 2 of"),
        (".stl", TWO, "endsolid two\n", r"it ends in line 17, and the solid of line 10 has no endsolid"),
        (".stl", TWO[: len(TWO) // 2], "endsolid one\n", r"it ends in line 8, and the solid of line 1 has"),
        (".stl", TWO, TWO[TWO.rindex("0 1 2"):], r"line 15: 'vertex': a corner is 'vertex x y z'"),
        (".obj", OBJ, " 3/1\n", r"it ends within line 6, 'f 1/1 2/1'; it may be cut short"),
        (".obj", OBJ, "1\n", r"it ends within line 6, 'f 1/1 2/1 3/'"),
        (".obj", OBJ, "/1\n", r"it ends within line 6, 'f 1/1 2/1 3'"),
    ],
)  # fmt: skip
def test_a_file_that_is_cut_short_is_refused(
    tmp_path: Path, suffix: str, text: str, end: str, says: str
) -> None:
    assert text.endswith(end) and faces(tmp_path, suffix, text) >= 1
    assert faces(tmp_path, suffix, text.rstrip("\n")) >= 1, "the end of the last line may lack"
    with pytest.raises(SceneError, match=says):
        faces(tmp_path, suffix, text.removesuffix(end))


@pytest.mark.parametrize(
    ("old", "new", "says"),
    [
        ("      vertex 0 0 1\n", "", r"line 7: 'endfacet': the facet has 2 corners, not 3"),
        ("  endfacet\n", "", r"line 8: 'endsolid one': the facet before it is not whole"),
        ("0 0 1\n    outer", "0 0 1\nfacet\n    outer", r"line 3: 'facet': facets stand in a solid"),
    ],
)
def test_facets_that_are_not_whole_are_refused(tmp_path: Path, old: str, new: str, says: str) -> None:
    with pytest.raises(SceneError, match=says):
        faces(tmp_path, ".stl", TWO.replace(old, new, 1))


@pytest.mark.parametrize("name", ["vertex 1 2 3", "endsolid", "a endsolid b", "facet", "solid", "", "x" * 99])
@pytest.mark.parametrize("count", [1, 2, 70])
def test_solids_may_be_called_anything(tmp_path: Path, name: str, count: int) -> None:
    text = "".join(SOLID.format(name, k) for k in range(count))
    assert faces(tmp_path, ".stl", text) == faces(tmp_path, ".stl", "; exported\n" + text.upper()) == count


def test_a_row_that_counts_in_words_is_refused(tmp_path: Path) -> None:
    with pytest.raises(SceneError, match=r"a\.ply"):
        faces(tmp_path, ".ply", PLY.replace("\n3 1 2 3 7\n", "\nthree 1 2 3 7\n"))


def binary(head: bytes, declared: int, triangles: int = 2) -> bytes:
    """A binary STL of so many triangles, which declares others."""
    data = b"".join(struct.pack("<12fH", *(0, 0, 1, k, 0, 0, 1, 0, 0, 0, 1, 0), 0) for k in range(triangles))
    return head.ljust(80, b"\0") + struct.pack("<I", declared) + data


@pytest.mark.parametrize("head", [b"", b"solid of a program", b"facets and vertex"])
def test_a_binary_stl_has_the_bytes_that_it_declares(tmp_path: Path, head: bytes) -> None:
    file = tmp_path / "a.stl"
    right = binary(head, 2)
    file.write_bytes(right)
    assert len(clrt.load(file).shapes[0].data().faces) == 2  # type: ignore[union-attr]
    for data, says in (
        (right[:-1], "it declares 2 triangles and has 1; it may be cut short"),
        (binary(head, 3), "it declares 3 triangles and has 2; it may be cut short"),
        (binary(head, 2**32 - 1), "it declares 4294967295 triangles and has 2; it may be cut short"),
        (right[:90], "it declares 2 triangles and has 0; it may be cut short"),
        (right[:83], "it has 83 bytes, the beginning of a binary file 84; it may be cut short"),
        (right + b"\n", "it declares 2 triangles, which end at byte 184, and has 185; save it anew"),
        (binary(head, 0), "it declares 0 triangles, which end at byte 84, and has 184; save it anew"),
    ):
        file.write_bytes(data)
        with pytest.raises(SceneError, match=rf"a\.stl: .*{says}$"):
            clrt.load(file)


def test_zeros_behind_a_text_are_no_binary_stl(tmp_path: Path) -> None:
    text = SOLID.format("", 1).replace("endsolid \n", "endsolid")
    assert faces(tmp_path, ".stl", text + "\0" * 50) == 1
    with pytest.raises(SceneError, match=r"it ends in line 8, and the solid of line 1 has no endsolid"):
        faces(tmp_path, ".stl", text[: text.index("  endfacet")] + "\0" * 50)
    (tmp_path / "a.stl").write_bytes(TWO.encode("utf-16"))
    with pytest.raises(SceneError, match="its text is UTF-16; save it as UTF-8"):
        clrt.load(tmp_path / "a.stl")


@pytest.mark.parametrize("text", ["", "\n", "; nothing\n", "endloop\n"])
def test_a_text_without_a_solid_is_no_stl(tmp_path: Path, text: str) -> None:
    with pytest.raises(SceneError, match=r"a\.stl"):
        faces(tmp_path, ".stl", text)
