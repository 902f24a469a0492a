"""glTF models as scenes: their author's materials, and what of it all is wrong, as docs/models.md says."""

from __future__ import annotations

import math
import warnings
from pathlib import Path

import msgspec
import numpy as np
import pytest

import clrt
from clrt.base.errors import LimitError, SceneError
from clrt.cli import main
from clrt.scene.scene import Material, Mesh
from clrt.scene.textures import ImageTexture
from tests.model_samples import (
    CAMERA,
    FLOOR,
    GLASS,
    METAL,
    PLASTIC,
    POINT,
    SPOT,
    SUN,
    WALL,
    YELLOW,
    corners,
    lobe,
    metal_rough,
    model,
    shining,
    write_glb,
)


def test_what_a_file_lacks_is_added(tmp_path: Path) -> None:
    """No camera: all in view; no light: one; no material: a matte one. With glass shadows are tinted."""
    scene = clrt.load(write_glb(tmp_path / "a.glb", model([GLASS])))
    assert scene.camera is not None and len(scene.lights) == 1 and scene.shadow == "tinted"
    assert scene.ambient == 0.2
    floor, wall = scene.shapes
    assert (floor.name, wall.name, wall.material) == ("floor", "wall 0", "glass")
    assert scene.material_of(floor) == Material(diffuse=0.8, specular=0.2)
    lit = clrt.load(write_glb(tmp_path / "b.glb", model([], (shining(0),), (SUN,))))
    assert lit.camera is not None and len(lit.lights) == 1 and lit.ambient == 0.05


def test_a_model_without_looks_has_its_nodes(tmp_path: Path) -> None:
    """It was one nameless shape."""
    scene = clrt.load(write_glb(tmp_path / "a.glb", model([])))
    (mesh,) = scene.shapes
    assert isinstance(mesh, Mesh) and (mesh.part, mesh.name, mesh.file) == (0, "floor", "a.glb")
    for wrong in ("yes", 1):
        with pytest.raises(clrt.SceneError, match=r"smooth: .* it must be True, False or None"):
            clrt.load(tmp_path / "a.glb", smooth=wrong)
    with pytest.raises(clrt.SceneError, match=r"camera: 1 .* it must be a text or None"):
        clrt.load(tmp_path / "a.glb", camera=1)


HAND = f"""
ambient = 0.05
background = 0.05
shadow = "tinted"
[camera]
origin = [1.0, 1.5, 9.0]
target = [1.0, 1.5, 0.0]
up = [0.0, 1.0, 0.0]
fov = {math.degrees(0.75)!r}
fov_axis = "vertical"
near = 0.5
width = 96
height = 64
[materials.plastic]
color = [0.8, 0.1, 0.05]
diffuse = 0.96
fresnel = "schlick"
reflection = 1.0
reflection_color = 0.04
highlight_color = 0.04
roughness = 0.4
specular = {lobe(0.4)["specular"]!r}
shininess = {lobe(0.4)["shininess"]!r}
[materials.gold]
color = [1.0, 0.75, 0.25]
diffuse = 0.0
fresnel = "schlick"
reflection = 1.0
reflection_color = [1.0, 0.75, 0.25]
highlight_color = [1.0, 0.75, 0.25]
specular = {lobe(0)["specular"]!r}
shininess = {lobe(0)["shininess"]!r}
[materials.glass]
color = 1.0
diffuse = 0.0
fresnel = true
ior = 1.4
specular = 1.0
shininess = {lobe(0)["shininess"]!r}
absorption = [{math.log(2) / 2!r}, 0.0, {math.log(1e6) / 2!r}]
[[lights]]
type = "point"
position = [1.0, 5.0, 3.0]
intensity = [{20 / math.pi!r}, {10 / math.pi!r}, {5 / math.pi!r}]
falloff = "inverse-square"
[[lights]]
type = "directional"
direction = [0.0, 0.0, -1.0]
intensity = {2 / math.pi!r}
[[lights]]
type = "spot"
position = [0.0, 2.0, 5.0]
target = [0.0, 2.0, 0.0]
angle = {math.degrees(0.5)!r}
penumbra = 0.5
intensity = {50 / math.pi!r}
falloff = "inverse-square"
"""


