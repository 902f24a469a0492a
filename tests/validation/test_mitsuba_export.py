"""What a file of Mitsuba's has of a scene's surroundings: nearness, media in one another, the sky."""

from __future__ import annotations

from typing import Any
from xml.etree import ElementTree

import numpy as np
import pytest

import clrt
from clrt.base.resources import scene_folder
from validation.oracle_mitsuba.xml import to_xml

CAMERA = {"origin": [0, 1, 5], "target": [0, 0, 0], "width": 32, "height": 24}
VIEWS: dict[str, dict[str, Any]] = {
    "perspective": {}, "thin lens": {"aperture": 0.01}, "orthographic": {"type": "orthographic", "size": 4},
}  # fmt: skip
BALL = {"type": "sphere", "center": [0, 0, 0], "radius": 1.0}


def exported(**table: Any) -> tuple[ElementTree.Element, str]:
    """The file of a scene, and the comments on top of it."""
    text = to_xml(clrt.load_dict({"camera": CAMERA} | table, folder=scene_folder()))
    return ElementTree.fromstring(text), text.split("<integrator")[0]


def numbers(element: ElementTree.Element) -> dict[str, float]:
    """What the floats within an element say, by their names."""
    return {inner.get("name", ""): float(inner.get("value", "")) for inner in element.iter("float")}


@pytest.mark.parametrize("radius", [0.0, 10.0, 1000.0, 1e6])
@pytest.mark.parametrize("kind", VIEWS)
def test_large_grounds_cut_nothing_away(radius: float, kind: str) -> None:
    """The camera sees from 1e-4 of its target's distance on, whatever else is in the scene."""
    ground = [{"type": "sphere", "center": [0, -1 - radius, 0], "radius": radius}] if radius else []
    tree, notes = exported(camera=CAMERA | VIEWS[kind], shapes=[BALL, *ground])
    (sensor,) = map(numbers, tree.iter("sensor"))
    near, far = sensor["near_clip"], sensor["far_clip"]
    assert 0 < near <= 1e-4 * np.hypot(1, 5) + 1e-12 and far > 2 * radius + 6
    assert "near" not in notes, "nothing is lost by it"


def glass(ior: float, **more: Any) -> dict[str, Any]:
    return {"color": 0.0, "diffuse": 0.0, "transmission": 1.0, "fresnel": True, "ior": ior} | more


def ball(radius: float, ior: float, x: float = 0.0, **more: Any) -> dict[str, Any]:
    return {"type": "sphere", "center": [x, 0, 0], "radius": radius, "material": glass(ior, **more)}


def box(half: float, ior: float) -> dict[str, Any]:
    return {"type": "box", "min": [-half] * 3, "max": [half] * 3, "material": glass(ior)}


MESH = {"type": "mesh", "material": glass(1.5), "faces": [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]],
        "vertices": [[-4, -4, -4], [12, -4, -4], [-4, 12, -4], [-4, -4, 12]]}  # fmt: skip
POST = {"type": "cylinder", "p0": [0, -0.5, 0], "p1": [0, 0.5, 0], "radius": 0.3, "caps": True,
        "material": glass(2.0)}  # fmt: skip
PANE = {"type": "disk", "center": [0, 0, 0], "normal": [0, 1, 0], "radius": 0.5,
        "material": glass(1.5, thin=True)}  # fmt: skip
MATTE = {"type": "sphere", "center": [0, 0, 0], "radius": 3.0, "material": {"color": 0.5}}


@pytest.mark.parametrize(
    ("shapes", "medium", "pairs", "partly"),
    [
        ([ball(1, 1.33), ball(0.6, 1.0)], 1.0, {(1.33, 1.0), (1.0, 1.33)}, ""),
        ([ball(0.6, 1.0), ball(1, 1.33)], 1.0, {(1.33, 1.0), (1.0, 1.33)}, ""),
        ([ball(1, 1.5), ball(0.6, 1.4, 3.0)], 1.2, {(1.5, 1.2), (1.4, 1.2)}, ""),
        ([ball(1, 1.5), ball(0.6, 1.4, 0.8)], 1.0, {(1.5, 1.0), (1.4, 1.0)}, "shapes[0] shapes[1]"),
        ([MESH, box(1.2, 1.4), ball(1, 1.3), POST], 1.0,
         {(1.5, 1.0), (1.4, 1.5), (1.3, 1.4), (2.0, 1.3)}, ""),
        ([ball(2, 1.33), PANE], 1.0, {(1.33, 1.0), (1.5, 1.33)}, ""),
        ([ball(2, 1.5, thin=True), ball(1, 1.33)], 1.0, {(1.5, 1.0), (1.33, 1.0)}, ""),
        ([MATTE, ball(1, 1.33)], 1.0, {(1.33, 1.0)}, ""),
    ],
)  # fmt: skip
def test_glass_in_glass_has_the_index_of_what_is_around_it(
    shapes: list[Any], medium: float, pairs: set[tuple[float, float]], partly: str
) -> None:
    """A scene's rays know the media that they are in, Mitsuba's boundaries both of their own."""
    tree, notes = exported(shapes=shapes, medium_ior=medium)
    found = set()
    for element in tree.iter("bsdf"):
        values = numbers(element)
        if element.get("type") in ("dielectric", "thindielectric"):
            found.add((round(values["int_ior"], 6), round(values["ext_ior"], 6)))
    assert found == pairs
    assert all(f"{part}: partly in another" in notes for part in partly.split())
    assert ("partly" in notes) == bool(partly)


@pytest.mark.parametrize(
    ("coefficients", "clip", "named"),
    [
        ([1, 1, -1, 0, 0, 0, 0, 0, 0, 0], None, True), ([1, 1, 1, 0, 0, 0, 0, 0, 0, -1], None, False),
        ([1, 1, -1, 0, 0, 0, 0, 0, 0, 0], [[-1, -1, -1], [1, 1, 1]], False),
    ],
)  # fmt: skip
def test_surfaces_without_an_end_are_named(coefficients: list[float], clip: Any, named: bool) -> None:
    more = {} if clip is None else {"clip": clip}
    _, notes = exported(shapes=[{"type": "quadric", "coefficients": coefficients, **more}, BALL])
    assert ("shapes[0]: it has no end" in notes) == named


@pytest.mark.parametrize(
    ("ambient", "background", "said", "unsaid"),
    [
        (0.0, 0.0, "", "ambient background"), (0.1, 0.0, "ambient: left out", "background"),
        (0.0, [0.5, 0.7, 1.0], "background: Mitsuba's sky lights surfaces, too", "ambient"),
        (0.2, 0.5, "ambient: left out;background: Mitsuba's sky lights", ""),
        (0.5, 0.5, "ambient: the light of Mitsuba's sky", "background left"),
        (0.2, "sky.exr", "ambient: left out;background: Mitsuba's sky lights", ""),
    ],
)  # fmt: skip
def test_a_sky_that_lights_is_named(ambient: Any, background: Any, said: str, unsaid: str) -> None:
    _, notes = exported(ambient=ambient, background=background, shapes=[BALL])
    assert all(part in notes for part in said.split(";"))
    assert not any(word in notes for word in unsaid.split())
