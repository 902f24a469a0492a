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


GREY = {"color": 0.5, "diffuse": 0.5, "reflection": 0.5}


def paned(count: int, radius: float, **keys: Any) -> clrt.Scene:
    """A light above so many panes of glass at one place, with an opaque one behind them; walls that are
    mirrors, so that tiles get there at different times."""
    clear = {"diffuse": 0, "transmission": 1, "thin": True}
    pane = {"type": "disk", "center": [0, 8.5, 0], "radius": radius, "normal": [0, 1, 0], "material": clear}
    stop = {**pane, "center": [0, 8.6, 0], "material": {"color": 0}}
    walls = [[[-9, y, z], [9, y, z], [9, top, back], [-9, top, back]]
             for y, z, top, back in ((2.5, -9, 2.5, -6), (0.05, -5.5, 0.9, -5.5))]  # fmt: skip
    return clrt.load_dict({
        "camera": {"origin": [0, 1, -5], "target": [0, 1, 0], "width": 64, "height": 48, "fov": 60},
        "max_depth": 4, "shadow": "tinted", "materials": MATERIALS,
        "lights": [{"type": "point", "position": [0, 9, 0]}],
        "shapes": [
            {"type": "plane", "point": [0, 0, 0], "normal": [0, 1, 0], "material": GREY},
            *[pane] * count, stop,
            *({"type": "polygon", "points": points, "material": GREY} for points in walls),
        ], **keys,
    })  # fmt: skip


@pytest.mark.filterwarnings("ignore:.*transmits but encloses nothing")
def test_what_is_refused_of_a_picture_is_refused_of_no_other() -> None:
    """One within `progress`, the next one, and the one around it: each is known by itself."""
    sky = {"origin": [0, 1, -5], "target": [0, 5, -9], "width": 4, "height": 4}
    with clrt.Tracer(paned(4300, 0.02), settings=clrt.Settings(tile=64 * 9)) as tracer:
        right = tracer.render(camera=sky).hash
        shown = []

        def show(*_: Any) -> None:
            try:
                shown.append(tracer.render(camera=sky).hash)
            except clrt.LimitError as error:
                shown.append(error)

        for _ in range(3):
            with pytest.raises(clrt.LimitError, match="a feeler crosses more than 4,096 surfaces"):
                tracer.render(progress=show)
            assert tracer.render(camera=sky).hash == right
        assert set(shown) == {right}


@pytest.mark.filterwarnings("ignore:.*transmits but encloses nothing")
def test_after_an_explanation_that_is_refused_pictures_are_right() -> None:
    few = paned(0, 1)
    with clrt.Tracer(few) as tracer:
        right = tracer.render().hash
        tracer.update(paned(5000, 3, ambient=0.5, ambient_samples=60_000))
        with pytest.raises(clrt.LimitError, match="has more than"):
            tracer.explain(32, 47)
        tracer.update(few)
        assert tracer.render().hash == right


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
