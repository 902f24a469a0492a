"""Materials cost time in proportion to their text in RGB scenes, too, whatever curves they name or state."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from clrt.spectra.bands import conductor, light, reflectance
from clrt.spectra.indices import Conductor
from clrt.spectra.spectrum import Spectrum
from tests.cost import bounded

MATERIALS: dict[str, Callable[[int], Any]] = {
    "one metal": lambda n: {"conductor": "gold"},
    "one curve": lambda n: {"conductor": {"eta": [[400, 1], [700, 2]], "k": 3}},
    "many metals": lambda n: {"conductor": {"eta": [[400, 1], [700, 2 + n / 7]], "k": 3}},
    "all of one": lambda n: {
        **dict.fromkeys(["color", "highlight_color", "reflection_color", "transmission_color"], "gold"),
        "emission": "D65",
    },
    "many lines": lambda n: {"color": {"line": 400 + n / 64}},
    "many bumps": lambda n: {"color": {"gaussian": [400 + n / 64, 9]}},
}  # fmt: skip


@pytest.mark.parametrize("name", MATERIALS)
@pytest.mark.filterwarnings("ignore")
def test_materials_cost_no_more_than_their_text_allows(name: str, tmp_path: Path) -> None:
    sphere = {"type": "sphere", "center": [0, 0, 0], "radius": 1}
    shapes = [{**sphere, "material": MATERIALS[name](n)} for n in range(8000)]
    (tmp_path / "a.json").write_text(json.dumps({"shapes": shapes}, separators=(",", ":")))
    assert bounded("load", tmp_path / "a.json").error == ""


def test_what_is_remembered_is_what_is_computed() -> None:
    """And long curves are not kept: they would stay in memory after their scenes."""
    points = tuple((400.0 + i, i / 99) for i in range(99))
    held = sys.getrefcount(points)
    for value in (Spectrum(samples=points[:3]), Spectrum(samples=points), Spectrum(blackbody=3200.0)):
        for color in (reflectance, light):
            np.testing.assert_array_equal(color(value, None), color(value, None))
    for metal in (Conductor(eta=points[1:4], k=3.0), Conductor(eta=2.0, k=points)):
        np.testing.assert_array_equal(conductor(metal, None), conductor(metal, None))
    del value, metal
    assert sys.getrefcount(points) == held
