"""Media: what fills what, which of them holds where they overlap, and how they swallow light."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from .parts import LIGHTS, OPAQUE, WIDTH, Table, room, with_material

HIDDEN, INSIDE, WITHIN = "invisible boundary", "camera in glass", "surface in a medium"
_CLEAR: Table = {"diffuse": 0.0, "fresnel": True}
_GLASS: Table = {**_CLEAR, "ior": 1.5, "absorption": [0.25, 0.08, 0.15]}
_WATER: Table = {**_CLEAR, "ior": 1.333, "absorption": [0.35, 0.1, 0.05], "priority": 1}
_ICE: Table = {**_CLEAR, "ior": 1.2, "color": 0.4, "diffuse": 0.1, "priority": 2}
_AIR: Table = {**_CLEAR, "ior": 1.0, "priority": 3}
_CONSTANT: Table = {"color": 0.3, "diffuse": 0.1, "transmission": 0.8, "reflection": 0.1}


def scenes() -> Iterator[tuple[str, Table, set[str]]]:
    """Name, scene and what nobody can see from the scene's tables."""
    yield "absorption", room(_absorbing()), set()
    yield "absorption by pieces", _pieces(), {HIDDEN}
    yield "absorption and least weight", room(_absorbing(), min_weight=0.15), set()
    yield "water in a glass", _tumbler(), {HIDDEN, WITHIN}
    yield "ice in water in a glass", room(_nested(1.9)), set()
    yield "the stronger medium", room(_overlapping(1, 0)), set()
    yield "the other stronger medium", room(_overlapping(0, 1)), set()
    yield "the medium entered last", room(_overlapping(0, 0)), set()
    yield "constant media", room(_overlapping(0, 1, _CONSTANT)), set()
    yield "hidden media", room(_hidden()), {HIDDEN}
    yield "media that differ by their pattern", room(_checkered()), set()
    yield "bubbles in glass", room(_bubbles()), set()
    yield "things in water", _aquarium(), {WITHIN}
    yield "ambient rays in water", _aquarium(ambient_samples=2, max_depth=2, lights=LIGHTS[:1]), {WITHIN}
    yield "camera under water", _under_water(), {INSIDE, WITHIN}
    yield "camera in nested media", _at_the_middle(), {INSIDE}
    yield "rays start in several media", _cut_open(), {INSIDE, HIDDEN}
    yield "medium around", room(_nested(1.7), medium_ior=1.1), set()


def _ball(radius: float, material: Table, x: float = 0.0, y: float = 0.0, z: float = 0.0) -> Table:
    return {"type": "sphere", "center": [x, y, z], "radius": radius, "material": material}


def _box(low: list[float], high: list[float], material: Table, **more: Any) -> Table:
    return {"type": "box", "min": low, "max": high, "material": material, **more}


def _checkered() -> list[Table]:
    """A ball in a ball that differs in the size of its squares alone: it is no part of that."""
    more = {**_CONSTANT, "diffuse": 0.4, "transmission": 0.5}
    pattern = {"type": "checker", "colors": [0.9, 0.2]}
    outer, inner = ({**more, "color": {**pattern, "divisions": divisions}} for divisions in (16, 6))
    return [_ball(1.9, outer), _ball(1.0, inner, 0.2)]


def _absorbing() -> list[Table]:
    """Glass of three colours, straight and with constant coefficients; one absorbs much."""
    turned = {"transform": [{"rotate": [[0.3, 1, 0.1], 40.0]}, {"translate": [-1.9, 0.1, 0.4]}]}
    return [
        _box([-0.9, -0.8, -0.3], [0.9, 0.8, 0.3], {**_CLEAR, "absorption": [1.1, 0.3, 0.05]}, **turned),
        _ball(1.0, {**_CONSTANT, "absorption": [0.02, 0.5, 0.7]}, 0.3, -0.9, 0.8),
        _ball(0.8, {**_CLEAR, "ior": "water", "absorption": 4.0}, 1.9, 0.9),
    ]


def _pieces() -> Table:
    """A bar of one material made of three that overlap: their boundaries inside it cannot be seen.

    No two sides coincide: which of them is met first is a rule of ours that Mitsuba does not have.
    """
    bar: Table = {**_CONSTANT, "specular": 0.4, "shininess": 20, "absorption": [0.1, 0.3, 0.6]}
    left = _box([-2.4, -0.6, -0.4], [-0.2, 0.5, 0.5], bar)
    shapes = [left, _box([-0.9, -0.55, -0.35], [1.2, 0.45, 0.45], bar), _ball(0.9, bar, 1.4)]
    return room(shapes, max_depth=2)


def _tumbler() -> Table:
    """The water reaches a little into the glass, which is stronger; a straw stands in it."""
    glass = {**_GLASS, "priority": 3, "ior": 1.45}

    def upright(low: float, high: float, radius: float, material: Table) -> Table:
        return {"type": "cylinder", "p0": [0.1, low, 0.2], "p1": [0.1, high, 0.2], "radius": radius,
                "caps": True, "material": material}  # fmt: skip

    straw = {"type": "cylinder", "p0": [-0.5, -1.6, 0.3], "p1": [1.3, 2.1, -0.1], "radius": 0.13,
             "caps": True, "material": {"color": [0.8, 0.4, 0.3], "diffuse": 0.8}}  # fmt: skip
    hollow = {**_AIR, "priority": 4}
    shapes = [upright(-1.9, 1.6, 1.5, glass), upright(-1.6, 1.61, 1.3, hollow),
              upright(-1.65, 0.7, 1.35, {**_WATER, "priority": 5}), straw]  # fmt: skip
    # the water ends within the glass wall only where it is stronger than the glass; below it is not
    weaker = upright(-1.7, -1.2, 1.4, {**_WATER, "priority": 2, "absorption": [0.1, 0.4, 0.2]})
    return room([*shapes, weaker], max_depth=5, lights=LIGHTS[:1])


