"""Pictures on surfaces as files: what is read, and one error for each that is not."""

from __future__ import annotations

import json
import struct
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import clrt
from clrt.flatten.flatten import flatten
from clrt.images.texture import read_texels, texture_bytes
from clrt.meshfiles.file import _uv
from tests.pictured import image, put

POINTS = [[0, 0, 0], [1, 0, 0], [0, 1, 0]]
UV = [[0, 0.25], [1, 0.5], [0.5, 1]]
MESH = {"type": "mesh", "vertices": POINTS, "faces": [[0, 1, 2]]}


def load(folder: Path, shape: dict[str, Any], **material: Any) -> clrt.Scene:
    return clrt.load_dict({"shapes": [{**shape, "material": material}]}, folder=folder)


BALL = {"type": "sphere", "center": [0, 0, 0], "radius": 1}
KEYS = {
    "no file": ({"file": "none.png"}, "there is no such file"),
    "outside": ({"file": "../a.png"}, "must lie in the scene's folder"),
    "no wrap": ({"file": "a.png", "wrap": "tile"}, "wrap must be 'repeat', 'clamp' or 'mirror'"),
    "no filter": ({"file": "a.png", "filter": "cubic"}, "filter must be 'linear', 'nearest' or 'mipmap'"),
    "no encoding": ({"file": "a.png", "encoding": "aces"}, "encoding must be 'srgb' or 'linear'"),
    "flat scale": ({"file": "a.png", "scale": [0, 1]}, "neither number of scale may be 0"),
    "unknown key": ({"file": "a.png", "wrapp": "clamp"}, "wrapp"),
    "levels of corners": (
        {"file": "a.ply", "part": 0, "filter": "mipmap"}, "colours of vertices and faces have no mip levels"
    ),
    "nothing": ({}, "the key 'file' is missing"),
}


@pytest.mark.parametrize("name", KEYS)
@pytest.mark.parametrize("key", ["color", "emission", "transmission_color"])
def test_a_wrong_key_is_one_error_that_names_its_place(tmp_path: Path, name: str, key: str) -> None:
    put(tmp_path / "a.png", np.zeros((2, 2, 3)), "uint8")
    keys, right = KEYS[name]
    with pytest.raises(clrt.SceneError) as error:
        load(tmp_path, BALL, **{key: {"type": "image", **keys}})
    assert right in str(error.value) and f"shapes[0].material.{key}" in str(error.value)
    with pytest.raises(clrt.SceneError, match=rf"materials.m.{key}"):
        clrt.load_dict({"materials": {"m": {key: {"type": "image", **keys}}}}, folder=tmp_path)


@pytest.mark.parametrize(
    ("placement", "right"),
    [
        ({"wrap": "tile"}, "wrap must be 'repeat', 'clamp' or 'mirror'"),
        ({"scale": [1, 0]}, "neither number of scale may be 0"),
        ({"file": "a.png"}, "file"),
        ("clamp", "placement"),
    ],
)
def test_a_wrong_placement_of_a_normal_map_is_one_error(
    tmp_path: Path, placement: Any, right: str
) -> None:
    put(tmp_path / "a.png", np.zeros((2, 2, 3)), "uint8")
    with pytest.raises(clrt.SceneError, match=r"shapes\[0\]\.material\.normal_map\.placement") as error:
        load(tmp_path, BALL, normal_map={"file": "a.png", "placement": placement})
    assert right in str(error.value)


