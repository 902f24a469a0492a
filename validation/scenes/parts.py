"""What matrix cases are put together from: primitives at a place, materials, and a room to stand in."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

Table = dict[str, Any]
Place = tuple[float, float, float]

WIDTH, HEIGHT = 160, 120

# Opaque materials, a term of the model each. Quiet colours: what is bright clips, what is vivid makes edges.
OPAQUE: dict[str, Table] = {
    "matte": {"color": [0.7, 0.5, 0.35], "diffuse": 0.8, "ambient": 0.5},
    "shiny": {"color": [0.3, 0.4, 0.55], "diffuse": 0.6, "specular": 0.4, "shininess": 18,
              "highlight_color": [1, 0.8, 0.6]},
    "mirror": {"color": [0.4, 0.4, 0.4], "diffuse": 0.2, "reflection": 0.7,
               "reflection_color": [0.9, 0.75, 0.6]},
    "metal": {"color": 0.3, "diffuse": 0.2, "specular": 0.5, "shininess": 24,
              "highlight_color": [0.9, 0.6, 0.3],
              "reflection": 0.6, "reflection_color": [0.9, 0.6, 0.3], "fresnel": "schlick"},
    "lamp": {"color": [0.5, 0.5, 0.6], "diffuse": 0.4, "emission": [0.25, 0.2, 0.1]},
    "checker": {"color": {"type": "checker", "colors": [[0.55, 0.5, 0.4], [0.35, 0.4, 0.5]], "size": 0.31,
                          "divisions": 6}, "diffuse": 0.8},
}  # fmt: skip

CLEAR: dict[str, Table] = {
    "glass": {"color": [0.3, 0.4, 0.3], "diffuse": 0.15, "reflection": 0.15, "transmission": 0.7,
              "transmission_color": [0.8, 1, 0.9]},
    "fresnel": {"color": 0.2, "diffuse": 0.1, "fresnel": True, "specular": 0.2, "shininess": 30},
    "diamond": {"diffuse": 0.0, "fresnel": True, "ior": "diamond", "reflection": 0.9, "transmission": 0.8,
                "transmission_color": [0.9, 0.8, 1]},
    "thin": {"color": 0.3, "diffuse": 0.1, "fresnel": True, "thin": True,
             "transmission_color": [1, 0.9, 0.7]},
    "air": {"color": 0.3, "diffuse": 0.2, "transmission": 0.6, "ior": 0.8},
    "same": {"color": 0.4, "diffuse": 0.3, "transmission": 0.5, "ior": 1.0, "reflection": 0.1},
}  # fmt: skip

WALL: Table = {"color": [0.55, 0.6, 0.65], "diffuse": 0.75, "ambient": 0.6}
FLOOR: Table = {"color": [0.6, 0.55, 0.5], "diffuse": 0.7, "ambient": 0.6}
LIGHTS: list[Table] = [
    {"type": "point", "position": [-5, 7, 9], "intensity": [0.7, 0.66, 0.6]},
    {"type": "directional", "direction": [-0.5, -0.7, -1], "intensity": [0.15, 0.2, 0.25]},
]
CAMERA: Table = {"origin": [0, 0.8, 8.5], "target": [0, 0, 0], "fov": 40, "width": WIDTH, "height": HEIGHT}


def room(shapes: list[Table], **changes: Any) -> Table:
    """A scene of these shapes before a wall, on a floor; `changes` replace keys of the scene."""
    walls: list[Table] = [
        {"type": "plane", "point": [0, -2.4, 0], "normal": [0, 1, 0], "material": FLOOR},
        {"type": "plane", "point": [0, 0, -3], "normal": [0, 0.05, 1], "material": WALL},
    ]
    table = {"max_depth": 4, "background": [0.3, 0.32, 0.35], "ambient": [0.22, 0.24, 0.26],
             "camera": CAMERA, "lights": LIGHTS, "shapes": [*walls, *shapes]}  # fmt: skip
    return {**table, **changes}


def _plus(at: Place, x: float, y: float, z: float) -> list[float]:
    return [at[0] + x, at[1] + y, at[2] + z]


def _put(at: Place, *steps: Table) -> list[Table]:
    return [*steps, {"translate": list(at)}]


def _turned(at: Place, s: float, *steps: Table) -> list[Table]:
    """Scaled by s, turned about a slanting axis and moved."""
    return _put(at, {"scale": [s, s, s]}, *steps, {"rotate": [[1, 0.6, 0.2], 35.0]})


def _ring(corners: int, radius: float, step: int = 1, turn: float = 0.3) -> list[list[float]]:
    angles = [turn + 2 * math.pi * step * k / corners for k in range(corners)]
    return [[radius * math.cos(a), radius * math.sin(a), 0.0] for a in angles]


def _facing(at: Place, s: float, points: list[list[float]]) -> Table:
    """A polygon of points in the xy-plane, turned a little from the camera."""
    turned = [[x * 0.8 + 0.3 * y, y, 0.6 * x - 0.4 * y] for x, y, _ in points]
    return {"type": "polygon", "points": [_plus(at, s * x, s * y, s * z) for x, y, z in turned]}


ARROW: list[list[float]] = [[-0.8, -1, 0], [0.8, -1, 0], [0.1, 0.0, 0], [0.8, 1, 0], [-0.8, 1, 0]]
KEYHOLE: list[list[float]] = [
    [-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0], [-1, -1, 0],
    [-0.45, -0.5, 0], [-0.45, 0.5, 0], [0.5, 0.4, 0], [0.5, -0.5, 0], [-0.45, -0.5, 0],
]  # fmt: skip
STAR = _ring(5, 1.1, step=2)

_OCTAHEDRON = {
    "vertices": [[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1]],
    "faces": [[0, 2, 4], [2, 1, 4], [1, 3, 4], [3, 0, 4], [2, 0, 5], [1, 2, 5], [3, 1, 5], [0, 3, 5]],
}
# an L-shaped prism: two concave faces and six quadrangles
_ELL: list[list[float]] = [[-0.8, -0.8], [0.8, -0.8], [0.8, 0], [0, 0], [0, 0.8], [-0.8, 0.8]]
_PRISM = {
    "vertices": [[x, y, z] for z in (0.5, -0.5) for x, y in _ELL],
    "faces": [[0, 1, 2, 3, 4, 5], [11, 10, 9, 8, 7, 6],
              *([k, k + 6, (k + 1) % 6 + 6, (k + 1) % 6] for k in range(6))],
}  # fmt: skip


def ball(rows: int, columns: int) -> tuple[list[list[float]], list[list[int]]]:
    """Vertices and faces, counter-clockwise from outside, of a unit sphere of quadrangles and triangles."""
    angles = [(math.pi * i / rows, 2 * math.pi * j / columns) for i in range(1, rows) for j in range(columns)]
    points = [[math.sin(a) * math.cos(b), math.cos(a), math.sin(a) * math.sin(b)] for a, b in angles]
    top, bottom, faces = len(points), len(points) + 1, []
    for j in range(columns):
        k = (j + 1) % columns
        faces += [[top, k, j], [bottom, top - columns + j, top - columns + k]]
        for at in range(0, (rows - 2) * columns, columns):
            faces.append([at + j, at + k, at + columns + k, at + columns + j])
    return [*points, [0.0, 1.0, 0.0], [0.0, -1.0, 0.0]], faces


def _smooth(at: Place, s: float) -> Table:
    vertices, faces = ball(5, 8)
    return {"type": "mesh", "vertices": vertices, "faces": faces, "smooth": True, "transform": _turned(at, s)}


def _given_normals(at: Place, s: float) -> Table:
    """A coarse ellipsoid with normals; mirrored and squeezed, so that winding and normals must follow."""
    vertices, faces = ball(6, 9)
    normals = [[x / 0.7, y, z / 0.9] for x, y, z in vertices]
    return {"type": "mesh", "vertices": [[0.7 * x, y, 0.9 * z] for x, y, z in vertices], "faces": faces,
            "normals": normals, "transform": _turned(at, s, {"scale": [-1, 0.7, 0.9]})}  # fmt: skip


Primitive = Callable[[Place, float], Table]

# name -> the primitive at a place, within about `size` of it, by coordinates or by a transform
CLOSED: dict[str, Primitive] = {
    "sphere": lambda at, s: {"type": "sphere", "center": list(at), "radius": s},
    "turned sphere": lambda at, s: {
        "type": "sphere", "center": [0.2, 0, 0], "radius": 0.5,
        "transform": _put(at, {"rotate": [[1, 1, 0], 70.0]}, {"scale": [2 * s, 2 * s, -2 * s]}),
    },
    "squashed sphere": lambda at, s: {
        "type": "sphere", "center": [0, 0, 0], "radius": 1.0,
        "transform": _turned(at, s, {"scale": [1, 0.6, 0.8]}),
    },
    "ellipsoid": lambda at, s: {"type": "ellipsoid", "center": list(at), "radii": [s, 0.7 * s, 0.8 * s]},
    "turned ellipsoid": lambda at, s: {
        "type": "ellipsoid", "center": [0, 0, 0], "radii": [1, 0.6, 0.5], "transform": _turned(at, s),
    },
    "quadric": lambda at, s: {  # a slanting ellipsoid, off centre
        "type": "quadric", "coefficients": [1.2, 1.6, 1, 0.3, 0.1, 0.2, 0.1, -0.2, 0.1, -0.8],
        "transform": _put(at, {"scale": [s, s, s]}),
    },
    "capped cylinder": lambda at, s: {
        "type": "cylinder", "p0": _plus(at, -0.6 * s, -0.6 * s, 0.2 * s),
        "p1": _plus(at, 0.5 * s, 0.7 * s, 0.4 * s),
        "radius": 0.6 * s, "caps": True,
    },
    "capped cone": lambda at, s: {
        "type": "cone", "p0": [0, -0.9, 0], "r0": 0.9, "p1": [0.1, 0.9, 0.1], "r1": 0.4, "caps": True,
        "transform": _turned(at, s),
    },
    "pointed cone": lambda at, s: {
        "type": "cone", "p0": _plus(at, 0.2 * s, s, 0), "r0": 0.0,
        "p1": _plus(at, -0.1 * s, -0.8 * s, 0.3 * s),
        "r1": 0.8 * s, "caps": True,
    },
    "box": lambda at, s: {
        "type": "box", "min": [-0.7, -0.6, -0.5], "max": [0.7, 0.6, 0.5],
        "transform": _put(at, {"rotate": [[0.3, 1, 0.1], 35.0]}, {"scale": [s, s, s]}),
    },
    "mirrored box": lambda at, s: {
        "type": "box", "min": [-0.7, -0.6, -0.5], "max": [0.5, 0.7, 0.6],
        "transform": _put(at, {"scale": [s, -s, s]}, {"rotate": ["y", -25.0]}),
    },
    "mesh": lambda at, s: {"type": "mesh", **_OCTAHEDRON, "transform": _turned(at, s)},
    "mesh of polygons": lambda at, s: {"type": "mesh", **_PRISM, "transform": _turned(at, s)},
    "smooth mesh": _smooth,
    "mesh with normals": _given_normals,
}  # fmt: skip

OPEN: dict[str, Primitive] = {
    "cylinder": lambda at, s: {
        "type": "cylinder", "p0": [0, -0.8, 0], "p1": [0, 0.8, 0], "radius": 0.7, "transform": _turned(at, s),
    },
    "cone": lambda at, s: {
        "type": "cone", "p0": _plus(at, 0, 0.9 * s, 0), "r0": 0.2 * s,
        "p1": _plus(at, 0.2 * s, -0.8 * s, 0.4 * s),
        "r1": 0.8 * s,
    },
    "spire": lambda at, s: {
        "type": "cone", "p0": _plus(at, -0.3 * s, -0.9 * s, 0.2 * s), "r0": 0.08 * s,
        "p1": _plus(at, 0.3 * s, 0.9 * s, -0.1 * s),
        "r1": 0.0,
    },
    "paraboloid": lambda at, s: {
        "type": "paraboloid", "apex": _plus(at, 0, -0.7 * s, 0), "axis": [0.2, 1, 0.5], "focal": 0.15 * s,
        "height": 1.1 * s,
    },
    "clipped quadric": lambda at, s: {  # of one sheet, in a box of its own
        "type": "quadric", "coefficients": [1, -0.6, 1, 0.05, 0, 0.1, 0, 0, 0, -0.2],
        "clip": [[-0.8, -0.8, -0.7], [0.8, 0.7, 0.9]], "transform": _turned(at, s),
    },
    "disk": lambda at, s: {"type": "disk", "center": list(at), "normal": [0.4, 0.3, 1], "radius": 0.9 * s},
    "turned disk": lambda at, s: {
        "type": "disk", "center": [0, 0, 0], "normal": [0, 0, 2], "radius": 0.8, "transform": _turned(at, s),
    },
    "polygon": lambda at, s: _facing(at, s, _ring(6, 0.9)),
    "mirrored polygon": lambda at, s: {
        "type": "polygon", "points": [[-0.9, -0.8, 0.1], [0.8, -0.9, -0.1], [0.1, 0.9, 0.0]],
        "transform": _put(at, {"scale": [s, s, -s]}, {"rotate": ["y", 20.0]}),
    },
    "concave polygon": lambda at, s: _facing(at, s, ARROW),
    "polygon with a hole": lambda at, s: _facing(at, s, KEYHOLE),
    "star polygon": lambda at, s: _facing(at, s, STAR),
}  # fmt: skip

CHECKERED = ("sphere", "turned sphere", "disk", "turned disk", "polygon", "mirrored polygon",
             "concave polygon",
             "polygon with a hole", "star polygon")  # fmt: skip


def slanting(corners: list[tuple[float, float]], x_slope: float, y_slope: float) -> Table:
    """A polygon over corners (x, y), in the plane z = x_slope x + y_slope y."""
    return {"type": "polygon", "points": [[x, y, x_slope * x + y_slope * y] for x, y in corners]}


def with_material(primitive: Table, material: Table | str) -> Table:
    return {**primitive, "material": material}
