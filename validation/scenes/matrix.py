"""Every primitive with every material, from outside and from inside, and planes as a room."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from .parts import (
    CHECKERED,
    CLEAR,
    CLOSED,
    HEIGHT,
    LIGHTS,
    OPAQUE,
    OPEN,
    WIDTH,
    Place,
    Primitive,
    Table,
    room,
    with_material,
)  # fmt: skip

_COLUMNS, _ROWS = (-2.1, 0.0, 2.1), (1.15, -1.15)
_DULL: Table = {"color": [0.4, 0.5, 0.4], "diffuse": 0.9}  # in place of a checker


def scenes() -> Iterator[tuple[str, Table, set[str]]]:
    """Name, scene and what nobody can see from the scene's tables."""
    for name, primitive in {**CLOSED, **OPEN}.items():
        yield f"opaque {name}", _grid(primitive, OPAQUE, name in CHECKERED), set()
        yield f"clear {name}", _grid(primitive, CLEAR, False), set()
    for name, primitive in CLOSED.items():
        yield f"inside {name}", _inside(name, primitive), {"from inside"}
        yield f"in glass {name}", _in_glass(name, primitive), {"from inside", "camera in glass"}
    yield "room of planes", _planes(), {"from inside"}


def _grid(primitive: Primitive, materials: dict[str, Table], checkered: bool) -> Table:
    """Six copies side by side, of a material each."""
    shapes = []
    for number, (name, material) in enumerate(materials.items()):
        at = (_COLUMNS[number % 3], _ROWS[number // 3], 0.2)
        shapes.append(with_material(primitive(at, 0.72),
                                    _DULL if name == "checker" and not checkered else material))
    return room(shapes)


def _view() -> Table:
    camera: Table = {"origin": [0.5, 0.2, 0.6], "target": [-0.4, -0.25, -1.0], "fov": 100}
    return {**camera, "width": WIDTH, "height": HEIGHT}


def _middle(name: str) -> Place:
    """Where a primitive goes whose inside is to be about the origin."""
    return (1.0, 1.2, 0.0) if name == "mesh of polygons" else (0.0, 0.0, 0.0)  # its origin is a corner


def _inside(name: str, primitive: Primitive) -> Table:
    """The camera, two lamps and a ball within the primitive, whose walls shine and mirror."""
    walls = {"color": [0.6, 0.5, 0.45], "diffuse": 0.5, "specular": 0.3, "shininess": 12, "reflection": 0.3,
             "reflection_color": [1, 0.9, 0.8]}  # fmt: skip
    places = (([0.2, 0.4, 0.3], [0.3, 0.35, 0.4]), ([-0.1, -0.3, -0.2], [0.3, 0.2, 0.15]))
    lamps = [{"type": "point", "position": place, "intensity": color} for place, color in places]
    ball = {"type": "sphere", "center": [-0.35, 0.1, -0.75], "radius": 0.3, "material": OPAQUE["shiny"]}
    return {"max_depth": 3, "background": 0.2, "ambient": 0.2, "camera": _view(), "lights": lamps,
            "shapes": [with_material(primitive(_middle(name), 3.0), walls), ball]}  # fmt: skip


def _in_glass(name: str, primitive: Primitive) -> Table:
    """The camera within glass, through whose walls it sees a room, or is reflected totally."""
    glass = {"color": 0.3, "diffuse": 0.1, "fresnel": True, "ior": 1.4, "transmission_color": [0.9, 1, 0.95]}
    balls = [{"type": "sphere", "center": [x, y, -2.2], "radius": 0.8, "material": OPAQUE[material]}
             for x, y, material in ((-2.4, -0.4, "matte"), (0.3, 1.2, "shiny"), (2.6, -0.7, "lamp"))]
    shapes = [with_material(primitive(_middle(name), 1.9), glass), *balls]
    return room(shapes, camera=_view(), lights=LIGHTS[:1])


def _planes() -> Table:
    """Four planes of different kinds round the camera, and a ball."""
    def side(point: Sequence[float], normal: Sequence[float], material: Table) -> Table:
        return {"type": "plane", "point": point, "normal": normal, "material": material}

    names = iter(OPAQUE.values())
    sides = [side(point, normal, next(names)) for point, normal in (
        ([0, -2, 0], [0, 1, 0.02]), ([-3, 0, 0], [1, 0.1, 0]), ([3, 0, 0], [-1, 0, 0.1]),
        ([0, 2.5, 0], [0, -1, 0]), ([0, 0, -4], [0, 0, 1]), ([0, 0, 9], [0, 0, -1]),
    )]  # fmt: skip
    sheet = side([0, 0, -2.5], [0.3, 0.1, 1], CLEAR["thin"])
    ball = {"type": "sphere", "center": [0.4, -1, 0.5], "radius": 0.8, "material": OPAQUE["mirror"]}
    lamp = {"type": "point", "position": [-1, 1.8, 3], "intensity": 0.6}
    camera = {"origin": [0, 0.3, 6], "target": [0, -0.2, 0], "fov": 60, "width": WIDTH, "height": HEIGHT}
    return {"max_depth": 4, "background": 0.2, "ambient": 0.2, "camera": camera, "lights": [lamp],
            "shapes": [*sides, sheet, ball]}  # fmt: skip
