"""Names and comments of meshes in Latin-1, as programs before UTF-8 wrote them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import clrt

OBJ = "# W\xfcrfel\no W\xfcrfel\ng \xe9\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"
HEAD = """ply
format {form} 1.0
comment W\xfcrfel
element vertex 3
property float x
property float y
property float z
element face 1
property list uchar int vertex_indices
end_header
"""
TEXT = HEAD.format(form="ascii") + "0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n"
VERTICES = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]], "<f4")
FACES = b"\x03" + np.arange(3, dtype="<i4").tobytes()


@pytest.mark.parametrize("encoding", ["latin-1", "utf-8"])
@pytest.mark.parametrize("kind", ["obj", "ply", "binary ply"])
def test_they_are_read(tmp_path: Path, kind: str, encoding: str) -> None:
    data = (OBJ if kind == "obj" else TEXT).encode(encoding)
    if kind == "binary ply":  # whose numbers are no text: 1.0 as float32 has bytes beyond ASCII
        data = HEAD.format(form="binary_little_endian").encode(encoding) + VERTICES.tobytes() + FACES
    file = tmp_path / f"a.{kind[-3:]}"
    file.write_bytes(data)
    scene = clrt.load_dict({"shapes": [{"type": "mesh", "file": file.name}]}, folder=tmp_path)
    assert np.array_equal(np.asarray(scene.shapes[0].data().vertices), VERTICES)
    assert len(clrt.load(file).shapes) == 1


def test_what_is_no_text_at_all_is_said_in_words(tmp_path: Path) -> None:
    """Not by the name of a package that would guess."""
    (tmp_path / "a.stl").write_bytes(bytes(range(128, 256)) * 9)
    with pytest.raises(clrt.SceneError, match=r"a\.stl") as caught:
        clrt.load(tmp_path / "a.stl")
    assert "Module" not in str(caught.value) and "Unicode" not in str(caught.value)
    (tmp_path / "a.ply").write_bytes(TEXT.encode("latin-1").replace(b"1 0 0", b"\xff\xfe 0 0"))
    with pytest.raises(clrt.SceneError, match=r"a\.ply cannot be read as a mesh: it is no text in UTF-8"):
        clrt.load(tmp_path / "a.ply")
