"""Scenes of extreme numbers: a picture or an error of clrt, never a word of numpy's."""

from __future__ import annotations

import warnings
from typing import Any

import numpy as np
import pytest

import clrt
from clrt.base.resources import validation_module
from clrt.flatten.camera import flatten_camera
from clrt.flatten.flatten import flatten
from clrt.scene.scene import read_scene

extreme = validation_module("hostile.extreme")


@pytest.mark.parametrize("seed", range(3))
def test_extreme_numbers_make_no_foreign_warnings(seed: int) -> None:
    generator = np.random.default_rng(seed)
    accepted = 0
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        warnings.simplefilter("ignore", clrt.ClrtWarning)
        for number in range(250):
            table = extreme.calm(extreme.extreme_scene(generator), generator)
            try:
                scene = read_scene(table)
                flatten(scene)
                assert scene.camera is not None
                flatten_camera(scene.camera)
                accepted += 1
                if accepted % 25 == 0 and scene.spectrum is None:
                    clrt.render(scene)
            except clrt.ClrtError:
                continue
            except RuntimeWarning as warning:
                raise AssertionError(f"seed {seed}, scene {number}: {warning}") from warning
    assert accepted > 20


@pytest.mark.parametrize(("camera", "most"), [
    ({"fov": 45.0}, "9.66e+12"), ({"type": "orthographic", "size": 1e18}, "8"),
    ({"fov": 90.0, "fov_axis": "vertical"}, "4e+12"),
])  # fmt: skip
def test_shifts_that_no_ray_can_follow_are_refused(camera: dict[str, Any], most: str) -> None:
    """Camera rays were no numbers, and the picture was the background."""
    plain = {"origin": [0, 0, 5], "target": [0, 0, 0], "width": 8, "height": 8, **camera}
    clrt.load_dict({"camera": {**plain, "shift": [7, -7]}})
    with pytest.raises(clrt.SceneError) as raised:
        clrt.load_dict({"camera": {**plain, "shift": [0, 1e21]}})
    text = f"(0.0, 1e+21) is not allowed; too far aside for float32; at most {most} pixels"
    assert str(raised.value) == f"camera.shift: {text}"


def test_a_time_is_no_number_of_a_scene() -> None:
    with pytest.raises(clrt.SceneError, match="a time or a date cannot be part of a scene; give a number"):
        clrt.load_dict({"max_depth": np.timedelta64(5, "ns")})