def test_a_normal_map_lies_as_its_placement_says_or_as_the_picture_of_color(tmp_path: Path) -> None:
    put(tmp_path / "a.png", np.zeros((4, 2, 3)), "uint8")
    own = {"scale": [2, -3], "offset": [0.5, 0.25], "wrap": "mirror", "filter": "mipmap"}
    other = {"color": image("a.png", scale=[5, 5], wrap="clamp")}
    for keys, color, expected in (
        ({"placement": own}, other, (2, -3, 0.5, 0.25, 2)), ({"placement": own}, {}, (2, -3, 0.5, 0.25, 2)),
        ({"placement": {}}, other, (1, 1, 0, 0, 0)), ({}, other, (5, 5, 0, 0, 0)), ({}, {}, (1, 1, 0, 0, 0)),
    ):  # fmt: skip
        scene = load(tmp_path, BALL, **color, normal_map={"file": "a.png", **keys})
        flat = flatten(scene)
        record = flat.textures[flat.pictured[0]["normal_map"]]
        fields = ("scale_u", "scale_v", "offset_u", "offset_v", "levels")
        assert tuple(record[field] for field in fields) == expected
        scene.save(tmp_path / "s.toml")
        assert clrt.load(tmp_path / "s.toml") == scene


def test_a_mesh_needs_uv_and_they_must_be_right(tmp_path: Path) -> None:
    put(tmp_path / "a.png", np.zeros((2, 2, 3)), "uint8")
    shown = {"color": image("a.png")}
    with pytest.raises(clrt.SceneError, match=r"shapes\[0\].material: .*the mesh has no uv"):
        load(tmp_path, MESH, **shown)
    with pytest.raises(clrt.SceneError, match=r"shapes\[0\].material: its normal_map .*no uv"):
        load(tmp_path, MESH, normal_map={"file": "a.png"})
    with pytest.raises(clrt.SceneError, match=r"shapes\[0\].uv: 2 uv for 3 vertices"):
        load(tmp_path, {**MESH, "uv": UV[:2]}, **shown)
    with pytest.raises(clrt.SceneError, match=r"shapes\[0\].uv\[1\].*must be finite"):
        load(tmp_path, {**MESH, "uv": np.array([[0, 0], [np.nan, 0], [1, 1]])}, **shown)
    with pytest.raises(clrt.SceneError, match="uv must be 2 numbers each"):
        load(tmp_path, {**MESH, "uv": [[0, 0, 0]] * 3}, **shown)
    with pytest.raises(clrt.SceneError, match=r"numbers \(n, 2\)"):
        load(tmp_path, {**MESH, "uv": np.zeros((3, 3))}, **shown)


def test_pictures_that_are_none_are_one_error(tmp_path: Path) -> None:
    put(tmp_path / "two.exr", np.zeros((2, 2, 2)), names=("U", "V"))
    put(tmp_path / "nan.exr", np.full((2, 2, 3), np.nan))
    put(tmp_path / "huge.exr", np.full((2, 2, 3), 3e38))
    (tmp_path / "text.png").write_text("no picture")
    whole = put(tmp_path / "whole.png", np.zeros((64, 64, 3)), "uint8").read_bytes()
    lying = whole[:16] + struct.pack(">II", 2000, 2000) + whole[24:]  # a header of another size
    (tmp_path / "lying.png").write_bytes(lying)
    (tmp_path / "short.png").write_bytes(whole[:60])
    words = {"two": "its channels are 'U, V'", "nan": "is nan", "text": "not an EXR", "lying": "lying.png",
             "short": "short.png"}  # fmt: skip
    for name, right in words.items():
        file = next(tmp_path.glob(f"{name}.*")).name
        with pytest.raises(clrt.ClrtError, match=right):
            flatten(load(tmp_path, BALL, color=image(file)))
    with pytest.raises(clrt.SceneError, match="is inf; a scene needs finite numbers"):
        flatten(load(tmp_path, BALL, emission=image("huge.exr", encoding="srgb")))


