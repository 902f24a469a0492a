"""Textures of glTF models: within the file, as data, in files beside it."""

from __future__ import annotations

import base64
import math
import struct
import warnings
import zlib
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import clrt
from clrt.base.errors import SceneError
from clrt.flatten.flatten import flatten
from clrt.images.file import write as write_picture
from clrt.scene.scene import ImageTexture, Mesh, NormalMap, Placement
from tests.model_samples import (
    BASE,
    CAMERA,
    DATA,
    FLOOR,
    LIGHTS,
    PICTURE,
    POINT,
    UV,
    WALL,
    load,
    shining,
    textured,
    write,
)

MOVED = {"index": 0, "extensions": {"KHR_texture_transform": {"scale": [2, 3], "offset": [0.5, 0]}}}
GLOWING = {
    "pbrMetallicRoughness": {
        "baseColorTexture": MOVED, "baseColorFactor": [0.5, 1, 0.25, 1],
        "metallicFactor": 0, "roughnessFactor": 0.5,
    },
    "normalTexture": {"index": 0, "scale": 0.5},
    "emissiveTexture": {"index": 0}, "emissiveFactor": [1, 0.5, 0.25],
    "extensions": {"KHR_materials_emissive_strength": {"emissiveStrength": 2}},
}  # fmt: skip
HAND = f"""
ambient = 0.05
background = 0.05
[camera]
origin = [0.0, 1.0, 6.0]
target = [0.0, 1.0, 0.0]
fov = {math.degrees(0.75)!r}
fov_axis = "vertical"
near = 0.5
width = 96
height = 64
[[lights]]
type = "point"
position = [1.0, 3.0, 4.0]
intensity = [{20 / math.pi!r}, {10 / math.pi!r}, {5 / math.pi!r}]
falloff = "inverse-square"
[[shapes]]
type = "mesh"
vertices = {[list(corner) for corner in FLOOR]}
faces = [[0, 1, 2]]
material = {{ diffuse = 0.8, specular = 0.2 }}
[[shapes]]
type = "mesh"
vertices = {[list(corner) for corner in WALL]}
faces = [[0, 1, 2]]
uv = {[list(corner) for corner in UV]}
[shapes.material]
color = {{ type = "image", file = "b.png", scale = [2, 3], offset = [0.5, 0], tint = [0.5, 1, 0.25] }}
diffuse = 0.96
fresnel = "schlick"
highlight_color = 0.04
specular = 4.0
shininess = 7.5
normal_map = {{ file = "b.png", scale = 0.5, placement = {{}} }}
emission = {{ type = "image", file = "b.png", tint = [2, 1, 0.5] }}
"""


def test_a_glowing_model_with_textures_and_the_same_scene_by_hand_have_one_hash(tmp_path: Path) -> None:
    table = textured(GLOWING, cameras=[CAMERA], extensions={LIGHTS: {"lights": [POINT]}})
    table["nodes"] += [{"camera": 0, "translation": [0, 1, 6]}, shining(0, translation=[1, 3, 4])]
    table["scenes"][0]["nodes"] += [2, 3]
    (tmp_path / "b.png").write_bytes(PICTURE)
    (tmp_path / "hand.toml").write_text(HAND)
    scene = load(tmp_path, table)
    hand = clrt.load(tmp_path / "hand.toml")
    found = clrt.render(scene, width=96, height=64).hash
    assert found == clrt.render(hand).hash
    for key, plain in (("color", 0.5), ("normal_map", None), ("emission", 0.0)):
        other = hand.replace({f"shapes[1].material.{key}": plain})
        assert clrt.render(other).hash != found, f"{key} does not show"


