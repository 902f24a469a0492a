"""OBJ and MTL files whose text is odd: marks, encodings, lines that go on, names that stand twice."""

from __future__ import annotations

from pathlib import Path

import pytest

import clrt
from clrt.base.errors import SceneError
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
