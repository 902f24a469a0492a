"""Meshes in coordinates of maps: told, with what mends it."""

from __future__ import annotations

import re
import warnings
from typing import Any

import numpy as np
import pytest

import clrt
from clrt.flatten.flatten import flatten

CORNERS = np.array([[0, 0, 0], [4, 0, 0], [0, 3, 0], [0, 0, 2]], float)
FACES = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]
MAP = np.array([431236.5, 200.0, -5423456.25])


def scene(offset: Any, size: float = 1.0, **more: Any) -> clrt.Scene:
    mesh = {"type": "mesh", "vertices": CORNERS * size + offset, "faces": FACES, **more}
    ball = {"type": "sphere", "center": [0, 0, 0], "radius": 1}
    return clrt.load_dict({"ambient": 1.0, "shapes": [ball, mesh]})


def test_a_mesh_that_rounding_deforms_is_told_with_its_mend() -> None:
    told = r"shapes\[1\]: its corners are rounded to 0\.5 of its 4 units"
    with pytest.warns(clrt.ClrtWarning, match=told) as found:
        flatten(scene(MAP))
    said = re.search(r"transform = \[\{ translate = \[(.*)\] \}\]", str(found[0].message))
    assert said
    moved = [{"translate": [float(part) for part in said[1].split(",")]}]
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        flatten(scene(MAP, transform=moved))


@pytest.mark.parametrize(("offset", "size"), [(0.0, 1.0), (0.0, 1e-6), (100.0, 1.0), (MAP, 1e4), (0.0, 1e9)])
def test_others_are_not(offset: Any, size: float) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        flatten(scene(offset, size))


@pytest.mark.parametrize(("size", "told"), [(500.0, True), (700.0, False)])
def test_as_many_steps_as_are_not_seen(size: float, told: bool) -> None:
    """2,000 units are 4,000 steps of 0.5 there, 2,800 are 5,600."""
    with warnings.catch_warnings(record=True) as found:
        warnings.simplefilter("always")
        flatten(scene(MAP, size))
    assert ["rounded to 0.5" in str(one.message) for one in found] == [True] * told