@pytest.mark.parametrize(
    ("material", "more", "key", "expected"),
    [
        (BASE, {}, "color", ImageTexture(file="a.glb", part=0)),
        (BASE, {"images": ({"uri": DATA, "mimeType": "image/png"},)}, "color",
         ImageTexture(file="a.glb", part=0)),
        (BASE, {"images": ({"uri": "in%20there/b.png"},)}, "color", ImageTexture(file="in there/b.png")),
        (BASE, {"images": ({"uri": "in there\\b.png", "mimeType": "image/jpg"},)}, "color",
         ImageTexture(file="in there/b.png")),
        (BASE, {"textures": [{"source": 0, "sampler": 0}],
                "samplers": [{"wrapS": 33071, "wrapT": 33071, "magFilter": 9728}]},
         "color", ImageTexture(file="a.glb", part=0, wrap="clamp", filter="nearest")),
        ({"pbrMetallicRoughness": {"baseColorFactor": [1, 0.5, 0, 1], "baseColorTexture": MOVED}}, {},
         "color", ImageTexture(file="a.glb", part=0, scale=(2, 3), offset=(0.5, 0), tint=(1, 0.5, 0))),
        ({"pbrMetallicRoughness": {"metallicFactor": 0.5, "baseColorTexture": {"index": 0}}}, {},
         "reflection_color", ImageTexture(file="a.glb", part=0, tint=(0.5, 0.5, 0.5))),
        ({"emissiveTexture": {"index": 0}, "emissiveFactor": [1, 1, 0.5],
          "extensions": {"KHR_materials_emissive_strength": {"emissiveStrength": 4}}}, {},
         "emission", ImageTexture(file="a.glb", part=0, tint=(4, 4, 2))),
        ({"normalTexture": {"index": 0, "scale": 0.5}}, {}, "normal_map",
         NormalMap(file="a.glb", part=0, scale=0.5)),
        ({"normalTexture": {"index": 0}}, {"images": ({"uri": "in%20there/b.png"},)}, "normal_map",
         NormalMap(file="in there/b.png")),
        ({"normalTexture": MOVED}, {}, "normal_map",
         NormalMap(file="a.glb", part=0, placement=Placement(scale=(2, 3), offset=(0.5, 0)))),
        ({"pbrMetallicRoughness": {"baseColorTexture": MOVED}, "normalTexture": MOVED}, {}, "normal_map",
         NormalMap(file="a.glb", part=0)),
        ({**BASE, "normalTexture": {"index": 1}},
         {"textures": [{"source": 0, "sampler": 0}, {"source": 0}],
          "samplers": [{"wrapS": 33071, "wrapT": 33071, "magFilter": 9728}]}, "normal_map",
         NormalMap(file="a.glb", part=0, placement=Placement())),
        ({**BASE, "extensions": {"KHR_materials_unlit": {}}}, {}, "emission",
         ImageTexture(file="a.glb", part=0)),
        ({**BASE, "extensions": {"KHR_materials_transmission": {"transmissionFactor": 1}},
          "pbrMetallicRoughness": {**BASE["pbrMetallicRoughness"], "roughnessFactor": 0}}, {},
         "transmission_color", ImageTexture(file="a.glb", part=0)),
    ],
)  # fmt: skip
def test_what_a_texture_becomes(
    tmp_path: Path, material: dict[str, Any], more: dict[str, Any], key: str, expected: Any,
    recwarn: pytest.WarningsRecorder,
) -> None:  # fmt: skip
    (tmp_path / "in there").mkdir()
    (tmp_path / "in there" / "b.png").write_bytes(PICTURE)
    scene = load(tmp_path, textured(material, **more))
    (found,) = scene.materials.values()
    assert getattr(found, key) == expected and [str(warning.message) for warning in recwarn] == []
    scene.save(tmp_path / "a.toml")
    assert clrt.load(tmp_path / "a.toml") == scene


