"""OBJ and MTL as Maya, 3ds Max, Blender and scanners write them, whatever the letter of the format says."""

from __future__ import annotations

from pathlib import Path

import pytest

import clrt
from clrt.scene.scene import ImageTexture
from tests.model_samples import PICTURE
from tests.obj_samples import CORNERS, WITH_UV, load


def test_transparency_that_leaves_nothing_is_opacity(tmp_path: Path) -> None:
    """`Tr 1.000000` without `d`, as scans are written; next to 1 it is what it says."""
    with pytest.warns(clrt.ClrtWarning, match="Tr 1 without d, which would leave nothing that is seen"):
        scene = load(tmp_path, "newmtl m\nKd 1 1 1\nTr 1.000000\nillum 1\n")
    assert scene.materials["m"].diffuse == 1 and scene.materials["m"].kt == 0
    clear = load(tmp_path, "newmtl m\nKd 1 1 1\nTr 0.99\nillum 1\n").materials["m"]
    assert clear.transmission == pytest.approx(0.99)


def test_a_black_colour_takes_no_picture_away(tmp_path: Path) -> None:
    (tmp_path / "a.png").write_bytes(PICTURE)
    with pytest.warns(clrt.ClrtWarning, match="Kd 0 0 0, which would leave a map_Kd black"):
        scene = load(tmp_path, "newmtl m\nillum 4\nKd 0 0 0\nTf 1 1 1\nmap_Kd a.png\n", WITH_UV)
    found = scene.materials["m"]
    assert isinstance(found.color, ImageTexture) and found.color.tint == (1, 1, 1) and found.kt == 0
    assert load(tmp_path, "newmtl m\nKd 0 0 0\n", WITH_UV).materials["m"].color == (0, 0, 0)


@pytest.mark.parametrize("end", ["\n", "\r\n"])
def test_names_with_a_sign_of_comments(tmp_path: Path, end: str, recwarn: pytest.WarningsRecorder) -> None:
    """3ds Max calls materials `Material #25`; Blender writes that as `Material_#25`."""
    (tmp_path / "Map #3.png").write_bytes(PICTURE)
    colors = {"M_#1": "1 0 0", "M_#2": "0 1 0", "M #3": "0 0 1", "M #4": "1 1 0", "plain #told": "0 1 1"}
    mtl = end.join(f"newmtl {name}{end}Kd {color}" for name, color in colors.items())
    used = [*colors, "plain", "M_#1 # a comment", "M_#1 #another"]
    obj = "".join(f"usemtl {name}{end}f 1/1 2/1 {k % 3 + 3}/1 # {k}{end}" for k, name in enumerate(used))
    (tmp_path / "a #1.mtl").write_bytes((mtl + f"{end}newmtl p#{end}map_Kd Map #3.png{end}").encode())
    head = f"mtllib a #1.mtl{end}{CORNERS}vt 0 0{end}"
    (tmp_path / "a.obj").write_bytes(f"{head}{obj}usemtl p#{end}f 1/1 2/1 3/1{end}".encode())
    scene = clrt.load(tmp_path / "a.obj")
    pictured = scene.materials["p#"].color
    assert isinstance(pictured, ImageTexture) and pictured.file == "Map #3.png"
    right = {**colors, "plain #told-2": colors["plain #told"], "M_#1-2": colors["M_#1"]}
    found = {name: material.color for name, material in scene.materials.items() if name != "p#"}
    assert found == {name: tuple(map(float, color.split())) for name, color in right.items()}
    assert [str(warning.message) for warning in recwarn] == []
    (tmp_path / "b.mtl").write_text("newmtl M_#1\nmap_Kd b.png #it\n")
    (tmp_path / "b.png").write_bytes(PICTURE)
    (tmp_path / "a.obj").write_text(f"mtllib b.mtl # its\n{CORNERS}{WITH_UV.replace(' m', ' M_#1')}")
    pictured = clrt.load(tmp_path / "a.obj").materials["M_#1"].color
    assert isinstance(pictured, ImageTexture) and pictured.file == "b.png"
    assert [str(warning.message) for warning in recwarn] == []
    (tmp_path / "a.obj").write_text(f"mtllib a #1.mtl\n{CORNERS}usemtl M\nf 1 2 3\n")
    with pytest.warns(clrt.ClrtWarning, match="the material 'M', which its library lacks"):
        clrt.load(tmp_path / "a.obj")


@pytest.mark.parametrize("line", ["map_Kd \"a b.png\"", "map_Kd 'a b.png'", "illum 2.000000\nmap_Kd a b.png"])
def test_what_others_write_and_read(line: str, tmp_path: Path, recwarn: pytest.WarningsRecorder) -> None:
    (tmp_path / "a b.png").write_bytes(PICTURE)
    (tmp_path / "a.mtl").write_text(f"newmtl m\n{line}\n")
    (tmp_path / "a.obj").write_text(f'mtllib\nmtllib "a.mtl"\n{CORNERS}{WITH_UV}')
    assert clrt.load(tmp_path / "a.obj").materials["m"].color == ImageTexture(file="a b.png")
    assert [str(warning.message) for warning in recwarn] == []


def test_an_unknown_option_leaves_a_map_out(tmp_path: Path) -> None:
    (tmp_path / "a.png").write_bytes(PICTURE)
    with pytest.warns(clrt.ClrtWarning, match="a picture with the option '-colorspace'"):
        found = load(tmp_path, "newmtl m\nKd 1 0 0\nmap_Kd -colorspace sRGB a.png\n", WITH_UV).materials["m"]
    assert found.color == (1, 0, 0)


@pytest.mark.parametrize("lost", ["gone.png", "pic.tga", "-colorspace sRGB a.png", "a.png"])
@pytest.mark.parametrize("more", ["", "Pr 0.5\n"])
def test_what_is_opaque_stays_so_without_its_picture(lost: str, more: str, tmp_path: Path) -> None:
    """Maya's textured materials, whose picture is missing, of another kind, or whose faces have no uv."""
    (tmp_path / "a.png").write_bytes(PICTURE)
    (tmp_path / "pic.tga").write_bytes(b"\0\0\2" + bytes(40))
    mtl = f"newmtl m\nillum 4\nKd 0 0 0\nTf 1 1 1\nmap_Kd {lost}\nNi 1.5\n{more}"
    obj = "usemtl m\nf 1 2 3\n" if lost == "a.png" else WITH_UV
    with pytest.warns(clrt.ClrtWarning, match="Kd 0 0 0"):
        scene = load(tmp_path, mtl, obj)
    (found,) = scene.materials.values()
    assert found.kt == 0 and found.color == pytest.approx((0.8, 0.8, 0.8)) and found.diffuse > 0.9


def test_what_glows_by_a_picture_is_dark_without_it(tmp_path: Path) -> None:
    with pytest.warns(clrt.ClrtWarning, match="the light of what glows by a picture that is left out"):
        scene = load(tmp_path, "newmtl m\nKd 0.1 0.1 0.1\nKe 1 1 1\nmap_Ke gone.png\n", WITH_UV)
    assert scene.materials["m"].emission in (0, (0, 0, 0))
