"""Tinted feelers through more panes than a way through the tree finds: the bits of a search one by one."""

from __future__ import annotations

import time
from typing import Any

import pytest

import clrt
from clrt import layout
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


@pytest.mark.filterwarnings("ignore:.*transmits but encloses nothing")
@pytest.mark.parametrize(
    ("count", "kind"), [(4000, "disk"), (5000, "disk"), (30_000, "disk"), (2000, "sphere"), (2400, "sphere")]
)
def test_a_feeler_that_crosses_too_many_is_refused(count: int, kind: str) -> None:
    """Or finds its way through, and costs little either way: each is looked for among all at its place."""
    shape = {"type": kind, "center": [0, 3, 0], "radius": 1, "material": "glass0"}
    shape |= {"normal": [0, 1, 0]} if kind == "disk" else {}
    floor = {"type": "plane", "point": [0, 0, 0], "normal": [0, 1, 0]}
    few = clrt.load_dict({
        "camera": {"origin": [0, 1, -5], "target": [0, 0, 0], "width": 12, "height": 9}, "max_depth": 0,
        "shadow": "tinted", "materials": MATERIALS, "lights": [{"type": "point", "position": [0, 9, 0]}],
        "shapes": [floor, shape],
    })  # fmt: skip
    with clrt.Tracer(few) as tracer:
        right = tracer.render().hash  # kernels are compiled
        tracer.update(few.replace({"shapes": [floor, *[shape] * count]}))
        begin = time.process_time()
        if count * (2 if kind == "sphere" else 1) < layout.PANES:
            tracer.render()
        else:
            with pytest.raises(clrt.LimitError, match="a feeler crosses more than 4,096 surfaces"):
                tracer.render()
        assert time.process_time() - begin < 4
        tracer.update(few)
        assert tracer.render().hash == right  # nothing of it is left


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