def test_a_model_and_the_same_scene_by_hand_have_one_hash(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    nodes = (
        {"camera": 0, "translation": [1, 1.5, 9]}, shining(0, translation=[1, 5, 3]), shining(1),
        shining(2, translation=[0, 2, 5]),
    )  # fmt: skip
    table = model([PLASTIC, METAL, GLASS], nodes, (POINT, SUN, SPOT), cameras=[CAMERA])
    glb = write_glb(tmp_path / "a.glb", table)
    shapes = [(None, FLOOR, 0)] + [(name, WALL, 2 * k) for k, name in enumerate(("plastic", "gold", "glass"))]
    text = HAND
    for name, wall, x in shapes:
        vertices = [[a + x, b, c] for a, b, c in wall]
        kind = f'"{name}"' if name else "{diffuse = 0.8, specular = 0.2}"
        text += f'[[shapes]]\ntype = "mesh"\nvertices = {vertices}\nfaces = [[0, 1, 2]]\nmaterial = {kind}\n'
    (tmp_path / "hand.toml").write_text(text)
    assert main(["convert", str(glb), str(tmp_path / "made.toml")]) == 0
    hashes = set()
    for name in ("a.glb", "hand.toml", "made.toml"):
        assert main(["hash", str(tmp_path / name), "--width", "96", "--height", "64"]) == 0
        hashes.add(capsys.readouterr().out.split()[0])
    assert len(hashes) == 1
    made = clrt.load(tmp_path / "made.toml")
    assert made == clrt.load(glb)
    (tmp_path / "far").mkdir()
    made.save(tmp_path / "far" / "b.toml")
    far = clrt.load(tmp_path / "far" / "b.toml")  # meshes in place
    assert corners(far) == corners(made)


def test_parts_of_a_file_in_other_scenes(tmp_path: Path) -> None:
    write_glb(tmp_path / "a.glb", model([METAL, GLASS]))
    shapes = [{"type": "mesh", "file": "a.glb", "part": k} for k in (2, 0, 2)]
    scene = clrt.load_dict({"shapes": shapes}, folder=tmp_path)
    first, floor, last = corners(scene)
    assert floor == [list(corner) for corner in FLOOR]
    assert first == last == [[x + 2, y, z] for x, y, z in WALL]
    assert corners(scene.replace({"shapes[0].part": 1}))[0] == [list(corner) for corner in WALL]
    for shape, says in (
        ({"file": "a.glb", "part": 3}, "file: part 3 is not allowed; a.glb has 3 parts, numbered from 0"),
        ({"file": "a.glb", "part": -1}, "part: -1 is not allowed; part must be a whole number from 0"),
        ({"vertices": FLOOR, "faces": [[0, 1, 2]], "part": 0}, "part: only a file has parts"),
    ):
        with pytest.raises(SceneError, match=rf"shapes\[0\]\.{says}"):
            clrt.load_dict({"shapes": [{"type": "mesh", **shape}]}, folder=tmp_path)


def test_far_too_many_things_go_by_their_material(tmp_path: Path) -> None:
    table = model([METAL, {}], tuple({"mesh": 1 + k % 2} for k in range(5000)))
    scene = clrt.load(write_glb(tmp_path / "a.glb", table))
    assert [(shape.name, shape.material) for shape in scene.shapes] == [
        (None, "material 1"), (None, "gold"), (None, Material(diffuse=0.8, specular=0.2)),
    ]  # fmt: skip
    assert sum(shape.primitives for shape in scene.shapes) == 5003
    with pytest.raises(LimitError, match="primitives: 5 003 is above"):
        clrt.load(tmp_path / "a.glb", limits=clrt.Limits(primitives=5000))
    with pytest.raises(LimitError, match="vertices: 15 009 is above"):
        clrt.load(tmp_path / "a.glb", limits=clrt.Limits(vertices=5000))


def test_two_materials_at_one_node(tmp_path: Path) -> None:
    """One thing, and one matte; another node of its name is another."""
    table = model([METAL, PLASTIC])
    table["meshes"][1]["primitives"].append({"attributes": {"POSITION": 0}, "material": 1})
    table["nodes"][2]["name"] = "wall 0"
    table["scenes"][0]["nodes"] = [1, 2]
    scene = clrt.load(write_glb(tmp_path / "a.glb", table))
    assert [(shape.name, shape.material) for shape in scene.shapes] == [
        ("wall 0", "gold"), ("wall 0", "plastic"), ("wall 0-2", "plastic"),
    ]  # fmt: skip
    image = clrt.render(scene, width=24, height=18, layers=("crypto_shape", "shape"))
    shape = np.asarray(image.layers["shape"])
    assert {*np.unique(shape)} == {-1, 0, 1, 2}
    np.testing.assert_array_equal(image.matte("wall 0") > 0, (shape == 0) | (shape == 1))
    np.testing.assert_array_equal(image.matte("wall 0-2") > 0, shape == 2)
    scene.save(tmp_path / "a.toml")
    assert clrt.load(tmp_path / "a.toml") == scene


def test_a_material_with_and_without_colours_has_two_names(tmp_path: Path) -> None:
    """The plain one has the author's; a second one of the author's is not taken for a coloured one."""
    dull = {**metal_rough([0.5, 1, 1], 0, 1), "name": "gold"}
    nodes = ({"mesh": 4, "name": "more"}, {"mesh": 1, "name": "again", "translation": [0, 2, 0]})
    table = model([METAL, dull, METAL], nodes)
    table["meshes"].append({"primitives": [{"attributes": {"POSITION": 0}, "material": 0}]})
    for mesh in (1, 2, 3):
        table["meshes"][mesh]["primitives"][0]["attributes"]["COLOR_0"] = 1
    scene = clrt.load(write_glb(tmp_path / "a.glb", table))
    named = {shape.name: shape.material for shape in scene.shapes if shape.name != "floor"}
    both = {"wall 0": "gold-4", "again": "gold-4", "more": "gold"}
    assert named == {**both, "wall 1": "gold-2", "wall 2": "gold-3"}
    assert {*scene.materials} == {*named.values()}
    pictured = {name for name, material in scene.materials.items() if material.pictures}
    assert pictured == {"gold-2", "gold-3", "gold-4"}
    colors = {name: material.color for name, material in scene.materials.items()}
    assert colors["gold"] == tuple(YELLOW[:3])
    image = clrt.render(scene, width=24, height=18, layers=("crypto_material",))
    assert all(image.matte(name, "material").any() for name in ("gold-2", "gold-3", "gold-4"))


def test_colours_of_vertices_multiply_the_base_colour(tmp_path: Path) -> None:
    """They are a picture after the file's last, of which there is one that nothing shows."""
    matte = {**metal_rough([0.5, 1, 1], 0, 1), "name": "matte"}
    unlit = {**metal_rough([0.5, 1, 1], 0, 1), "name": "unlit", "extensions": {"KHR_materials_unlit": {}}}
    table = model([METAL, matte, unlit, GLASS], images=[{"uri": "none.png"}])
    for mesh in table["meshes"]:
        mesh["primitives"][0]["attributes"]["COLOR_0"] = 2
    table["accessors"].append({"bufferView": 1, "componentType": 5121, "count": 3, "type": "VEC4"})
    table["bufferViews"].append({"buffer": 0, "byteOffset": 72, "byteLength": 12})
    table["buffers"] = [{"byteLength": 84}]
    colors = np.array([(255, 0, 51, 9), (0, 0, 51, 9), (0, 255, 51, 9)], np.uint8)
    corners = np.array([FLOOR, WALL], "<f4").tobytes() + colors.tobytes()
    with pytest.warns(clrt.ClrtWarning, match="alpha of vertices' colours"):
        scene = clrt.load(write_glb(tmp_path / "a.glb", table, corners))
    solid = write_glb(tmp_path / "b.glb", table, corners.replace(b"3\t", b"3\xff"))
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        clrt.load(solid)
    assert not any("alpha" in str(one.message) for one in told)
    image = ImageTexture(file="a.glb", part=1, wrap="clamp")
    plain, gold, dull, glowing, glass = (scene.material_of(shape) for shape in scene.shapes)
    assert plain.color == image and plain.diffuse == 0.8
    yellow = msgspec.structs.replace(image, tint=(1.0, 0.75, 0.25))
    assert gold.color == gold.reflection_color == gold.highlight_color == yellow
    half = msgspec.structs.replace(image, tint=(0.5, 1.0, 1.0))
    assert dull.color == half and dull.diffuse == 0.96
    assert glowing.emission == half and glowing.diffuse == 0
    assert glass.color == glass.transmission_color
    assert isinstance(glass.transmission_color, ImageTexture)
    assert [shape.material for shape in scene.shapes][1:] == ["gold", "matte", "unlit", "glass"]
    assert scene.materials.keys() == {"gold", "matte", "unlit", "glass"}
    red = scene.replace({"materials.gold.color": [1.0, 0.0, 0.0]})
    assert red.material_of(red.shapes[1]).color == (1.0, 0.0, 0.0)
    scene.save(tmp_path / "a.toml")
    assert clrt.load(tmp_path / "a.toml") == scene
    for kind in ("VEC2", "SCALAR"):
        table["accessors"][2]["type"] = kind
        with pytest.raises(SceneError, match=r"a\.glb: cannot be read .*accessors\[2\] has not one colour"):
            clrt.load(write_glb(tmp_path / "a.glb", table, corners))
