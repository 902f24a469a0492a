"""What float32 does to a scene's picture, as limits of its own are derived from it."""

from __future__ import annotations

import numpy as np
import pytest

import clrt
from clrt.base.resources import validation_module

noise = validation_module("noise")
cases = validation_module("cases")


def test_every_number_moves_by_one_step_of_float32() -> None:
    camera = {"origin": [0, 0.3, 4.1], "target": [0, 0, 0], "width": 8, "height": 6}
    ball = {"type": "sphere", "center": [3000.0, 0, 0], "radius": 0.7}
    scene = clrt.load_dict({"camera": camera, "shapes": [ball], "ambient": 0.5})
    one, other = noise.moved(scene, 1), noise.moved(scene, 1)
    assert one.to_dict() == other.to_dict() and one.camera.width == 8
    for was, now in ((3000.0, one.shapes[0].center[0]), (0.7, one.shapes[0].radius)):
        assert abs(now - was) == float(np.spacing(np.float32(was)))


# picture -> whose limits, and how often light is rounded that much
@pytest.mark.parametrize(("measured", "name", "times"), [
    ("shipped thesis_3_07_acne", "shipped thesis_3_07_acne", 2),
    ("shipped thesis_3_07_acne", "shipped thesis_3_07_acne (oracle64)", 2),
    ("shipped thesis_3_07_acne at 16 samples", "shipped thesis_3_07_acne at 16 samples", 2),
    ("shipped thesis_3_07_acne at 16 samples", "shipped thesis_3_07_acne at 16 samples (oracle64)", 2),
    ("shipped straw at 16 samples", "shipped straw at 16 samples (mitsuba-table)", 2),
    ("shipped rainbow", "shipped rainbow", 4),  # when the scene is read, and at three hits on the drop
    ("shipped rainbow", "shipped rainbow (oracle64)", 4),
])  # fmt: skip
def test_own_limits_are_within_the_noise(measured: str, name: str, times: int) -> None:
    """And the rows are of the scenes as they are."""
    rows = noise.kept()
    assert rows[measured]["scene"] == noise.digest(measured)
    own = cases.OWN_LIMITS[name][0]
    for field, (_, low) in noise.FIGURES.items():
        if field in own:
            most = noise.allowed(field, rows[measured]["noise"][field], times)
            assert own[field] >= most if low else own[field] <= most, field


def test_what_has_limits_of_its_own_was_measured_or_is_full_of_edges() -> None:
    """The share of edges is the reference's alone, in which float32 has no say."""
    assert set(noise.cases()) <= noise.kept().keys()
    others = {name: own.keys() for name, (own, _) in cases.OWN_LIMITS.items()
              if name.partition(" (")[0] not in noise.cases()}  # fmt: skip
    assert others == {f"shipped sphereflake{samples}": {"mask"} for samples in ("", " at 16 samples")}
    flake = noise.kept()["shipped sphereflake"]
    assert flake["scene"] == noise.digest("shipped sphereflake")
    assert flake["noise"]["fine"] == flake["noise"]["coarse"] == 1.0


def test_a_limit_for_one_oracle_is_said_too() -> None:
    assert "60.5 dB" in cases.case_named("shipped straw at 16 samples").note
