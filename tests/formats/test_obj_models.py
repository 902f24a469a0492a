"""OBJ files with their materials, as docs/models.md says."""

from __future__ import annotations

import os
import re
import time
import warnings
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import clrt
from clrt.base.errors import LimitError, SceneError
from clrt.flatten.flatten import flatten
from clrt.images.file import write as write_picture
from clrt.scene.scene import ImageTexture, Material, Mesh, NormalMap, Placement
from tests.cost import bounded
from tests.model_samples import PICTURE
from tests.obj_samples import CORNERS, WITH_UV, load


@pytest.mark.parametrize(
    ("mtl", "expected"),
    [
        ("Kd 0.5 0.25 0.125", {"color": [0.5, 0.25, 0.125]}),
        ("Ka 1 1 1\nKd 0.5\nKs 0.5 0.25 0\nNs 200\nillum 2", {
            "color": [0.5] * 3, "specular": 0.5, "highlight_color": [1.0, 0.5, 0.0], "shininess": 50.0,
        }),
        ("Kd 1 0 0\nKs 1 1 1\nNs 2\nillum 1 # matte", {"color": [1.0, 0.0, 0.0]}),
        ("Kd 1 0.5 0\nKe 0 0 2\nillum 0", {"color": 0.0, "diffuse": 0.0, "emission": [1.0, 0.5, 0.0]}),
        ("Kd 0 0 0\nKs 0.5 0.5 0.5\nNs 1\nillum 3", {
            "color": [0.0] * 3, "specular": 0.5, "shininess": 1.0, "highlight_color": [1.0] * 3,
            "reflection": 0.5, "reflection_color": [1.0] * 3,
        }),
        ("Kd 0 0 0\nKs 0.25 0.5 0.5\nNs 40\nillum 5", {
            "color": [0.0] * 3, "specular": 0.5, "shininess": 10.0, "highlight_color": [0.5, 1.0, 1.0],
            "fresnel": "schlick", "reflection": 1.0, "reflection_color": [0.25, 0.5, 0.5],
        }),
        ("Kd 1 1 1\nd 0.25", {"color": [1.0] * 3, "diffuse": 0.25, "transmission": 0.75, "thin": True}),
        ("Kd 1 1 1\nTr 0.25", {"color": [1.0] * 3, "diffuse": 0.75, "transmission": 0.25, "thin": True}),
        ("Kd 1 1 1\nd -halo 0.5\nillum 4\nTf 1 0 0", {
            "color": [1.0] * 3, "diffuse": 0.5, "transmission": 0.5, "transmission_color": [1.0, 0.0, 0.0],
            "thin": True,
        }),
        ("Kd 0 0 0\nTf 0.5 1 1\nNi 1.25\nillum 7", {
            "color": [0.0] * 3, "diffuse": 0.0, "transmission": 1.0, "transmission_color": [0.5, 1.0, 1.0],
            "ior": 1.25, "fresnel": True,
        }),
        ("Kd 0 0 0\nd 0\nNi 1.25\nillum 6", {
            "color": [0.0] * 3, "diffuse": 0.0, "transmission": 1.0, "ior": 1.25,
        }),
        ("Kd 1 1 1\nillum 4", {"color": [1.0] * 3}),
        ("illum 4\nKd 0.5 0.2 0.2\nKa 0 0 0\nTf 1 1 1\nNi 1", {"color": [0.5, 0.2, 0.2]}),  # Maya's
        ("illum 9\nKd 0 0 0\nTf 1 1 0.5", {
            "color": [0.0] * 3, "diffuse": 0.0, "transmission": 1.0, "transmission_color": [1.0, 1.0, 0.5],
            "thin": True,
        }),
        ("illum 9\nTf 1 1 0.5", {"color": [0.8] * 3}),
        ("Kd 1 0 0\nTf 1 1 1\nNi 1.25\nillum 6", {
            "color": [1.0, 0.0, 0.0], "diffuse": 0.0, "transmission": 1.0, "ior": 1.25,
            "transmission_color": [1.0] * 3,
        }),
        ("Kd 1 0.5 0\nPr 0\nPm 1\nKe 1 0 0", {
            "color": [1.0, 0.5, 0.0], "diffuse": 0.0, "fresnel": "schlick", "specular": 100.0,
            "shininess": 199.5, "highlight_color": [1.0, 0.5, 0.0], "reflection": 1.0,
            "reflection_color": [1.0, 0.5, 0.0], "emission": [1.0, 0.0, 0.0],
        }),
        ("Kd 1 0 0\nPr 0\nTf 0.5 1 1\nNi 1.25\nillum 7", {
            "color": [0.5, 1.0, 1.0], "diffuse": 0.0, "fresnel": True, "ior": 1.25, "reflection": 1.0,
            "transmission": 1.0, "transmission_color": [0.5, 1.0, 1.0], "shininess": 199.5,
            "specular": 1.0,
        }),
        ("Kd 1 1 1\nPr 0.5\nd 0\nKe 1 1 1", {
            "color": [1.0] * 3, "diffuse": 0.0, "fresnel": "schlick", "transmission": 1.0, "thin": True,
            "highlight_color": [0.04] * 3, "shininess": 7.5,
        }),
        ("Kd 1 0.5 0\nd 0.5\nillum 0", {
            "color": 0.0, "diffuse": 0.0, "emission": [0.5, 0.25, 0.0], "transmission": 0.5, "thin": True,
        }),
        ("Kd 1 1 1\nPm 0\nNs 250", {
            "color": [1.0] * 3, "diffuse": 0.96, "fresnel": "schlick", "specular": 4.0, "shininess": 7.5,
            "highlight_color": [0.04] * 3,
        }),
    ],
)  # fmt: skip
def test_what_a_material_becomes(
    tmp_path: Path, mtl: str, expected: dict[str, Any], recwarn: pytest.WarningsRecorder
) -> None:
    scene = load(tmp_path, f"# by hand\n\nnewmtl m\n{mtl}\n")
    found, right = scene.materials["m"], Material(**expected)
    for name in right.__struct_fields__:
        value = getattr(right, name)
        plain = value is None or isinstance(value, (str, bool))
        want = value if plain else pytest.approx(value, rel=1e-9)
        got = getattr(found, name)
        assert (list(got) if isinstance(got, tuple) else got) == want, name
    assert [str(warning.message) for warning in recwarn] == []
    assert scene.shadow == ("tinted" if "transmission" in expected else "opaque")


