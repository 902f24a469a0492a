"""What a material of a model becomes in a scene."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import pytest

import clrt
from tests.model_samples import (
    GLASS,
    PLASTIC,
    lobe,
    metal_rough,
    model,
    write_glb,
)


def material(tmp_path: Path, table: dict[str, Any]) -> dict[str, Any]:
    """What a material of a file becomes, as a scene file has it."""
    scene = clrt.load(write_glb(tmp_path / "a.glb", model([table])))
    (found,) = scene.to_dict()["materials"].values()
    return dict(found)


def veiled(mode: str, alpha: float, table: dict[str, Any]) -> dict[str, Any]:
    """A material of which a share alpha is there."""
    metal = table["pbrMetallicRoughness"]
    color = [*metal["baseColorFactor"][:3], alpha]
    return {**table, "alphaMode": mode, "pbrMetallicRoughness": {**metal, "baseColorFactor": color}}


F0 = 0.04
ABSORPTION = [math.log(2) / 2, 0.0, math.log(1e6) / 2]
HALF_GLASS = {"KHR_materials_transmission": {"transmissionFactor": 0.5}}


@pytest.mark.parametrize(
    ("table", "expected"),
    [
        (metal_rough([0.8, 0.1, 0.05], 0, 0.4), {
            "color": [0.8, 0.1, 0.05], "diffuse": 0.96, "fresnel": "schlick", "reflection": 1.0,
            "highlight_color": [F0] * 3, "reflection_color": [F0] * 3, "roughness": 0.4, **lobe(0.4),
        }),
        (metal_rough([0.5, 0.5, 0.5], 0, 0.5), {
            "color": [0.5] * 3, "diffuse": 0.96, "fresnel": "schlick",
            "highlight_color": [F0] * 3, **lobe(0.5),
        }),
        (metal_rough([1, 0.75, 0.25], 1, 0), {
            "color": [1, 0.75, 0.25], "diffuse": 0.0, "fresnel": "schlick", "reflection": 1.0,
            "highlight_color": [1, 0.75, 0.25], "reflection_color": [1, 0.75, 0.25], **lobe(0),
        }),
        (metal_rough([0.5, 0.5, 0.5], 0.5, 1), {
            "color": [0.5] * 3, "diffuse": 0.48, "fresnel": "schlick", "reflection": 1.0, "roughness": 1.0,
            "highlight_color": [0.27] * 3, "reflection_color": [0.27] * 3, "specular": 0.25, "shininess": 1.0,
        }),
        (GLASS, {
            "color": [1.0] * 3, "diffuse": 0.0, "fresnel": True, "ior": 1.4, "reflection": 1.0,
            "transmission": 1.0, "transmission_color": [1.0] * 3, "specular": 1.0,
            "shininess": lobe(0)["shininess"], "absorption": ABSORPTION,
        }),
        (metal_rough([1, 0, 0], 0.5, 0, extensions=HALF_GLASS), {
            "color": [1, 0, 0], "diffuse": 0.36, "fresnel": True, "reflection": 0.25, "transmission": 0.25,
            "transmission_color": [1, 0, 0], "thin": True,
            "specular": 0.25, "shininess": lobe(0)["shininess"],
        }),
        (metal_rough([1, 1, 1], 0, 0, extensions={
            "KHR_materials_transmission": {"transmissionFactor": 1}, "KHR_materials_ior": {"ior": 1.0},
            "KHR_materials_volume": {"thicknessFactor": 0.1},
         }), {
            "color": [1.0] * 3, "diffuse": 0.0, "fresnel": True, "ior": 1.0, "reflection": 1.0,
            "transmission": 1.0, "transmission_color": [1.0] * 3, "shininess": lobe(0)["shininess"],
        }),
        ({**PLASTIC, "alphaMode": "BLEND"}, {
            "color": [0.8, 0.1, 0.05], "diffuse": 0.3 * 0.96, "transmission": 0.7, "thin": True,
            "fresnel": "schlick", "highlight_color": [F0] * 3,
            "specular": 0.3 * lobe(0.4)["specular"], "shininess": lobe(0.4)["shininess"],
        }),
        ({**PLASTIC, "alphaMode": "MASK"}, {
            "color": [0.8, 0.1, 0.05], "diffuse": 0.0, "transmission": 1.0, "thin": True,
            "fresnel": "schlick", "highlight_color": [F0] * 3, "shininess": lobe(0.4)["shininess"],
        }),
        ({**PLASTIC, "alphaMode": "MASK", "alphaCutoff": 0.3}, {
            "color": [0.8, 0.1, 0.05], "diffuse": 0.96, "fresnel": "schlick", "reflection": 1.0,
            "highlight_color": [F0] * 3, "reflection_color": [F0] * 3, "roughness": 0.4, **lobe(0.4),
        }),
        (metal_rough([0.25, 0.5, 1], 0, 1, extensions={"KHR_materials_unlit": {}}), {
            "color": 0.0, "diffuse": 0.0, "emission": [0.25, 0.5, 1.0],
        }),
        (veiled("BLEND", 0.25, metal_rough([0.25, 0.5, 1], 0, 1, extensions={"KHR_materials_unlit": {}})), {
            "color": 0.0, "diffuse": 0.0, "emission": [0.0625, 0.125, 0.25], "transmission": 0.75,
            "thin": True,
        }),
        (veiled("MASK", 0.25, metal_rough([0, 0, 0], 0, 1, emissiveFactor=[1, 1, 1])), {
            "color": [0.0] * 3, "diffuse": 0.0, "transmission": 1.0, "thin": True, "fresnel": "schlick",
            "highlight_color": [F0] * 3, "shininess": 1.0,
        }),
        (veiled("BLEND", 0.5, metal_rough([1, 1, 1], 1, 0, emissiveFactor=[1, 1, 1])), {
            "color": [1.0] * 3, "diffuse": 0.0, "transmission": 0.5, "thin": True, "fresnel": "schlick",
            "reflection": 0.5, "reflection_color": [1.0] * 3, "highlight_color": [1.0] * 3,
            "specular": 0.5 * lobe(0)["specular"], "shininess": lobe(0)["shininess"], "emission": [0.5] * 3,
        }),
        (metal_rough([0, 0, 0], 0, 1, emissiveFactor=[1, 0.5, 0], extensions={
            "KHR_materials_emissive_strength": {"emissiveStrength": 3},
            "KHR_materials_specular": {"specularFactor": 0.5, "specularColorFactor": [1, 0.5, 100]},
         }), {
            "color": [0.0] * 3, "diffuse": 0.5, "fresnel": "schlick", "specular": 0.125, "shininess": 1.0,
            "highlight_color": [0.04, 0.02, 1.0], "emission": [3.0, 1.5, 0.0],
        }),
        (metal_rough([1, 0.5, 0], 0.5, 0.2, extensions={"KHR_materials_specular": {"specularFactor": 0.5}}), {
            "color": [1.0, 0.5, 0.0], "diffuse": 0.5 * 0.98, "fresnel": "schlick", "reflection": 0.75,
            "roughness": 0.2, "reflection_color": [0.51 / 0.75, 0.26 / 0.75, 0.01 / 0.75],
            "highlight_color": [0.51 / 0.75, 0.26 / 0.75, 0.01 / 0.75],
            "specular": 0.75 * lobe(0.2)["specular"], "shininess": lobe(0.2)["shininess"],
        }),
    ],
)  # fmt: skip
def test_what_a_material_becomes(tmp_path: Path, table: dict[str, Any], expected: dict[str, Any]) -> None:
    found = material(tmp_path, table)
    kept = clrt.load_dict({"materials": {"m": expected}}).to_dict()["materials"]["m"]  # without defaults
    assert found.keys() == kept.keys()
    for name, value in kept.items():
        right = value if isinstance(value, (str, bool)) else pytest.approx(value, rel=1e-12)
        assert found[name] == right, name


NOTHING = {"KHR_materials_specular": {"specularFactor": 0}}


@pytest.mark.parametrize("extensions", [NOTHING, {"KHR_materials_ior": {"ior": 1}}])
@pytest.mark.parametrize("rough", [0.0, 0.2, 0.5, 1.0])
def test_what_reflects_nothing_is_black_at_grazing_angles(
    tmp_path: Path, extensions: dict[str, Any], rough: float
) -> None:
    """Schlick's curve went to 1 there: a black floor had highlights of 9 and a mirror."""
    found = material(tmp_path, metal_rough([0, 0, 0], 0, rough, extensions=extensions))
    floor = {"type": "plane", "point": [0, 0, 0], "normal": [0, 1, 0], "material": found}
    scene = clrt.load_dict({
        "camera": {"origin": [0, 0.2, 3], "target": [0, 0, 0], "width": 24, "height": 16},
        "lights": [{"type": "directional", "direction": [0, -0.1, 1], "intensity": 1}],
        "background": 1.0, "shapes": [floor], "max_depth": 2,
    })  # fmt: skip
    image = clrt.render(scene, layers=["shape"])
    assert not image.pixels[image.layers["shape"] >= 0].any() and (image.layers["shape"] >= 0).any()


