"""Tinted feelers through more panes than a way through the tree finds: the bits of a search one by one."""

from __future__ import annotations

from typing import Any

import pytest

import clrt
from clrt.device.device import Device
from clrt.flatten.flatten import flatten
from validation.twin.compare import compare_picture

PANES = 70
"""Three ways of PANES (kernels/panes.clh), the last with a few."""
SHEETS: list[dict[str, Any]] = [
    {"type": "polygon", "material": f"glass{k % 7}",
     "points": [[-9, y, -9], [9, y, -9], [9, y, 9], [-9, y, 9]]}
    for k in range(PANES)
    for y in [1.0 + k % 3 / 64]  # each third at one place
]  # fmt: skip
TRIANGLES = [sheet | {"points": sheet["points"][:3]} for sheet in SHEETS]
BALLS: list[dict[str, Any]] = [
    {"type": "sphere", "center": [0, 3, 0], "radius": 0.5 + (k % 20) / 64, "material": f"glass{k % 7}"}
    for k in range(40)  # each place twice, each sphere crossed twice
]
MATERIALS = {
    f"glass{k}": {"transmission": 0.97, "transmission_color": [1, 0.97 + k / 300, 0.99], "diffuse": 0}
    for k in range(7)
}


@pytest.mark.parametrize("shapes", [SHEETS, TRIANGLES, BALLS], ids=["polygons", "triangles", "spheres"])
def test_panes_are_found_in_their_order(shapes: list[dict[str, Any]]) -> None:
    floor = {"type": "plane", "point": [0, 0, 0], "normal": [0, 1, 0]}
    lid = {"type": "disk", "center": [2, 3.9, 0], "normal": [0, 1, 0], "radius": 1.2}
    lights = [{"type": "point", "position": [1, 4, 0], "intensity": [9, 9, 9]},
              {"type": "sphere", "center": [0.2, 4.2, 0], "radius": 0.1, "samples": 2}]  # fmt: skip
    scene = clrt.load_dict({
        "camera": {"origin": [0, 0.8, -5], "target": [0, 0, 0]}, "max_depth": 0, "shadow": "tinted",
        "materials": MATERIALS, "shapes": [floor, lid, *shapes], "lights": lights,
    })  # fmt: skip
    found = compare_picture(Device(), scene, flatten(scene), width=12)
    assert found.difference is None, str(found.difference)
