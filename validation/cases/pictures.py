"""Pictures on surfaces, judged by the float64 oracle: Mitsuba's side does not translate them."""

from __future__ import annotations

from collections.abc import Iterator

from .parts import CLOSED, Table, room, with_material

_GLOBE: Table = {"color": {"type": "image", "file": "globe.png"}, "diffuse": 0.8}
_TILES: Table = {
    "color": {"type": "image", "file": "tiles.png", "scale": [0.4, 0.4], "offset": [0.1, 0.3]},
    "normal_map": {"file": "tile-normals.png", "scale": 0.5}, "diffuse": 0.8,
}  # fmt: skip
_WOOD: Table = {
    "color": {"type": "image", "file": "wood.png", "wrap": "mirror", "scale": [1.4, -0.7]}, "diffuse": 0.7,
    "reflection": 0.3, "reflection_color": {"type": "image", "file": "tiles.png", "wrap": "clamp"},
}  # fmt: skip


def scenes() -> Iterator[tuple[str, Table, set[str]]]:
    """Name, scene and what nobody can see from the scene's tables."""
    yield "picture on a sphere", room([with_material(CLOSED["sphere"]((0, -0.3, 0), 1.6), _GLOBE)]), set()
    floor = {"type": "plane", "point": [0, -1.2, 0], "normal": [0, 1, 0.1], "material": _TILES}
    yield "picture and normals on a floor", room([floor]), set()
    shapes = [with_material(CLOSED["box"]((-1.3, -0.3, 0.3), 1.1), _WOOD),
              with_material(CLOSED["capped cylinder"]((1.4, -0.2, 0.0), 1.1), _WOOD)]  # fmt: skip
    yield "picture on a box and a cylinder", room(shapes), set()
    gathered = [with_material(CLOSED["sphere"]((0.2, -0.3, 0), 1.6), {**_GLOBE, "ambient": 0.9})]
    yield "picture and ambient rays", room(gathered, ambient_samples=3, max_depth=2), set()
