"""Media in the float64 oracle: layers whose transmittance can be written down."""

from __future__ import annotations

import itertools
from typing import Any

import numpy as np
import pytest

import clrt
from clrt.flatten.inside import count_inside
from validation.oracle64 import media_at, radiance64, render64

pytestmark = pytest.mark.filterwarnings("ignore::clrt.base.errors.ClrtWarning")
NEAR = 1e-8  # rays start 1e-10 of the layers' size, 50, off their surfaces
UP = [[0.0, 0.0, 1.0]]


def clear(ior: float, **more: Any) -> dict[str, Any]:
    """A material that mirrors nothing back, so that one path brings all light."""
    return {"diffuse": 0.0, "fresnel": True, "reflection": 0.0, "ior": ior, **more}


def layer(low: float, high: float, **material: Any) -> dict[str, Any]:
    return {"type": "box", "min": [-50, -50, low], "max": [50, 50, high], "material": clear(**material)}


def through(shapes: list[dict[str, Any]], start: float = -5.0, **settings: Any) -> float:
    """What of a white background a ray along +z sees."""
    scene = clrt.load_dict({"shapes": shapes, "background": 1.0, "max_depth": 9, **settings})
    return float(radiance64(scene, [[0.1, 0.2, start]], UP)[0][0, 0])


def passed(*indices: float) -> float:
    """Fresnel's share at normal incidence through boundaries between these indices."""
    pairs = itertools.pairwise(indices)
    return float(np.prod([1 - ((a - b) / (a + b)) ** 2 for a, b in pairs]))


GLASS, WATER = {"ior": 1.5, "absorption": 0.3}, {"ior": 1.333, "absorption": 0.7}


@pytest.mark.parametrize(
    ("glass", "water", "change"),
    [(1, 0, 1.0), (0, 1, 0.5), (0, 0, 0.5)],  # among equals the one entered last
)
def test_the_medium_on_top_is_there(glass: int, water: int, change: float) -> None:
    overlapping = [layer(0, 1, **GLASS, priority=glass), layer(0.5, 2, **WATER, priority=water)]
    expected = passed(1, 1.5, 1.333, 1) * np.exp(-0.3 * change - 0.7 * (2 - change))
    assert through(overlapping) == pytest.approx(expected, abs=NEAR)
    assert through(overlapping[::-1]) == pytest.approx(expected, abs=NEAR)


def test_what_lies_inside_a_stronger_medium_is_not_there() -> None:
    hidden = [layer(0, 3, **GLASS, priority=1), layer(1, 2, **WATER)]
    assert through(hidden) == pytest.approx(passed(1, 1.5, 1) * np.exp(-0.9), abs=NEAR)
    assert through(hidden, max_depth=2) == through(hidden)  # crossing it takes no generation


def test_ice_in_water_in_a_glass() -> None:
    nested = [layer(0, 5, **GLASS), layer(1, 4, **WATER, priority=1), layer(2, 3, ior=1.31, priority=2)]
    expected = passed(1, 1.5, 1.333, 1.31, 1.333, 1.5, 1) * np.exp(-0.3 * 2 - 0.7 * 2)
    assert through(nested) == pytest.approx(expected, abs=NEAR)


@pytest.mark.parametrize("start", [0.25, 1.5, 2.5])
def test_a_ray_starts_in_the_media_around_it(start: float) -> None:
    nested = [layer(2, 3, ior=1.31, priority=2), layer(0, 5, **GLASS), layer(1, 4, **WATER)]
    indices = [1.5, 1.333, 1.31, 1.333, 1.5, 1][int(start) :]
    lengths = np.array([1, 1, 1, 1, 1.0])[int(start) :]
    lengths[0] = 1 - start % 1
    sigma = np.array([0.3, 0.7, 0, 0.7, 0.3])[int(start) :]
    assert through(nested, start) == pytest.approx(passed(*indices) * np.exp(-sigma @ lengths), abs=NEAR)


