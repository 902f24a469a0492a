"""Flat and long ellipsoids do not shadow themselves, however steeply a ray leaves them."""

from __future__ import annotations

import numpy as np
import pytest

import clrt


@pytest.mark.parametrize("radii", [(15, 2, 15), (15, 0.3, 15), (1, 40, 1), (5, 5, 5)])
@pytest.mark.parametrize("toward", [(1, 0.6, 0.5), (0.3, 1, -0.4), (-1, 0.1, -0.9)])
def test_what_faces_the_light_is_lit(radii: tuple[float, ...], toward: tuple[float, ...]) -> None:
    """An ellipsoid is convex: nothing lies between the side that faces a light and that light."""
    ellipsoid = {"type": "ellipsoid", "center": [20, 0, -10], "radii": radii}
    tracer = clrt.Tracer(clrt.load_dict({"shapes": [ellipsoid]}))
    aim = np.random.default_rng(1).normal(size=(4000, 3))
    place = np.array([20.0, 0, -10]) + 100 * aim / np.linalg.norm(aim, axis=1, keepdims=True)
    target = np.array([20.0, 0, -10]) + 0.9 * np.roll(aim, 1, axis=0) / 3 * radii
    hits = tracer.intersect(place, target - place)
    found = hits.primitive >= 0
    assert found.sum() > 1000
    unit = np.array(toward) / np.linalg.norm(toward)
    lit = {"type": "directional", "direction": (-unit).tolist(), "intensity": 1.0}
    material = {"color": 1.0, "diffuse": 1.0}
    scene = clrt.load_dict({"lights": [lit], "shapes": [{**ellipsoid, "material": material}]})
    seen, _ = clrt.Tracer(scene).radiance(place, target - place)
    towards_eye = np.sum(hits.normal * (target - place), axis=1) < 0
    facing = np.sum(hits.normal * unit, axis=1)
    bright = found & towards_eye & (facing > 1e-3)
    assert bright.sum() > 300
    assert seen[bright, 0] == pytest.approx(facing[bright], abs=1e-3)
