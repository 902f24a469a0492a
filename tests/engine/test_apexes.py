"""The tips of cones and paraboloids, where a root is double, a normal is missing and a clip box touches."""

from __future__ import annotations

import numpy as np
import pytest

from tests.engine.test_primitives import KINDS, SCALES, TURNED, Case, Rays, U, check, placed, step_matrix
from tests.engines import ENGINES, Engine, unit


@pytest.mark.parametrize("engine", ENGINES.values(), ids=ENGINES)
@pytest.mark.parametrize("scale", SCALES)
@pytest.mark.parametrize("kind", ["paraboloid", "cone with apex"])
def test_a_ray_along_the_axis_meets_the_apex(engine: Engine, scale: float, kind: str) -> None:
    """There a cone has a double root and no normal, and a paraboloid's clip box touches the surface."""
    upright = {"type": "paraboloid", "apex": [0, 0.7, 0], "axis": [0, -1, 0], "focal": 0.25, "height": 2.0}
    apex, keys = (0.7, upright) if kind == "paraboloid" else (1.0, KINDS[kind])
    rays = Rays.of([[0, 4, 0], [0, apex - 0.75, 0]], [[0, -1, 0], [0, 1, 0]], scale, (0, 0, 0))
    hits = engine.intersect(placed(keys, scale, (0, 0, 0)), rays.origin, rays.direction)
    assert hits.primitive.tolist() == [0, 0]
    # a few roundings of coordinates up to 4
    assert hits.t / scale == pytest.approx([4 - apex, 0.75], abs=16 * U * 4)
    facing = -rays.direction if kind == "cone with apex" else np.array([[0, 1, 0]] * 2)
    if engine.name == "oracle64" or scale != 1e-3:  # an apex between two float32 numbers is not hit exactly
        assert np.abs(hits.normal - facing).max() < 1e-6


@pytest.mark.parametrize("engine", ENGINES.values(), ids=ENGINES)
@pytest.mark.parametrize("kind", ["paraboloid", "cone with apex", "turned cone with apex"])
def test_there_is_no_hole_at_an_apex(engine: Engine, kind: str) -> None:
    """Rays aimed to within 1e-4 sizes of it, where a clip box touches the surface or roots almost meet."""
    keys = {**KINDS, **TURNED}[kind]
    axis = -unit(keys["axis"]) if kind == "paraboloid" else np.array([0, 1, 0])
    matrix = step_matrix(keys)
    apex = matrix[:3, :3] @ (keys["apex"] if kind == "paraboloid" else keys["p1"]) + matrix[:3, 3]
    rng = np.random.default_rng(20240611)
    above = unit(matrix[:3, :3] @ axis + 0.3 * rng.normal(size=(500, 3)))
    aims = apex + 1e-4 * np.resize([0.01, 0.1, 1], 500)[:, None] * rng.normal(size=(500, 3))
    for scale in SCALES:
        rays = Rays.of(aims + 3 * above, -above, scale, (0, 0, 0))
        hit, _ = check(engine, Case(keys, scale, (0, 0, 0)), rays)
        assert hit > 0.7
