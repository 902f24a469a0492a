"""Scenes whose picture nobody wants: one warning each, and none for what ships or is meant."""

from __future__ import annotations

import re
import warnings
from typing import Any

import pytest

import clrt
from clrt.base.resources import shipped_scenes
from clrt.flatten.flatten import flatten

CAMERA = {"origin": [0, 1, 5], "target": [0, 0, 0], "width": 4, "height": 3}
LIGHT = {"type": "point", "position": [3, 5, 4]}
BALL = {"type": "sphere", "center": [0, 0, 0], "radius": 1}
FLOOR = {"type": "plane", "point": [0, -1, 0], "normal": [0, 1, 0]}
GLASS = {"diffuse": 0, "transmission": 1}
MIRROR = {"diffuse": 0, "reflection": 1}
CORNERS = [[x, y, z] for x in (-9, 9) for y in (-9, 9) for z in (-9, 9)]
SIDES = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]


def warned(table: dict[str, Any]) -> list[str]:
    """The warnings of loading and compiling a scene."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        flatten(clrt.load_dict({"camera": CAMERA, "lights": [LIGHT], "shapes": [BALL], **table}))
    return [str(warning.message) for warning in caught]


def around(**more: Any) -> dict[str, Any]:
    return {"type": "box", "min": [-9, -9, -9], "max": [9, 9, 9], **more}


SILENT: list[tuple[dict[str, Any], str]] = [
    ({"lights": []}, r"shapes\[0\]: there is no light: .*Add \[\[lights\]\] or ambient"),
    ({"lights": [{**LIGHT, "intensity": 0}], "background": 0.5}, "there is no light"),
    ({"background": [135, 206, 235]}, r"background: \(135.* is 235 times the light of white; .* 0 to 255\?"),
    ({"ambient": 255}, "ambient: 255.* 0 to 255"),
    ({"lights": [{**LIGHT, "intensity": [255, 240, 220]}]}, r"lights\[0\].intensity: .* 0 to 255"),
    ({"shapes": [{**BALL, "material": {"emission": [200, 0, 0]}}]}, "material.emission: .* 0 to 255"),
    ({"materials": {"red": {"color": [200, 30, 30]}}}, "red.color: a reflectance of 200; .* 0 to 255"),
    ({"shapes": [{**BALL, "material": {"color": [200, 30, 30]}}]},
     r"shapes\[0\].material.color: .* 0 to 255"),
    ({"materials": {"squares": {"color": {"type": "checker", "colors": [0.5, 99]}}}},
     "colors.1.: .* 0 to 255"),
    ({"shapes": [{**BALL, "material": {"color": 1.5}}]},
     "a reflectance of 1.5; above 1 a surface makes light$"),
    ({"camera": {**CAMERA, "origin": [0, -2, 5]}, "shapes": [BALL, FLOOR]},
     r"shapes\[1\]: it hides all lights and other shapes: the camera is on the other side"),
    ({"camera": {**CAMERA, "origin": [0, -2, 5]}, "shapes": [{**FLOOR, "normal": [0, -1, 0]}, BALL],
      "lights": [{"type": "directional", "direction": [0, -1, 0]}]}, r"shapes\[0\]: it hides all"),
    ({"camera": {**CAMERA, "origin": [0, 0, 0.5]}, "shapes": [BALL]},
     r"shapes\[0\]: .* the camera is inside"),
    ({"lights": [{**LIGHT, "position": [0, 50, 0]}], "shapes": [around(), {**BALL, "center": [0, 20, 0]}]},
     "the camera is inside"),
    ({"lights": [{"type": "directional", "direction": [0, -1, 0]}],
      "shapes": [{"type": "mesh", "vertices": CORNERS, "faces": SIDES}]}, "the camera is inside"),
]  # fmt: skip


@pytest.mark.parametrize(("table", "words"), SILENT)
def test_a_silent_scene_is_warned_of_once(table: dict[str, Any], words: str) -> None:
    found = warned(table)
    assert len(found) == 1, found
    assert re.search(words, found[0]), found


MEANT: list[dict[str, Any]] = [
    {},
    {"camera": None, "lights": []},
    {"lights": [], "ambient": 0.2},
    {"lights": [], "background": 1, "shapes": [{**BALL, "material": MIRROR}]},
    {"lights": [], "shapes": [{**BALL, "material": {"emission": 0.5}}]},
    {"lights": [{**LIGHT, "intensity": [84, 71, 54], "falloff": "inverse-square"}]},
    {"background": 40.5},
    {"lights": [{**LIGHT, "intensity": 3}]},
    {"shapes": [BALL, FLOOR]},
    {"shapes": [BALL, {**FLOOR, "normal": [0, -1, 0]}]},
    {"camera": {**CAMERA, "origin": [0, -2, 5]}, "shapes": [BALL, {**FLOOR, "material": GLASS}]},
    {"camera": {**CAMERA, "origin": [0, -2, 5]}, "shapes": [BALL, FLOOR], "one_sided": "opaque"},
    {"camera": {**CAMERA, "origin": [0, -2, 5]}, "shapes": [BALL, FLOOR, {**BALL, "center": [0, -5, 0]}]},
    {"shapes": [around(), BALL]},
    {"shapes": [around()]},
    {"lights": [{**LIGHT, "position": [0, 50, 0]}], "shapes": [around(), BALL]},
    {"lights": [{**LIGHT, "position": [0, 50, 0]}], "shapes": [around(material=GLASS)]},
    {"lights": [{"type": "directional", "direction": [0, -1, 0]}],
     "shapes": [{"type": "mesh", "vertices": CORNERS, "faces": SIDES[1:]}]},  # a room without a wall
    {"camera": {**CAMERA, "origin": [0, 0, 0.5], "near": 2}, "shapes": [BALL]},
]  # fmt: skip


@pytest.mark.parametrize("table", MEANT)
def test_a_scene_that_may_be_meant_is_not_warned_of(table: dict[str, Any]) -> None:
    assert warned(table) == []


@pytest.mark.parametrize("name", shipped_scenes())
def test_no_scene_that_ships_is_warned_of(name: str) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        flatten(clrt.load(name))