def test_faces_by_material(tmp_path: Path) -> None:
    mtl = "newmtl red one\nKd 1 0 0\nnewmtl blue\nKd 0 0 1\n"
    obj = "f 1 2 5\no thing\nusemtl blue\nf 1 2 3\ng more\nusemtl red one\nf 1 2 4 # a comment\nusemtl blue\n"
    with pytest.warns(clrt.ClrtWarning, match="counterpart: the material 'none', which its library lacks$"):
        scene = load(tmp_path, mtl, f"{obj}f -3 -2 -1\nusemtl none\nf 1 4 3\nusemtl empty\n")
    found = {}
    for shape in scene.shapes:
        assert isinstance(shape, Mesh)
        data = shape.data()
        found[str(shape.material)[:8]] = [data.vertices[face].tolist() for face in data.faces]
        assert shape.name is None
    a, b, c, d, e = ([float(x) for x in line.split()[1:]] for line in CORNERS.splitlines())
    plain = str(Material(diffuse=0.8, specular=0.2))[:8]
    assert found == {"blue": [[a, b, c], [c, d, e]], "red one": [[a, b, d]], plain: found[plain]}
    assert scene.materials.keys() == {"red one", "blue"}
    plains = [shape for shape in scene.shapes if isinstance(shape.material, Material)]
    assert sum(shape.primitives for shape in plains) == 2 and len(scene.shapes) == 4


def test_parts_in_a_scene_file(tmp_path: Path) -> None:
    scene = load(tmp_path, "newmtl m\nnewmtl n\n", "usemtl m\nf 1 2 3\nusemtl n\nf 2 3 4\nf 3 4 5\n")
    scene.save(tmp_path / "a.toml")
    again = clrt.load(tmp_path / "a.toml")
    assert again == scene and [shape.primitives for shape in again.shapes] == [1, 2]
    for shape, other in zip(scene.shapes, again.shapes, strict=True):
        assert isinstance(shape, Mesh) and isinstance(other, Mesh)
        assert shape.data().vertices.tolist() == other.data().vertices.tolist()


