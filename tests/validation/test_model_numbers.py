"""The table of numbers in MODEL.md, asked of the float64 oracle and of the kernels alike.

Where light goes is measured, not computed: see `tests/screen.py`.

Tolerances: the oracle must agree to the digits that the table prints. The kernels' are stated where they are
used: float32's unit roundoff 6e-8, times the roundings on the way, times the condition of the quantity.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import clrt
from tests.engines import ENGINES, Engine, unit
from tests.screen import degrees_between, landed, passage, polar

GLASS = {"diffuse": 0.0, "transmission": 1.0, "ior": 1.5}  # constant coefficients: all light is transmitted
WHITE = {"background": 1.0}


@pytest.fixture(params=ENGINES)
def engine(request: pytest.FixtureRequest) -> Engine:
    return ENGINES[request.param]


def scene(*shapes: dict[str, Any], **settings: Any) -> clrt.Scene:
    return clrt.load_dict({"shapes": list(shapes), **settings})


def half_space(normal: Any, **material: Any) -> dict[str, Any]:
    """The plane through the origin."""
    return {"type": "plane", "point": [0, 0, 0], "normal": list(normal), "material": {**GLASS, **material}}


def test_1_refraction_into_glass(engine: Engine) -> None:
    u = np.array([3, -4, 0]) / 5
    t = [0.4, -0.916515139, 0]
    point, direction = passage(engine, [half_space([0, 1, 0])], (-5 * u, u), [0, 0, 0], t)
    assert direction == pytest.approx(t, abs=landed(engine))
    assert point / np.linalg.norm(point) == pytest.approx(t, abs=2 * landed(engine))
    assert direction[1] ** 2 == pytest.approx(0.84, abs=2 * landed(engine))  # k is the squared cosine


def test_2_refraction_out_of_glass_and_reflection(engine: Engine) -> None:
    u = np.array([3, -4, 0]) / 5
    t, r = [0.9, -0.435889894, 0], [0.6, 0.8, 0]
    _, out = passage(engine, [half_space([0, -1, 0])], (-0.5 * u, u), [0, 0, 0], t)
    assert out == pytest.approx(t, abs=landed(engine))
    assert out[1] ** 2 == pytest.approx(0.19, abs=2 * landed(engine))
    mirror = half_space([0, 1, 0], reflection=1.0, transmission=0.0)
    _, back = passage(engine, [mirror], (-0.5 * u, u), [0, 0, 0], r)
    assert back == pytest.approx(r, abs=landed(engine))


def reflectance(engine: Engine, degrees: float, normal: Any, **settings: Any) -> float:
    """Fr of a boundary, as the share of a white background that it mirrors and does not let through."""
    both = []
    for kr, kt in ((1.0, 0.0), (0.0, 1.0)):
        boundary = half_space(normal, fresnel=True, reflection=kr, transmission=kt)
        light, _ = engine.radiance(scene(boundary, **WHITE, **settings), -2 * polar(degrees), polar(degrees))
        both.append(light[0, 0])
    assert both[0] + both[1] == pytest.approx(1, abs=3e-7)  # no light is lost: 1 - Fr and Fr round apart
    return float(both[0])


@pytest.mark.parametrize(
    ("degrees", "expected"),
    [(0, 0.04), (30, 0.0415226260), (45, 0.0502399110), (60, 0.0891867128), (85, 0.612799645)],
)
def test_3_fresnel_into_glass(engine: Engine, degrees: float, expected: float) -> None:
    # dFr/dcos is at most 6 (at 85 degrees), the cosine is good to two roundings
    assert reflectance(engine, degrees, [0, 1, 0]) == pytest.approx(expected, abs=engine.tolerance(1e-6))


@pytest.mark.parametrize(
    ("degrees", "expected"),
    [(40, 0.245291204), (41, 0.379751266), (np.degrees(np.arctan(1 / 1.5)), 0.0739644970)],
)
def test_4_fresnel_out_of_glass(engine: Engine, degrees: float, expected: float) -> None:
    # near the critical angle cos_t = sqrt(k) is small and magnifies the rounding of k tenfold
    assert reflectance(engine, degrees, [0, -1, 0]) == pytest.approx(expected, abs=engine.tolerance(5e-6))


BALL = {"type": "sphere", "center": [0, 0, 0], "radius": 1.0, "material": GLASS}


def test_6_sphere(engine: Engine) -> None:
    origin, z = [0, 0.5, -3], [0, 0, 1]
    leaving = [0, -0.359305634, 0.933219943]
    point, direction = passage(engine, [BALL], (origin, z), [0, 0.155442165, 0.987844995], leaving)
    # an error of the entry's normal comes out about three times as large
    assert direction == pytest.approx(leaving, abs=2 * landed(engine))
    precision = np.degrees(2 * landed(engine)) + 5e-9
    assert degrees_between(direction, z) == pytest.approx(21.05755873, abs=precision)
    # the ray leaves the sphere where the measured line does
    b = np.dot(point, direction)
    exit_point = point + (-b + np.sqrt(b * b - np.dot(point, point) + 1)) * direction
    assert exit_point == pytest.approx([0, 0.155442165, 0.987844995], abs=4 * landed(engine))
    entry = np.array(origin) + engine.intersect(scene(BALL), origin, z).t[0] * np.array(z)
    assert np.linalg.norm(exit_point - entry) == pytest.approx(1.885618083, abs=4 * landed(engine))


def test_7_sphere_with_fresnel(engine: Engine) -> None:
    ball = {**BALL, "material": {"diffuse": 0.0, "fresnel": True, "reflection": 0.0}}
    light, _ = engine.radiance(scene(ball, **WHITE), [0, 0.5, -3], [0, 0, 1])
    assert light[0] == pytest.approx([0.918678877] * 3, abs=engine.tolerance(1e-6))  # two Fresnel factors


def test_8_slab(engine: Engine) -> None:
    slab = {"type": "box", "min": [-5, -1, -5], "max": [5, 0, 5], "material": GLASS}
    u = polar(45)
    point, direction = passage(engine, [slab], (-u, u), [0.53, -1, 0], u)
    assert direction == pytest.approx(u, abs=landed(engine))
    shift = np.linalg.norm(point - np.dot(point, u) * u)  # distance from the straight line through the origin
    assert shift == pytest.approx(0.329142308, abs=2 * landed(engine))


def prism(angle: float = 60.0) -> dict[str, Any]:
    """A glass prism whose edge (0, 0, z) points up."""
    half = np.radians(angle / 2)
    x, y = 2 * np.sin(half), -2 * np.cos(half)
    vertices = [[px, py, z] for z in (-5, 5) for px, py in ((0, 0), (-x, y), (x, y))]
    faces = [[0, 2, 1], [3, 4, 5], [0, 1, 4, 3], [1, 2, 5, 4], [2, 0, 3, 5]]
    return {"type": "mesh", "vertices": vertices, "faces": faces, "material": GLASS}


def test_9_minimum_deviation_of_a_prism(engine: Engine) -> None:
    middle, half_width = np.array([0, -np.sqrt(0.75), 0]), np.array([0.5, 0, 0])

    def deviation(turn: float) -> float:
        """Of a ray that comes in `turn` degrees steeper than half the least deviation."""
        half = np.radians(37.18075578 / 2 + turn)
        u = np.array([np.cos(half), np.sin(half), 0])
        entry = middle - half_width  # half-way up the left face
        leaving = polar(90 - 37.18075578 / 2)
        _, direction = passage(engine, [prism()], (entry - u, u), middle + half_width, leaving)
        return degrees_between(u, direction)

    least = deviation(0.0)
    assert least == pytest.approx(37.18075578, abs=np.degrees(3 * landed(engine)) + 5e-9)
    # both sides deviate more, by curvature: a ray that were not at the minimum would show a slope
    steeper, flatter = deviation(1.0) - least, deviation(-1.0) - least
    assert steeper > 1e-3 and flatter > 1e-3
    assert steeper == pytest.approx(flatter, rel=0.15)


RAINBOW = {"angle": 42.07810736, "b": np.sqrt((4 - 1.333**2) / 3)}  # Descartes' ray at its impact parameter


@pytest.mark.filterwarnings("ignore:.*a surface makes light")
def test_11_rainbow(engine: Engine) -> None:
    drop = {**BALL, "material": {**GLASS, "ior": "water", "reflection": 1.0}}
    angle = np.radians(RAINBOW["angle"])
    leaving = [0, -np.sin(angle), -np.cos(angle)]

    def rainbow(b: float) -> float:
        # in generation 3 only the ray that was mirrored once inside goes down and back
        near = [0, -RAINBOW["b"], -0.5]
        _, out = passage(engine, [drop], ([0, b, -9], [0, 0, 1]), near, leaving, max_depth=3)
        return degrees_between(out, [0, 0, -1])

    at = rainbow(RAINBOW["b"])
    # three passages through the curved surface, each magnifying the error of the one before
    assert at == pytest.approx(RAINBOW["angle"], abs=np.degrees(8 * landed(engine)) + 5e-9)
    assert rainbow(RAINBOW["b"] - 0.02) < at - 1e-3 and rainbow(RAINBOW["b"] + 0.02) < at - 1e-3


def test_11_brightness_of_the_rainbow(engine: Engine) -> None:
    drop = {**BALL, "material": {"diffuse": 0.0, "ior": "water", "fresnel": True}}
    shining = {"diffuse": 0.0, "emission": 1.0}
    lamp = {"type": "disk", "center": [0, -6, -6], "normal": [0, 1, 1], "radius": 3, "material": shining}
    light, _ = engine.radiance(scene(drop, lamp, max_depth=3), [0, RAINBOW["b"], -3], [0, 0, 1])
    # the table prints 8 digits; the three Fresnel factors are good to 4e-6
    assert light[0] == pytest.approx([0.05092182] * 3, abs=engine.tolerance(2e-7, 5e-9))


def quadric(coefficients: list[float]) -> clrt.Scene:
    return scene({"type": "quadric", "coefficients": coefficients})


def both_hits(
    engine: Engine, found: clrt.Scene, origin: Any, direction: Any
) -> tuple[np.ndarray, np.ndarray]:
    """Distances and normals of the first two hits of a ray; the second is asked for from between them."""
    origin, u = np.asarray(origin, float), unit(direction)
    first = engine.intersect(found, origin, u)
    beyond = first.t[0] + 0.01
    second = engine.intersect(found, origin + beyond * u, u)
    return np.array([first.t[0], second.t[0] + beyond]), np.concatenate([first.normal, second.normal])


def test_12_general_quadric(engine: Engine) -> None:
    coefficients = [1, 2, 3, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, -7]
    t, normal = both_hits(engine, quadric(coefficients), [0.3, -0.2, -5], [0.1, 0.2, 1])
    # coordinates up to 5 are good to 3e-7 each
    assert t == pytest.approx([3.4507064402, 5.8051354205], abs=engine.tolerance(3e-6))
    expected = [0.1406860007, 0.2802985105, -0.9495473628]
    assert normal[0] == pytest.approx(expected, abs=engine.tolerance(3e-6))


def test_13_paraboloid(engine: Engine) -> None:
    form = [1, 0, 1, 0, 0, 0, 0, -0.5, 0, 0]
    shape = {"type": "paraboloid", "apex": [0, 0, 0], "axis": [0, 1, 0], "focal": 0.25, "height": 5}
    for found in (quadric(form), scene(shape)):
        hits = engine.intersect(found, [0.5, 5, 0.25], [0, -1, 0])
        assert hits.t == pytest.approx([4.6875], abs=engine.tolerance(1e-6))
        # the table's normal faces the ray, which comes from inside
        assert -hits.normal[0] == pytest.approx(np.array([-2, 2, -1]) / 3, abs=engine.tolerance(1e-6))


@pytest.mark.parametrize(("falloff", "expected"), [("none", 0.4112744370), ("inverse-square", 0.0618767455)])
def test_14_shading(engine: Engine, falloff: str, expected: float) -> None:
    material = {"color": 0.5, "diffuse": 0.7, "specular": 0.3, "shininess": 10}
    light = {"type": "point", "position": [2, 1, -4], "intensity": 1.2, "falloff": falloff}
    ball = scene({**BALL, "material": material}, lights=[light], ambient=0.1)
    seen, _ = engine.radiance(ball, [0, 0, -3], [0, 0, 1])
    # the tenth power magnifies the cosine's rounding; the offset of the feeler is 1e-6 of a unit
    assert seen[0] == pytest.approx([expected] * 3, abs=engine.tolerance(3e-6))


def test_15_camera(engine: Engine) -> None:
    camera = {"origin": [1, 2, 3], "target": [4, 0, -1], "fov": 50, "width": 640, "height": 360}
    sky = {"type": "sphere", "center": [1, 2, 3], "radius": 64.0}
    position = engine.layer(scene(sky, camera=camera), "position")
    direction = unit(position[50, 100] - [1, 2, 3])
    assert direction == pytest.approx([0.321777233, -0.183906196, -0.928783034], abs=engine.tolerance(4e-7))


def bent(engine: Engine, degrees: float, inner: Any, medium: Any, inside: bool) -> float:
    """The angle to the normal after the boundary between a material and the medium around it."""
    boundary = half_space([0, -1, 0] if inside else [0, 1, 0], ior=inner)
    u = polar(degrees)
    _, out = passage(engine, [boundary], (-2 * u, u), [0, 0, 0], polar(degrees * 1.2), medium_ior=medium)
    return degrees_between(out, [0, -1, 0])


def test_16_air_glass_water(engine: Engine) -> None:
    abs_ = np.degrees(landed(engine)) + 5e-9
    assert bent(engine, 30, "glass", 1.0, inside=False) == pytest.approx(19.47122063, abs=abs_)
    assert bent(engine, 19.47122063, "glass", 1.333, inside=True) == pytest.approx(22.03010873, abs=2 * abs_)
    fr = reflectance(engine, 19.47122063, [0, -1, 0], medium_ior=1.333)
    assert fr == pytest.approx(0.0035454923, abs=engine.tolerance(1e-7))


def totally_reflects(engine: Engine, degrees: float, ior: Any, medium: float) -> bool:
    """Whether a ray from inside is totally reflected; radiance and count must agree."""
    inside = scene(half_space([0, -1, 0], ior=ior), medium_ior=medium, background=1.0, max_depth=1)
    _, rays = engine.radiance(inside, -2 * polar(degrees), polar(degrees))
    assert rays["transmission"] + rays["total_internal_reflection"] == 1
    assert rays["reflection"] == rays["total_internal_reflection"]
    return bool(rays["total_internal_reflection"])


@pytest.mark.parametrize(
    ("ior", "medium", "index", "printed"),
    [("glass", 1.333, 1.5, 62.70617608), ("glass", 1.0, 1.5, 41.810), ("diamond", 1.0, 2.419, 24.418)],
)
def test_16_20_critical_angles(engine: Engine, ior: str, medium: float, index: float, printed: float) -> None:
    critical = np.degrees(np.arcsin(medium / index))
    assert critical == pytest.approx(printed, abs=5e-9 if medium > 1 else 5e-4)
    # k there has a slope of 2 eta^2 sin cos >= 1 per radian; in float32 it is good to 4e-7
    margin = engine.tolerance(5e-5, 1e-6)
    assert not totally_reflects(engine, critical - margin, ior, medium)
    assert totally_reflects(engine, critical + margin, ior, medium)


def test_20_air_to_water(engine: Engine) -> None:
    assert bent(engine, 45, "water", 1.0, inside=False) == pytest.approx(32.037, abs=5e-4)  # as printed


def test_19_concave_polygon(engine: Engine) -> None:
    points = [[0, 0, 0], [4, 0, 0], [4, 4, 0], [2, 1, 0], [0, 4, 0]]
    hits = engine.intersect(
        scene({"type": "polygon", "points": points}), [[2, 0.5, -1], [2, 2, -1]], [[0, 0, 1], [0, 0, 1]]
    )
    assert hits.primitive.tolist() == [0, -1]
    assert hits.t.tolist() == [1, np.inf]
