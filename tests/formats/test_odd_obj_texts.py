"""OBJ and MTL files whose text is odd: marks, encodings, lines that go on, names that stand twice."""

from __future__ import annotations

import re
import time
from pathlib import Path

import pytest

import clrt
from clrt.base.errors import SceneError
from clrt.meshfiles.broken import BrokenMesh
from clrt.meshfiles.obj.lines import check_lines
from clrt.scene.scene import Material, Mesh

MARK = b"\xef\xbb\xbf"
CORNERS = b"v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n"
QUAD = b"usemtl m\nf 1 2 3 4\n"


def load(folder: Path, obj: bytes, mtl: bytes = b"newmtl m\nKd 1 0 0\n") -> clrt.Scene:
    (folder / "a.mtl").write_bytes(mtl)
    (folder / "a.obj").write_bytes(obj)
    return clrt.load(folder / "a.obj")


def color(scene: clrt.Scene, name: str) -> object:
    return scene.materials[name].color


@pytest.mark.parametrize(
    "line", [b"f 1 2 3 \\\n4\n", b"f 1 2 3\\\r\n4\r\n", b"f 1 \\\n2 \\\n3 4\n", b"f 1 2 3 \\\r4\r"]
)
@pytest.mark.parametrize("materials", [b"mtllib a.mtl\n", b""])
@pytest.mark.filterwarnings("ignore:.*its materials and colours")
def test_a_face_over_two_lines_is_whole(tmp_path: Path, line: bytes, materials: bytes) -> None:
    (shape,) = load(tmp_path, materials + CORNERS + b"usemtl m\n" + line).shapes
    assert isinstance(shape, Mesh) and shape.primitives == 2


@pytest.mark.parametrize("ends", [b"\n", b"\r\n", b"\r"])
def test_a_mark_before_the_first_line_is_passed_over(tmp_path: Path, ends: bytes) -> None:
    for first in (b"", b"mtllib a.mtl\n"):
        text = (first + CORNERS + b"mtllib a.mtl\n" * (not first) + QUAD).replace(b"\n", ends)
        scene = load(tmp_path, MARK + text, MARK + b"newmtl m\nKd 1 0 0\n".replace(b"\n", ends))
        (shape,) = scene.shapes
        assert isinstance(shape, Mesh) and shape.primitives == 2 and color(scene, "m") == (1.0, 0.0, 0.0)


def test_materials_that_a_mark_or_a_carriage_return_is_before_are_named(tmp_path: Path) -> None:
    for text in (MARK + b"usemtl m\n" + CORNERS + QUAD[9:], (CORNERS + QUAD).replace(b"\n", b"\r")):
        with pytest.warns(clrt.ClrtWarning, match="its materials and colours are ignored"):
            load(tmp_path, text)


@pytest.mark.parametrize("mtl", [b"", "newmtl m\nKd 1 0 0\n".encode("utf-16"), b"Kd 1 0 0\n"])
def test_a_library_without_any_material_is_named(tmp_path: Path, mtl: bytes) -> None:
    with pytest.warns(clrt.ClrtWarning, match="the material 'm', which its library lacks$"):
        (shape,) = load(tmp_path, b"mtllib a.mtl\n" + CORNERS + QUAD, mtl).shapes
    assert isinstance(shape.material, Material)


@pytest.mark.parametrize(
    ("one", "two", "names"),
    [
        (b"\xe9", b"\xe8", ["é", "è"]),  # Latin-1
        ("é".encode(), "è".encode(), ["é", "è"]),
        (b"\xe9", "é".encode(), ["é", "é-2"]),  # both
        (b"a\xe2\x80\xa8b", b"a\xe2\x80\xa8c", ["a\u2028b", "a\u2028c"]),  # no end of a line
        (b"a\xc2\x85b", b"a\x0bb", ["a\x85b", "a b"]),
        (b"a  b", b"a c", ["a b", "a c"]),
    ],
)
def test_names_stay_different(tmp_path: Path, one: bytes, two: bytes, names: list[str]) -> None:
    mtl = b"newmtl %b\nKd 1 0 0\nnewmtl %b\nKd 0 1 0\n" % (one, two)
    faces = b"usemtl %b\nf 1 2 3\nusemtl %b\nf 1 3 4\n" % (one, two)
    scene = load(tmp_path, b"mtllib a.mtl\n" + CORNERS + faces, mtl)
    assert [shape.material for shape in scene.shapes] == names
    assert [color(scene, name) for name in names] == [(1.0, 0.0, 0.0), (0.0, 1.0, 0.0)]


def test_what_stands_twice_is_named(tmp_path: Path) -> None:
    says = "counterpart: the earlier one of two materials called 'm'$"
    obj = b"mtllib a.mtl\n" + CORNERS + QUAD
    twice = b"newmtl m\nKd 1 0 0\nnewmtl n\nnewmtl n\nnewmtl m\nKd 0 1 0\n"
    with pytest.warns(clrt.ClrtWarning, match=says):
        assert color(load(tmp_path, obj, twice), "m") == (0.0, 1.0, 0.0)
    (tmp_path / "b.mtl").write_text("newmtl m\nKd 0 0 1\n")
    with pytest.warns(clrt.ClrtWarning, match=says):
        assert color(load(tmp_path, b"mtllib b.mtl\n" + obj), "m") == (1.0, 0.0, 0.0)