def test_libraries(tmp_path: Path) -> None:
    for name, color in (("b c.mtl", "1 0 0"), ("b.mtl", "0 1 0"), ("c.mtl", "0 0 1")):
        (tmp_path / name).write_text(f"newmtl {name[0]}\nKd {color}\n")
    for libraries, names in (("b c.mtl", {"b"}), ("b.mtl c.mtl", {"b", "c"}), (r".\b.mtl", {"b"})):
        faces = "usemtl b\nf 1 2 3\nusemtl c\nf 2 3 4\n"
        (tmp_path / "b.obj").write_text(f"mtllib {libraries}\n{CORNERS}{faces}")
        assert clrt.load(tmp_path / "b.obj").materials.keys() == names
    (tmp_path / "b.obj").write_text(f"mtllib gone.mtl\n{CORNERS}usemtl b\nf 1 2 3\n")
    with pytest.warns(clrt.ClrtWarning, match=r"the materials of 'gone\.mtl', which is not there"):
        assert clrt.load(tmp_path / "b.obj").materials == {}
    (tmp_path / "b.obj").write_text(f"{CORNERS}usemtl b\nf 1 2 3\n")
    with pytest.warns(clrt.ClrtWarning, match="its materials and colours are ignored"):
        assert len(clrt.load(tmp_path / "b.obj").shapes) == 1


def test_what_has_no_counterpart(tmp_path: Path) -> None:
    mtl = "Kd xyz 1 1 1\nmap_d a.png\nmap_Bump b.png\nmap_Ka x\nPs 1\nfoo\x1b 1\nmap_other x\nnorm n.png\n"
    with pytest.warns(clrt.ClrtWarning) as said:
        load(tmp_path, f"Kd what\nnewmtl m\n{mtl}newmtl unused\nrefl x\n")
    (text,) = [str(warning.message) for warning in said]
    assert text == (
        "a.obj: left out, since there is no counterpart: xyz colours, transparency in textures, bump maps, "
        "sheen, 'foo\\x1b', textures, the picture 'n.png', which is not there"
    )


@pytest.mark.parametrize("lines", ["d {0}\nTr {0}", "Tr {0}\nd {0}"])
@pytest.mark.parametrize("share", [1.0, 0.3])
def test_d_counts_where_tr_contradicts_it(lines: str, share: float, tmp_path: Path) -> None:
    """Many programs write both alike, as opacity; whichever stands later."""
    with pytest.warns(clrt.ClrtWarning, match=rf"Tr {share:g}, which contradicts d {share:g}$"):
        scene = load(tmp_path, f"newmtl m\nKd 1 1 1\n{lines.format(share)}\n")
    assert scene.materials["m"].diffuse == pytest.approx(share)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        scene = load(tmp_path, "newmtl m\nKd 1 1 1\nd 0.333\nTr 0.667\n")
    assert scene.materials["m"].diffuse == pytest.approx(0.333)


@pytest.mark.parametrize(
    ("line", "says"),
    [
        ("map_Kd gone.png", "the picture 'gone.png', which is not there"),
        ("map_Kd C:\\me\\wood.png\nmap_Ke b.png",
         "the picture 'C:/me/wood.png', which is not there, the picture 'b.png', which is not there"),
        ("map_Kd tex", "the picture 'tex', which is not there"),
        ("map_Kd", "a picture without a name"),
        ("map_Ke -s 1 2 3", "a picture without a name"),
        ("norm", "a picture without a name"),
    ],
)  # fmt: skip
def test_pictures_that_are_not_there_are_named(line: str, says: str, tmp_path: Path) -> None:
    """And what names a folder, or nothing, as some programs do where an image has no name."""
    (tmp_path / "tex").mkdir()
    with pytest.warns(clrt.ClrtWarning, match=f"no counterpart: {re.escape(says)}$"):
        scene = load(tmp_path, f"newmtl m\nKd 1 0.5 0\n{line}\n", WITH_UV)
    assert scene.materials["m"].color == (1.0, 0.5, 0.0)


