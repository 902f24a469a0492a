"""Textures of glTF models: within the file, as data, in files beside it."""

from __future__ import annotations

import base64
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import clrt
from clrt.base.errors import LimitError, SceneError
from clrt.images.file import write as write_picture
from clrt.scene.scene import ImageTexture, Mesh, NormalMap, Placement, Scene
from tests.model_samples import CAMERA, FLOOR, LIGHTS, PICTURE, POINT, WALL, model, shining, write_glb

UV = ((0.0, 0.0), (1.0, 0.0), (0.0, 1.0))
DATA = f"data:image/png;base64,{base64.b64encode(PICTURE).decode()}"
BASE = {"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}, "metallicFactor": 0}}

MOVED = {"index": 0, "extensions": {"KHR_texture_transform": {"scale": [2, 3], "offset": [0.5, 0]}}}


def textured(
    material: dict[str, Any], images: tuple[dict[str, Any], ...] = ({"bufferView": 1},), **more: Any
) -> dict[str, Any]:
    """A model of one material whose wall has uv; texture i shows image i."""
    table = model([material])
    table["meshes"][1]["primitives"][0]["attributes"]["TEXCOORD_0"] = 2
    table["accessors"].append(
        {"bufferView": 0, "byteOffset": 72, "componentType": 5126, "count": 3, "type": "VEC2"}
    )
    table["buffers"][0]["byteLength"] = 96 + len(PICTURE)
    table["bufferViews"] = [
        {"buffer": 0, "byteLength": 96}, {"buffer": 0, "byteOffset": 96, "byteLength": len(PICTURE)},
    ]  # fmt: skip
    return {
        **table, "images": list(images), "textures": [{"source": k} for k in range(len(images))], **more,
    }  # fmt: skip


def write(path: Path, table: dict[str, Any]) -> Path:
    corners = np.array([FLOOR, WALL], "<f4").tobytes() + np.array(UV, "<f4").tobytes()
    return write_glb(path, table, corners + PICTURE)


def load(tmp_path: Path, table: dict[str, Any], **options: Any) -> Scene:
    return clrt.load(write(tmp_path / "a.glb", table), **options)


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


@pytest.mark.parametrize(
    ("change", "says", "kept"),
    [
        ({"images": ({"uri": "gone.png"},)}, "pictures that are not there", False),
        ({"images": ({"uri": "x" * 5000},)}, "pictures that are not there", False),
        ({"images": ({"bufferView": 1, "mimeType": "image/webp"},)}, "neither PNG nor JPEG", False),
        ({"textures": [{}]}, "neither PNG nor JPEG", False),
        ({"textures": [{"source": 0, "sampler": 0}], "samplers": [{"wrapS": 33648}]},
         "a second way of wrapping", True),
    ],
)  # fmt: skip
def test_textures_that_are_left_out(
    tmp_path: Path, change: dict[str, Any], says: str, kept: bool
) -> None:
    with pytest.warns(clrt.ClrtWarning, match=f"no counterpart: .*{says}") as said:
        (found,) = load(tmp_path, textured(BASE, **change)).materials.values()
    assert len(said) == 1 and isinstance(found.color, ImageTexture) == kept


KINDS = {
    "webp": b"RIFF\x24\0\0\0WEBPVP8 ", "tga": bytes([0, 0, 2]), "ktx2": b"\xabKTX 20\xbb", "gif": b"GIF89a",
}  # fmt: skip


@pytest.mark.parametrize("place", ["beside", "data", "lines", "percents", "view"])
@pytest.mark.parametrize("kind", KINDS)
def test_what_is_no_picture_by_its_first_bytes_is_left_out(tmp_path: Path, kind: str, place: str) -> None:
    """Whatever its name and its type say; beside it a picture that is one."""
    data = KINDS[kind] + bytes(40)
    (tmp_path / "x.png").write_bytes(data)
    text = base64.b64encode(data).decode()
    lines = "".join(f"{letter}\r\n" for letter in text)
    percents = "".join(f"%{byte:02x}" for byte in data)
    image = {
        "beside": {"uri": "x.png"},
        "data": {"uri": f"data:image/png;base64,{text}"},
        "lines": {"uri": f"data:image/png;base64,{lines}"},
        "percents": {"uri": f"data:,{percents}"},
        "view": {"bufferView": 2, "mimeType": "image/png"},
    }[place]
    found = {"baseColorTexture": {"index": 1}, "metallicRoughnessTexture": {"index": 0}}
    material = {"pbrMetallicRoughness": found, "normalTexture": {"index": 0}, "emissiveTexture": {"index": 0}}
    table = textured(material, (image, {"bufferView": 1}))
    table["bufferViews"].append({"buffer": 0, "byteOffset": 96 + len(PICTURE), "byteLength": len(data)})
    table["buffers"][0]["byteLength"] += len(data)
    corners = np.array([FLOOR, WALL], "<f4").tobytes() + np.array(UV, "<f4").tobytes()
    with pytest.warns(clrt.ClrtWarning) as said:
        scene = clrt.load(write_glb(tmp_path / "a.glb", table, corners + PICTURE + data))
    (text,) = [str(warning.message) for warning in said]
    left = "textures of roughness and metal, but for their mean, textures that are neither PNG nor JPEG"
    assert text == f"a.glb: left out, since there is no counterpart: {left}"
    (made,) = scene.materials.values()
    assert made.pictures.keys() == {"color", "reflection_color", "highlight_color"} and made.roughness == 1.0
    clrt.render(scene, width=4, height=4)


def test_a_picture_by_its_first_bytes_that_is_broken_is_refused(tmp_path: Path) -> None:
    from clrt.flatten.flatten import flatten

    (tmp_path / "x.webp").write_bytes(PICTURE[:40])
    (tmp_path / "empty.png").write_bytes(b"")
    for image in ({"uri": "x.webp"}, {"uri": DATA[:62]}, {"uri": "empty.png"}, {"uri": "data:image/png"}):
        with pytest.raises(SceneError, match=r"x\.webp: |empty\.png: |images\[0\]: "):
            flatten(load(tmp_path, textured(BASE, (image,))))


def test_a_picture_of_many_textures_is_looked_at_once(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from clrt.meshfiles import gltf

    looked: list[str] = []
    monkeypatch.setattr(gltf, "_head_of", lambda uri: looked.append(uri) or PICTURE[:8])
    many = textured(BASE, ({"uri": DATA},), textures=[{"source": 0}] * 9)
    for index in range(1, 9):
        info = {"pbrMetallicRoughness": {"baseColorTexture": {"index": index}}}
        many["materials"].append(info)
        many["meshes"][1]["primitives"].append({**many["meshes"][1]["primitives"][0], "material": index})
    assert len(load(tmp_path, many).materials) == 9 and looked == [DATA]


@pytest.mark.parametrize(
    ("info", "says", "kept"),
    [
        ({"index": 0, "texCoord": 1}, "textures of second uv", False),
        ({"index": 0, "texCoord": 1, "extensions": {"KHR_texture_transform": {"texCoord": 0, "rotation": 1}}},
         "the rotation of textures", True),
    ],
)  # fmt: skip
def test_uv_that_are_left_out(tmp_path: Path, info: dict[str, Any], says: str, kept: bool) -> None:
    material = {"pbrMetallicRoughness": {"baseColorTexture": info}, "alphaMode": "MASK"}
    with pytest.warns(clrt.ClrtWarning, match=rf"no counterpart: .*{says}") as said:
        (found,) = load(tmp_path, textured(material)).materials.values()
    assert "transparency in textures" in str(said[0].message)
    assert isinstance(found.color, ImageTexture) == kept


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


@pytest.mark.parametrize(
    ("material", "named"),
    [
        ({"normalTexture": {"index": 0}}, True),
        (BASE, False),
        ({"normalTexture": {"index": 0, "texCoord": 1}}, False),  # which is left out
        ({"normalTexture": {"index": 0}, "extensions": {"KHR_materials_unlit": {}}}, False),
        (None, False),
    ],
)
def test_tangents_are_named_where_a_normal_map_would_lean_by_them(
    tmp_path: Path, material: dict[str, Any] | None, named: bool, recwarn: pytest.WarningsRecorder
) -> None:
    table = textured(material or {})
    primitive = table["meshes"][1]["primitives"][0]
    primitive["attributes"]["TANGENT"] = 0
    if material is None:
        del primitive["material"]
    load(tmp_path, table)
    said = [str(warning.message) for warning in recwarn]
    assert any("tangents of normal maps" in text for text in said) == named
    assert len(said) <= 1 and (not named or said[0].endswith("no counterpart: tangents of normal maps"))


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


@pytest.mark.parametrize(
    ("image", "says"),
    [
        ({"bufferView": 9}, r"a\.glb: there is no bufferViews\[9\]"),
        ({}, r"a\.glb: images\[0\] has no data"),
        ({"uri": "data:;base64,A"}, r"a\.glb: images\[0\] is not in base64"),
        ({"uri": DATA[:62]}, r"a\.glb: images\[0\]"),
    ],
)
def test_pictures_that_cannot_be_read(tmp_path: Path, image: dict[str, Any], says: str) -> None:
    from clrt.flatten.flatten import flatten

    scene = load(tmp_path, textured(BASE, (image,)))
    with pytest.raises(SceneError, match=says) as caught:
        flatten(scene)
    assert "\n" not in str(caught.value) and len(str(caught.value)) < 400
    rough = {"pbrMetallicRoughness": {"metallicRoughnessTexture": {"index": 0}}}
    with pytest.raises(SceneError, match=says):
        load(tmp_path, textured(rough, (image,)))


def test_a_view_that_is_too_long(tmp_path: Path) -> None:
    from clrt.flatten.flatten import flatten

    table = textured(BASE)
    table["bufferViews"][1]["byteLength"] = 9999
    with pytest.raises(SceneError, match=r"images\[0\] reaches beyond the \d+ bytes of its buffer"):
        flatten(load(tmp_path, table))
    table = textured(BASE)
    table["buffers"].append({"uri": "far.bin"})
    table["bufferViews"][1]["buffer"] = 1
    with pytest.raises(SceneError, match=r"images\[0\] is not within the file"):
        flatten(load(tmp_path, table))


def test_textures_stay_in_the_folder_and_within_limits(tmp_path: Path) -> None:
    from clrt.flatten.flatten import flatten

    (tmp_path / "far.png").write_bytes(PICTURE)
    (tmp_path / "in").mkdir()
    for uri in ("../far.png", str(tmp_path / "far.png"), "..%2Ffar.png"):
        with pytest.raises(SceneError, match="a file must lie in the scene's folder"):
            load(tmp_path / "in", textured(BASE, ({"uri": uri},)))
    with pytest.raises(LimitError, match="texture_bytes: 48 is above the limit of 40"):
        flatten(load(tmp_path, textured(BASE), limits=clrt.Limits(texture_bytes=40)))
    with pytest.raises(LimitError, match=r"a\.glb: images\[0\].*image_pixels: 4 is above"):
        flatten(load(tmp_path, textured(BASE), limits=clrt.Limits(image_pixels=3)))


@pytest.mark.parametrize(
    ("table", "says"),
    [
        (textured(BASE, textures=[]), r"there is no textures\[0\]"),
        (textured(BASE, images=()), r"there is no textures\[0\]"),
        (textured(BASE, textures=[{"source": 5}]), r"there is no images\[5\]"),
        (textured(BASE, textures=[{"source": 0, "sampler": 1}]), r"there is no samplers\[1\]"),
        (textured(BASE, samplers=[{"wrapS": 7}]), "Invalid enum value 7"),
    ],
)
def test_textures_that_contradict_themselves(tmp_path: Path, table: dict[str, Any], says: str) -> None:
    with pytest.raises(SceneError, match=rf"a\.glb: cannot be read as a mesh: .*{says}"):
        load(tmp_path, table)


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
