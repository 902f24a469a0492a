"""Scenes as arrays: materials, lights, background and the scene's own values."""

from __future__ import annotations

from typing import Any

import numpy as np

from clrt import layout
from clrt.flatten.flatten import FlatScene, flatten
from clrt.images.image import write
from clrt.scene.scene import Scene

SPHERE = {"type": "sphere", "center": [1.0, 2.0, 3.0], "radius": 0.5}
PLANE = {"type": "plane", "point": [0.0, -1.0, 0.0], "normal": [0.0, 2.0, 0.0]}
SQUARE = {"type": "polygon", "points": [[0, 0, 0], [2, 0, 0], [2, 2, 0], [0, 2, 0]]}
BOX = {"type": "box", "min": [0.0, 0.0, 0.0], "max": [1.0, 2.0, 3.0]}
DISK = {"type": "disk", "center": [0.0, 1.0, 0.0], "normal": [0.0, 3.0, 4.0], "radius": 2.0}


def flat(*shapes: dict[str, Any], **scene: Any) -> FlatScene:
    return flatten(Scene(shapes=shapes, **scene))


def test_equal_materials_share_a_number() -> None:
    scene = flat(
        SPHERE | {"material": "red"},
        SPHERE | {"material": {"color": [1, 0, 0]}},
        SPHERE,
        PLANE | {"material": "also red"},
        BOX | {"material": {"color": [1, 0, 0], "diffuse": 0.25}},
        materials={
            "red": {"color": [1, 0, 0]},
            "also red": {"color": [1.0, 0.0, 0.0]},
            "unused": {"color": 0.1},
        },
    )
    assert scene.primitives["material"].tolist() == [0, 0, 1, 0, *[2] * 6]
    assert scene.materials["color"].tolist() == [[1, 0, 0], [np.float32(0.8)] * 3, [1, 0, 0]]


def test_materials_carry_their_resolved_numbers() -> None:
    glass = {
        "fresnel": True, "diffuse": 0.0, "ambient": 0.25, "specular": 0.5, "shininess": 9.0, "ior": "diamond",
        "thin": True, "highlight_color": 0.5, "emission": [1, 2, 3],
        "reflection_color": [0.1, 0.2, 0.3], "transmission_color": [0.4, 0.5, 0.6],
    }  # fmt: skip
    record = flat(SPHERE | {"material": glass}).materials[0]
    single = np.float32
    assert [record[k] for k in ("ka", "kd", "ks", "kr", "kt")] == [0.25, 0.0, 0.5, 1.0, 1.0]
    assert record["shininess"] == 9.0 and record["ior"] == single(2.419)
    assert record["fresnel"] == layout.FRESNEL["FRESNEL"] and record["thin"] == 1
    assert record["highlight"].tolist() == [0.5] * 3
    assert record["mirror"].tolist() == np.array([0.1, 0.2, 0.3], single).tolist()
    assert record["tint"].tolist() == np.array([0.4, 0.5, 0.6], single).tolist()
    assert record["emission"].tolist() == [1, 2, 3]
    schlick = flat(SPHERE | {"material": {"fresnel": "schlick"}}).materials[0]
    assert schlick["fresnel"] == layout.FRESNEL["SCHLICK"] and schlick["kr"] == 0.0


def test_a_checker_knows_whether_it_lies_on_a_plane_or_a_sphere() -> None:
    checker = {"color": {"type": "checker", "colors": [[1, 0, 0], 0.25], "size": 2.0, "divisions": 6}}
    shapes = [shape | {"material": "checker"} for shape in (PLANE, SPHERE, SQUARE, DISK)]
    scene = flat(*shapes, materials={"checker": checker})
    assert scene.primitives["material"].tolist() == [0, 1, 0, 0]
    on_plane, on_sphere = layout.CHECKER["CHECKER_FLAT"], layout.CHECKER["CHECKER_SPHERE"]
    assert scene.materials["checker"].tolist() == [on_plane, on_sphere]
    assert scene.materials["checker_size"].tolist() == [2.0, 6.0]
    assert scene.materials["color"][0].tolist() == [1, 0, 0]
    assert scene.materials["color2"][0].tolist() == [0.25] * 3


def test_one_sided_marks_the_opaque_materials_only() -> None:
    glass = SPHERE | {"material": {"diffuse": 0.5, "transmission": 0.5}}
    scene = flat(SPHERE, glass, one_sided="opaque")
    assert scene.materials["one_sided"].tolist() == [1, 0] and scene.scene["one_sided"][0] == 1
    assert flat(glass, one_sided="opaque").scene["one_sided"][0] == 0
    assert flat(SPHERE).scene["one_sided"][0] == 0


def test_lights_and_the_scene_s_own_values() -> None:
    scene = flat(
        PLANE,
        lights=[
            {"type": "point", "position": [1, 2, 3], "intensity": 2.0, "falloff": "inverse-square"},
            {"type": "directional", "direction": [0, -3, -4], "intensity": [1, 2, 3]},
        ],
        background=[0.1, 0.2, 0.3], ambient=0.5, depth_color=[0, 0, 1], ambient_samples=4, medium_ior=1.25,
        min_weight=0.125, shadow="tinted", conformance="spd",
    )  # fmt: skip
    point, sun = scene.lights
    assert point["place"].tolist() == [1, 2, 3, 0] and point["intensity"].tolist() == [2, 2, 2]
    kinds, falloff = layout.LIGHT_KINDS, layout.FALLOFF
    assert (point["kind"], point["falloff"]) == (kinds["POINT"], falloff["INVERSE_SQUARE"])
    np.testing.assert_allclose(sun["place"], [0, 0.6, 0.8, 0], rtol=1e-7)
    assert (sun["kind"], sun["falloff"]) == (kinds["DIRECTIONAL"], falloff["FALLOFF_NONE"])
    assert sun["intensity"].tolist() == [1, 2, 3]
    info = scene.scene[0]
    assert info["primitives"] == 1 and info["unbounded"] == 1 and info["lights"] == 2
    assert info["ambient_samples"] == 4 and info["tinted"] == 1 and info["spd"] == 1
    assert info["medium_ior"] == 1.25 and info["min_weight"] == 0.125
    assert info["background_width"] == info["background_height"] == 0
    assert info["background"].tolist() == np.array([0.1, 0.2, 0.3], np.float32).tolist()
    assert info["ambient"].tolist() == [0.5] * 3 and info["depth_color"].tolist() == [0, 0, 1]


def test_a_background_image_is_read_row_by_row(tmp_path: Any) -> None:
    pixels = np.arange(24, dtype=np.float32).reshape(2, 4, 3)
    write(tmp_path / "sky.exr", [pixels])
    scene = flatten(Scene(background="sky.exr", folder=tmp_path))
    info = scene.scene[0]
    assert (info["background_width"], info["background_height"]) == (4, 2)
    np.testing.assert_array_equal(scene.background, pixels.reshape(-1))
