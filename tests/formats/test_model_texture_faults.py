"""Textures of a model that a scene cannot show are left out and named; broken ones are refused."""

from __future__ import annotations

import base64
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import clrt
from clrt.base.errors import LimitError, SceneError
from clrt.scene.scene import ImageTexture
from tests.model_samples import (
    BASE,
    DATA,
    FLOOR,
    PICTURE,
    UV,
    WALL,
    load,
    textured,
    write_glb,
)

WEBP = "data:image/png;base64," + base64.b64encode(b"RIFF\x24\0\0\0WEBPVP8 ").decode()


@pytest.mark.parametrize(
    ("change", "says", "kept"),
    [
        ({"images": ({"uri": "gone.png"},)}, "the picture 'gone.png', which is not there", False),
        ({"images": ({"uri": "x" * 5000},)}, "the picture 'x+\\.\\.\\., which is not there", False),
        ({"images": ({"uri": WEBP, "mimeType": "image/png"},)}, "neither PNG nor JPEG", False),
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
    assert made.pictures.keys() == {"color"} and made.diffuse == 0.96, "beside a texture 1 is a factor"
    clrt.render(scene, width=4, height=4)


def test_a_picture_by_its_first_bytes_that_is_broken_is_refused(tmp_path: Path) -> None:
    from clrt.flatten.flatten import flatten

    (tmp_path / "x.webp").write_bytes(PICTURE[:40])
    (tmp_path / "empty.png").write_bytes(b"")
    for image in ({"uri": "x.webp"}, {"uri": DATA[:62]}, {"uri": "empty.png"}, {"uri": "data:image/png"}):
        with pytest.raises(SceneError, match=r"x\.webp: |empty\.png: |images\[0\](: |\.uri begins)"):
            flatten(load(tmp_path, textured(BASE, (image,))))


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


@pytest.mark.parametrize(
    ("image", "says"),
    [
        ({"bufferView": 9}, r"a\.glb: there is no bufferViews\[9\]"),
        ({}, r"a\.glb: images\[0\] has no data"),
        ({"uri": "data:;base64,A"}, r"a\.glb: images\[0\] is not in base64: it has 1 letters"),
        ({"uri": DATA[:40] + "!!!!" + DATA[40:]}, r"images\[0\] is not in base64: letter 19 is '!'"),
        ({"uri": DATA.replace("base64", "bas64")}, r"images\[0\]\.uri begins with 'data:image/png;bas64,'"),
        ({"uri": "data:image/png,%8"}, r"images\[0\]\.uri has '%8'"),
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
