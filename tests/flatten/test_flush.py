"""Surfaces that lie on one another where light passes: what comes of them, and that it is told."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import clrt
from clrt.base.resources import shipped_scenes
from clrt.flatten.flatten import flatten
from clrt.flatten.flush import warn_of_flush
from clrt.formats.shipped import load_scene
from tests.growth import LEAST, seconds

Table = dict[str, Any]
GLASS: Table = {"fresnel": True, "diffuse": 0, "ior": 1.5}
SHEET: Table = {"thin": True, "transmission": 0.5}
FLOOR = [[-3, 0, -3], [3, 0, -3], [3, 0, 3], [-3, 0, 3]]
TURNED = {"transform": [{"rotate": ["x", 30.0]}, {"translate": [5, 6, 7]}]}


def box(low: float = 0.0, material: Table | str = GLASS, x: float = 0.0, **more: Any) -> Table:
    return {"type": "box", "min": [x, low, 0], "max": [x + 1, 2, 1], "material": material, **more}


def rod(low: float, high: float, radius: float = 1.0, material: Table = GLASS, caps: bool = True) -> Table:
    return {"type": "cylinder", "p0": [0, low, 0], "p1": [0, high, 0], "radius": radius, "caps": caps,
            "material": material}  # fmt: skip


def ball(radius: float = 1.0, **more: Any) -> Table:
    return {"type": "sphere", "center": [0, 1, 0], "radius": radius, "material": {**GLASS, **more}}


PLANE: Table = {"type": "plane", "point": [0, 0, 0], "normal": [0, 1, 0]}
POLYGON: Table = {"type": "polygon", "points": FLOOR}
NOTCH = [[2, 0, -2], [2, 0, 0], [0, 0, 0], [0, 0, 2], [-2, 0, 2], [-2, 0, -2]]
NOTCHED: Table = {"type": "polygon", "points": NOTCH}
MESH: Table = {"type": "mesh", "vertices": FLOOR, "faces": [[0, 1, 2], [0, 2, 3]]}
AIR: Table = {**GLASS, "ior": "air", "priority": 1}
TOLD = {
    "a hollow that ends where the glass does": [rod(-1, 1), rod(-0.8, 1, 0.85, AIR)],
    "on a plane": [box(), PLANE], "on a polygon": [box(), POLYGON], "on a mesh": [rod(0, 1), MESH],
    "on a disk": [rod(0, 1, 0.5), {"type": "disk", "center": [0, 0, 0], "normal": [0, 1, 0], "radius": 3}],
    "two of one glass": [box(), box(x=0.5)], "side by side": [box(), box(x=1, material={"color": 0.5})],
    "a small one on it": [
        {"type": "box", "min": [-9, -1, -9], "max": [9, 0, 9], "material": GLASS},
        {"type": "box", "min": [0, 0, 0], "max": [0.1, 0.1, 0.1]},
    ],
    "the same ball": [ball(), ball(ior=1.3, priority=1)],
    "a sheet around it": [rod(-0.3, 1), rod(-0.4, 2, 1.0, SHEET, caps=False)],
    "turned": [box(**TURNED), {**POLYGON, **TURNED}],
    "about a quadric": [
        {"type": "quadric", "coefficients": [1, 0, 1, 0, 0, 0, 0, 0, 0, -1],
         "clip": [[-2, -2, -2], [2, 2, 2]], "material": GLASS}, rod(-1, 3, 1.0, SHEET, caps=False),
    ],
    "a part of a cap": [rod(0, 1), {"type": "box", "min": [0.6, 1, 0.3], "max": [2, 2, 2]}],
    "a part of a rod's length": [rod(-1, 1), rod(0.9, 2, material={"color": 0.5})],
    "beside the notch of a floor": [box(x=-0.9), NOTCHED],
    "a mesh of glass": [{"type": "mesh", "material": GLASS, "vertices": [
        [0, 0, 0], [1, 0, 0], [1, 0, 1], [0, 0, 1], [0, 1, 0], [1, 1, 0], [1, 1, 1], [0, 1, 1]], "faces": [
        [0, 1, 2, 3], [4, 7, 6, 5], [0, 4, 5, 1], [1, 5, 6, 2], [2, 6, 7, 3], [3, 7, 4, 0]]}, PLANE],
}  # fmt: skip
UNTOLD = {
    "in the notch of a floor": [box(), NOTCHED],
    "edge on edge": [box(), {"type": "box", "min": [1, 2, 0], "max": [2, 3, 1]}],
    "corner on corner": [box(), {"type": "box", "min": [1, 2, 1], "max": [2, 3, 2]}],
    "one as far into the other": [box(), box(x=1 - 1e-4, material={"color": 0.5})],
    "a hollow that ends before": [rod(-1, 1), rod(-0.8, 0.9995, 0.85, AIR)],
    "above": [box(1e-4), PLANE], "into": [box(-1e-4), PLANE], "pierced": [rod(-1, 1, 0.5), PLANE],
    "touches": [ball(), PLANE],
    "away": [rod(0, 1, 0.5), {"type": "disk", "center": [5, 0, 0], "normal": [0, 1, 0], "radius": 3}],
    "an open end": [rod(-0.3, 1, 0.9), rod(-0.3, 2, 1.0, SHEET, caps=False)],
    "nothing passes": [box(material={"color": 0.5}), box(x=1, material={"color": 0.2}), PLANE],
}


def told(scene: clrt.Scene) -> list[str]:
    with warnings.catch_warnings(record=True) as found:
        warnings.simplefilter("always")
        flatten(scene)
    return [str(one.message) for one in found if "with a piece of its surface" in str(one.message)]


@pytest.mark.parametrize("name", TOLD)
def test_what_lies_on_another_is_told(name: str) -> None:
    (said,) = told(clrt.load_dict({"shapes": TOLD[name]}))
    first, second = sorted([said.partition(":")[0], said.partition("surface on ")[2].partition(":")[0]])
    assert (first, second) == ("shapes[0]", "shapes[1]")
    assert told(clrt.load_dict({"shapes": TOLD[name][::-1]}))


@pytest.mark.parametrize("name", UNTOLD)
def test_what_is_apart_is_not(name: str) -> None:
    assert told(clrt.load_dict({"shapes": UNTOLD[name]})) == []
    assert told(clrt.load_dict({"shapes": UNTOLD[name][::-1]})) == []


SQUARES = np.array([[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]])
FACES = {"mesh": SQUARES, "triangles": SQUARES[:, [[0, 1, 2], [0, 2, 3]]].reshape(-1, 3)}


def block(kind: str, low: np.ndarray, high: np.ndarray, **more: Any) -> Table:
    """A box, as such or as a mesh."""
    if kind == "box":
        return {"type": "box", "min": low.tolist(), "max": high.tolist(), **more}
    ends = np.array([low, high])
    corners = [[ends[i, 0], ends[j, 1], ends[k, 2]] for i in (0, 1) for j in (0, 1) for k in (0, 1)]
    return {"type": "mesh", "vertices": corners, "faces": FACES[kind], **more}


@pytest.mark.parametrize("turned", [False, True])
def test_all_blocks_that_share_a_part_of_a_face_are_told_and_none_that_share_an_edge(turned: bool) -> None:
    """A twentieth of the smaller face is enough; faces of half a square are looked at as it is."""
    draw = np.random.default_rng(11)
    counts = {True: 0, False: 0}
    while min(counts.values()) < 60:
        size, place = draw.uniform(0.1, 3, (2, 3)), draw.uniform(-1, 1, (2, 3))
        low, high = place - size / 2, place + size / 2
        if touch := counts[False] < 60:  # side by side, and perhaps behind one another, too
            axes = draw.permutation(2)[: draw.integers(1, 3)]
            low[1, axes] = high[0, axes]
            high[1, axes] = low[1, axes] + size[1, axes]
        low[1, 2] = high[0, 2]  # the second stands on the first
        high[1, 2] = low[1, 2] + size[1, 2]
        shared = np.minimum(*high)[:2] - np.maximum(*low)[:2]
        share = np.prod(np.maximum(shared, 0)) / np.prod(size[:, :2], axis=1).min()
        if not touch and share < 0.05:
            continue
        turn = [{"rotate": [axis, draw.uniform(0, 360)]} for axis in "xyz"]
        move = {"transform": [*turn, {"translate": draw.uniform(-9, 9, 3).tolist()}]} if turned else {}
        shapes = [
            block(str(kind), *ends, material=GLASS, **move)
            for kind, ends in zip(draw.choice(["box", *FACES], 2), np.stack([low, high], axis=1), strict=True)
        ]
        assert len(told(clrt.load_dict({"shapes": shapes}))) == (not touch), (shapes, share)
        counts[not touch] += 1


@pytest.mark.parametrize("name", ["update", "sweep"])
def test_it_is_told_when_a_material_lets_light_pass(name: str) -> None:
    """Though the shapes are what they were; once, until more of them do."""
    camera = {"origin": [0, 6, 0], "target": [0, 0, 0], "width": 1, "height": 1}
    materials = {"b": {"diffuse": 0.5}, "c": {"diffuse": 0.5}}
    shapes = [PLANE, box(material="b"), box(x=5, material="c")]
    scene = clrt.load_dict({"camera": camera, "materials": materials, "shapes": shapes})
    values = [0.0, 0.5, 0.6]
    with warnings.catch_warnings(record=True) as found:
        warnings.simplefilter("always")
        if name == "sweep":
            assert len([*clrt.sweep(scene, {"materials.b.transmission": values})]) == len(values)
        else:
            with clrt.Tracer(scene) as tracer:
                for value in values:
                    tracer.update(scene.replace({"materials.b.transmission": value}))
    (said,) = [str(one.message) for one in found if "with a piece of its surface" in str(one.message)]
    assert "shapes[1]: lies" in said and "on shapes[0]:" in said


@pytest.mark.parametrize("name", shipped_scenes())
def test_no_scene_that_ships_has_such_surfaces(name: str) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", clrt.ClrtWarning)
        scene = load_scene(name)
    assert told(scene) == []


@pytest.mark.parametrize("gap", [1e-4, -1e-4])
def test_the_advice_mends_it(gap: float) -> None:
    """A red floor under glass that stands on it is not seen through it; with the gap of the advice it is."""
    camera = {"origin": [0.6, 6, 0.4], "target": [0.5, 0, 0.5], "width": 1, "height": 1}
    red = {**PLANE, "material": {"color": [1, 0, 0]}}
    base: Table = {"camera": camera, "ambient": 1.0, "background": [0, 0, 1]}
    lost, seen = (clrt.render({**base, "shapes": [box(low), red]}).pixels[0, 0] for low in (0.0, gap))
    assert lost[0] < 0.1 < 0.8 < seen[0]


def test_many_shapes_cost_little() -> None:
    """Pairs are looked at until they are many."""
    rng = np.random.default_rng(1)
    places = rng.uniform(-5, 5, (20_000, 3)).tolist()
    shapes = [{"type": "sphere", "center": place, "radius": 0.3, "material": "glass"} for place in places]
    scene = clrt.load_dict({"materials": {"glass": GLASS}, "shapes": shapes})
    assert told(scene) == []


def comb(x: float, teeth: int = 30) -> Table:
    """Many small triangles in one plane, apart from those of another `x`, though the boxes of all meet."""
    corners = np.array([[0, 0, 0], [0.2, 0, 0], [0, 0.2, 0]])
    places = [[x + i, j, 0] for i in range(teeth) for j in range(teeth)]
    vertices = (np.array(places)[:, None] + corners).reshape(-1, 3)
    return {"type": "mesh", "vertices": vertices, "faces": np.arange(len(vertices)).reshape(-1, 3)}


def spheres(n: int) -> list[Table]:
    places = np.random.default_rng(1).uniform(-5, 5, (n, 3)).tolist()
    return [{"type": "sphere", "center": [0, 0, 0], "radius": 20, "material": GLASS},
            *({"type": "sphere", "center": place, "radius": 0.01} for place in places)]  # fmt: skip


ANGLES = np.linspace(0, 2 * np.pi, 1000, endpoint=False)
CIRCLE = np.column_stack([np.cos(ANGLES), 0.5 + 0 * ANGLES, np.sin(ANGLES)]).tolist()
CROWDS: dict[str, tuple[Callable[[int], list[Table]], int]] = {
    "within one of glass": (spheres, 1000),
    "meshes in one plane": (lambda n: [{**comb(0), "material": GLASS}, *[comb(0.5)] * n], 20),
    "polygons": (lambda n: [box(), *[{**POLYGON, "points": CIRCLE}] * n], 160),
}


@pytest.mark.parametrize("name", CROWDS)
def test_the_hint_is_bounded(name: str) -> None:
    """Not in proportion to the scene: what it looks at, and what that takes, have an end."""
    make, n = CROWDS[name]

    def took(count: int) -> float:
        scene = clrt.load_dict({"shapes": make(count)})
        extents = flatten(scene).extents
        assert extents is not None
        passes = np.arange(len(scene.shapes)) == 0
        return seconds(lambda: warn_of_flush(scene, extents.low, extents.high, passes))

    assert took(4 * n) < 2 * max(took(n), LEAST)


LAMPS: dict[str, Table] = {
    "rectangle": {"type": "rectangle", "u": [0.5, 0, 0], "v": [0, 0, -0.5]},
    "disk": {"type": "disk", "normal": [0, 1, 0], "radius": 0.4},
}
CEILINGS = {
    "plane": PLANE, "polygon": POLYGON, "mesh": MESH,
    "box": {"type": "box", "min": [-3, -1, -3], "max": [3, 0, 3]},
}  # fmt: skip


@pytest.mark.parametrize("ceiling", CEILINGS)
@pytest.mark.parametrize("lamp", LAMPS)
def test_a_lamp_in_a_ceiling_is_told_and_lights_as_one_below_it(lamp: str, ceiling: str) -> None:
    """Feelers end before its plane, where rounding would put the ceiling before it as often as behind."""
    camera = {"origin": [0, 2, 6], "target": [0, 1, 0], "width": 24, "height": 18, "fov": 60}
    wall = {"type": "polygon", "points": [[-2, 0.1, -1], [2, 0.1, -1], [2, 2.5, -1], [-2, 2.5, -1]]}
    shapes = [CEILINGS[ceiling], wall]
    seen = []
    for height, visible in ((0.0, True), (0.0, False), (1e-3, False)):
        light = {**LAMPS[lamp], "center": [0, height, 0], "radiance": 60, "visible": visible, "samples": 4}
        scene = clrt.load_dict({"camera": camera, "shapes": shapes, "lights": [light]})
        with warnings.catch_warnings(record=True) as told:
            warnings.simplefilter("always")
            seen.append(clrt.render(scene).pixels)
        lies = [str(each.message) for each in told if "lies in the surface of shapes[0]" in str(each.message)]
        assert len(lies) == (height == 0 and visible) and all(one.startswith("lights[0]: ") for one in lies)
    lit = seen[2].max(axis=2) > 0.05
    assert lit.sum() > 20 and np.abs(seen[1] - seen[2])[lit].max() < 0.05 * seen[2].max()


@pytest.mark.parametrize("kind", ["point", "spot"])
def test_a_lamp_on_a_surface_lights_what_one_before_it_lights(kind: str) -> None:
    light = {"type": kind, "intensity": 1, **({"target": [0, 0, 0], "angle": 80} if kind == "spot" else {})}
    seen = []
    for height in (2.3, 2.2999):
        table = {"camera": {"origin": [0, 1, 4], "target": [0, 1, 0], "width": 48, "height": 48, "fov": 60},
                 "shapes": [{**PLANE, "point": [0, y, 0], "normal": [0, 1 - y, 0]} for y in (0, 2.3)],
                 "lights": [{**light, "position": [0, height, 0]}]}  # fmt: skip
        seen.append(clrt.render(table).pixels)
    assert np.abs(seen[0] - seen[1]).max() < 2e-3 and seen[0].max() > 0.5
