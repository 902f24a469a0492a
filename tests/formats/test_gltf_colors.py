"""Colours of vertices of glTF files: linear between corners, times the base colour."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import clrt
from clrt.images.file import decode
from tests.model_samples import write_glb
from tests.vertex_color_samples import CORNERS, FACES, VIEW, expected, seen


def write_glb_colors(path: Path, kind: str, plain: bool = False, metallic: float = 0.0, **more: Any) -> Path:
    """The triangles as three parts of one node, of one material with the base colour (1, 0.5, 0.25).

    `plain`: the last part has no colours; `more` of the material.
    """
    surface = {"baseColorFactor": [1, 0.5, 0.25, 1], "metallicFactor": metallic}
    linear = decode(np.array([corner[2:] for corner in CORNERS], np.uint8)).astype(float)
    code = {"u1": 5121, "u2": 5123, "f4": 5126}[kind]
    most = 1.0 if kind == "f4" else np.iinfo(kind).max
    colors = np.concatenate([linear * most, np.full((len(linear), 1), 0.3 * most)], axis=1)
    stored = [
        np.array([(x, y, 0) for x, y, *_ in CORNERS], "<f4").tobytes(),
        (colors if kind == "f4" else np.round(colors)).astype(f"<{kind}").tobytes(),
        np.array(FACES, "<u2").tobytes(),
    ]
    stored = [part + bytes(-len(part) % 4) for part in stored]
    attributes = [{"POSITION": 0} if plain and k == 2 else {"POSITION": 0, "COLOR_0": 1} for k in range(3)]
    table: dict[str, Any] = {
        "asset": {"version": "2.0"}, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [
            {"attributes": attributes[k], "indices": 2 + k, "material": 0} for k in range(3)
        ]}],
        "materials": [{"pbrMetallicRoughness": surface, **more}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": 5, "type": "VEC3"},
            {"bufferView": 1, "componentType": code, "count": 5, "type": "VEC4", "normalized": True},
            *({"bufferView": 2, "byteOffset": 6 * k, "componentType": 5123, "count": 3, "type": "SCALAR"}
              for k in range(3)),
        ],
        "bufferViews": [
            {"buffer": 0, "byteLength": len(part), "byteOffset": sum(map(len, stored[:k]))}
            for k, part in enumerate(stored)
        ],
        "buffers": [{"byteLength": sum(map(len, stored))}],
    }  # fmt: skip
    return write_glb(path, table, b"".join(stored))


@pytest.mark.parametrize(("kind", "plain"), [("u1", False), ("u2", False), ("f4", True)])
def test_colors_of_vertices_of_gltf(kind: str, plain: bool, tmp_path: Path) -> None:
    """As a PLY's, times the base colour; a part without is white beside those that have some."""
    scene = clrt.load(write_glb_colors(tmp_path / "scan.glb", kind, plain))
    albedo, position = seen(scene)
    right = expected(position[..., 0], position[..., 1])
    known = np.isfinite(right).all(axis=-1)
    white = known & (position[..., 1] > 2) & plain
    right[white] = 1.0
    assert known.sum() > 100 and (not plain or white.sum() > 20)
    steps = {"u1": 0.5 / 255, "u2": 0.5 / 65535, "f4": 0.0}[kind]
    diffuse = scene.material_of(scene.shapes[0]).diffuse
    shown = right * (1, 0.5, 0.25)
    np.testing.assert_allclose(albedo[known], diffuse * shown[known], atol=steps + 4e-6)
    scene.save(tmp_path / "scan.toml")
    small = {"camera.width": 24, "camera.height": 18}
    again = clrt.load(tmp_path / "scan.toml").replace(small)
    assert clrt.render(again).hash == clrt.render(scene.replace(small)).hash


@pytest.mark.parametrize("metallic", [0.25, 1.0])
def test_colors_of_vertices_tint_what_is_metal_of_a_material_too(metallic: float, tmp_path: Path) -> None:
    """They are of the base colour, which of what is metal by a share is that share of its mirror's colour."""
    scene = clrt.load(write_glb_colors(tmp_path / "scan.glb", "u1", metallic=metallic))
    table = scene.to_dict()["materials"]["material 0"]
    image = {"type": "image", "file": "scan.glb", "part": 0, "wrap": "clamp"}
    assert table["color"] == image | {"tint": [1, 0.5, 0.25]}
    mirrored = image | {"tint": [metallic, 0.5 * metallic, 0.25 * metallic]}
    assert table["highlight_color"] == table["reflection_color"] == mirrored


def test_what_is_unlit_and_not_there_does_not_glow_by_its_corners(tmp_path: Path) -> None:
    clear = {"pbrMetallicRoughness": {"baseColorFactor": [1, 1, 1, 0]}, "alphaMode": "BLEND"}
    unlit = {"extensions": {"KHR_materials_unlit": {}}}
    for more, glows in (clear, False), ({}, True):
        scene = clrt.load(write_glb_colors(tmp_path / "scan.glb", "u1", **more, **unlit))
        assert bool(scene.material_of(scene.shapes[0]).emission) == glows


def test_gltf_pictures_that_are_not_there(tmp_path: Path) -> None:
    """The number behind the last picture is that of colours; without any it is none."""
    path = write_glb_colors(tmp_path / "scan.glb", "u1")
    image = {"type": "image", "file": "scan.glb"}

    def load(number: int) -> None:
        material = {"color": {**image, "part": number}}
        mesh = {"type": "mesh", "file": "scan.glb", "part": 0, "material": material}
        clrt.render(clrt.load_dict({**VIEW, "shapes": [mesh]}, folder=tmp_path))

    load(0)
    with pytest.raises(clrt.ClrtError, match=r"there is no images\[1\]"):
        load(1)
    path.write_bytes(path.read_bytes().replace(b"COLOR_0", b"COLOR_1"))
    ball = {"type": "sphere", "center": [0, 0, 0], "radius": 1, "material": {"color": {**image, "part": 0}}}
    with pytest.raises(clrt.ClrtError, match=r"images\[0\] is not there; it has no colours of vertices"):
        clrt.render(clrt.load_dict({**VIEW, "shapes": [ball]}, folder=tmp_path))
    path.write_bytes(b"glTF")
    with pytest.raises(clrt.ClrtError, match=r"scan\.glb"):
        clrt.render(clrt.load_dict({**VIEW, "shapes": [ball]}, folder=tmp_path))
