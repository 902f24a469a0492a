"""Quadrics that are pointed, thin, flat or without an end: convex ones shadow nothing of themselves, and all
are where they are said to be, wherever they lean to."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import clrt

U = 2.0**-24
AXIS = np.array([0.3, 0.5, 0.8]) / np.sqrt(0.98)
ACROSS = np.cross(AXIS, [1, 0, 0]) / np.linalg.norm(np.cross(AXIS, [1, 0, 0]))


def leaning(slope: float, level: float) -> list[float]:
    """r^2 + 2 slope s + level = 0, s along AXIS and r the distance from it, as a quadric's coefficients."""
    (a, d, f), (_, b, e), (_, _, c) = np.eye(3) - np.outer(AXIS, AXIS)
    return [a, b, c, d, e, f, *(slope * AXIS), level]


def cone(height: float, r0: float, r1: float) -> dict[str, Any]:
    return {"type": "cone", "p0": [0, 0, 0], "r0": r0, "p1": (height * AXIS).tolist(), "r1": r1}


CONVEX: dict[str, dict[str, Any]] = {
    **{f"spire of {height:g}": cone(height, 0.5, 0.0) for height in (0.02, 0.5, 3.0, 5.0, 10.0, 50.0)},
    "icicle": cone(10.0, 0.0, 0.5),
    "blunt spire": cone(10.0, 0.5, 0.04),
    "upright spire": {"type": "cone", "p0": [0, 0, 0], "r0": 0.5, "p1": [0, 10, 0], "r1": 0},
    "rod": {"type": "cylinder", "p0": [0, 0, 0], "p1": (10 * AXIS).tolist(), "radius": 1e-3},
    "needle": {"type": "ellipsoid", "center": [0, 0, 0], "radii": [1e-3, 1e-3, 5],
               "transform": [{"rotate": [[1, 2, 0.5], 50.0]}]},
    "endless cylinder": {"type": "quadric", "coefficients": leaning(0, -0.25)},
    "endless paraboloid": {"type": "quadric", "coefficients": leaning(-0.2, 0)},
}  # fmt: skip


def aims(keys: dict[str, Any], rng: np.random.Generator, n: int) -> np.ndarray:
    """Places on the axis, not near a tip."""
    share = rng.uniform(0.25, 0.75, (n, 1))
    if "p1" in keys:
        return np.asarray(share * keys["p1"])
    if "coefficients" in keys:
        return np.asarray(30 * share * AXIS)
    matrix = clrt.load_dict({"shapes": [keys]}).shapes[0].matrix[:3, :3]
    return np.asarray((4 * share - 2) * matrix[:, 2])


@pytest.mark.parametrize("place", [(0, 0, 0), (30, -20, 10)])
@pytest.mark.parametrize("scale", [0.01, 1.0])
@pytest.mark.parametrize("name", CONVEX)
def test_what_faces_a_light_is_lit(name: str, scale: float, place: tuple[float, ...]) -> None:
    keys, n, rng = CONVEX[name], 3000, np.random.default_rng(3)
    steps = [*keys.get("transform", []), {"scale": scale}, {"translate": [scale * x for x in place]}]
    target = scale * (aims(keys, rng, n) + place)
    away = rng.normal(size=(n, 3))
    origins = target + 20 * scale * away / np.linalg.norm(away, axis=1, keepdims=True)
    for toward in ((0.3, 1, 0.5), (-0.7, 0.9, 0.6)):
        unit = np.array(toward) / np.linalg.norm(toward)
        light = {"type": "directional", "direction": (-unit).tolist(), "intensity": 1.0}
        shape = {**keys, "transform": steps, "material": {"color": 1.0, "diffuse": 1.0}}
        tracer = clrt.Tracer(clrt.load_dict({"lights": [light], "shapes": [shape]}))
        hits = tracer.intersect(origins, target - origins)
        seen, _ = tracer.radiance(origins, target - origins)
        met = hits.primitive >= 0
        facing = np.sum(np.where(met[:, None], hits.normal, 0) * unit, axis=1)
        front = met & (np.sum(hits.normal * (target - origins), axis=1) < 0)
        assert met.mean() > 0.98, "rays aimed at its axis meet it"
        bright = front & (facing > 0.01)
        assert bright.sum() > 100
        assert (seen[bright, 0] > 0.5 * facing[bright]).all()