def test_all_pictures_together_have_a_limit_that_headers_tell(tmp_path: Path) -> None:
    for name in "ab":
        put(tmp_path / f"{name}.png", np.zeros((10, 20, 3)), "uint8")
    assert texture_bytes(tmp_path / "a.png", clrt.Limits()) == 12 * 200
    table = {"shapes": [
        {**BALL, "material": {"color": image("a.png"), "emission": image("b.png")}},
        {**BALL, "material": {"color": image("a.png", wrap="clamp")}},  # read once
    ]}  # fmt: skip
    limits = clrt.Limits(texture_bytes=2 * 12 * 200)
    flatten(clrt.load_dict(table, folder=tmp_path, limits=limits))
    with pytest.raises(clrt.LimitError, match="texture_bytes: 4 800 is above the limit of 4 799"):
        flatten(clrt.load_dict(table, folder=tmp_path, limits=clrt.Limits(texture_bytes=4799)))


def test_mip_levels_count_before_they_are_made(tmp_path: Path) -> None:
    """10 x 20, 5 x 10, 2 x 5, 1 x 2 and 1 x 1 texels; and those of a row, which are nearly as many again."""
    put(tmp_path / "a.png", np.zeros((10, 20, 3)), "uint8")
    put(tmp_path / "row.png", np.zeros((1, 64, 3)), "uint8")
    limits = clrt.Limits()
    assert texture_bytes(tmp_path / "a.png", limits, levels=True) == 12 * (200 + 50 + 10 + 2 + 1)
    assert texture_bytes(tmp_path / "row.png", limits, levels=True) == 12 * 127
    # of a material that shows it with levels, of another without, and of its tinted twin: two sets of texels
    shown = image("a.png", filter="mipmap"), image("a.png"), image("a.png", tint=[0.5, 1, 1])
    table = {"shapes": [{**BALL, "material": {"color": one}} for one in shown]}
    flatten(clrt.load_dict(table, folder=tmp_path, limits=clrt.Limits(texture_bytes=12 * 463)))
    with pytest.raises(clrt.LimitError, match="texture_bytes: 5 556 is above the limit of 5 555"):
        flatten(clrt.load_dict(table, folder=tmp_path, limits=clrt.Limits(texture_bytes=5555)))


def test_texels_are_what_their_place_needs(tmp_path: Path) -> None:
    limits = clrt.Limits()
    put(tmp_path / "grey.exr", [[[-1.0], [3.0]]])
    assert read_texels(tmp_path / "grey.exr", "reflectance", None, limits)[0, :, 1].tolist() == [0, 1]
    assert read_texels(tmp_path / "grey.exr", "light", None, limits)[0, :, 1].tolist() == [0, 3]
    assert read_texels(tmp_path / "grey.exr", "normal", None, limits)[0, :, 1].tolist() == [-3, 5]
    put(tmp_path / "a.png", [[[0, 128, 255]]], "uint8")
    assert read_texels(tmp_path / "a.png", "normal", None, limits)[0, 0] == pytest.approx([-128 / 127, 0, 1])
    put(tmp_path / "b.png", [[[1, 32768, 65535]]], "uint16")
    assert read_texels(tmp_path / "b.png", "normal", None, limits)[0, 0].tolist() == [-1, 0, 1]
    half = read_texels(tmp_path / "b.png", "reflectance", "linear", limits)[0, 0, 1]
    assert half == np.float32(32768 / 65535)
    put(tmp_path / "rgba.png", [[[10, 20, 30, 0]]], "uint8")
    expected = read_texels(put(tmp_path / "rgb.png", [[[10, 20, 30]]], "uint8"), "light", "srgb", limits)
    assert np.array_equal(read_texels(tmp_path / "rgba.png", "light", None, limits), expected)


def glb(path: Path, kind: int, places: bytes, count: int = 3) -> None:
    """A triangle with TEXCOORD_0 of this type of component."""
    data = np.array(POINTS, "<f4").tobytes() + places
    views = [{"buffer": 0, "byteLength": 36}, {"buffer": 0, "byteOffset": 36, "byteLength": len(places)}]
    accessors = [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"},
                 {"bufferView": 1, "componentType": kind, "count": count, "type": "VEC2"}]  # fmt: skip
    attributes = {"POSITION": 0, "TEXCOORD_0": 1}
    text = json.dumps({
        "asset": {"version": "2.0"}, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": attributes}]}], "accessors": accessors,
        "bufferViews": views, "buffers": [{"byteLength": len(data)}],
    }).encode()  # fmt: skip
    text += b" " * (-len(text) % 4)
    chunks = struct.pack("<I4s", len(text), b"JSON") + text + struct.pack("<I4s", len(data), b"BIN\0") + data
    path.write_bytes(struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks)


