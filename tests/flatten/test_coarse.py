"""Things in coordinates of maps: told, with what mends it."""

from __future__ import annotations

import re
import warnings
from typing import Any

import numpy as np
import pytest

import clrt
from clrt.flatten.flatten import flatten

CORNERS = np.array([[0, 0, 0], [4, 0, 0], [0, 3, 0], [0, 0, 2]], float)
FACES = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]
MAP = np.array([431236.5, 200.0, -5423456.25])
EYE = np.array([3.0, 4.0, 12.0])
FAR = np.array([20000.0, 0.0, 9000.0])
TURNED = [{"rotate": ["y", 30]}]
KINDS: dict[str, dict[str, Any]] = {
    "mesh": {"type": "mesh", "vertices": CORNERS, "faces": FACES},
    "sphere": {"type": "sphere", "center": [0, 0, 0], "radius": 1.5},
    "box": {"type": "box", "min": [0, 0, 0], "max": [2, 3, 1]},
    "cylinder": {"type": "cylinder", "p0": [0, 0, 0], "p1": [1, 2, 1], "radius": 0.5},
    "cone": {"type": "cone", "p0": [0, 0, 0], "p1": [1, 2, 1], "r0": 1, "r1": 0},
    "disk": {"type": "disk", "center": [0, 0, 0], "normal": [0, 1, 1], "radius": 2},
    "polygon": {"type": "polygon", "points": [[0, 0, 0], [4, 0, 0], [0, 3, 0]]},
    "ellipsoid": {"type": "ellipsoid", "center": [0, 0, 0], "radii": [1, 2, 3]},
}


def scene(offset: Any, size: float = 1.0, **more: Any) -> clrt.Scene:
    mesh = {"type": "mesh", "vertices": CORNERS * size + offset, "faces": FACES, **more}
    ball = {"type": "sphere", "center": [0, 0, 0], "radius": 1}
    return clrt.load_dict({"ambient": 1.0, "shapes": [ball, mesh]})


def of_maps(kind: str, offset: Any, before: list[Any], moved: Any = (0, 0, 0)) -> clrt.Scene:
    """A thing, a light and the camera at an offset, all moved besides."""
    place = np.asarray(offset, float) + moved
    shape = KINDS[kind] | {"transform": [*before, {"translate": place.tolist()}]}
    camera = {"origin": (place + EYE).tolist(), "target": place.tolist(), "width": 40, "height": 30}
    light = {"type": "point", "position": (place + 9.0).tolist(), "intensity": 200}
    return clrt.load_dict({"camera": camera, "lights": [light], "shapes": [shape], "max_depth": 0})


def said(made: clrt.Scene) -> list[str]:
    with warnings.catch_warnings(record=True) as found:
        warnings.simplefilter("always")
        flatten(made)
    return [str(one.message) for one in found]


@pytest.mark.parametrize("before", [[], TURNED])
@pytest.mark.parametrize("kind", KINDS)
def test_what_rounding_deforms_is_told_with_its_mend(kind: str, before: list[Any]) -> None:
    """What it says is done, and the picture is that of the same thing at the origin."""
    (text,) = said(of_maps(kind, MAP, before))
    assert re.search(r"shapes\[0\]: it(s corners are| is) rounded to 0\.5( of its [34]\S*| units)*, so", text)
    found = re.search(r"move all of the scene, its camera and lights too, by \[(.*)\]$", text)
    assert found
    moved = of_maps(kind, MAP, before, [float(part) for part in found[1].split(",")])
    assert not said(moved)
    there, here = clrt.render(moved).pixels, clrt.render(of_maps(kind, [0, 0, 0], before)).pixels
    assert (np.abs(there - here).max(axis=2) > 0.02).mean() < 0.01 and here.max() > 0.1


@pytest.mark.parametrize(("offset", "size"), [(0.0, 1.0), (0.0, 1e-6), (100.0, 1.0), (MAP, 1e4), (0.0, 1e9)])
def test_others_are_not(offset: Any, size: float) -> None:
    assert not said(scene(offset, size))


@pytest.mark.parametrize(("size", "told"), [(500.0, True), (700.0, False)])
def test_as_many_steps_as_are_not_seen(size: float, told: bool) -> None:
    """2,000 units are 4,000 steps of 0.5 there, 2,800 are 5,600."""
    assert ["rounded to 0.5" in text for text in said(scene(MAP, size))] == [True] * told


@pytest.mark.parametrize(("height", "told"), [(10.0, True), (500.0, True), (1000.0, False), (2600.0, False)])
@pytest.mark.parametrize("kind", ["mesh", "box"])
def test_a_camera_that_is_near_to_what_it_sees_out_there(kind: str, height: float, told: bool) -> None:
    """A terrain is large enough for its own corners, and the camera stands on it."""
    ground = CORNERS * 3000 + MAP
    camera = {"origin": (ground[1] + [0, height, 0]).tolist(), "target": ground[1].tolist()}
    land = {"type": "mesh", "vertices": ground, "faces": FACES}
    if kind == "box":
        land = {"type": "box", "min": (MAP - 9000).tolist(), "max": (MAP + FAR).tolist()}
    texts = said(clrt.load_dict({"camera": camera, "ambient": 1.0, "shapes": [land]}))
    assert ["camera.origin: it is rounded to 0.5, so far out" in text for text in texts] == [True] * told


@pytest.mark.parametrize(("away", "told"), [(1000.0, False), (50.0, False), (0.05, True)])
def test_small_things_in_a_large_scene_are_not_told_of_where_nothing_is_seen(away: float, told: bool) -> None:
    """A pebble on a plain: its 0.02 units are 300 steps, of which two are less than a pixel from afar."""
    pebble = {"type": "sphere", "center": [1000, 0, 0], "radius": 0.01}
    camera = {"origin": [1000, 0, away], "target": [1000, 0, 0], "width": 640}
    made = clrt.load_dict({"camera": camera, "ambient": 1.0, "shapes": [pebble, KINDS["box"]]})
    assert ["shapes[0]: it is rounded" in text for text in said(made)] == [True] * told


def test_a_camera_that_is_far_from_all_is_not_told_of() -> None:
    """It may look at a point a unit ahead, and stand within what is around all."""
    sky = {"type": "sphere", "center": [0, 0, 0], "radius": 5e6}
    for origin, target in (([0, 0, 2e6], [0, 0, 0]), ([0, 0, 2e6], [0, 0, 2e6 - 1]), ([0, 1, 5], [0, 1, 4])):
        camera = {"origin": origin, "target": target, "fov": 0.001}
        for shapes in ([KINDS["sphere"]], [KINDS["sphere"], sky] if origin[2] == 5 else []):
            assert not said(clrt.load_dict({"camera": camera, "ambient": 1.0, "shapes": shapes}))
