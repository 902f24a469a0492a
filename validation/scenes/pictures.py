"""Pictures on surfaces."""

from __future__ import annotations

from collections.abc import Iterator

from .parts import CLOSED, OPEN, Table, room, with_material

_GLOBE: Table = {"color": {"type": "image", "file": "globe.png"}, "diffuse": 0.8}
_TILES: Table = {
    "color": {"type": "image", "file": "tiles.png", "scale": [0.4, 0.4], "offset": [0.1, 0.3]},
    "normal_map": {"file": "tile-normals.png", "scale": 0.5}, "diffuse": 0.8,
}  # fmt: skip
_LAMP: Table = {
    "color": 0.5, "emission": {"type": "image", "file": "globe.png", "tint": [0.6, 0.5, 0.2]}, "diffuse": 0.6,
    "specular": 0.4, "shininess": 20.0,
    "highlight_color": {"type": "image", "file": "tiles.png", "encoding": "linear", "scale": [2.0, -2.0]},
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
    shapes = [_tile(-1.5, _LAMP), _tile(1.5, {**_TILES, "color": {**_TILES["color"], "filter": "nearest"}}),
              with_material(CLOSED["sphere"]((0.2, 1.6, 0.0), 0.7), _GLOBE)]  # fmt: skip
    yield "picture on a mesh", room(shapes), set()
    yield "picture in bands", {**room(shapes), "spectrum": {"bands": 6}}, set()
    gathered = [with_material(CLOSED["sphere"]((0.2, -0.3, 0), 1.6), {**_GLOBE, "ambient": 0.9})]
    yield "picture and ambient rays", room(gathered, ambient_samples=3, max_depth=2), set()
    placed: Table = {"file": "tile-normals.png", "scale": 0.6,
                     "placement": {"scale": [0.7, -0.5], "offset": [0.2, 0.6], "wrap": "mirror"}}  # fmt: skip
    painted = (_GLOBE, {**_GLOBE, "normal_map": placed}, {**_WOOD, "reflection": 0.0}, _LAMP, _GLOBE)
    names = ("disk", "polygon", "cone", "paraboloid", "clipped quadric")
    places = ((-1.5, 0.8, 0.2), (1.5, 0.7, 0.2), (-0.1, 0.6, 0.4), (-1.0, -1.1, 0.5), (1.2, -1.1, 0.5))
    open_ones = [with_material(OPEN[name](at, 0.9), material)
                 for name, at, material in zip(names, places, painted, strict=True)]  # fmt: skip
    yield "pictures on open shapes", room(open_ones), set()
    yield "normals on sheared shapes", room(_sheared({**_GLOBE, "normal_map": placed})), set()
    yield "colours of vertices", room([_stone("vertices")]), set()
    yield "colours of faces", room([_stone("faces")]), set()


def _sheared(material: Table) -> list[Table]:
    """Under transforms that shear, what is a slope in v and what is its gradient go apart: with one for the
    other a normal map was turned over about a quadric's poles, and in the float64 oracle on cones."""
    shapes: tuple[Table, ...] = (
        {"type": "quadric", "coefficients": [1, 1, 1, 0, 0, 0, 0, 0, 0, -1]},
        {"type": "ellipsoid", "center": [0, 0, 0], "radii": [1, 0.9, 1.1]},
        {"type": "cone", "p0": [0, -0.3, 0], "r0": 1.3, "p1": [0, 0.3, 0], "r1": 0},
        {"type": "paraboloid", "apex": [0, 0.4, 0], "axis": [0, -1, 0], "focal": 0.5, "height": 0.8},
    )
    places = ((-1.3, 1.0, 0.2), (1.3, 1.0, 0.2), (-1.2, -1.1, 0.5), (1.3, -1.1, 0.5))
    steps = [{"rotate": ["x", 40]}, {"scale": [1, 0.5, 1]}, {"rotate": ["y", 20]}]
    return [{**shape, "material": material, "transform": [*steps, {"translate": list(place)}]}
            for shape, place in zip(shapes, places, strict=True)]  # fmt: skip


def at_levels() -> Iterator[tuple[str, Table, set[str]]]:
    """Mip levels, on quadrics apart."""
    fine: Table = {"filter": "mipmap", "scale": [2.5, 2.5]}
    globe: Table = {"color": {**_GLOBE["color"], **fine, "wrap": "mirror"}, "diffuse": 0.8}
    tiles: Table = {**_TILES, "color": {**_TILES["color"], "filter": "mipmap"}}
    mirror: Table = {"color": 0.1, "diffuse": 0.3, "reflection": 0.7,
                     "reflection_color": {"type": "image", "file": "tiles.png", **fine}}  # fmt: skip
    glass: Table = {"diffuse": 0.05, "transmission": 0.9, "ior": 1.3,
                    "transmission_color": {"type": "image", "file": "wood.png", **fine}}  # fmt: skip
    wood: Table = {"color": {"type": "image", "file": "wood.png", **fine, "wrap": "clamp"}, "diffuse": 0.8}
    floor = {"type": "plane", "point": [0, -1.9, 0], "normal": [0, 1, 0.05], "material": tiles}
    shapes = [floor, with_material(CLOSED["sphere"]((-1.4, 0.7, 0.2), 0.8), globe),
              with_material(CLOSED["turned ellipsoid"]((0.0, 1.5, -0.4), 0.8), wood),
              with_material(CLOSED["capped cylinder"]((1.4, -0.8, 0.6), 0.8), mirror),
              with_material(CLOSED["box"]((-0.2, -0.9, 0.8), 0.8), glass),
              _tile(-1.6, {"color": {**_WOOD["color"], "filter": "mipmap"}, "diffuse": 0.9})]  # fmt: skip
    yield "pictures at their levels", room(shapes), set()
    quadric = with_material(CLOSED["quadric"]((0.3, -0.2, 0.0), 1.8), globe)
    yield "a picture at its levels on a quadric", room([quadric]), set()


def _stone(kind: str) -> Table:
    """A body with colours at its vertices, or on its faces."""
    file = f"stone-{kind}.ply"
    color = {"type": "image", "file": file, "part": 0, "wrap": "clamp"}
    turned = [{"scale": 1.7}, {"rotate": ["y", 25]}, {"rotate": ["x", 20]}, {"translate": [0, -0.2, 0]}]
    mesh: Table = {"type": "mesh", "file": file, "part": 0, "transform": turned}
    return with_material(mesh, {"color": color, "diffuse": 0.8})


def _tile(x: float, material: Table) -> Table:
    """A leaning square of two triangles, of which one shows the picture mirrored."""
    corners = [[x - 1.2, -1.3, 1.0], [x + 1.2, -1.3, 1.2], [x + 1.2, 0.9, 0.0], [x - 1.2, 0.9, -0.2]]
    uv = [[0.1, 0.9], [1.3, 0.8], [1.2, -0.3], [0.6, 1.9]]
    mesh: Table = {"type": "mesh", "vertices": corners, "faces": [[0, 1, 2], [0, 2, 3]], "uv": uv}
    return with_material(mesh, material)
