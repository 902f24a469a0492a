"""What is wrong with a glTF model's looks, lights and cameras is told, where it is."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

import clrt
from clrt.base.errors import SceneError
from tests.model_samples import CAMERA, METAL, SPOT, SUN, model, shining, write_glb

FLAT = {"type": "orthographic", "orthographic": {"xmag": 0, "ymag": 1}}


@pytest.mark.parametrize(
    ("table", "says"),
    [
        (model([{"pbrMetallicRoughness": {"baseColorFactor": [1, 1, 1]}}]),
         r"materials\[0\] are not those of a glTF file: Expected `array` of length 4"),
        (model([{"extensions": {"KHR_materials_volume": {"attenuationDistance": -1}}}]),
         r"materials\[0\]\.extensions\.KHR_materials_volume are not those of a glTF file: .*>= 0"),
        ({**model([{}]), "materials": []}, r"there is no materials\[0\]"),
        ({**model([{}]), "materials": 1}, "its materials are not those of a glTF file"),
        (model([], ({"camera": 0},)), r"there is no cameras\[0\]"),
        (model([], ({"camera": 0},), cameras=[{"type": "perspective"}]),
         r"cameras\[0\] is of type perspective, but says nothing of that"),
        (model([], ({"camera": 0},), cameras=[{"type": "orthographic"}]),
         r"cameras\[0\] is of type orthographic"),
        (model([], ({"camera": 0},), cameras=[{"type": "perspective", "perspective": {"yfov": 4}}]),
         "Expected `float` < 3.14"),
        (model([], ({"camera": 0},), cameras=[FLAT]), r"cameras\[0\] has a view of no size"),
        (model([], ({"camera": 0, "scale": [0, 0, 0]},), cameras=[CAMERA]),
         r"nodes\[1\] has a camera or a light, but no direction"),
        (model([], ({"camera": 0, "scale": [1, 1e300, 1e300]},), cameras=[CAMERA]),
         r"nodes\[1\] has a camera or a light, but no direction"),
        (model([], (shining(1),), (SUN,)), r"there is no lights\[1\]"),
        (model([], (shining(0),), ({"type": "area"},)), "Invalid enum value 'area'"),
        (model([], (shining(0),), ({**SPOT, "spot": {"innerConeAngle": 0.6, "outerConeAngle": 0.5}},)),
         r"the cone of lights\[0\] ends where it begins"),
        (model([], (shining(0),), ({**SUN, "intensity": -1},)), "Expected `float` >= 0"),
        (model([METAL], ({"children": [3]}, {"children": [2]})), r"nodes\[\d\] is below two nodes"),
    ],
)  # fmt: skip
def test_looks_that_contradict_themselves(tmp_path: Path, table: dict[str, Any], says: str) -> None:
    with pytest.raises(SceneError, match=rf"a\.glb: cannot be read as a mesh: .*{says}") as caught:
        clrt.load(write_glb(tmp_path / "a.glb", table))
    assert len(str(caught.value)) < 400 and "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("table", "says"),
    [
        (model([{"emissiveFactor": [1, 1, 1], "extensions": {
            "KHR_materials_emissive_strength": {"emissiveStrength": 1e300}}}]), "materials.*emission"),
        (model([], (shining(0),), ({**SUN, "intensity": 1e300},)), r"lights\[0\]\.intensity"),
        (model([], ({"camera": 0, "translation": [1e300, 0, 0]},), cameras=[CAMERA]), "camera.origin"),
        (model([METAL], nodes=({"camera": 0, "matrix": [1, 0, 0, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 0, 1]},),
               cameras=[CAMERA]), "camera.up: .*parallel"),
    ],
)  # fmt: skip
def test_numbers_that_no_device_holds(tmp_path: Path, table: dict[str, Any], says: str) -> None:
    with pytest.raises(SceneError, match=rf"a\.glb: {says}"):
        clrt.load(write_glb(tmp_path / "a.glb", table))


def test_a_model_of_points_has_no_faces(tmp_path: Path) -> None:
    table = model([METAL], ({"camera": 0},), cameras=[CAMERA])
    for mesh in table["meshes"]:
        mesh["primitives"][0]["mode"] = 0
    with pytest.raises(SceneError, match=r"a\.glb: it has no faces"):
        clrt.load(write_glb(tmp_path / "a.glb", table))


def test_a_model_at_one_point(tmp_path: Path) -> None:
    """Nothing could be framed; nor is there a plain mesh's."""
    for materials in ([METAL], []):
        table = model(materials)
        for node in table["nodes"]:
            node["scale"] = [0, 0, 0]
        table["scenes"] = [{"nodes": [0]}] if not materials else [{"nodes": [1]}]
        with pytest.raises(SceneError, match=r"a\.glb: all its vertices are at one point"):
            clrt.load(write_glb(tmp_path / "a.glb", table))