def _nested(size: float) -> list[Table]:
    return [_ball(size, _GLASS), _ball(0.8 * size, _WATER, 0.05),
            _box([-0.3 * size] * 3, [0.35 * size] * 3, _ICE, transform=[{"rotate": [[1, 0.4, 0.3], 30.0]}])]


def _overlapping(first: int, second: int, base: Table = _CLEAR) -> list[Table]:
    red = {**base, "ior": 1.5, "absorption": [0.05, 0.4, 0.6], "priority": first}
    blue = {**base, "ior": 1.2, "absorption": [0.6, 0.3, 0.05], "priority": second}
    return [_ball(1.5, red, -0.8, 0.1), _ball(1.4, blue, 0.9, -0.2, 0.3)]


def _hidden() -> list[Table]:
    """Weaker media wholly inside a stronger one, whose surfaces would shine if they were there."""
    shining = {**_ICE, "specular": 0.5, "emission": 0.3, "priority": -1}
    inside = [_ball(0.6, shining, -0.6), _ball(0.5, {**shining, "ior": 2.0}, 0.7, 0.3)]
    return [_ball(1.9, {**_GLASS, "absorption": [0.1, 0.2, 0.05]}), *inside]


def _bubbles() -> list[Table]:
    block = _box([-2.2, -1.4, -0.9], [2.2, 1.5, 0.9], {**_GLASS, "ior": 1.6},
                 transform=[{"rotate": [[0.2, 1, 0], 25.0]}])  # fmt: skip
    return [block, _ball(0.6, _AIR, -0.9, 0.2), _ball(0.45, _AIR, 0.3, -0.5, 0.2),
            _ball(0.55, {**_CONSTANT, "ior": 1.0, "priority": 1}, 1.1, 0.5)]  # fmt: skip


def _things() -> list[Table]:
    """What is no medium has the one around it on its outside."""
    coated = {"color": [0.5, 0.4, 0.3], "diffuse": 0.5, "fresnel": True, "ior": 1.9, "transmission": 0.0}
    sheet: Table = {"type": "disk", "center": [0.1, 0.2, 0.9], "normal": [0.5, 0.2, 1], "radius": 0.8,
                    "material": {**_CLEAR, "color": 0.3, "diffuse": 0.1, "thin": True, "ior": 1.7}}
    return [_ball(0.7, coated, -1.3, -0.5), _ball(0.6, OPAQUE["mirror"], 1.4, -0.6, 0.2), sheet,
            _ball(0.5, {**_CLEAR, "ior": 1.5, "priority": 2}, 0.3, -0.9, 1.0)]  # fmt: skip


def _aquarium(**changes: Any) -> Table:
    tank = _box([-2.3, -1.5, -1.0], [2.3, 1.4, 1.8], {**_WATER, "absorption": [0.3, 0.12, 0.08]})
    return room([tank, *_things()], **{"max_depth": 3, **changes})


def _under_water() -> Table:
    surface = {"type": "plane", "point": [0, 2.2, 0], "normal": [0.02, 1, 0.05],
               "material": {**_WATER, "priority": 0, "absorption": [0.09, 0.03, 0.02]}}  # fmt: skip
    return room([surface, *_things()], max_depth=3)


def _at_the_middle() -> Table:
    """Each direction leaves ice, water and glass through other boundaries."""
    camera = {"origin": [0.1, 0.05, 0.1], "target": [-0.4, 0.1, -1.0], "fov": 70, "width": WIDTH,
              "height": 120}  # fmt: skip
    return room(_nested(2.2), camera=camera, lights=LIGHTS[:1])


def _cut_open() -> Table:
    """Parallel rays that start on a plane through overlapping media, along whose sides they run.

    Each has a list of its own, and none starts so near a surface that its distance is rounding.
    """
    camera = {"origin": [0, 0, 6], "target": [0, 0, 0], "type": "orthographic", "size": 5.0, "near": 6.05,
              "width": WIDTH, "height": 120}  # fmt: skip
    rod = {"type": "cylinder", "p0": [-1.6, 0.7, -1.05], "p1": [-1.6, 0.7, 0.85], "radius": 0.75,
           "caps": True}
    corners = [[0.9, -1.5], [2.2, -0.8], [1.3, 1.4]]
    wedge = {"type": "mesh", "vertices": [[x, y, z] for z in (-0.9, 0.7) for x, y in corners],
             "faces": [[2, 1, 0], [3, 4, 5], [0, 1, 4, 3], [1, 2, 5, 4], [2, 0, 3, 5]]}  # fmt: skip
    ice = {**_ICE, "absorption": [0.1, 0.1, 0.5]}
    return room([_box([-1.9, -1.6, -1.2], [1.8, 1.2, 1.5], _GLASS),
                 _box([-1.3, -1.2, -1.1], [1.2, 0.8, 1], _WATER),
                 with_material(rod, {**_GLASS, "ior": 1.2, "priority": 4}), with_material(wedge, ice),
                 _box([-0.6, -0.9, -0.5], [0.2, 0.1, 0.6], _AIR)], camera=camera, max_depth=3)  # fmt: skip