@pytest.mark.parametrize("radius", [1e-2, 1e-3, 1e-4, 1e-5])
@pytest.mark.parametrize("kind", ["cylinder", "cone", "quadric"])
def test_leaning_rods_have_their_radius(kind: str, radius: float) -> None:
    """To what float32 leaves of coordinates of half their length: 4 roundings of it at most, seldom 2."""
    half, n, rng = 5.0, 5000, np.random.default_rng(4)
    ends = {"p0": (-half * AXIS).tolist(), "p1": (half * AXIS).tolist()}
    keys: dict[str, Any] = {"type": kind, **ends, "radius": radius}
    if kind == "cone":
        keys = {"type": kind, **ends, "r0": radius, "r1": 0.5 * radius}
    if kind == "quadric":
        keys = {"type": kind, "coefficients": leaning(0, -radius * radius)}
    s, angle = rng.uniform(-0.8 * half, 0.8 * half, n), rng.uniform(0, 2 * np.pi, n)
    here = radius * (0.75 - 0.25 * s / half if kind == "cone" else np.ones(n))
    out = np.cos(angle)[:, None] * ACROSS + np.sin(angle)[:, None] * np.cross(AXIS, ACROSS)
    beside = (rng.uniform(-0.8, 0.8, n) * here)[:, None] * np.cross(AXIS, out)
    origins = (s[:, None] * AXIS + beside + 3 * out).astype(np.float32)
    t = clrt.Tracer(clrt.load_dict({"shapes": [keys]})).intersect(origins, (-out).astype(np.float32)).t
    assert np.isfinite(t).all()
    points = origins - t.astype(float)[:, None] * out
    off = np.abs(np.linalg.norm(points - (points @ AXIS)[:, None] * AXIS, axis=1) - here)
    assert off.max() < 8 * U * half and np.median(off) < 1 * U * half


@pytest.mark.parametrize(
    ("conic", "radius"), [(-1.0022985, 11.04), (-1.00001, 11.04), (-1.0, 11), (-1.2, 1), (-3, 1)]
)
def test_mirrors_of_telescopes_are_where_they_are(conic: float, radius: float) -> None:
    """x^2 + y^2 + (1 + K) z^2 = 2 R z, turned; Hubble's primary mirror is the first."""
    coefficients = [1, 1, 1 + conic, 0, 0, 0, 0, 0, -radius, 0]
    scene = clrt.load_dict({"shapes": [
        {"type": "quadric", "coefficients": coefficients, "transform": [{"rotate": [[1, 2, 3], 40.0]}]}
    ]})  # fmt: skip
    turn, rng = scene.shapes[0].matrix[:3, :3], np.random.default_rng(6)
    x, y = rng.uniform(-1, 1, (2, 4000))
    square = x * x + y * y
    points = np.stack([x, y, square / (radius + np.sqrt(radius * radius - (1 + conic) * square))], 1)
    ways = np.array([0, 0, -1]) + rng.normal(0, 0.1, (4000, 3))
    ways /= np.linalg.norm(ways, axis=1, keepdims=True)
    t = clrt.Tracer(scene).intersect((points - 5 * ways) @ turn.T, ways @ turn.T).t
    assert np.abs(t - 5).max() < 16 * U * 5


