"""The numbers for lights in docs/model.md, asked of the float64 oracle and of the kernels alike.

A plane of kd F = 1 through the point shows what falls on it. Tolerances: the oracle agrees to the digits
that are printed; float32 is off by its roundings, times what the quantity makes of them.
"""

from __future__ import annotations

from typing import Any, Final

import numpy as np
import pytest

import clrt
from tests.engines import ENGINES, Engine
from validation.oracle64 import hashing

WHITE = {"color": 1.0, "diffuse": 1.0, "ambient": 0.0}


@pytest.fixture(params=ENGINES)
def engine(request: pytest.FixtureRequest) -> Engine:
    return ENGINES[request.param]


def received(engine: Engine, light: dict[str, Any], point: Any = (0, 0, 0), n: Any = (0, 0, 1)) -> float:
    """What a white plane of this normal sends back of a light at a point."""
    plane = {"type": "plane", "point": list(point), "normal": list(n), "material": WHITE}
    scene = clrt.load_dict({"shapes": [plane], "lights": [light]})
    point, n = np.asarray(point, float), np.asarray(n, float)
    found, _ = engine.radiance(scene, [point + 1e-3 * n], [-n])
    return float(found[0, 0])


SPOT = {"type": "spot", "position": [0, 3, 0], "target": [0, 0, 0]}


@pytest.mark.parametrize(
    ("degrees", "share"),
    [(0, 1), (27, 1), (28, 2 / 3), (29.5, 1 / 6), (29.999, 1 / 3000), (30.001, 0), (80, 0)],
)
def test_25_share_of_a_spot(engine: Engine, degrees: float, share: float) -> None:
    x = 3 * np.tan(np.radians(degrees))
    cosine = 3 / np.hypot(x, 3)
    # the angle is good to 4 roundings of 0.5, of which the penumbra of 0.052 makes 5e-6; and the feeler
    # starts twice the offset, 1.7e-6, above the plane, where the angle is 2.4e-7 larger: as much again
    expected = pytest.approx(share, abs=engine.tolerance(1e-5))
    assert received(engine, SPOT, (x, 0, 0), (0, 1, 0)) / cosine == expected


@pytest.mark.parametrize(("degrees", "share"), [(29.99, 1), (30.01, 0)])
def test_25_spot_without_penumbra(engine: Engine, degrees: float, share: float) -> None:
    x = 3 * np.tan(np.radians(degrees))
    found = received(engine, {**SPOT, "penumbra": 0}, (x, 0, 0), (0, 1, 0)) / (3 / np.hypot(x, 3))
    assert found == pytest.approx(share, abs=engine.tolerance(1e-6))


def test_26_spot_that_fades(engine: Engine) -> None:
    spot = {**SPOT, "intensity": 2.0, "falloff": "inverse-square"}
    # the share is 0.64: 5e-6 of it, and the rest of the product is rounded ten times
    found = received(engine, spot, (1.6, 0, 0), (0, 1, 0))
    assert found == pytest.approx(0.0980822850, rel=engine.tolerance(1e-5, 1e-8))


def test_a_spot_sends_no_feeler_where_it_does_not_shine(engine: Engine) -> None:
    plane = {"type": "plane", "point": [0, 0, 0], "normal": [0, 1, 0]}
    scene = clrt.load_dict({"shapes": [plane], "lights": [SPOT]})
    _, rays = engine.radiance(scene, [[1, 1, 0], [2, 1, 0]], [[0, -1, 0]] * 2)
    assert rays["feelers"] == 1 and rays["hits"] == 2


RECTANGLE = {"type": "rectangle", "center": [0.3, -0.2, 2], "u": [0, 1, 0], "v": [1, 0, 0]}
TURNED = {"type": "rectangle", "center": [1, 0.5, 1.5], "u": [0, 0.5, 0.25], "v": [0.6, -0.1, 0.4],
          "two_sided": True}  # fmt: skip
DISK = {"type": "disk", "center": [0, 0, 2], "normal": [0, 0, -3], "radius": 1}
SPHERE = {"type": "sphere", "center": [1, 2, 2], "radius": 0.5}
FORMS: dict[str, tuple[dict[str, Any], float]] = {
    "21 rectangle": (RECTANGLE, 0.230747527),
    "22 turned rectangle": (TURNED, 0.0310064048),
    "23 sphere": (SPHERE, 1 / 54),
    "23 sphere cut by the horizon": ({**SPHERE, "center": [2, 0, 0.5], "radius": 1}, 0.0626439828),
    "24 disk": (DISK, 1 / 5),
    "24 disk aside": ({**DISK, "center": [1.5, 0, 2]}, 0.10228414),
    "all around": ({"type": "sphere", "center": [0.3, 0.4, 0.5], "radius": 3, "two_sided": True}, 1.0),
    "a wall as wide as the sky": ({**RECTANGLE, "u": [0, 90, 0], "v": [90, 0, 0]}, 0.9995960544),
}


def lambert(light: dict[str, Any]) -> float:
    """Lambert's formula (1760) for what a polygon of radiance 1 sends to a white wall at 0 with normal z."""
    center, u, v = (np.array(light[name], float) for name in ("center", "u", "v"))
    corners = [center - u - v, center + u - v, center + u + v, center - u + v]
    total = 0.0
    for a, b in zip(corners, [*corners[1:], corners[0]], strict=True):
        across = np.cross(a, b)
        angle = np.arctan2(np.linalg.norm(across), a @ b)
        total += angle * across[2] / np.linalg.norm(across)
    return float(abs(total) / (2 * np.pi))


