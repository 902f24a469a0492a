"""Media, asked of the float64 oracle and of the kernels alike: what can be written down, and random heaps.

Kernels are float32: a dozen factors, each good to a few roundings of 6e-8, are good to 2e-6; and distances
start off their surfaces by 5e-7 of the coordinates, here up to 9 (the oracle's by 1e-10).
"""

from __future__ import annotations

import itertools
from typing import Any

import numpy as np
import pytest

import clrt
from clrt.base.resources import validation_module
from tests.engines import ENGINES, Engine
from tests.screen import degrees_between, landed, passage, polar

WHITE: dict[str, Any] = {"background": 1.0, "max_depth": 9}
DOWN = ([0.1, 5.0, 0.2], [0.0, -1.0, 0.0])
GLOW = {"diffuse": 0.0, "emission": 1.0}
pytestmark = pytest.mark.filterwarnings("ignore:.*medium of the same priority")


@pytest.fixture(params=ENGINES)
def engine(request: pytest.FixtureRequest) -> Engine:
    return ENGINES[request.param]


def near(engine: Engine) -> float:
    return engine.tolerance(5e-6, 1e-8)


def clear(ior: Any, **more: Any) -> dict[str, Any]:
    """A material that mirrors nothing back, so that one path brings all light."""
    return {"diffuse": 0.0, "fresnel": True, "reflection": 0.0, "ior": ior, **more}


def bed(low: float, high: float, ior: Any, **more: Any) -> dict[str, Any]:
    """A layer of 6 x 6 units between two heights."""
    return {"type": "box", "min": [-3, low, -3], "max": [3, high, 3], "material": clear(ior, **more)}


def half_space(height: float, material: dict[str, Any]) -> dict[str, Any]:
    """All that lies below a height."""
    return {"type": "plane", "point": [0, height, 0], "normal": [0, 1, 0], "material": material}


def ball(radius: float, ior: Any, center: Any = (0, 0, 0), **more: Any) -> dict[str, Any]:
    return {"type": "sphere", "center": list(center), "radius": radius, "material": clear(ior, **more)}


def light(engine: Engine, shapes: list[dict[str, Any]], ray: Any = DOWN, **settings: Any) -> np.ndarray:
    scene = clrt.load_dict({"shapes": shapes, **WHITE, **settings})
    return engine.radiance(scene, *ray)[0][0]


def passed(*indices: float) -> float:
    """The share of light that passes boundaries between these indices at normal incidence."""
    share = 1.0
    for a, b in itertools.pairwise(indices):
        share *= 1 - ((a - b) / (a + b)) ** 2
    return share


def test_7_sphere_with_fresnel_and_absorption(engine: Engine) -> None:
    seen = light(engine, [ball(1, 1.5, absorption=0.3)], ([0, 0.5, -3], [0, 0, 1]))
    assert seen == pytest.approx([0.521782696] * 3, abs=engine.tolerance(1e-6))


def test_16_air_to_glass_to_water(engine: Engine) -> None:
    glass = {"diffuse": 0.0, "transmission": 1.0, "ior": "glass"}
    water = {**glass, "ior": "water", "priority": 1}
    overlapping = [
        {**bed(-1, 0, 1.5), "material": glass},
        half_space(-0.5, water),
    ]
    entry = -0.5 * np.tan(np.radians(19.47122063))
    place, leaving = [-entry, -0.5, 0], polar(22.03010873)
    _, out = passage(engine, overlapping, (-2 * polar(30), polar(30)), place, leaving, max_depth=3)
    expected = 22.03010873
    assert degrees_between(out, [0, -1, 0]) == pytest.approx(expected, abs=np.degrees(2 * landed(engine)))


@pytest.mark.parametrize("beyond", [-1, 1])
def test_16_critical_angle_from_glass_to_water(engine: Engine, beyond: int) -> None:
    """With a list of media as with `medium_ior`: the ray starts in the glass, above the water in it."""
    glass = {"type": "sphere", "center": [0, 0, 0], "radius": 50, "material": clear("glass")}
    water = half_space(0, clear("water", priority=1))
    u = polar(62.70617608 + beyond * engine.tolerance(1e-4, 1e-6))
    scene = clrt.load_dict({"shapes": [glass, water], "max_depth": 1, "background": 1.0})
    _, rays = engine.radiance(scene, -2 * u, u)
    assert rays["total_internal_reflection"] == (beyond > 0)


