"""Boxes of primitives, against points sampled on each shape in float64."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from clrt import layout
from clrt.flatten.geometry import padded
from flatten_samples import NOT_TIGHT, SHAPES, clipped, flat, gradient, place, value


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("name", SHAPES)
def test_boxes_hold_every_point_of_their_shape_and_little_else(name: str, seed: int) -> None:
    scene, points, _ = place(name, seed)
    low, high = (scene.boxes[0][side][:3].astype(float) for side in ("low", "high"))
    assert (points >= low).all() and (points <= high).all()
    if (
        seed == 0 or name not in NOT_TIGHT
    ):  # a box smaller by 1 % on any side would lose points, so the check above can fail
        slack = 0.01 * (high - low) + 1e-6 * np.abs(points).max()
        assert (points.min(axis=0) <= low + slack).all() and (points.max(axis=0) >= high - slack).all()


@pytest.mark.parametrize("name", ["thin cylinder", "cone"])
def test_boxes_have_room_for_where_rounding_moves_hits(name: str) -> None:
    """Points on which F vanishes but for rounding, within the clip."""
    scene, points, _ = place(name, 3)
    record = scene.quadrics[0]
    slope = gradient(record, points)
    length = np.linalg.norm(slope, axis=1, keepdims=True)
    size = np.abs(points).max()
    steps = size * np.logspace(-7, -2, 40)
    lost = 0
    for step in steps:
        moved = points + step * slope / length
        form, terms = value(record, moved)
        kept = (np.abs(form) <= 8 * 2.0**-24 * terms) & clipped(record, moved, 0.0)
        low, high = (scene.boxes[0][side][:3].astype(float) for side in ("low", "high"))
        assert (moved[kept] >= low).all() and (moved[kept] <= high).all()
        tight_low, tight_high = points.min(axis=0), points.max(axis=0)
        pad = layout.QUADRIC_PAD * size
        lost += int(((moved[kept] < tight_low - pad) | (moved[kept] > tight_high + pad)).any(axis=1).sum())
    if name == "thin cylinder":  # a cone is written about its apex, where rounding is small
        assert lost > 0, "without that room some of them would be outside"


@pytest.mark.parametrize(
    "shape",
    [
        {"type": "sphere", "center": [0.1, 0.2, 1e6], "radius": 1e-3},
        {"type": "polygon", "points": [[0.1, 0, 1e4], [1.1, 0, 1e4], [0, 1.3, 1e4]]},
        {"type": "disk", "center": [0.1, 1e5, 0.3], "normal": [0, 1, 0], "radius": 0.1},
    ],
)
def test_boxes_are_padded_by_what_their_coordinates_are_worth_in_float32(shape: dict[str, Any]) -> None:
    scene, _ = flat(shape)
    low, high = (scene.boxes[0][side][:3].astype(float) for side in ("low", "high"))
    largest = np.maximum(np.abs(low), np.abs(high)).max()
    assert (high - low >= 2 * 0.99 * layout.PAD * largest).all()
    axis = int(np.argmax(np.abs(low)))
    rounded = 4 * 2.0**-23 * largest
    assert high[axis] - low[axis] <= 2 * layout.PAD * largest + rounded + 2.1 * shape.get("radius", 0.0)


def test_bent_polygons_get_thicker_boxes() -> None:
    points = [[0, 0, 0], [1, 0, 5e-5], [1, 1, 0], [0, 1, 5e-5]]
    scene, _ = flat({"type": "polygon", "points": points})
    low, high = scene.boxes[0]["low"][2], scene.boxes[0]["high"][2]
    assert low < -4e-5 and high > 9e-5


def test_boxes_are_rounded_outwards_and_by_one_step_at_most() -> None:
    rng = np.random.default_rng(5)
    low = rng.normal(size=(100_000, 3)) * 10 ** rng.uniform(-6, 6, (100_000, 1))
    high = low + rng.random(size=low.shape) * np.abs(low)
    boxes = padded(low, high, 0.0)
    least, most = boxes.records["low"][:, :3], boxes.records["high"][:, :3]
    assert (least <= low).all() and (most >= high).all() and boxes.bounded.all()
    assert (np.nextafter(least, np.float32(np.inf)) > low).all()
    assert (np.nextafter(most, np.float32(-np.inf)) < high).all()
    exact = padded(np.array([[-1.0, 0.0, 0.5]]), np.array([[1.0, 0.0, 2.0]]), 0.0).records
    assert exact["low"].tolist() == [[-1, 0, 0.5, 0]] and exact["high"].tolist() == [[1, 0, 2, 0]]