def seen_by(engine: Engine, light: dict[str, Any], rays: int) -> np.ndarray:
    """What falls on the same white point, (rays,): each ray sees the light by other points."""
    plane = {"type": "plane", "point": [0, 0, 0], "normal": [0, 0, 1], "material": WHITE}
    scene = clrt.load_dict({"shapes": [plane], "lights": [{**light, "visible": False}]})
    found, _ = engine.radiance(scene, [[0, 0, 1e-3]] * rays, [[0, 0, -1]] * rays)
    return np.asarray(found[:, 0], float)


@pytest.mark.parametrize("name", FORMS)
def test_21_to_24_closed_forms(name: str) -> None:
    """A million points. Rays are hashed: their means are independent, and of finite variance."""
    light, expected = FORMS[name]
    if light["type"] == "rectangle":
        assert lambert(light) == pytest.approx(expected, abs=1e-9)
    found = seen_by(ENGINES["kernels"], light, 1 << 16)
    assert found.mean() == pytest.approx(expected, abs=4.5 * found.std() / np.sqrt(len(found)) + 1e-6)


R2: Final = 1 / 1.324717957244746 ** np.arange(1, 3)  # Roberts' plastic number, and its square


def most_off(points: np.ndarray, fine: int) -> float:
    """How far the mean over shifted `points` (n, 2) of the unit square is at most off from row 21, relative.

    Over a shift the mean is smooth but where a point goes round: between these lines it is taken at `fine`
    steps of each side, with the limits at the lines themselves, where the extremes are.
    """

    def between(turns: np.ndarray) -> np.ndarray:
        lines = np.unique([0.0, *turns, 1.0])
        low, high = lines[:-1, None] + 1e-12, lines[1:, None] - 1e-12
        return np.asarray(low + (high - low) * np.linspace(0, 1, fine + 1)).ravel()

    shifts = np.stack(np.meshgrid(*map(between, (1 - points).T), indexing="ij"), axis=-1)
    total = np.zeros(shifts.shape[:2])
    for point in points:
        v, u = np.moveaxis(2 * ((shifts + point) % 1) - 1, -1, 0)
        x, y = u + 0.3, v - 0.2
        total += 4 / np.pi * 4 / (x**2 + y**2 + 4) ** 2  # area times cosines over pi and the distance squared
    return float(np.abs(total / len(points) / FORMS["21 rectangle"][1] - 1).max())


def test_21_spread_of_16_points() -> None:
    """The shifted R2 sequence: no shift at all is off by more than 7.04 %, and 1.92 % on the average."""
    light, expected = FORMS["21 rectangle"]
    bound = most_off(np.arange(16)[:, None] * R2 % 1, 8)
    assert bound == pytest.approx(most_off(np.arange(16)[:, None] * R2 % 1, 3), abs=1e-4)
    assert 0.07 < bound < 0.071 < most_off(np.random.default_rng(1).random((16, 2)), 3)
    found = np.abs(seen_by(ENGINES["kernels"], light, 1 << 14) / expected - 1)
    assert 0.95 * bound < found.max() <= bound + 1e-6
    assert np.sqrt(np.mean(found**2)) == pytest.approx(0.0192, rel=0.03)


@pytest.mark.parametrize("name", FORMS)
def test_oracle_and_kernels_take_the_same_points(name: str) -> None:
    light, _ = FORMS[name]
    ours, theirs = (seen_by(ENGINES[engine], light, 40) for engine in ("kernels", "oracle64"))
    # directions are rounded to 1e-7, of which the cosine at the horizon makes 1e-7 absolutely
    np.testing.assert_allclose(ours, theirs, rtol=3e-6, atol=3e-7)


def test_38_numbers_of_a_pixel() -> None:
    base = hashing.combine(hashing.word(np.zeros(1)), np.array([12345]))
    u1, u2 = hashing.pair(hashing.combine(base, 0x80000002), 16 * 1 + 4)
    assert (u1[0], u2[0]) == pytest.approx((0.6586342454, 0.5340567231), abs=1e-10)


def test_samples_of_a_pixel_cover_the_light_together() -> None:
    """16 pixel samples of 4 points are 64 of one sequence: as good as 64 points at once, and better than 16
    runs of 4 points that know nothing of each other, which are 4 times less off than one."""
    floor = {"type": "plane", "point": [0, 0, 0], "normal": [0, 0, 1], "material": WHITE}
    camera = {"type": "orthographic", "origin": [0, 0, 0.5], "target": [0, 0, 0], "size": 1e-4,
              "width": 24, "height": 24}  # fmt: skip
    light = {**RECTANGLE, "visible": False}
    spread = {}
    for samples, spp in ((4, 16), (64, 1), (4, 1)):
        lights = [{**light, "samples": samples}]
        scene = {"camera": {**camera, "spp": spp}, "shapes": [floor], "lights": lights}
        spread[samples, spp] = clrt.render(clrt.load_dict(scene)).pixels.std()
    assert spread[4, 16] == pytest.approx(spread[64, 1], rel=0.3)
    assert spread[4, 16] < spread[4, 1] / 4 / 1.5