def test_a_line_of_other_letters_that_is_wrong_is_shown(tmp_path: Path) -> None:
    with pytest.raises(SceneError, match=r"'a\.mtl', line 2: 'Kd é' is not understood"):
        load(tmp_path, b"mtllib a.mtl\n" + CORNERS + QUAD, b"newmtl m\nKd \xe9\n")


THREE = b"v 0 0 0\nv 1 0 0\nv 1 1 0\n"


@pytest.mark.parametrize(
    ("text", "says"),
    [
        (THREE + b"f 1 2 9\n", "line 4: a face names v 9, and there are 3 of them"),
        (THREE + b"f 1 2 3\nf 1 3 2 9\n", "line 5: a face names v 9"),
        (THREE + b"vt 0 0\nf 1/1/1 2/1/1 9/1/1\n", "line 5: a face names v 9"),
        (THREE + b"f 1 2 99999999999999999999\n", "line 4: a face names v 99999999999999999999, and"),
        (THREE + b"f 1 2 0\n", "line 4: a face names v 0 after 3 of them; the first is 1, the last -1"),
        (THREE + b"f 1 2 -4\n", "line 4: a face names v -4 after 3 of them"),
        (THREE + b"# f 9\n\n\tf 1 \\\n2 9\n", "line 6: a face names v 9"),
        (THREE.replace(b"\n", b"\r") + b"f 1 2 9 \\\r3\rf 1 2 3\r", "line 4: a face names v 9"),
        (b"f 1 2 3\n", "line 1: a face names v 1, and there are 0 of them"),
        (b"f 1.0 2 3\n" + THREE, r"line 1: a face names '1\.0', which is no whole number"),
        (THREE + b"f 1 2 3\nf x 2 3\n", "line 5: a face names 'x', which is no whole number"),
        (THREE + b"f 1,2,3\n", "line 4: a face names '1,2,3', which is no whole number"),
        (THREE + b"f 1_0 -2 3\n", "line 4: a face names '1_0', which is no whole number"),
        (THREE + b"vt 0 0\nf 1/1.5 2/1 3/1\n", r"line 5: a face names '1\.5', which is no whole number"),
        (THREE + b"f /1 2 3\n", "line 4: a face names '/1', which has no number of a vertex"),
        (b"v 0,5 0 0\n" + THREE + b"f 1 2 3\n", "line 1: '0,5' is no number; decimals have a point"),
        (THREE + b"v 0x1 0 0\nf 1 2 3\n", "line 4: '0x1' is no number"),
        (b"v 1_0 0 0\n" + THREE + b"f 1 2 3\n", "line 1: '1_0' is no number"),
        (THREE + b"v 1 2\nf 1 2 3\n", "line 4: 'v 1 2' has fewer than 3 numbers"),
        (THREE + b"vn 0 0,1 0\nf 1//1 2//1 3//1\n", "line 4: '0,1' is no number; decimals have a point"),
        (THREE + b"vt a b\nf 1/1 2/1 3/1\n", "line 4: 'a' is no number"),
        (THREE + b"f 1 2 9\nf 1 2", "it ends within line 5, 'f 1 2'; it may be cut short"),
        (THREE + b"f 1 2 9\nf 1 2 3 \\", r"it ends within line 5, 'f 1 2 3 \\\\'; it may be cut short"),
        (THREE.replace(b"\n", b"\r") + b"f 1 2", "it ends within line 4, 'f 1 2'; it may be cut short"),
        (b"v 0,5 0 0 \\\n", "line 1: '0,5' is no number"),
        (b"v 0 0 0 \\\n", "has no faces"),
    ],
)
@pytest.mark.parametrize("before", [b"", b"mtllib a.mtl\nusemtl m\n"])
def test_a_line_that_cannot_be_read_is_told_with_its_number_and_value(
    tmp_path: Path, before: bytes, text: bytes, says: str
) -> None:
    """As a model, where its materials are read and where not, and as a mesh."""
    lines = before.count(b"\n")
    says = re.sub(r"(?<=line )\d+", lambda found: str(int(found[0]) + lines), says)
    with pytest.raises(SceneError, match=says):
        load(tmp_path, before + text)
    with pytest.raises(SceneError, match=says) as error:
        clrt.load_dict({"shapes": [{"type": "mesh", "file": "a.obj"}]}, folder=tmp_path)
    assert "\n" not in str(error.value) and "Error" not in str(error.value)


def test_lines_that_go_on_are_looked_through_in_a_time_of_their_bytes(tmp_path: Path) -> None:
    def taken(count: int) -> float:
        text = THREE + b"f 1 2 3 \\\n" + b"1 2 3 \\\n" * count + b"9\n"
        start = time.process_time()
        with pytest.raises(BrokenMesh, match="line 4: a face names v 9, and there are 3"):
            check_lines(text)
        return time.process_time() - start

    assert taken(200_000) < 30 * max(taken(20_000), 0.01)