INSIDE: list[tuple[dict[str, Any], float]] = [
    ({"type": "sphere", "center": [0, 0, 0], "radius": 1}, 1.0),
    ({"type": "ellipsoid", "center": [0, 0, 0], "radii": [1, 1, 2]}, 2.0),
    ({"type": "box", "min": [-1, -1, -1], "max": [1, 1, 1]}, 1.0),
    ({"type": "cylinder", "p0": [0, 0, -1], "p1": [0, 0, 1], "radius": 1, "caps": True}, 1.0),
    ({"type": "cone", "p0": [0, 0, -1], "r0": 1, "p1": [0, 0, 1], "r1": 0.5, "caps": True}, 1.0),
    ({"type": "plane", "point": [0, 0, 1], "normal": [0, 0, 1]}, 1.0),
    ({"type": "quadric", "coefficients": [1, 1, 1, 0, 0, 0, 0, 0, 0, -1]}, 1.0),
    ({"type": "mesh", "vertices": [[0, 0, 1], [2, 0, -1], [-1, 2, -1], [-1, -2, -1]],
      "faces": [[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]]}, 1.0),
    ({"type": "disk", "center": [0, 0, 1], "normal": [0, 0, 1], "radius": 1}, 1.0),  # taken as listed
]  # fmt: skip


@pytest.mark.parametrize(("shape", "way"), INSIDE, ids=lambda value: getattr(value, "get", str)("type"))
def test_every_shape_knows_its_inside(shape: dict[str, Any], way: float) -> None:
    filled = {**shape, "material": clear(1.0, absorption=[0.1, 0.5, 1.0])}
    scene = clrt.load_dict({"shapes": [filled], "background": 1.0})
    light, _ = radiance64(scene, [[0, 0, 0.0]], UP)
    assert light[0] == pytest.approx(np.exp(np.array([-0.1, -0.5, -1.0]) * way), abs=NEAR)


def test_nothing_comes_from_where_an_absorbing_medium_has_no_end() -> None:
    water = clear(1.0, absorption=[0, 0.1, 1])
    sea = {"type": "plane", "point": [0, 0, 1], "normal": [0, 0, 1], "material": water}
    light, _ = radiance64(clrt.load_dict({"shapes": [sea], "background": 0.7}), [[0, 0, 0]], [[0, 0, -1]])
    assert light[0].tolist() == [0.7, 0.0, 0.0]


def test_absorption_counts_against_the_least_weight() -> None:
    dark = [layer(0, 1, ior=1.0, absorption=2.0), layer(2, 3, ior=1.0, absorption=2.0)]
    assert through(dark, min_weight=0.019) == 0.0  # exp(-4) = .0183 is not followed
    assert through(dark, min_weight=0.018) == pytest.approx(np.exp(-4), abs=NEAR)


def test_invisible_boundaries_show_in_no_layer() -> None:
    camera = {"origin": [0, 0, -5], "target": [0, 0, 0], "fov": 20, "width": 5, "height": 5}
    inner, outer = layer(1, 2, **WATER), layer(0.5, 3, **GLASS, priority=1)
    found = render64(
        clrt.load_dict({"shapes": [inner, outer], "background": 1.0, "camera": {**camera, "near": 5.7}}),
        layers=["depth", "shape"],
    )
    assert (found.layers["shape"] == 1).all()  # from inside the glass, through both sides of the water
    assert found.layers["depth"][2, 2] == pytest.approx(2.3)


@pytest.mark.parametrize("missing", [0, 1, 3])
def test_an_open_mesh_holds_what_it_winds_around(missing: int) -> None:
    """As docs/model.md says: most of all directions leave through its faces; mirrored ones, too."""
    faces = [[0, 3, 2, 1], [4, 5, 6, 7], [0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7]][missing:]
    corners = [[x, y, z] for z in (-1, 1) for x, y in ((-1, -1), (1, -1), (1, 1), (-1, 1))]
    cup = {"type": "mesh", "vertices": corners, "faces": faces, "material": clear(1.5)}
    points = np.random.default_rng(missing).uniform(-1.5, 1.5, (400, 3))
    for scale in ([1, 1, 1], [-1, 1, 1]):
        scene = clrt.load_dict({"shapes": [{**cup, "transform": [{"scale": scale}]}]})
        inside = (media_at(scene, points) >= 0).any(axis=1)
        assert np.array_equal(inside, count_inside(scene.shapes[0], points) > 0)
        assert inside.any() and not inside.all()