@pytest.mark.parametrize(
    ("line", "key", "expected"),
    [
        ("map_Kd a b.png", "color", {}),
        ("map_Kd -s 2 4 1 -o 0.5 -clamp on -bm 1 -mm 0 1 -t 0 0 0 .\\a b.png", "color", {
            "wrap": "clamp", "scale": (2.0, 4.0), "offset": (0.5, -3.0),
        }),
        ("map_Kd -s 2 -o 0.5 0.25 -clamp off a b.png\nKd 1 0.5 0", "color", {
            "scale": (2.0, 1.0), "offset": (0.5, -0.25), "tint": (1.0, 0.5, 0.0),
        }),
        ("map_Kd -mm 0 0.5 a b.png", "color", {"tint": (0.5, 0.5, 0.5)}),
        ("map_Kd -mm 0 0.5 a b.png\nKd 1 0.5 0", "color", {"tint": (0.5, 0.25, 0.0)}),
        ("map_Kd -mm 0 0.5 -cc off -blendu on a b.png\nKd 2 2 2", "color", {"tint": (1.0, 1.0, 1.0)}),
        ("map_Ke a b.png", "emission", {}),
        ("map_Ke a b.png\nKe 2 2 2\nPm 0", "emission", {"tint": (2.0, 2.0, 2.0)}),
        ("map_Kd a b.png\nillum 0", "emission", {}),
    ],
)  # fmt: skip
def test_maps(tmp_path: Path, line: str, key: str, expected: dict[str, Any]) -> None:
    (tmp_path / "a b.png").write_bytes(PICTURE)
    scene = load(tmp_path, f"newmtl m\nKd 1 1 1\nnorm a b.png\n{line}\n", WITH_UV)
    material = scene.materials["m"]
    assert getattr(material, key) == ImageTexture(file="a b.png", **expected)
    bumps = NormalMap(file="a b.png", placement=Placement())
    assert material.normal_map == (bumps if "illum" not in line else None)
    with pytest.warns(clrt.ClrtWarning, match="counterpart: .*textures of 'm' where it has no uv"):
        plain = load(tmp_path, f"newmtl m\nKd 1 1 1\nnorm a b.png\n{line}\n").materials["m"]
    assert not plain.pictures and (plain.emission in (0, (0, 0, 0)) or "illum 0" in line)


def test_many_options_of_a_map_cost_time_by_their_number(tmp_path: Path) -> None:
    took = []
    for count in (50_000, 200_000):
        began = time.process_time()
        with pytest.warns(clrt.ClrtWarning, match="a picture without a name"):
            load(tmp_path, f"newmtl m\nmap_Kd {'-blendu on ' * count}\n", WITH_UV)
        took.append(time.process_time() - began)
    assert took[1] <= 6 * took[0]


def test_colours_in_bytes_are_told_of(tmp_path: Path) -> None:
    """A scene file gets the same word."""
    with pytest.warns(clrt.ClrtWarning, match=r"m\.color: a reflectance of 255; .* from 0 to 255\?"):
        load(tmp_path, "newmtl m\nKd 255 128 0\n", WITH_UV)


@pytest.mark.parametrize("more", ["Pr 0.5", "illum 7", "illum 6\nd 0.5"])
def test_an_index_of_0_is_none(tmp_path: Path, more: str) -> None:
    """Some write it where they know of none."""
    with pytest.warns(clrt.ClrtWarning, match=r"an index of refraction \(Ni\) of 0$"):
        found = load(tmp_path, f"newmtl m\nNi 0\n{more}\n", WITH_UV).materials["m"]
    assert found == load(tmp_path, f"newmtl m\n{more}\n", WITH_UV).materials["m"]


def test_glass_is_smooth_and_its_roughness_named(tmp_path: Path) -> None:
    with pytest.warns(clrt.ClrtWarning, match="the roughness of glass"):
        rough = load(tmp_path, "newmtl m\nPr 0.5\nTf 1 1 1\nillum 7\n").materials["m"]
    assert rough.transmission == 1 and rough.roughness == 0


@pytest.mark.parametrize("more", ["", "Pr 0.5\n", "illum 0\n"])
def test_a_picture_without_a_colour_is_shown_as_it_is(tmp_path: Path, more: str) -> None:
    (tmp_path / "a.png").write_bytes(PICTURE)
    mtl = f"newmtl m\n{more}map_Kd a.png\n"
    found, white = (load(tmp_path, f"{mtl}{kd}", WITH_UV).materials["m"] for kd in ("", "Kd 1 1 1\n"))
    assert found == white and found.pictures
    plain = load(tmp_path, f"newmtl m\n{more}").materials["m"]
    assert 0.8 in (np.max(plain.color), np.max(plain.emission))


