"""The numbers of docs/model.md on dispersion and media, of oracle and kernels alike."""

from __future__ import annotations

import numpy as np
import pytest

from tests.engines import ENGINES, Engine
from tests.screen import degrees_between, landed, passage, polar
from tests.validation.test_model_numbers import BALL, prism, scene
from validation.oracle64.palette import Palette
from validation.oracle64.spectra import index


@pytest.fixture(params=ENGINES)
def engine(request: pytest.FixtureRequest) -> Engine:
    return ENGINES[request.param]


BK7 = {486.1327: 1.522376290, 587.5618: 1.516800035, 656.2725: 1.514322347}  # F, d, C
DEVIATION = {486.1327: 39.13904981, 587.5618: 38.64669851, 656.2725: 38.42931640}


def test_10_indices_of_the_oracle() -> None:
    assert index("BK7", np.array(list(BK7))) == pytest.approx(list(BK7.values()), abs=2e-9)
    rgb = Palette.of(scene(BALL))
    assert rgb.index("BK7") == pytest.approx([1.516800035], abs=2e-9)


@pytest.mark.parametrize("nm", BK7)
def test_10_prism(engine: Engine, nm: float) -> None:
    """A ray that enters at the d line's minimum; its colour has an index of its own."""
    half = np.radians(DEVIATION[587.5618] / 2)
    u = np.array([np.cos(half), np.sin(half), 0])
    middle, half_width = np.array([0, -np.sqrt(0.75), 0]), np.array([0.5, 0, 0])
    glass = prism()
    glass["material"] = {**glass["material"], "ior": BK7[nm]}
    entry = middle - half_width
    leaving = polar(90 - DEVIATION[587.5618] / 2)
    _, direction = passage(engine, [glass], (entry - u, u), middle + half_width, leaving)
    tolerance = np.degrees(3 * landed(engine)) + 5e-9
    assert degrees_between(u, direction) == pytest.approx(DEVIATION[nm], abs=tolerance)


def test_16_air_glass_water_in_layers(engine: Engine) -> None:
    """Through glass into water that reaches into it: the glass is stronger, so both meet at its end."""
    clear = {"diffuse": 0.0, "transmission": 1.0}
    plane = {"type": "plane", "point": [0, -1, 0], "normal": [0, 1, 0]}
    water = {**plane, "point": [0, -0.5, 0], "material": {**clear, "ior": "water"}}
    slab = {"type": "box", "min": [-9, -1, -9], "max": [9, 0, 9],
            "material": {**clear, "ior": "glass", "priority": 1}}  # fmt: skip
    u = polar(30)
    exit_point = [np.tan(np.radians(19.47122063)), -1.0, 0.0]
    _, direction = passage(engine, [slab, water], (-2 * u, u), exit_point, polar(22.03010873))
    tolerance = 2 * (np.degrees(landed(engine)) + 5e-9)
    assert degrees_between(direction, [0, -1, 0]) == pytest.approx(22.03010873, abs=tolerance)
