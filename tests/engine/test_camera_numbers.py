"""Rows 41 to 43 of docs/model.md, "Numbers to test against": worked out, and in pictures."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import clrt

PAGE = (Path(__file__).parents[2] / "docs" / "model.md").read_text("utf-8")


def stated(number: int) -> list[float]:
    """The numbers of a row's last column."""
    (value,) = re.findall(rf"^\| {number} \|.*\| (.*) \|$", PAGE, re.M)
    return [float(word) for word in re.findall(r"-?\d*\.?\d+", value)]


def test_a_pixel_of_an_orthographic_camera() -> None:
    """Row 41: where its ray meets the plane through the target, across the view."""
    eye, target, up, size = np.array([1.0, 2, 3]), np.array([4.0, 0, -1]), np.array([0.0, 1, 0]), 5.0
    view = (target - eye) / np.linalg.norm(target - eye)
    right = np.cross(view, up) / np.linalg.norm(np.cross(view, up))
    across, upwards = size * (100.5 / 640 - 0.5), size * 360 / 640 * (0.5 - 50.5 / 360)
    place = target + across * right + upwards * np.cross(right, view)
    np.testing.assert_allclose(stated(41), place, atol=5e-7)
    camera = {"type": "orthographic", "origin": eye.tolist(), "target": target.tolist(), "size": size,
              "width": 640, "height": 360}  # fmt: skip
    shape = {"type": "plane", "point": target.tolist(), "normal": view.tolist()}
    image = clrt.render({"camera": camera, "ambient": 1.0, "shapes": [shape]}, crop=(100, 50, 101, 51),
                        layers=["position"])  # fmt: skip
    np.testing.assert_allclose(image.layers["position"][0, 0], place, atol=2e-6)


@pytest.mark.parametrize(("more", "samples"), [(-1e-5, 16), (1e-5, 4)])
def test_a_threshold_of_adaptive_samples(more: float, samples: int) -> None:
    """Row 42: two halves of one surface, each alone in its pixel, get more just below this threshold."""
    (differ,) = stated(42)
    assert differ == pytest.approx((0.4**0.5 - 0.25**0.5) ** 2, abs=5e-9)
    camera = {"type": "orthographic", "origin": [0, 0.5, 1], "target": [0, 0.5, 0], "size": 2, "width": 2,
              "height": 1, "spp": 4}  # fmt: skip
    sheet = {"type": "plane", "point": [0, 0, 0], "normal": [0, 0, 1], "material": {
        "color": {"type": "checker", "colors": [0.25, 0.4], "size": 1.0}, "diffuse": 1.0}}  # fmt: skip
    adaptive = {"spp": 16, "threshold": differ + more}
    scene = {"camera": camera, "ambient": 1.0, "shapes": [sheet], "adaptive": adaptive}
    image = clrt.render(scene, layers=["samples"])
    assert sorted(np.unique(image.pixels).tolist()) == pytest.approx([0.25, 0.4])
    assert image.layers["samples"].tolist() == [[samples, samples]]


@pytest.mark.parametrize(("kind", "row"), [("box", 0), ("tent", 1), ("mitchell", 2)])
@pytest.mark.parametrize("columns", [1, 2, 3])
def test_alpha_is_weighed_as_the_filter_weighs(kind: str, columns: int, row: int) -> None:
    """Row 43: a pixel of 4 x 4 samples, of which the first, two and three columns hit."""
    right = stated(43)[3 * row :][:3]
    reach = {"box": 0.5, "tent": 1.0, "mitchell": 2.0}[kind]
    edge = reach * (2 * columns / 4 - 1)  # in pixels, between two columns; one is as wide as the world's unit
    camera: dict[str, Any] = {
        "type": "orthographic", "origin": [0, 0, 1], "target": [0, 0, 0], "size": 1, "width": 1, "height": 1,
        "spp": 16, "filter": kind,
    }  # fmt: skip
    corners = [[-9, -9, 0], [edge, -9, 0], [edge, 9, 0], [-9, 9, 0]]
    scene = {"camera": camera, "ambient": 1.0, "shapes": [{"type": "polygon", "points": corners}]}
    alpha = clrt.render(scene, layers=["alpha"]).layers["alpha"]
    assert alpha.shape == (1, 1) and alpha[0, 0] == pytest.approx(right[columns - 1], abs=1e-6)
