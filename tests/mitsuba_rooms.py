"""Rooms that Mitsuba and the renderer both render, and how far their pictures differ."""

from __future__ import annotations

import warnings
from typing import Any

import numpy as np

import clrt
from clrt.base.errors import ClrtWarning
from clrt.base.resources import scene_folder
from clrt.scene.scene import Scene
from validation.oracle_mitsuba import Source

WIDTH, HEIGHT = 80, 60
CAMERA = {"origin": [0.5, 3.2, 6.5], "target": [0.1, 0.3, 0.0], "fov": 40.0}
POINT = {"type": "point", "position": [3.0, 5.0, 4.0], "intensity": 0.7}
NEAR = {**POINT, "intensity": [22.0, 20.0, 18.0], "falloff": "inverse-square"}
SUN = {"type": "directional", "direction": [1.0, -2.0, -1.0], "intensity": [0.3, 0.3, 0.25]}
FLOOR = {"type": "plane", "point": [0.0, 0.0, 0.0], "normal": [0.0, 1.0, 0.0], "material": "floor"}
BALL = {"type": "sphere", "center": [-1.4, 0.9, 0.0], "radius": 0.8, "material": "a"}
BOX = {"type": "box", "min": [0.3, 0.1, -0.5], "max": [1.5, 1.3, 0.7], "material": "b",
       "transform": [{"rotate": ["y", 30.0]}]}  # fmt: skip
CONE = {"type": "cone", "p0": [-0.3, 0.05, 1.3], "r0": 0.5, "p1": [-0.3, 1.0, 1.3], "r1": 0.1, "caps": True,
        "material": "c"}  # fmt: skip
EGG = {"type": "ellipsoid", "center": [1.6, 0.5, 1.3], "radii": [0.5, 0.4, 0.3], "material": "d"}
GREY = {"color": [0.8, 0.75, 0.7], "diffuse": 0.9}
RED = {"color": [0.9, 0.2, 0.2], "diffuse": 0.7, "specular": 0.4, "shininess": 25.0, "reflection": 0.2}
MATTE = {"color": [0.9, 0.2, 0.2], "diffuse": 0.7}
MIRROR = {"diffuse": 0.0, "reflection": 0.8, "reflection_color": [1.0, 0.9, 0.7]}
GLASS = {"diffuse": 0.0, "fresnel": True, "transmission_color": [0.9, 1.0, 0.95]}


def room(materials: dict[str, Any], shapes: Any = (FLOOR, BALL, BOX, CONE, EGG), **more: Any) -> Source:
    """A scene of these materials and shapes; `more` overrides what is usual."""
    usual = {"camera": CAMERA, "lights": [POINT, SUN], "ambient": [0.1, 0.12, 0.1]}
    scene = usual | {"background": [0.05, 0.1, 0.2], "materials": materials, "shapes": list(shapes)} | more
    return Source(scene, str(scene_folder()), WIDTH, HEIGHT)