def test_mesh_files_bring_uv_as_a_scene_says_them(tmp_path: Path) -> None:
    put(tmp_path / "a.exr", np.random.default_rng(1).random((4, 4, 3)))
    shown = {"color": image("a.exr")}
    expected = flatten(load(tmp_path, {**MESH, "uv": UV}, **shown)).hash
    lines = [f"v {x} {y} {z}" for x, y, z in POINTS] + [f"vt {u} {1 - v}" for u, v in UV]
    (tmp_path / "a.obj").write_text("\n".join([*lines, "f 1/1 2/2 3/3", ""]))
    head = ["ply", "format ascii 1.0", "element vertex 3", *(f"property float {name}" for name in "xyzst")]
    head += ["element face 1", "property list uchar int vertex_indices", "end_header"]
    rows = [f"{x} {y} {z} {u} {1 - v}" for (x, y, z), (u, v) in zip(POINTS, UV, strict=True)]
    (tmp_path / "a.ply").write_text("\n".join([*head, *rows, "3 0 1 2", ""]))
    glb(tmp_path / "a.glb", 5126, np.array(UV, "<f4").tobytes())
    for name in ("a.obj", "a.ply", "a.glb"):
        mesh = {"type": "mesh", "file": name}
        assert flatten(load(tmp_path, mesh, **shown)).hash == expected, name
        with pytest.raises(clrt.SceneError, match="exclude each other"):
            load(tmp_path, {**mesh, "uv": UV}, **shown)
    glb(tmp_path / "b.glb", 5121, bytes([0, 51, 255, 102, 51, 255]))
    found = load(tmp_path, {"type": "mesh", "file": "b.glb"}, **shown).shapes[0].data().uv
    assert found.tolist() == [[0, 0.2], [1, 0.4], [0.2, 1]]
    glb(tmp_path / "c.glb", 5126, np.array(UV[:2], "<f4").tobytes(), 2)
    with pytest.raises(clrt.SceneError, match="has not one uv for each of 3 vertices"):
        load(tmp_path, {"type": "mesh", "file": "c.glb"}, **shown)


def test_a_scene_saved_elsewhere_still_finds_its_pictures(tmp_path: Path) -> None:
    inner = tmp_path / "in"
    inner.mkdir()
    put(inner / "a.png", np.full((2, 2, 3), 99), "uint8")
    scene = clrt.load_dict({
        "materials": {"m": {"color": image("in/a.png"), "normal_map": {"file": "in/a.png"}}},
        "shapes": [{**BALL, "material": "m"}, {**BALL, "material": {"emission": image("in/a.png")}},
                   {**MESH, "uv": UV, "material": "m"}],
    }, folder=tmp_path)  # fmt: skip
    scene.save(inner / "s.toml")
    again = clrt.load(inner / "s.toml")
    assert again.materials["m"].color.file == "a.png" and flatten(again).hash == flatten(scene).hash
    other = tmp_path / "other"
    other.mkdir()
    with pytest.raises(clrt.SceneError, match=r"materials.m.color.file: 'in/a.png' is not in"):
        scene.save(other / "s.toml")
    assert clrt.load_dict(scene.to_dict(), folder=tmp_path) == scene


def test_uv_that_do_not_fit_their_vertices_are_a_broken_file() -> None:
    with pytest.raises(ValueError, match="uv must be 2 numbers for each vertex"):
        _uv(SimpleNamespace(uv=np.zeros((2, 2))), 3)