@pytest.mark.parametrize("order", [1, -1])
@pytest.mark.parametrize(("glass", "water", "change"), [(1, 0, 1.0), (0, 1, 0.5), (0, 0, 0.5)])
def test_where_media_overlap_the_higher_priority_is_there(
    engine: Engine, glass: int, water: int, change: float, order: int
) -> None:
    """The ray comes to the glass first; of equals the one entered last counts."""
    shapes = [
        bed(-1, 0, 1.5, absorption=0.3, priority=glass),
        bed(-2, -0.5, 1.333, absorption=[0.7, 0.1, 0], priority=water),
    ]
    expected = passed(1, 1.5, 1.333, 1) * np.exp(-0.3 * change - np.array([0.7, 0.1, 0]) * (2 - change))
    assert light(engine, shapes[::order]) == pytest.approx(expected, abs=near(engine))


def test_a_bubble_in_glass_in_water(engine: Engine) -> None:
    """Each in the other, all of one priority; the ray starts in the water, which is everywhere."""
    water = half_space(9, clear(1.333, absorption=0.01))
    shapes = [ball(1, 1.0), ball(3, 1.5, absorption=0.2), water]
    ray = [0, 5, 0], [0, -1, 0]
    floor = half_space(-4, GLOW)
    expected = passed(1.333, 1.5, 1, 1.5, 1.333) * np.exp(-0.01 * 3 - 0.2 * 4)
    assert light(engine, [*shapes, floor], ray)[0] == pytest.approx(expected, abs=near(engine))


def test_water_in_a_hollow_glass(engine: Engine) -> None:
    """A glass is a block of glass, a hollow of air that outranks it, and water that reaches into its wall."""
    shapes = [
        bed(-3, 0, 1.5, absorption=0.1),
        bed(-2.5, 1, 1.0, priority=1),
        bed(-2.6, -1, 1.333, absorption=0.4, priority=2),
    ]
    # through air down to -1, water to -2.6, glass to -3
    expected = passed(1, 1.333, 1.5, 1) * np.exp(-0.4 * 1.6 - 0.1 * 0.4)
    assert light(engine, shapes)[0] == pytest.approx(expected, abs=near(engine))


def test_bodies_of_one_medium_are_one_body(engine: Engine) -> None:
    """Also where they cross each other: no boundary between them, no generation, no count."""
    ray = [0.2, 0.3, -9], [0, 0, 1]
    alone, heap = [ball(2, 1.5)], [ball(2, 1.5), ball(1, 1.5), ball(0.5, 1.5, center=(0.3, 0.2, 0.5))]
    scenes = [clrt.load_dict({"shapes": shapes, **WHITE}) for shapes in (alone, heap)]
    (one, one_rays), (many, many_rays) = (engine.radiance(scene, *ray) for scene in scenes)
    assert np.array_equal(one, many) and one_rays == many_rays
    assert many_rays["hits"] == 2


@pytest.mark.filterwarnings("ignore:.*a surface makes light")
def test_what_is_not_seen_is_not_shaded_and_casts_no_feeler(engine: Engine) -> None:
    """Bright, matt ice in stronger glass: the ray meets the glass twice, and the lamp is never asked for."""
    ice = {"color": 1.0, "transmission": 0.5, "ior": "ice", "emission": 1.0}
    hidden = {"type": "sphere", "center": [0, 0, 0], "radius": 1, "material": ice}
    glass = ball(2, 1.5, priority=1)
    lamp = {"type": "directional", "direction": [0, 0, 1]}
    scene = clrt.load_dict({"shapes": [hidden, glass], "lights": [lamp], **WHITE})
    seen, rays = engine.radiance(scene, [0, 0, -5], [0, 0, 1])
    assert seen[0] == pytest.approx([passed(1, 1.5, 1)] * 3, abs=near(engine))
    assert rays["hits"] == 2 and rays["feelers"] == 0 and rays["transmission"] == 2


def test_layers_see_through_what_is_not_seen(engine: Engine) -> None:
    """Depth and shape are of the first boundary that is."""
    inner = ball(1, 1.5)
    camera = {"origin": [0, 0, -5], "target": [0, 0, 0], "fov": 1, "width": 1, "height": 1}
    around = {**ball(1.5, 1.5, priority=1, absorption=0.1), "name": "around"}
    scene = clrt.load_dict({"shapes": [inner, around, ball(6, 1.0, priority=-1)], "camera": camera})
    assert engine.layer(scene, "shape")[0, 0] == 1
    assert engine.layer(scene, "depth")[0, 0] == pytest.approx(3.5, abs=engine.tolerance(1e-6))