def as_read(room: Source) -> Scene:
    """The room as the renderer reads it."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ClrtWarning)
        scene = clrt.load_dict(dict(room.tables), folder=room.folder)
    return scene.override(width=room.width, height=room.height, spp=room.spp, max_depth=room.max_depth)


def ours(room: Source, layers: Any = ("depth", "shape")) -> clrt.Image:
    return clrt.Tracer(as_read(room)).render(layers=layers)


def off(picture: np.ndarray, other: np.ndarray, tolerance: float = 1e-4) -> float:
    """The share of pixels that differ by more."""
    return float(np.mean(np.abs(picture - other).max(axis=2) > tolerance))


MATERIALS = {"floor": GREY, "a": RED, "b": GLASS, "c": RED, "d": MIRROR}
CHECKER = {
    "color": {"type": "checker", "colors": [[0.9, 0.8, 0.7], [0.1, 0.2, 0.3]], "size": 0.37, "divisions": 9}
}
STAR = [[2.0 + np.cos(a), 1.2 + np.sin(a), -0.8] for a in 4 * np.pi / 5 * np.arange(5) + 0.1]
TRANSFORM = [
    {"scale": [-1.2, 0.7, 1.0]},
    {"rotate": [[1.0, 2.0, 0.5], 40.0]},
    {"translate": [-1.3, 1.2, 0.4]},
]
OTHERS = [
    FLOOR,
    {"type": "polygon", "points": STAR, "material": "a"},
    {"type": "cylinder", "p0": [-0.6, -0.6, 0.0], "p1": [0.3, 0.6, 0.0], "radius": 0.4, "material": "b",
     "transform": TRANSFORM},
    {"type": "paraboloid", "apex": [0.6, 0.1, 1.2], "axis": [0.1, 1.0, 0.2], "focal": 0.1, "height": 1.0,
     "material": "c"},
    {"type": "disk", "center": [-0.3, 0.4, 2.0], "normal": [0.3, 1.0, 0.8], "radius": 0.5, "material": "d"},
    {"type": "quadric", "coefficients": [4, -2, 4, 0, 0, 0, 0, 0, 0, -0.3],
     "clip": [[-2, -0.6, -2], [2, 0.6, 2]], "transform": [{"translate": [1.7, 0.7, 1.0]}], "material": "c"},
    {"type": "mesh", "vertices": [[0, 0, 0], [1, 0, 0], [0, 0, 1], [0, 1, 0]], "smooth": True,
     "faces": [[0, 1, 2], [0, 3, 1], [0, 2, 3], [1, 3, 2]], "transform": [{"translate": [0.3, 0.2, -1.0]}],
     "material": "a"},
]  # fmt: skip
CHECKERED = {"floor": CHECKER, "a": CHECKER, "b": CHECKER, "c": RED, "d": CHECKER}
PLAQUE = {"type": "polygon", "points": [[1.5, 0.1, -1], [2.5, 0.2, -1], [2.5, 1.9, -1.4], [1.5, 1.8, -1.4]],
          "material": "b"}  # fmt: skip
SCENES: dict[str, dict[str, Any]] = {
    "solids": {"materials": MATERIALS},
    "other shapes": {"materials": MATERIALS, "shapes": OTHERS},
    "one-sided": {"materials": MATERIALS | {"b": RED}, "shapes": OTHERS, "one_sided": "opaque"},
    "checkers": {"materials": CHECKERED, "shapes": [FLOOR, BALL, PLAQUE, {**OTHERS[4], "radius": 0.9}]},
    "shares and tints": {
        "materials": MATERIALS
        | {"b": {"diffuse": 0.1, "reflection": 0.2, "transmission": 0.7,
                 "transmission_color": [0.9, 0.5, 0.2]}},
        "shadow": "tinted", "depth_color": [0.5, 0.1, 0.7], "max_depth": 3,
    },
    "schlick, thin, emission": {
        "materials": MATERIALS
        | {"a": {"specular": 0.5, "highlight_color": [0.9, 0.6, 0.2], "reflection": 0.9, "fresnel": "schlick",
                 "reflection_color": [0.9, 0.6, 0.2], "emission": [0.2, 0.1, 0.0]},
           "b": {**GLASS, "thin": True}},
        "medium_ior": 1.33, "min_weight": 0.02,
    },
    "ambient rays": {"materials": MATERIALS, "ambient_samples": 3, "max_depth": 2},
    "sky": {"materials": MATERIALS, "background": "sky.exr"},
    "orthographic": {
        "materials": MATERIALS,
        "camera": {**CAMERA, "type": "orthographic", "size": 4, "fov_axis": "vertical", "shift": [2, -3],
                   "near": 1},
    },
    "mirrored": {
        "materials": MATERIALS, "camera": {**CAMERA, "mirror": True, "shift": [3.5, -7.25], "near": 2},
    },
}  # fmt: skip


def stock_room(materials: dict[str, Any], more: dict[str, Any]) -> Source:
    """A room without ambient light, which Mitsuba does not have."""
    return room({"floor": GREY, **materials}, ambient=0.0, **more)