def test_no_such_material_is_said_to_make_light(tmp_path: Path, recwarn: pytest.WarningsRecorder) -> None:
    """Of the light that falls on it head-on a surface returns no more, whatever its numbers."""
    tables = [metal_rough([1, 1, 1], m / 4, r / 8) for m in range(5) for r in range(9)]
    tables += [metal_rough([1, 1, 1], m, 0.3, extensions=HALF_GLASS) for m in (0, 0.5)]
    tables += [PLASTIC | {"alphaMode": mode, "alphaCutoff": 0.5} for mode in ("BLEND", "MASK")]
    clrt.load(write_glb(tmp_path / "a.glb", model(tables)))
    assert [str(warning.message) for warning in recwarn if "make" in str(warning.message)] == []


@pytest.mark.parametrize("far", [None, 0, 1e30])
def test_glass_without_an_attenuation(tmp_path: Path, far: float | None) -> None:
    """three.js writes null for infinity, the distance of glass that states none."""
    more = {"KHR_materials_transmission": {"transmissionFactor": 1}}
    volume = {"thicknessFactor": 1, "attenuationColor": [0.5, 1, 1], "attenuationDistance": far}
    both = {**more, "KHR_materials_volume": volume}
    found = material(tmp_path, metal_rough([1, 1, 1], 0, 0, extensions=both))
    assert max(found.get("absorption", [0.0])) < 1e-20 and found["transmission"] == 1


def test_what_glows_by_a_picture_that_is_not_there_is_dark(tmp_path: Path) -> None:
    table = model([{"emissiveFactor": [1, 1, 1], "emissiveTexture": {"index": 0}}])
    table |= {"textures": [{"source": 0}], "images": [{"uri": "gone.png"}]}
    with pytest.warns(clrt.ClrtWarning, match="the light of what glows by a picture that is left out"):
        scene = clrt.load(write_glb(tmp_path / "a.glb", table))
    assert [m.emission for m in scene.materials.values()] == [0]


def test_the_factor_of_glass_is_named(tmp_path: Path) -> None:
    more = {"KHR_materials_transmission": {"transmissionFactor": 1}, **NOTHING}
    with pytest.warns(clrt.ClrtWarning, match="the specularFactor of glass"):
        material(tmp_path, metal_rough([1, 1, 1], 0, 0, extensions=more))