def test_the_camera_in_glass(engine: Engine) -> None:
    """Its first segment is absorbed, and Fresnel sees the light leave."""
    camera = {"origin": [0, 0, 0], "target": [0, 0, 1], "fov": 60, "width": 3, "height": 3}
    scene = clrt.load_dict({"shapes": [ball(2, 1.5, absorption=0.25)], "camera": camera, **WHITE})
    expected = passed(1.5, 1) * np.exp(-0.25 * 2)
    assert engine.layer(scene, "transmission") == pytest.approx(expected, abs=near(engine))


@pytest.mark.parametrize("start", [0.5, 3.5])
def test_the_camera_starts_where_its_near_plane_is(engine: Engine, start: float) -> None:
    view = {"type": "orthographic", "size": 0.2, "near": start, "width": 2, "height": 2}
    camera = {"origin": [0, 0, -4], "target": [0, 0, 1], **view}
    scene = clrt.load_dict({"shapes": [ball(1, 1.0, absorption=1.0)], "camera": camera, **WHITE})
    half = np.sqrt(1 - 0.05**2 - 0.05**2)
    way = 2 * half if start < 1 else half + 0.5
    assert engine.layer(scene, "transmission") == pytest.approx(np.exp(-way), abs=near(engine))


def test_a_ray_that_ends_nowhere_in_a_medium_brings_nothing(engine: Engine) -> None:
    sea = {"type": "plane", "point": [0, 0, 0], "normal": [0, 1, 0],
           "material": clear(1.0, absorption=[0, 1e-6, 3])}  # fmt: skip
    assert light(engine, [sea]).tolist() == [1, 0, 0]
    assert light(engine, [sea], ([0, -1, 0], [0, -1, 0])).tolist() == [1, 0, 0]


def test_a_medium_that_is_left_without_having_been_entered(engine: Engine) -> None:
    """A lone pane, met from behind: the ray was in it all the way."""
    pane = {"type": "polygon", "points": [[-9, 0, -9], [9, 0, -9], [9, 0, 9], [-9, 0, 9]],
            "material": clear(1.5, absorption=0.1)}  # fmt: skip
    with pytest.warns(clrt.ClrtWarning, match="encloses nothing"):
        seen = light(engine, [pane])
    assert seen[0] == pytest.approx(passed(1.5, 1) * np.exp(-0.5), abs=near(engine))


def test_a_pane_and_a_coat_under_water_reflect_as_water_sees_them(engine: Engine) -> None:
    """Their indices count against that of the medium around them, not `medium_ior`."""
    water, sheet = half_space(9, clear(1.333)), clear(1.5, thin=True)
    pane = {"type": "disk", "center": [0, 0, 0], "normal": [0, 1, 0], "radius": 5, "material": sheet}
    once = 1 - passed(1.333, 1.5)
    floor = half_space(-4, GLOW)
    seen = light(engine, [water, pane, floor])[0]
    assert seen == pytest.approx(1 - 2 * once / (1 + once), abs=near(engine))
    coat = {"diffuse": 0.0, "fresnel": True, "transmission": 0.0, "ior": 1.5}
    lamp = {"type": "disk", "center": [0, 8, 0], "normal": [0, 1, 0], "radius": 1, "material": GLOW}
    assert light(engine, [water, half_space(-4, coat), lamp])[0] == pytest.approx(once, abs=near(engine))


def test_feelers_know_no_media(engine: Engine) -> None:
    """Tinted ones take `kt Tt` of every surface, seen or not, and no absorption."""
    floor = half_space(-4, {})
    tint = {"transmission": 0.9, "transmission_color": [1, 0.5, 0.8], "absorption": 2.0}
    shapes = [floor, bed(-2, 0, 1.5, **tint), bed(-1.5, -1, 1.5, **tint, priority=-1)]
    lamp = {"type": "directional", "direction": [0, -1, 0], "intensity": 1.0}
    ray = [0, -3, 0], [0, -1, 0]
    seen = light(engine, shapes, ray, lights=[lamp], shadow="tinted")
    assert seen == pytest.approx(0.8 * (0.9 * np.array([1, 0.5, 0.8])) ** 4, abs=near(engine))


def test_ambient_rays_are_absorbed_where_they_start(engine: Engine) -> None:
    """A white speck in the middle of a grey ball of air: the sky through one radius of it."""
    speck = {"type": "sphere", "center": [0, 0, 0], "radius": 1e-3, "material": {"color": 1.0, "diffuse": 0.0,
                                                                                 "ambient": 1.0}}  # fmt: skip
    fog = ball(2, 1.0, absorption=0.5)
    seen = light(engine, [speck, fog], ([0, 0, -1], [0, 0, 1]), ambient=0.25, ambient_samples=16)
    # ambient rays pass the fog's boundary and bring what transmission brings there: the background
    expected = np.exp(-0.5 * 0.999) * np.exp(-0.5 * 1.999)
    assert seen[0] == pytest.approx(expected, rel=1e-3)


