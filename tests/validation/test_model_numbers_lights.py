"""The numbers for lights in docs/model.md, asked of the float64 oracle and of the kernels alike.

A plane of kd F = 1 through the point shows what falls on it. Tolerances: the oracle agrees to the digits that
are printed; float32 is off by its roundings, times how much the quantity makes of them, as said where it is used.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import clrt
from tests.engines import ENGINES, Engine

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
    ("degrees", "share"), [(0, 1), (27, 1), (28, 2 / 3), (29.5, 1 / 6), (29.999, 1 / 3000), (30.001, 0), (80, 0)]
)
def test_25_share_of_a_spot(engine: Engine, degrees: float, share: float) -> None:
    x = 3 * np.tan(np.radians(degrees))
    cosine = 3 / np.hypot(x, 3)
    # the angle is good to 4 roundings of 0.5, of which the penumbra of 0.052 makes 5e-6
    expected = pytest.approx(share, abs=engine.tolerance(5e-6))
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
