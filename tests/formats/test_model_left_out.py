"""What a model has and a scene has not: named, in one warning."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

import clrt
from tests.model_samples import (
    CAMERA,
    GLASS,
    METAL,
    POINT,
    corners,
    model,
    shining,
    write_glb,
)


def test_one_warning_names_all_that_has_no_counterpart(
    tmp_path: Path, recwarn: pytest.WarningsRecorder
) -> None:
    rough = {**GLASS, "pbrMetallicRoughness": {"metallicFactor": 0, "roughnessFactor": 0.5}}
    coats: dict[str, Any] = {"KHR_materials_clearcoat": {}, "FOO_\x1bbar": {}}
    other = {"extensions": coats, "occlusionTexture": {"index": 0}}
    table = model(
        [rough, other], (shining(0, skin=0),), ({**POINT, "range": 5},),
        textures=[{}],
    )  # fmt: skip
    table["nodes"][1]["skin"] = 0
    table["meshes"][1]["primitives"][0]["attributes"]["COLOR_0"] = 1
    clrt.load(write_glb(tmp_path / "a.glb", table))
    (said,) = [str(warning.message) for warning in recwarn]
    assert said == (
        "a.glb: left out, since there is no counterpart: the roughness of glass, clearcoat, FOO bar, "
        "occlusion, the range of lights, skins"
    )


def test_glass_of_which_only_a_part_is_there_is_all_there_and_named(tmp_path: Path) -> None:
    metal = {"metallicFactor": 0, "roughnessFactor": 0, "baseColorFactor": [1, 1, 1, 0.5]}
    half = {**GLASS, "pbrMetallicRoughness": metal, "alphaMode": "BLEND"}
    with pytest.warns(clrt.ClrtWarning, match="no counterpart: the alpha of glass"):
        clrt.load(write_glb(tmp_path / "a.glb", model([half])))


def animated(table: dict[str, Any]) -> None:
    table["animations"] = [{"channels": [], "samplers": []}]


def staged_twice(table: dict[str, Any]) -> None:
    table["scenes"].append({"nodes": [0]})


def beside(mode: int) -> Any:
    """Another primitive, at the node of the first."""

    def change(table: dict[str, Any]) -> None:
        table["meshes"][0]["primitives"].append({"attributes": {"POSITION": 0}, "mode": mode})

    return change


@pytest.mark.parametrize("materials", [[], [METAL]])
@pytest.mark.parametrize(
    ("change", "says"),
    [
        (animated, "animations"), (staged_twice, "further scenes"), (beside(0), "points"),
        (beside(1), "lines"), (beside(2), "lines"), (beside(3), "lines"),
        (beside(9), "primitives of unknown modes"),
    ],
)  # fmt: skip
def test_what_is_no_surface_of_the_scene_is_named(
    tmp_path: Path, change: Any, says: str, materials: list[Any], recwarn: pytest.WarningsRecorder
) -> None:
    """Also where a file says nothing of how it looks; what is shown is what was."""
    table = model(materials)
    before = clrt.load(write_glb(tmp_path / "a.glb", table))
    change(table)
    scene = clrt.load(write_glb(tmp_path / "a.glb", table))
    (said,) = [str(one.message) for one in recwarn]
    assert said == f"a.glb: left out, since there is no counterpart: {says}"
    assert corners(scene) == corners(before)
    recwarn.clear()
    table["animations"], table["scenes"] = [], table["scenes"][:1]
    table["meshes"][0]["primitives"][1:] = []
    assert clrt.load(write_glb(tmp_path / "a.glb", table)) == before and not recwarn


def test_all_that_is_no_surface_is_named_in_one_warning(
    tmp_path: Path, recwarn: pytest.WarningsRecorder
) -> None:
    table = model([{"occlusionTexture": {"index": 0}}], (shining(0),), ({**POINT, "range": 5},))
    table["nodes"][1]["skin"] = 0
    for change in (animated, staged_twice, beside(1), beside(0), beside(3)):
        change(table)
    table["meshes"].append({"primitives": [{"attributes": {"POSITION": 0}, "mode": 9}]})  # nothing shows it
    clrt.load(write_glb(tmp_path / "a.glb", table))
    (said,) = [str(one.message) for one in recwarn]
    left = "occlusion, the range of lights, further scenes, animations, lines, points, skins"
    assert said == f"a.glb: left out, since there is no counterpart: {left}"


def test_extensions_that_nothing_reads_are_named(tmp_path: Path, recwarn: pytest.WarningsRecorder) -> None:
    """Listed or not, of materials or of others, of a file that says nothing else of how it looks."""
    known = ["KHR_texture_transform", "KHR_materials_sheen", "EXT_texture_webp", "KHR_lights_punctual"]
    table = model([], extensionsUsed=[*known, "FOO_bar", "FOO_bar", "odd name\x1b"])
    table["nodes"][0]["extensions"] = {"MSFT_lod": {"ids": []}, "KHR_node_visibility": {"visible": True}}
    table["scenes"][0]["extensions"] = {"EXT_lights_image_based": {"light": 0}}
    table["extensions"] = {"FB_other": {}}
    clrt.load(write_glb(tmp_path / "a.glb", table))
    others = "'EXT_lights_image_based', the extension 'MSFT_lod', the extension 'FB_other'"
    left = f"the extension 'FOO_bar', the extension 'odd name\\x1b', the extension {others}"
    assert [str(one.message) for one in recwarn] == [
        f"a.glb: left out, since there is no counterpart: {left}"
    ]
    recwarn.clear()
    clrt.load(write_glb(tmp_path / "a.glb", model([{"extensions": {"FOO_bar": {}}}])))
    assert [str(one.message) for one in recwarn] == [
        "a.glb: left out, since there is no counterpart: FOO bar"
    ]


def test_hidden_nodes_and_what_is_below_them_are_not_shown(tmp_path: Path) -> None:
    hidden = {"KHR_node_visibility": {"visible": False}}
    lamp = {**hidden, "KHR_lights_punctual": {"light": 0}}
    nodes = (
        {"extensions": hidden, "children": [4, 5, 6]}, {"extensions": lamp}, {"mesh": 0}, shining(0),
        {"camera": 0, "translation": [0, 1, 6]},
    )  # fmt: skip
    table = model([METAL], nodes, (POINT,), cameras=[CAMERA], extensionsRequired=["KHR_node_visibility"])
    table["nodes"][1]["extensions"] = hidden
    table["scenes"][0]["nodes"] = [0, 1, 2, 3]
    scene = clrt.load(write_glb(tmp_path / "a.glb", table))
    assert [shape.name for shape in scene.shapes] == ["floor"]
    assert scene.camera is not None and scene.camera.origin == (0.0, 1.0, 6.0)
    assert len(scene.lights) == 1 and scene.ambient == 0.2  # as where there is none
