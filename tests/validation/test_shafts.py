"""Feelers to lights with extent that meet what stands between alone: the bits of a search without a tree."""

from __future__ import annotations

from typing import Any

import msgspec
import pytest

import clrt
from clrt.device.device import Device
from clrt.flatten.flatten import flatten
from validation.twin.compare import compare_picture
from validation.twin.scenes import scenes

SCENES = scenes()
LIGHTS: list[dict[str, Any]] = [
    {"type": "rectangle", "center": [0.2, 1.6, 0.6], "u": [0.7, 0, 0.2], "v": [0.1, 0.2, 0.6], "samples": 16},
    {"type": "disk", "center": [-2, 0.6, 1], "normal": [2, 0, -1], "radius": 0.4, "samples": 9,
     "visible": False},
    {"type": "sphere", "center": [1.5, 0.9, 1.7], "radius": 0.3, "radiance": [3, 4, 5], "samples": 5},
    {"type": "point", "position": [2, 3, 4]},
]  # fmt: skip


@pytest.mark.parametrize("shadow", ["opaque", "tinted"])
@pytest.mark.parametrize("name", ["flat shapes", "quadrics", "meshes", "tinted shadows", "one-sided"])
def test_shafts_leave_out_nothing_that_a_feeler_meets(name: str, shadow: str) -> None:
    shapes = SCENES[name][0]
    lit = clrt.load_dict({"lights": LIGHTS, "max_depth": 2})
    scene = msgspec.structs.replace(shapes, lights=lit.lights, max_depth=2, shadow=shadow)
    found = compare_picture(Device(), scene, flatten(scene), width=36)
    assert found.difference is None, str(found.difference)
    assert found.rays > 5000