def heap(seed: int) -> list[dict[str, Any]]:
    """Shapes of all kinds through one another, each of a priority of its own."""
    rng = np.random.default_rng(seed)

    def made(index: int, **keys: Any) -> dict[str, Any]:
        material = {"diffuse": 0.2, "fresnel": index % 2 == 0, "reflection": 0.4, "transmission": 0.8,
                    "ior": float(rng.uniform(1, 1.7)), "priority": index - 3,
                    "absorption": rng.uniform(0, 0.5, 3).tolist(), "color": rng.random(3).tolist(),
                    }  # fmt: skip
        steps = [{"rotate": [rng.normal(size=3).tolist(), float(rng.uniform(0, 360))]},
                 {"scale": rng.uniform(0.6, 1.4, 3).tolist()} if index < 3 else {"scale": 1.2},
                 {"translate": rng.normal(size=3).tolist()}]  # fmt: skip
        return {**keys, "material": material, "transform": steps}

    corners = [[0, 0, 0], [2, 0, 0], [0, 2, 0], [0, 0, 2]]
    return [
        made(0, type="sphere", center=[0, 0, 0], radius=1.0),
        made(1, type="box", min=[-1, -1, -1], max=[1, 1, 1]),
        made(2, type="mesh", vertices=corners, faces=[[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]),
        made(3, type="cylinder", p0=[0, -1, 0], p1=[0, 1, 0], radius=0.7, caps=True),
        made(4, type="cone", p0=[0, -1, 0], r0=1.0, p1=[0, 1, 0], r1=0.2, caps=True),
        made(5, type="ellipsoid", center=[0, 0, 0], radii=[1, 0.5, 0.8]),
    ]


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.filterwarnings("ignore:.*a surface makes light")
def test_heaps_of_media_are_as_the_oracle_has_them(seed: int) -> None:
    """Rays start anywhere, inside too: the same counts but for rays at edges, the same light."""
    rng = np.random.default_rng(100 + seed)
    lit = {"ambient": 0.3, "lights": [{"type": "directional", "direction": [1, -2, 0.5]}]}
    scene = clrt.load_dict({"shapes": heap(seed), "background": [0.5, 0.7, 0.9], "max_depth": 4, **lit})
    o, d = rng.normal(size=(2, 400, 3)) * [[[1.5]], [[1.0]]]
    ours, our_rays = ENGINES["kernels"].radiance(scene, o, d)
    theirs, their_rays = ENGINES["oracle64"].radiance(scene, o, d)
    off = np.abs(ours - theirs).max(axis=1)
    assert np.median(off) < 1e-6 and (off > 1e-3).mean() <= 0.01
    for kind in ("hits", "transmission", "reflection"):
        assert our_rays[kind] == pytest.approx(their_rays[kind], rel=0.01)


@pytest.mark.parametrize("x", [0.0, 30.0])
def test_joints_of_solids_of_one_glass_are_no_edges(x: float) -> None:
    """Rays that enter one solid just behind another of the same material were taken to have crossed an edge:
    the joints of a rounded rod were dark and dashed, 43 and 170 pixels of these pictures."""
    glass = {"transmission": 1.0, "diffuse": 0.0, "ior": 1.5, "fresnel": True, "absorption": 0.5}
    ends = [[x - 1, 0, 0], [x + 1, 0.2, 0.1]]
    rod = {"type": "cylinder", "p0": ends[0], "p1": ends[1], "radius": 0.5, "caps": True, "material": glass}
    balls = [{"type": "sphere", "center": end, "radius": 0.5, "material": glass} for end in ends]
    camera = {"origin": [x + 0.3, 0.2, 8], "target": [x, 0.1, 0], "fov": 28, "width": 160, "height": 120}
    scene = clrt.load_dict({
        "background": [0.5, 0.6, 0.7], "ambient": 1, "max_depth": 6, "camera": camera,
        "shapes": [rod, *balls],
    })  # fmt: skip
    right = validation_module("oracle64").render64(scene).pixels
    wrong = np.abs(clrt.render(scene).pixels - right).max(axis=-1) > 0.01
    assert np.count_nonzero(wrong) <= 12  # the surfaces touch there