@pytest.mark.parametrize(
    ("line", "key"), [("map_Kd", "color"), ("map_Ke", "emission"), ("norm", "normal_map")]
)
@pytest.mark.parametrize("head", [bytes([0, 0, 2]), b"DDS |\0\0\0", b"GIF89a", b"RIFF\x24\0\0\0WEBPVP8 "])
def test_pictures_of_kinds_that_are_not_read_are_left_out(
    tmp_path: Path, line: str, key: str, head: bytes
) -> None:
    """By their first bytes: of a picture that is read any name will do, and a broken one is refused."""
    (tmp_path / "in").mkdir()
    (tmp_path / "in" / "wood.tga").write_bytes(head + bytes(30))
    mtl = f"newmtl m\nKd 1 0.5 0\n{line} in/wood.tga\n"
    plain = load(tmp_path, "newmtl m\nKd 1 0.5 0\n", WITH_UV).materials["m"]
    says = r"a\.obj: left .*: the picture 'in/wood\.tga' \(no EXR, HDR, PNG, JPEG, TIFF or BMP\)$"
    with pytest.warns(clrt.ClrtWarning, match=says) as said:
        assert load(tmp_path, mtl, WITH_UV).materials["m"] == plain
    assert len(said) == 1
    (tmp_path / "in" / "wood.tga").write_bytes(PICTURE)
    assert getattr(load(tmp_path, mtl, WITH_UV).materials["m"], key).file == "in/wood.tga"
    (tmp_path / "in" / "wood.tga").write_bytes(PICTURE[:40])
    with pytest.raises(SceneError, match=r"wood\.tga: cannot be read: .*png"):
        flatten(load(tmp_path, mtl, WITH_UV))


def test_pictures_of_other_kinds_that_are_read(tmp_path: Path) -> None:
    write_picture(tmp_path / "a.exr", [np.full((2, 2, 3), 0.25, np.float32)])
    scene = load(tmp_path, "newmtl m\nmap_Kd a.exr\nKd 1 1 1\n", WITH_UV)
    assert scene.materials["m"].color == ImageTexture(file="a.exr")


@pytest.mark.parametrize(
    ("line", "says"),
    [
        ("map_Kd -mm 0.25 0.5", r"the range of textures \(-mm\)"),
        ("map_Kd -mm 0 -1", r"the range of textures \(-mm\)"),
        ("norm -mm 0 0.5", r"the range of textures \(-mm\)"),
        ("map_Kd -cc on", r"colour correction of textures \(-cc\)"),
        ("map_Kd -imfchan r", r"one channel of textures \(-imfchan\)"),
        ("map_Kd -t 0 1", r"turbulence of textures \(-t\)"),
    ],
)
def test_options_of_maps_without_a_counterpart_are_named(tmp_path: Path, line: str, says: str) -> None:
    (tmp_path / "a.png").write_bytes(PICTURE)
    with pytest.warns(clrt.ClrtWarning, match=f"since there is no counterpart: {says}$"):
        material = load(tmp_path, f"newmtl m\nKd 1 1 1\n{line} a.png\n", WITH_UV).materials["m"]
    plain = load(tmp_path, f"newmtl m\nKd 1 1 1\n{line.split()[0]} a.png\n", WITH_UV).materials["m"]
    assert material == plain


def test_a_normal_map_leans_as_it_says(tmp_path: Path) -> None:
    (tmp_path / "a.png").write_bytes(PICTURE)
    for more in ("", "Pm 0\n"):
        material = load(tmp_path, f"newmtl m\n{more}norm -bm 0.0 a.png\n", WITH_UV).materials["m"]
        assert material.normal_map == NormalMap(file="a.png", scale=0.0, placement=Placement())
    with pytest.raises(SceneError, match=r"line 2: 'norm -bm much a\.png'"):
        load(tmp_path, "newmtl m\nnorm -bm much a.png\n", WITH_UV)


@pytest.mark.parametrize("more", ["", "Pm 0\n"])
def test_a_normal_map_lies_by_its_own_options(tmp_path: Path, more: str) -> None:
    (tmp_path / "a b.png").write_bytes(PICTURE)
    lines = f"newmtl m\n{more}map_Kd -s 5 5 a b.png\nnorm -s 2 4 1 -o 0.5 -clamp on a b.png\n"
    material = load(tmp_path, lines, WITH_UV).materials["m"]
    placement = Placement(wrap="clamp", scale=(2, 4), offset=(0.5, -3))
    assert material.normal_map == NormalMap(file="a b.png", placement=placement)


