"""The oracle's surfaces in closed form: mirrors, sheets, shading normals, ambient directions."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import clrt
from tests.engines import unit
from tests.screen import polar
from tests.solids import scene
from validation.oracle64 import hashing, radiance64


def light(found: clrt.Scene, direction: Any, origin: Any = None) -> np.ndarray:
    """Radiance along a ray, by default one that meets the origin."""
    start = -2 * np.asarray(direction) if origin is None else origin
    return np.asarray(radiance64(found, start, direction)[0][0])


def floor(**material: Any) -> dict[str, Any]:
    return {"type": "plane", "point": [0, 0, 0], "normal": [0, 1, 0], "material": material}


def small_lamp(center: Any) -> dict[str, Any]:
    """What only a ray sees that is aimed well."""
    return {
        "type": "sphere",
        "center": list(center),
        "radius": 1e-6,
        "material": {"diffuse": 0, "emission": 1.0},
    }


@pytest.mark.parametrize("degrees", [0, 60, 80])
def test_schlick_takes_a_tint_to_white(degrees: float) -> None:
    tint, cosine = np.array([0.9, 0.6, 0.2]), np.cos(np.radians(degrees))
    mirror = floor(fresnel="schlick", diffuse=0.0, reflection=0.8, reflection_color=tint.tolist())
    expected = 0.8 * (tint + (1 - tint) * (1 - cosine) ** 5)
    assert light(scene(mirror, background=1.0), polar(degrees)) == pytest.approx(expected, abs=1e-14)
    shiny = floor(fresnel="schlick", diffuse=0.0, specular=0.5, highlight_color=tint.tolist(), shininess=7)
    lamp = [{"type": "directional", "direction": polar(-20).tolist()}]
    # the mirrored light lies 20 degrees to one side, the viewer `degrees` to the same
    alignment = np.cos(np.radians(degrees - 20))
    tinted = tint + (1 - tint) * (1 - np.cos(np.radians(20))) ** 5
    seen = light(scene(shiny, lights=lamp), polar(degrees))
    assert seen == pytest.approx(0.5 * tinted * alignment**7, abs=1e-14)


@pytest.mark.parametrize("side", [1, -1])
def test_thin_sheets_are_the_same_from_both_sides(side: int) -> None:
    """A sheet of glass reflects 2 Fr / (1 + Fr) and lets rays pass straight; it never reflects totally."""
    u = polar(60) * [1, side, 1]
    reflectance = 2 * 0.0891867128 / (1 + 0.0891867128)
    pane = {"fresnel": True, "thin": True, "diffuse": 0.0}
    assert light(scene(floor(**pane, transmission=0.0), background=1.0), u) == pytest.approx(
        reflectance, abs=1e-9
    )
    through = scene(floor(**pane, reflection=0.0), small_lamp(3 * u))
    assert light(through, u) == pytest.approx(1 - reflectance, abs=1e-9)


def smooth(degrees: float, **material: Any) -> dict[str, Any]:
    """A triangle round the origin in y = 0, outer side up, whose corners have normals leaning to +x."""
    normal = (-polar(-degrees)).tolist()
    corners = [[-3, 0, -3], [0, 0, 6], [3, 0, -3]]
    faces, normals = [[0, 1, 2]], [normal] * 3
    mesh = {"type": "mesh", "vertices": corners, "faces": faces, "normals": normals}
    return {**mesh, "material": material}


def test_shading_normals_make_the_light_and_geometric_ones_the_sides() -> None:
    lean, down = np.radians(20), [0, -1, 0]

    def shade(towards_light: Any, ray: Any) -> float:
        lamp = [{"type": "directional", "direction": (-np.asarray(towards_light, float)).tolist()}]
        return float(light(scene(smooth(20.0, color=1.0), lights=lamp), ray)[0])

    assert shade([0, 1, 0], down) == pytest.approx(np.cos(lean), abs=1e-14)
    assert shade(-polar(-20), down) == pytest.approx(1, abs=1e-14)
    # from below both normals turn round
    assert shade(polar(-20), [0, 1, 0]) == pytest.approx(1, abs=1e-14)
    # above the shading plane but below the surface, and the other way round: no light
    assert shade([1, -0.1, 0], down) == 0 and shade([-1, 0.1, 0], down) == 0
    # seen so flatly that the shading normal looks away, the geometric one serves
    flat = polar(75)
    assert np.dot(-polar(-20), flat) > 0
    assert shade([0, 1, 0], flat) == pytest.approx(1, abs=1e-14)


def test_normals_are_interpolated() -> None:
    corners = np.array([[0, 0, 0], [0, 0, 1], [1, 0, 0]], float)
    normals = unit([[0, 1, 0], [0.3, 1, 0], [0, 1, 0.4]])
    mesh = {"type": "mesh", "vertices": corners, "faces": [[0, 1, 2]], "normals": normals}
    mesh["material"] = {"color": 1.0}
    lamp = [{"type": "directional", "direction": [0, -1, 0]}]
    weights = np.array([0.5, 0.2, 0.3])
    seen = light(scene(mesh, lights=lamp), [0, -1, 0], weights @ corners + [0, 1, 0])
    assert seen[0] == pytest.approx(unit(weights @ normals)[1], abs=1e-14)


def test_mirrored_rays_stay_above_the_surface() -> None:
    """Where the shading normal would send one below, the geometric one sends it."""
    u = polar(80)
    for lean, expected in ((8.0, u * [1, -1, 1]), (-4.0, None)):
        ns = -polar(-lean)
        reflected = u - 2 * np.dot(u, ns) * ns
        assert (reflected[1] < 0) == (expected is not None)
        ahead = reflected if expected is None else expected
        mirror = scene(smooth(lean, diffuse=0.0, reflection=1.0), small_lamp(3 * ahead))
        assert light(mirror, u) == pytest.approx(1, abs=1e-14)


@pytest.mark.filterwarnings("ignore:.*transmits but encloses nothing")
def test_a_ray_that_would_not_leave_is_totally_reflected() -> None:
    """The shading normal would let it out, but on the wrong side; to the geometric one it is too flat."""
    u = polar(50) * [1, -1, 1]
    assert 1.5 * np.sin(np.radians(50 - 8.5)) < 1 < 1.5 * np.sin(np.radians(50))
    glass = smooth(8.5, diffuse=0.0, transmission=1.0, ior=1.5)
    seen, stats = radiance64(scene(glass, background=1.0), -2 * u, u)
    assert stats["rays"]["total_internal_reflection"] == 1 and stats["rays"]["transmission"] == 0
    assert seen[0] == pytest.approx([1] * 3)


def test_ambient_directions_are_cosine_distributed() -> None:
    """First and second moments of cos(theta) / pi over the hemisphere, in any frame."""
    for n in (unit([0.3, -0.4, 0.9]), unit([0.3, 0.1, -0.9]), np.array([0, 1.0, 0])):
        h = hashing.combine(hashing.word(np.arange(20)), 3)
        directions = np.array([hashing.cosine_direction(h, i, np.tile(n, (20, 1))) for i in range(256)])
        flat = directions.reshape(-1, 3)
        assert np.linalg.norm(flat, axis=1) == pytest.approx(1, abs=1e-12)
        # 5120 points: standard errors of 3e-3 even if they were independent
        assert flat.mean(axis=0) == pytest.approx(2 / 3 * n, abs=0.01)
        moments = flat.T @ flat / len(flat)
        assert moments == pytest.approx(0.25 * np.eye(3) + 0.25 * np.outer(n, n), abs=0.01)
        assert np.ptp(directions[0], axis=0).min() > 0.5  # each hash has its own