def test_roughness_and_metal_are_the_means_of_their_texture(tmp_path: Path) -> None:
    """Of `PICTURE`: green 128, 255, 0, 64; blue 0, 128, 255, 64; as they are stored, not decoded."""
    of = {"metallicRoughnessTexture": {"index": 0}, "metallicFactor": 0.5}
    with pytest.warns(clrt.ClrtWarning, match="textures of roughness and metal, but for their mean"):
        (found,) = load(tmp_path, textured({"pbrMetallicRoughness": of})).materials.values()
    assert found.roughness == pytest.approx(447 / 4 / 255, abs=1e-6)
    assert found.diffuse == pytest.approx(0.96 * (1 - 0.5 * 447 / 4 / 255), abs=1e-6)
    write_picture(tmp_path / "b.exr", [np.full((2, 2, 3), 0.25, np.float32)])
    of["baseColorTexture"] = {"index": 1}
    with pytest.warns(clrt.ClrtWarning):
        scene = load(tmp_path, textured({"pbrMetallicRoughness": of}, ({"uri": "b.exr"}, {"bufferView": 1})))
    (found,) = scene.materials.values()
    assert found.roughness == 0.25 and found.color == ImageTexture(file="a.glb", part=1)


def test_a_picture_of_many_textures_is_looked_at_once(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from clrt.meshfiles.gltf import stored

    looked: list[str] = []
    monkeypatch.setattr(stored, "head_of", lambda uri, count: looked.append(uri) or PICTURE[:8])
    many = textured(BASE, ({"uri": DATA},), textures=[{"source": 0}] * 9)
    for index in range(1, 9):
        info = {"pbrMetallicRoughness": {"baseColorTexture": {"index": index}}}
        many["materials"].append(info)
        many["meshes"][1]["primitives"].append({**many["meshes"][1]["primitives"][0], "material": index})
    assert len(load(tmp_path, many).materials) == 9 and looked == [DATA]


def test_what_has_no_uv_has_no_textures(tmp_path: Path) -> None:
    table = textured(BASE)
    del table["meshes"][1]["primitives"][0]["attributes"]["TEXCOORD_0"]
    with pytest.warns(clrt.ClrtWarning, match="textures of 'material 0' where it has no uv"):
        assert not next(iter(load(tmp_path, table).materials.values())).pictures
    transmitting = {"extensions": {
        "KHR_materials_transmission": {"transmissionFactor": 1, "transmissionTexture": {"index": 0}},
    }}  # fmt: skip
    with pytest.warns(clrt.ClrtWarning, match="textures of transmission, thickness and specular"):
        load(tmp_path, textured(transmitting))


def test_a_picture_within_is_that_picture(tmp_path: Path) -> None:
    """Flattened, the texels of a part, of data and of a file are the same; so are those times a tint."""
    from clrt.flatten.flatten import flatten

    (tmp_path / "b.png").write_bytes(PICTURE)
    texels = []
    images: tuple[dict[str, Any], ...] = ({"bufferView": 1}, {"uri": DATA}, {"uri": "b.png"})
    for image in images:
        flat = flatten(load(tmp_path, textured(BASE, (image,))))
        assert flat.pictures is not None
        texels.append(flat.pictures.texels.tolist())
    assert texels[0] == texels[1] == texels[2]
    glowing: dict[str, Any] = {"emissiveTexture": {"index": 0}, "emissiveFactor": [1, 0.5, 0]}
    tinted = flatten(load(tmp_path, textured(glowing)))
    assert tinted.pictures is not None
    glowing["extensions"] = {"KHR_materials_emissive_strength": {"emissiveStrength": 3e38}}
    write_picture(tmp_path / "c.exr", [np.full((1, 1, 3), 9.0, np.float32)])
    with pytest.raises(SceneError, match=r"c\.exr: times its tint it leaves the range of float32"):
        flatten(load(tmp_path, textured(glowing, ({"uri": "c.exr"},))))
    right = np.array(texels[0][:-1], np.float32).reshape(-1, 3) * np.array([1, 0.5, 0], np.float32)
    assert tinted.pictures.texels[:-1].reshape(-1, 3).tolist() == right.tolist()


def test_a_texture_times_the_colours_of_vertices(tmp_path: Path) -> None:
    table = textured(BASE)
    table["meshes"][1]["primitives"][0]["attributes"]["COLOR_0"] = 1  # the corners of the wall, each clipped
    with pytest.warns(clrt.ClrtWarning, match="but for their mean"):
        scene = load(tmp_path, table)
    color = scene.material_of(scene.shapes[1]).color
    assert isinstance(color, ImageTexture) and color.part == 0
    np.testing.assert_allclose(color.tint, [1 / 3, 1 / 3, 0])


@pytest.mark.parametrize("of", [BASE, {"normalTexture": {"index": 0}}])
def test_what_is_unlit_times_the_mean_colour_of_vertices(of: dict[str, Any], tmp_path: Path) -> None:
    table = textured({**of, "extensions": {"KHR_materials_unlit": {}}})
    table["meshes"][1]["primitives"][0]["attributes"]["COLOR_0"] = 1
    with pytest.warns(clrt.ClrtWarning, match="but for their mean"):
        scene = load(tmp_path, table)
    shown = scene.material_of(scene.shapes[1])
    emission: Any = shown.emission
    assert shown.color == 0 and isinstance(emission, ImageTexture) == (of is BASE)
    np.testing.assert_allclose(emission.tint if of is BASE else emission, [1 / 3, 1 / 3, 0])


def test_parts_in_scene_files(tmp_path: Path) -> None:
    write(tmp_path / "a.glb", textured(BASE))
    ball = {"type": "sphere", "center": [0, 0, 0], "radius": 1}
    for picture, says in (
        ({"file": "a.glb"}, r"color\.file: 'a\.glb' is not allowed; of a model's file say which picture"),
        ({"file": "b.png", "part": 0},
         r"color\.part: 0 is not allowed; only \.glb, \.gltf, \.ply files have"),
        ({"file": "a.glb", "part": -1}, r"color\.part: -1 is not allowed; part must be a whole number"),
        ({"file": "a.glb", "part": 0, "tint": [1, 1, -1]}, r"color\.tint.*-1"),
    ):
        material = {"color": {"type": "image", **picture}}
        with pytest.raises(SceneError, match=says):
            clrt.load_dict({"shapes": [{**ball, "material": material}]}, folder=tmp_path)
    with pytest.raises(SceneError, match=r"normal_map\.file: 'a\.glb' is not allowed"):
        clrt.load_dict({"shapes": [{**ball, "material": {"normal_map": {"file": "a.glb"}}}]}, folder=tmp_path)


@pytest.mark.parametrize("one_mesh", [False, True])
def test_textures_stay_where_there_are_uv(tmp_path: Path, one_mesh: bool) -> None:
    table = textured(BASE)
    bare = {"attributes": {"POSITION": 0}, "material": 0}
    if one_mesh:
        table["meshes"][1]["primitives"].append(bare)
    else:
        table["meshes"][0]["primitives"] = [bare]
    with pytest.warns(clrt.ClrtWarning, match=r"counterpart: textures of 'material 0' where it has no uv$"):
        scene = load(tmp_path, table)
    meshes = [shape for shape in scene.shapes if isinstance(shape, Mesh)]
    shown = [(mesh.data().uv is not None, scene.material_of(mesh).pictures) for mesh in meshes]
    assert sorted(uv for uv, pictures in shown if pictures) == [True]
    assert [bool(pictures) for uv, pictures in shown if not uv] == [False] * (len(shown) - 1)
    assert list(scene.materials) == ["material 0", "material 0-2"]


def test_what_a_picture_within_a_model_declares_of_its_colours_is_ignored(tmp_path: Path) -> None:
    """glTF 2.0, "Images": colour spaces of PNG and JPEG are. So it is not told, as of a picture's file."""
    chunk = b"gAMA" + struct.pack(">I", 100000)
    gamma = struct.pack(">I", 4) + chunk + struct.pack(">I", zlib.crc32(chunk))
    declared = PICTURE[:33] + gamma + PICTURE[33:]  # after the header
    (tmp_path / "a.png").write_bytes(declared)
    with pytest.warns(clrt.ClrtWarning, match="a.png: its colours are declared as"):
        flatten(clrt.load_dict({"background": "a.png"}, folder=tmp_path))
    uri = f"data:image/png;base64,{base64.b64encode(declared).decode()}"
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        scene = load(tmp_path, textured(BASE, ({"uri": uri},)))
        assert flatten(scene).hash == flatten(load(tmp_path, textured(BASE))).hash
