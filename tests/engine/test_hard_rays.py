"""Rays that hurt: not finite, grazing, along axes, in planes, from on and between surfaces, at all scales."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import clrt
from validation.scenes.parts import CLOSED
from validation.twin.picture import trace32

CHECKED = clrt.Settings(check=True)  # the film makes a NaN a bright pixel, so that what is seen hides it
BAD = np.array([np.nan, np.inf, -np.inf, 0.0, -0.0, 1e-45, 1e38, -3e38], np.float32)
AXES = [axis for k in range(3) for sign in (1, -1) for axis in [np.eye(3)[k] * sign]]
SCALES = (1e-6, 1.0, 1e6)
SHAPES: dict[str, list[dict[str, Any]]] = {
    "sphere": [{"type": "sphere", "center": [0, 0, 0], "radius": 1}],
    "box": [{"type": "box", "min": [-1, -1, -1], "max": [1, 1, 1]}],
    "cylinder": [{"type": "cylinder", "p0": [0, -1, 0], "p1": [0, 1, 0], "radius": 1, "caps": True}],
    "cone": [{"type": "cone", "p0": [0, -1, 0], "r0": 1, "p1": [0, 1, 0], "r1": 0, "caps": True}],
    "ellipsoid": [{"type": "ellipsoid", "center": [0, 0, 0], "radii": [1, 0.5, 1]}],
    "paraboloid": [{"type": "paraboloid", "apex": [0, -1, 0], "axis": [0, 1, 0], "focal": 0.25, "height": 1}],
    "hyperboloid": [{"type": "quadric", "coefficients": [1, -1, 1, 0, 0, 0, 0, 0, 0, -0.25],
                     "clip": [[-1, -1, -1], [1, 1, 1]]}],
    "plane": [{"type": "plane", "point": [0, 0, 0], "normal": [0, 1, 0]}],
    "square": [{"type": "polygon", "points": [[-1, 0, -1], [-1, 0, 1], [1, 0, 1], [1, 0, -1]]}],
    "disk": [{"type": "disk", "center": [0, 0, 0], "normal": [0, 1, 0], "radius": 1}],
    "tetrahedron": [{"type": "mesh", "vertices": [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]],
                     "faces": [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]}],
    "coincident": [{"type": "sphere", "center": [0, 0, 0], "radius": 1}] * 3,
    "interpenetrating": [{"type": "sphere", "center": [0, 0, 0], "radius": 1},
                         {"type": "sphere", "center": [0.5, 0, 0], "radius": 1},
                         {"type": "box", "min": [-1, -0.5, -1], "max": [1, 0.5, 1]}],
    "touching": [{"type": "sphere", "center": [-1, 0, 0], "radius": 1},
                 {"type": "sphere", "center": [1, 0, 0], "radius": 1},
                 {"type": "plane", "point": [0, -1, 0], "normal": [0, 1, 0]}],
}  # fmt: skip


def scaled(shapes: list[dict[str, Any]], scale: float) -> list[dict[str, Any]]:
    """The shapes, larger; lengths and places but no directions and coefficients."""
    if scale == 1.0:
        return shapes
    out = []
    for shape in shapes:
        if shape["type"] == "plane":
            out.append(shape)
        else:
            out.append({**shape, "transform": [{"scale": scale}]})
    return out


def hard_rays(scale: float) -> tuple[np.ndarray, np.ndarray]:
    """Origins on, in and beside the shapes; directions along axes, nearly so, and to edges and corners."""
    places = [0.0, 0.5, 1.0, -1.0, np.nextafter(np.float32(1), np.float32(2)), 3.0]
    origins = np.array([[x, y, z] for x in places for y in (0.0, 1.0, -1.0, 2.5) for z in (0.0, 1.0, -2.0)])
    slight = [axis + small * other for axis in AXES for other in AXES[::2] for small in (1e-7, -1e-20)]
    corners = [[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]
    edges = [[1, 1, 0], [0, 1, 1], [1, 0, -1], [1, -1, 0]]
    directions = np.array([*AXES, *slight, *corners, *edges], np.float64)
    o = np.repeat(origins, len(directions), axis=0) * scale
    d = np.tile(directions, (len(origins), 1))
    return o.astype(np.float32), d.astype(np.float32)


@pytest.fixture(scope="module", params=SHAPES)
def name(request: pytest.FixtureRequest) -> str:
    return str(request.param)


def tracer(shapes: list[dict[str, Any]], **more: Any) -> clrt.Tracer:
    table = {"lights": [{"type": "point", "position": [0, 1, 0]}], "ambient": 0.1, "background": 0.2, **more}
    return clrt.Tracer(clrt.load_dict({**table, "shapes": shapes}), settings=CHECKED)


def test_rays_that_are_none_miss_and_bring_nothing_that_is_not_finite(name: str) -> None:
    """Every coordinate of origin and direction in turn is not finite, zero, tiny or huge."""
    rays = [(np.array([0.2, 0.3, 4]), np.array([0, 0, -1.0]))]
    for value in BAD:
        for k in range(3):
            for part in range(2):
                ray = [part.copy() for part in rays[0]]
                ray[part][k] = value
                rays.append((ray[0], ray[1]))
        rays.append((np.zeros(3), np.full(3, value)))
        rays.append((np.full(3, value), np.ones(3)))
    o, d = (np.array(part, np.float32) for part in zip(*rays, strict=True))
    made = tracer(SHAPES[name])
    hits = made.intersect(o, d)
    unusable = ~(np.isfinite(o).all(axis=1) & np.isfinite(d).all(axis=1) & d.any(axis=1))
    assert (hits.primitive[unusable] == -1).all() and np.isinf(hits.t[unusable]).all()
    assert np.isfinite(hits.normal).all() and not np.isnan(hits.t).any() and (hits.t > 0).all()
    assert np.array_equal(made.occluded(o, d), hits.primitive >= 0)
    assert np.isfinite(made.radiance(o, d)[0]).all()
    for limit in (np.nan, 0.0, -1.0):
        assert not made.occluded(o, d, t_max=limit).any()


@pytest.mark.parametrize("scale", SCALES)
def test_hard_rays_find_what_brute_force_finds(name: str, scale: float) -> None:
    made = tracer(scaled(SHAPES[name], scale))
    o, d = hard_rays(scale)
    hits = made.intersect(o, d)
    found = trace32(made.flat, o, d)
    assert np.array_equal(hits.primitive, found.primitive) and np.array_equal(hits.t, found.t)
    assert np.isfinite(hits.normal).all() and (hits.t > 0).all()
    assert np.isfinite(made.radiance(o, d)[0]).all()


def test_of_coincident_shapes_the_first_is_met() -> None:
    o, d = hard_rays(1.0)
    primitive = tracer(SHAPES["coincident"]).intersect(o, d).primitive
    assert set(np.unique(primitive)) == {-1, 0}


# --- optics: in a white furnace whatever passes no light on or makes some shows -----------------------------

GLASSES: dict[str, dict[str, Any]] = {
    "fresnel": {"diffuse": 0, "fresnel": True},
    "constant": {"diffuse": 0, "reflection": 0.3, "transmission": 0.7},
    "transmitting": {"diffuse": 0, "transmission": 1},
    "mirror": {"diffuse": 0, "reflection": 1},
    "thin": {"diffuse": 0, "fresnel": True, "thin": True},
}
INDICES = (1.0, np.nextafter(np.float32(1), np.float32(2)), 1.5, 2.419, 0.75, 1e-3, 1e3)


def furnace(shapes: list[dict[str, Any]], **more: Any) -> clrt.Tracer:
    """White surroundings, and white what rays of the last generation would have brought."""
    return tracer(shapes, background=1.0, depth_color=1.0, ambient=0, lights=[], max_depth=4, **more)


@pytest.mark.parametrize("glass", GLASSES)
@pytest.mark.parametrize("ior", INDICES)
def test_no_corner_of_optics_loses_or_makes_light(glass: str, ior: float) -> None:
    material = {**GLASSES[glass], "ior": float(ior)}
    o, d = hard_rays(1.0)
    for name in ("sphere", "box", "tetrahedron", "coincident", "interpenetrating", "touching", "plane"):
        made = furnace([{**shape, "material": material} for shape in SHAPES[name]])
        seen, _ = made.radiance(o, d)
        assert np.allclose(seen, 1.0, rtol=0, atol=4e-6), (name, np.abs(seen - 1).max())


@pytest.mark.parametrize("ior", [1.5, 2.419, 1.0003])
def test_light_is_kept_within_ulps_of_the_critical_angle(ior: float) -> None:
    """From inside glass below a plane: just transmitted, or totally reflected, and nothing in between."""
    material = {"diffuse": 0, "fresnel": True, "ior": ior}
    made = furnace([{"type": "plane", "point": [0, 0, 0], "normal": [0, 1, 0], "material": material}])
    sine = np.float32(1 / ior)
    steps = [sine]
    for _ in range(40):
        steps = [np.nextafter(steps[0], np.float32(0)), *steps, np.nextafter(steps[-1], np.float32(2))]
    s = np.array(steps, np.float32)
    d = np.stack([s, np.sqrt(1 - s.astype(np.float64) ** 2).astype(np.float32), np.zeros_like(s)], axis=1)
    seen, counts = made.radiance(np.tile(np.float32([0, -1, 0]), (len(s), 1)), d)
    assert np.allclose(seen, 1.0, rtol=0, atol=4e-6)
    rays = counts["rays"]
    assert rays["total_internal_reflection"] > 20 and rays["transmission"] > 20
    # at the very angle nothing is reflected totally, but Fr is 1 all the same
    assert 0 <= len(s) - rays["transmission"] - rays["total_internal_reflection"] <= 1


@pytest.mark.parametrize("glass", ["fresnel", "constant", "transmitting"])
def test_a_camera_in_nested_and_touching_glass(glass: str) -> None:
    """Spheres about one another, with a gap, at the same place, and an ulp apart."""
    inner = [0.5, 0.9, 1.0, np.nextafter(np.float32(1), np.float32(0))]
    o = np.zeros((500, 3), np.float32)
    d = np.random.default_rng(3).normal(size=(500, 3))
    for radius in inner:
        outer, water = {**GLASSES[glass], "ior": 1.5}, {**GLASSES[glass], "ior": 1.333, "priority": 1}
        ball = {"type": "sphere", "center": [0, 0, 0]}
        shapes = [{**ball, "radius": r, "material": m} for r, m in ((1, outer), (float(radius), water))]
        seen, _ = furnace(shapes).radiance(o, d)
        assert np.allclose(seen, 1.0, rtol=0, atol=4e-6), (radius, np.abs(seen - 1).max())


def test_every_closed_primitive_keeps_light() -> None:
    o, d = hard_rays(1.0)
    for name, make in CLOSED.items():
        shape = {**make((0.0, 0.0, 0.0), 1.0), "material": GLASSES["fresnel"]}
        seen, _ = furnace([shape]).radiance(o, d)
        assert np.allclose(seen, 1.0, rtol=0, atol=4e-6), (name, np.abs(seen - 1).max())


def test_rays_start_no_farther_back_than_they_came() -> None:
    """A closed room with mirrors for walls on a floor so wide that rays leave it by much: what met the floor
    close to a wall started behind the wall, where the lamps are."""
    wide, mirror = 1000, {"diffuse": 0.2, "reflection": 0.8}
    walls = [
        [[-1, 0, -1], [1, 0, -1], [1, 1, -1], [-1, 1, -1]], [[-1, 1, -1], [1, 1, -1], [1, 1, 1], [-1, 1, 1]],
        [[-1, 0, -1], [-1, 1, -1], [-1, 1, 1], [-1, 0, 1]], [[1, 0, -1], [1, 0, 1], [1, 1, 1], [1, 1, -1]],
        [[-1, 0, 1], [1, 0, 1], [1, 1, 1], [-1, 1, 1]],
    ]  # fmt: skip
    floor = [[-wide, 0, wide], [wide, 0, wide], [wide, 0, -wide], [-wide, 0, -wide]]
    lamps = [[3, 1, 0], [0, 3, 0], [-2, 1, -2], [0, 0.2, -3]]
    pixels = clrt.render({
        "camera": {"origin": [0, 0.3, 0.3], "target": [0, 0.01, -1], "fov": 50, "width": 400, "height": 400},
        "ambient": 0.1, "background": [5, 0, 0], "max_depth": 3,
        "lights": [{"type": "point", "position": lamp, "intensity": 9} for lamp in lamps],
        "shapes": [{"type": "polygon", "points": floor, "material": {"color": 0.8}},
                   *({"type": "polygon", "points": wall, "material": mirror} for wall in walls)],
    }).pixels  # fmt: skip
    assert pixels.max() < 0.3