def flat(kind: str, thin: float) -> dict[str, Any]:
    """A body that reaches 1 to 2 about the origin and is so thin that nothing of it is beyond that."""
    turned = {"transform": [{"rotate": [[1, 2, 0.5], 50.0]}]}
    return {
        "plate": {"type": "ellipsoid", "center": [0, 0, 0], "radii": [1, 1, thin], **turned},
        "rod": {"type": "ellipsoid", "center": [0, 0, 0], "radii": [1, thin, thin], **turned},
        "ribbon": {"type": "ellipsoid", "center": [0, 0, 0], "radii": [1, thin, 1e-3]},
        "pressed ball": {"type": "sphere", "center": [0, 0, 0], "radius": 1,
                         "transform": [{"scale": [1, 1, thin]}, {"rotate": [[1, 2, 0.5], 50.0]}]},
        "hat": {"type": "cone", "p0": [0, 0, 0], "r0": 1, "p1": [0, 0, thin], "r1": 0, "caps": False},
        "stump": {"type": "cone", "p0": [0, 0, 0], "r0": 1, "p1": [0, 0, thin], "r1": 0.5, "caps": False},
        "form": {"type": "quadric", "coefficients": [1, 1, thin**-2, 0, 0, 0, 0, 0, 0, -1]},
        "long form": {"type": "quadric", "coefficients": [thin**2, 0, 1, 0, 0, 0, 0, 0, 0, -(thin**2)],
                      "clip": [[-5, -1, -1], [5, 1, 1]]},
    }[kind]  # fmt: skip


@pytest.mark.parametrize("thin", [1e-3, 1e-5, 3e-7, 1e-7, 3e-8, 1e-9, 1e-15, 1e-30])
@pytest.mark.parametrize(
    "kind", ["plate", "rod", "ribbon", "pressed ball", "hat", "stump", "form", "long form"]
)
def test_what_is_too_thin_is_refused_and_all_else_ends_where_it_should(kind: str, thin: float) -> None:
    """In place of a plate or a rod without an end."""
    try:
        tracer = clrt.Tracer(clrt.load_dict({"shapes": [flat(kind, thin)]}))
    except clrt.SceneError as error:
        assert thin < 2e-7
        assert any(text in str(error) for text in ("which is lost in rounding", "singular", "float32"))
        return
    rng = np.random.default_rng(9)
    aims = rng.normal(size=(4000, 3))
    aims *= rng.uniform(2.1, 40, (4000, 1)) / np.linalg.norm(aims, axis=1, keepdims=True)
    ways = rng.normal(size=(4000, 3))
    nearest = np.linalg.norm(np.cross(ways, aims), axis=1) / np.linalg.norm(ways, axis=1)
    far = nearest > 2.1
    assert far.sum() > 2000
    with tracer:
        assert not np.isfinite(tracer.intersect((aims - 5 * ways)[far], ways[far]).t).any()


def test_a_cone_that_is_nearly_a_cylinder_is_not_too_thin() -> None:
    for more in (0.0, 1e-15, 1e-9, 1e-6):
        keys = {"type": "cone", "p0": [0, 0, 0], "r0": 1, "p1": [0, 0, 3], "r1": 1 + more}
        with clrt.Tracer(clrt.load_dict({"shapes": [keys]})) as tracer:
            assert tracer.intersect([5, 0, 1.5], [-1, 0, 0]).t == pytest.approx(4, abs=1e-5)


@pytest.mark.parametrize(
    ("length", "r0", "r1"), [(100, 5e-3, 4.995e-3), (1000, 0.05, 0.04995), (1, 1e-6, 0.99e-6)]
)
def test_a_long_rod_that_hardly_tapers_is_not_too_thin(length: float, r0: float, r1: float) -> None:
    keys = {"type": "cone", "p0": [0, 0, 0], "r0": r0, "p1": [0, 0, length], "r1": r1}
    with clrt.Tracer(clrt.load_dict({"shapes": [keys]})) as tracer:
        for share in (0.01, 0.5, 0.99):
            radius = r0 + share * (r1 - r0)
            t = tracer.intersect([2 * r0, 0, share * length], [-1, 0, 0]).t
            assert t == pytest.approx(2 * r0 - radius, rel=1e-3)
