"""Texts with a byte order mark of UTF-8, as editors write it: it is no part of what they say."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

import clrt
from clrt.base.mark import unmarked
from clrt.formats import READERS
from clrt.scene.scene import Mesh
from tests.meshfiles.test_gltf import document
from tests.meshfiles.test_latin1 import FACES, HEAD, TEXT, VERTICES
from tests.model_samples import model, write_glb

MARK = b"\xef\xbb\xbf"
FACET = b"facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\n"
BINARY = bytes(80) + (1).to_bytes(4, "little") + bytes(12) + VERTICES.tobytes() + bytes(2)
TEXTS = {
    "a.toml": b'ambient = 1\n[[shapes]]\ntype = "sphere"\ncenter = [0, 0, 0]\nradius = 1\n',
    "a.json": b'{"ambient": 1, "shapes": [{"type": "sphere", "center": [0, 0, 0], "radius": 1}]}',
    "a.nff": b"v\nfrom 2 1 1\nat 0 0 0\nup 0 0 1\nangle 40\nhither 1\nresolution 4 3\nl 1 2 3\ns 0 0 0 1\n",
    "a.txt": b"Sphere Point 0 0 0 Radius 1 Surface Spectrum 380 750 Constants .6 .3 .1 1.4 100\n",
    "a.xml": b'<scene version="3.0.0"><shape type="sphere"/></scene>',
    "a.obj": b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n",
    "a.ply": TEXT.encode(),
    "b.ply": HEAD.format(form="binary_little_endian").encode() + VERTICES.tobytes() + FACES,
    "a.stl": b"solid a\n" + FACET + b"endsolid a\n",
    "b.stl": b"\nSOLID\n" + FACET + b"endsolid\nsolid b\n" + FACET + b"endsolid b\n",
    "a.gltf": json.dumps(document()).encode(),
}


def test_all_formats_but_those_without_text_are_here() -> None:
    assert {Path(name).suffix for name in TEXTS} == READERS.keys() - {".glb"}


@pytest.mark.filterwarnings("ignore::clrt.ClrtWarning")
@pytest.mark.parametrize("name", TEXTS)
def test_a_mark_before_a_text_is_passed_over(tmp_path: Path, name: str) -> None:
    tables = []
    for mark in (b"", MARK):
        (tmp_path / name).write_bytes(mark + TEXTS[name])
        scene = clrt.load(tmp_path / name)
        meshes = [shape.data().vertices.tolist() for shape in scene.shapes if isinstance(shape, Mesh)]
        tables.append((scene.to_dict(), meshes))
    assert tables[0] == tables[1] and tables[0][0]["shapes"]


def test_what_is_no_text_may_begin_with_the_bytes_of_a_mark(tmp_path: Path) -> None:
    (tmp_path / "a.stl").write_bytes(MARK + BINARY[3:])
    (shape,) = clrt.load(tmp_path / "a.stl").shapes
    assert isinstance(shape, Mesh) and shape.data().vertices.tolist() == VERTICES.tolist()
    write_glb(tmp_path / "a.glb", model([]))
    assert len(clrt.load(tmp_path / "a.glb").shapes) == 1


def test_one_mark_is_taken_away_and_nothing_is_copied_without() -> None:
    assert unmarked(MARK + MARK + b"x") == MARK + b"x" and unmarked(MARK) == b"" == unmarked(b"")
    plain = b"\xef\xbbx"
    assert unmarked(plain) is plain
    assert bytes(unmarked(memoryview(MARK + b"x"))) == b"x"
