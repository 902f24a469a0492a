"""Scenes that Mitsuba's own plugins can express, so that nobody here wrote the shading."""

from __future__ import annotations

from collections.abc import Iterator

from .parts import CLOSED, OPEN, Table, room, with_material

_POINT: Table = {"type": "point", "position": [-4, 6, 8]}
_LAMP: Table = {**_POINT, "intensity": [90, 80, 70], "falloff": "inverse-square"}
_SPOT: Table = {"type": "spot", "position": [-4, 5, 7], "target": [-0.5, 0, 0], "angle": 21, "penumbra": 0.6}
_SHARP: Table = {**_SPOT, "position": [5, 3, 8], "angle": 16, "penumbra": 0, "intensity": [50, 60, 70]}
_SUN: Table = {"type": "directional", "direction": [0.5, -0.8, -1], "intensity": [0.3, 0.35, 0.3]}
_SPOTS = [{**_SPOT, "intensity": [70, 60, 50]}, _SHARP]
_MIRROR: Table = {"diffuse": 0.0, "reflection": 0.85, "reflection_color": [1, 0.9, 0.7]}
_GLASS: Table = {"diffuse": 0.0, "fresnel": True, "ior": 1.5}
_SHEET: Table = {"diffuse": 0.0, "reflection": 0.3, "transmission": 0.7, "ior": 1.0}
_BODIES = {**CLOSED, **OPEN}
# what is not approximated there by triangles, or by a curved shape that is off by 1e-5 of a distance
EXACT = ("sphere", "turned sphere", "box", "mirrored box", "mesh", "mesh of polygons", "disk", "turned disk",
         "polygon",
         "mirrored polygon", "concave polygon", "polygon with a hole", "star polygon")  # fmt: skip


def scenes() -> Iterator[tuple[str, Table, str]]:
    """Name, scene and the stock configuration that expresses it."""
    yield "stock S1: lamp", _diffuse([_LAMP]), "S1"
    yield "stock S1: sun", _diffuse([_SUN, _LAMP]), "S1"
    lens = {"aperture": 0.03, "focus": 7.0, "spp": 4}
    yield "stock S1: lens", _diffuse([_LAMP], lens), "S1"
    for name in ("tent", "gaussian", "mitchell"):
        yield f"stock S1: {name}", _diffuse([_LAMP], {"spp": 9, "filter": name}), "S1"
    yield "stock S1: spots", _diffuse([{**spot, "falloff": "inverse-square"} for spot in _SPOTS]), "S1"
    faint = [{**spot, "intensity": [0.5, 0.45, 0.4]} for spot in _SPOTS]
    yield "stock S5: spots", _diffuse(faint), "S5"
    yield "stock S5", _diffuse([{**_POINT, "intensity": 0.7}, _SUN]), "S5"
    yield "stock S2", _mirrors(), "S2"
    yield "stock S4", _lobe(), "S4"
    yield "stock S6", _random([_SHEET, {**_SHEET, "thin": True, "ior": 1.4}, _MIRROR]), "S6"
    yield "stock S8", _random([_GLASS, {**_GLASS, "ior": 1.8}, {**_GLASS, "thin": True}]), "S8"
    yield "stock S3", _chains(), "S3"


def _matte(red: float, green: float, blue: float) -> Table:
    return {"color": [red, green, blue], "diffuse": 0.8, "ambient": 0.0}


def _stage(shapes: list[Table], lights: list[Table], camera: Table | None = None) -> Table:
    """The usual room without ambient light, which Mitsuba does not have."""
    table = room([], ambient=0.0, lights=lights)
    walls = [{**wall, "material": {**wall["material"], "ambient": 0.0}} for wall in table["shapes"]]
    return {**table, "camera": {**table["camera"], **(camera or {})}, "shapes": [*walls, *shapes]}


def _diffuse(lights: list[Table], camera: Table | None = None) -> Table:
    """Every primitive that Mitsuba itself has, to the precision of its numbers, side by side."""
    shapes = []
    for number, name in enumerate(EXACT):
        row, column = divmod(number, 5)
        at = (-2.6 + 1.3 * column, 1.5 - 1.4 * row, 0.3 * (number % 3))
        color = _matte(0.4 + 0.1 * row, 0.5, 0.7 - 0.1 * column)
        shapes.append(with_material(_BODIES[name](at, 0.55), color))
    return _stage(shapes, lights, camera)


def _mirrors() -> Table:
    names = ("sphere", "mesh", "box", "turned sphere", "mesh of polygons", "disk")
    shapes = [with_material(_BODIES[name]((-2.1 + 2.1 * (k % 3), 1.1 - 2.2 * (k // 3), 0.2), 0.75),
                            _MIRROR if k % 2 else _matte(0.6, 0.4, 0.3)) for k,
              name in enumerate(names)]  # fmt: skip
    return {**_stage(shapes, [_LAMP]), "max_depth": 4}


def _lobe() -> Table:
    """One ball with nothing but a highlight."""
    shine = {"diffuse": 0.0, "specular": 0.8, "shininess": 12, "highlight_color": [1, 0.8, 0.6]}
    ball = {"type": "sphere", "center": [0, 0, 0], "radius": 2.4, "material": shine}
    return {**room([], ambient=0.0, lights=[{**_SUN, "intensity": [0.9, 0.8, 0.7]}]), "shapes": [ball]}


def _random(clear: list[Table]) -> Table:
    names = ("sphere", "box", "polygon")
    shapes = [with_material(_BODIES[name]((-2.1 + 2.1 * k, 0, 0.4), 1.0), material)
              for k, (name, material) in enumerate(zip(names, clear, strict=True))]  # fmt: skip
    return {**_stage(shapes, [_LAMP]), "max_depth": 4}


def _chains() -> Table:
    """Glowing walls seen through glass and in mirrors."""
    glow = [{"type": "box", "min": [x, -2.4, -3], "max": [x + 1.6, 2.4, -2.6],
             "material": {"diffuse": 0.0, "emission": color}}
            for x,
            color in ((-3.9, [0.7, 0.5, 0.3]), (-0.8, [0.3, 0.6, 0.4]), (2.3, [0.3, 0.4, 0.7]))]  # fmt: skip
    ball = {"type": "sphere", "center": [-1.3, 0, 0.4], "radius": 1.3, "material": _GLASS}
    box = with_material(CLOSED["box"]((1.5, 0.1, 0.5), 1.3), {**_GLASS, "ior": 1.3})
    floor = {"type": "disk", "center": [0, -2.4, 0], "normal": [0, 1, 0], "radius": 6, "material": _MIRROR}
    return {**room([], ambient=0.0, lights=[]), "max_depth": 6, "shapes": [*glow, ball, box, floor]}
