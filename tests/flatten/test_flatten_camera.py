"""The camera record: unit vectors, half extents, overrides."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from clrt.base.errors import SceneError
from clrt.flatten.flatten import flatten_camera
from clrt.scene.scene import Camera

ROW_15: dict[str, Any] = {
    "origin": (1.0, 2.0, 3.0),
    "target": (4.0, 0.0, -1.0),
    "fov": 50.0,
    "width": 640,
    "height": 360,
}


def direction(record: np.ndarray, x: float, y: float) -> np.ndarray:
    """Where pixel (x, y) of the record looks, as the model says it."""
    c = {name: record[name][0].astype(np.float64) for name in record.dtype.names}
    across = 2 * (x + 0.5 + c["shift_x"]) / c["width"] - 1
    along = 1 - 2 * (y + 0.5 + c["shift_y"]) / c["height"]
    d = c["forward"] + across * c["half_width"] * c["right"] + along * c["half_height"] * c["up"]
    return np.asarray(d[:3] / np.linalg.norm(d))


def test_the_model_s_camera_ray() -> None:
    record = flatten_camera(Camera(**ROW_15))
    assert record.shape == (1,)
    np.testing.assert_allclose(
        direction(record, 100, 50), [0.321777233, -0.183906196, -0.928783034], atol=1e-7
    )
    assert record["origin"][0].tolist() == [1, 2, 3, 0]


def test_a_vertical_fov_swaps_the_factors() -> None:
    half = math.tan(math.radians(25.0))
    wide, tall = (flatten_camera(Camera(**ROW_15, fov_axis=axis))[0] for axis in ("horizontal", "vertical"))
    assert wide["half_width"] == np.float32(half) and wide["half_height"] == np.float32(half * 360 / 640)
    assert tall["half_height"] == np.float32(half) and tall["half_width"] == np.float32(half * 640 / 360)


def test_orthographic_extents_are_world_units() -> None:
    record = flatten_camera(Camera(**ROW_15, type="orthographic", size=8.0, near=0.5))[0]
    assert (record["half_width"], record["half_height"]) == (4.0, 2.25)
    assert record["orthographic"] == 1 and record["near"] == 0.5
    upright = flatten_camera(Camera(**ROW_15, type="orthographic", size=9.0, fov_axis="vertical"))[0]
    assert (upright["half_width"], upright["half_height"]) == (8.0, 4.5)


def test_mirror_negates_right_only() -> None:
    plain, mirrored = (flatten_camera(Camera(**ROW_15, mirror=mirror))[0] for mirror in (False, True))
    np.testing.assert_array_equal(mirrored["right"], -plain["right"])
    for name in ("forward", "up", "origin"):
        np.testing.assert_array_equal(mirrored[name], plain[name])
    np.testing.assert_allclose(np.cross(plain["right"][:3], plain["forward"][:3]), plain["up"][:3], atol=1e-7)


def test_up_falls_back_to_z_only_where_it_is_not_given() -> None:
    down = {"origin": (0.0, 5.0, 0.0), "target": (0.0, 0.0, 0.0)}
    record = flatten_camera(Camera(**down))[0]
    assert record["up"].tolist() == [0, 0, 1, 0] and record["right"].tolist() == [-1, 0, 0, 0]
    with pytest.raises(SceneError, match=r"camera\.up: .*parallel"):
        flatten_camera(Camera(**down, up=(0.0, 1.0, 0.0)))


def test_one_side_alone_keeps_the_aspect_ratio() -> None:
    def size(**given: Any) -> tuple[int, int]:
        record = flatten_camera(Camera(**ROW_15), **given)[0]
        return int(record["width"]), int(record["height"])

    assert size() == (640, 360)
    assert size(width=320) == (320, 180)
    assert size(height=100) == (178, 100)
    assert size(width=1) == (1, 1)
    assert size(width=64, height=64) == (64, 64)
    square = flatten_camera(Camera(**ROW_15), width=64, height=64)[0]
    assert square["half_width"] == square["half_height"]
    for wrong in ({"width": 0}, {"height": -3}, {"width": 1 << 31}):
        with pytest.raises(SceneError, match="pixel"):
            size(**wrong)


def test_samples_form_a_square_grid() -> None:
    assert flatten_camera(Camera(**ROW_15, spp=16))["grid"][0] == 4
    assert flatten_camera(Camera(**ROW_15, spp=16), spp=9)["grid"][0] == 3
    with pytest.raises(SceneError, match=r"spp: 5 .* 4 or 9"):
        flatten_camera(Camera(**ROW_15), spp=5)
    with pytest.raises(SceneError, match="spp: 0 "):
        flatten_camera(Camera(**ROW_15), spp=0)


def test_jitter_is_a_seed_or_absent() -> None:
    plain = flatten_camera(Camera(**ROW_15))[0]
    assert (plain["jitter"], plain["seed"]) == (0, 0)
    zero = flatten_camera(Camera(**ROW_15, jitter=0))[0]
    assert (zero["jitter"], zero["seed"]) == (1, 0)
    large = flatten_camera(Camera(**ROW_15, jitter=4294967295, shift=(-0.5, 0.25)))[0]
    assert (large["jitter"], large["seed"]) == (1, 4294967295)
    assert (large["shift_x"], large["shift_y"]) == (-0.5, 0.25)
    assert flatten_camera(Camera(**ROW_15, jitter=3), jitter=7)["seed"][0] == 7