def test_maps_lie_beside_their_library(tmp_path: Path) -> None:
    (tmp_path / "in").mkdir()
    (tmp_path / "in" / "a.png").write_bytes(PICTURE)
    (tmp_path / "in" / "a.mtl").write_text("newmtl m\nKd 1 1 1\nmap_Kd a.png\n")
    (tmp_path / "a.obj").write_text(f"mtllib in/a.mtl\n{CORNERS}{WITH_UV}")
    scene = clrt.load(tmp_path / "a.obj")
    assert scene.materials["m"].color == ImageTexture(file="in/a.png")
    (mesh,) = scene.shapes
    assert isinstance(mesh, Mesh) and mesh.data().uv is not None
    (tmp_path / "in" / "a.mtl").write_text("newmtl m\nmap_Kd ../../far.png\n")
    (tmp_path.parent / "far.png").write_bytes(PICTURE)
    with pytest.raises(SceneError, match="must lie in the scene's folder"):
        clrt.load(tmp_path / "a.obj")


@pytest.mark.parametrize(
    ("mtl", "says"),
    [
        ("newmtl m\nKd 1 1\n", "cannot be read as a mesh: 'a.mtl', line 2: 'Kd 1 1' is not understood"),
        ("newmtl m\n\nKd\n", "line 3: 'Kd' is not understood"),
        ("newmtl m\nNs much\n", "line 2: 'Ns much'"),
        ("newmtl m\nd nan\n", "line 2: 'd nan'"),
        ("newmtl m\nillum 2.5\n", "line 2: 'illum 2.5'"),
        ("newmtl m\nKd 1e999 0 0\n", "line 2: 'Kd 1e999 0 0'"),
        ("newmtl m\nmap_Kd -s a.png\n", "line 2: 'map_Kd -s a"),
        ("newmtl m\nmap_Kd -clamp\n", "line 2: 'map_Kd -clamp'"),
    ],
)
def test_broken_lines(tmp_path: Path, mtl: str, says: str) -> None:
    with pytest.raises(SceneError, match=rf"a\.obj: .*{says}"):
        load(tmp_path, mtl)


def test_libraries_stay_in_the_folder(tmp_path: Path) -> None:
    (tmp_path / "far.mtl").write_text("newmtl m\n")
    (tmp_path / "in").mkdir()
    for name in ("../far.mtl", str(tmp_path / "far.mtl"), "..\\far.mtl"):
        (tmp_path / "in" / "a.obj").write_text(f"mtllib {name}\n{CORNERS}usemtl m\nf 1 2 3\n")
        with pytest.raises(SceneError, match=r"a\.obj: .*a file must lie in the scene's folder"):
            clrt.load(tmp_path / "in" / "a.obj")
    os.mkfifo(tmp_path / "in" / "pipe")
    (tmp_path / "in" / "a.obj").write_text(f"mtllib pipe\n{CORNERS}usemtl m\nf 1 2 3\n")
    with pytest.raises(SceneError, match=r"there is no such file|a named pipe"):
        clrt.load(tmp_path / "in" / "a.obj")
    with pytest.raises(LimitError, match=r"text_bytes: \d+ is above"):
        load(tmp_path, "newmtl m\n" * 100, limits=clrt.Limits(text_bytes=100))
    long = "x" * 5000
    with pytest.warns(clrt.ClrtWarning, match="which is not there"):
        (tmp_path / "in" / "a.obj").write_text(f"mtllib {long}\n{CORNERS}usemtl m\nf 1 2 3\n")
        clrt.load(tmp_path / "in" / "a.obj")


def test_a_great_many_materials(tmp_path: Path) -> None:
    """Apart as long as trimesh is quick about it."""
    mtl = "".join(f"newmtl m{k}\nKd 0 0 1\n" for k in range(2000))
    obj = "".join(f"usemtl m{k % 300}\nf 1 2 3\n" for k in range(20_000))
    scene = load(tmp_path, mtl, obj)
    assert len(scene.shapes) == 300 and sum(shape.primitives for shape in scene.shapes) == 20_000
    assert [shape.material for shape in scene.shapes][:3] == ["m0", "m1", "m2"]
    obj = "".join(f"usemtl m{k % 2000}\nf 1 2 3\n" for k in range(20_000))
    with pytest.warns(clrt.ClrtWarning, match="its materials and colours are ignored"):
        assert len(load(tmp_path, mtl, obj).shapes) == 1
    bounded("read", tmp_path / "a.obj")
