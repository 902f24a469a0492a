"""Shapes to test with: one of each kind, as it is and under an affine transform."""

from __future__ import annotations

from typing import Any

import numpy as np

import clrt
from tests.engines import unit

TURN = [
    {"rotate": [[1, 2, 3], 40]},
    {"scale": [1.0, 0.6, 1.7]},
    {"rotate": ["x", 25]},
    {"translate": [0.2, -0.1, 0.3]},
]
SADDLE = [1, 1, -1.5, 0.2, 0.1, -0.3, 0.1, 0.0, 0.2, -0.4]  # a hyperboloid of one sheet
L_SHAPE = [[0, 0, 0], [2, 0, 0], [2, 1, 0], [1, 1, 0], [1, 2, 0], [0, 2, 0]]
TETRA = {
    "vertices": [[1, 1, 1], [-1, -1, 1], [-1, 1, -1], [1, -1, -1]],
    "faces": [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]],
}
SHAPES: dict[str, dict[str, Any]] = {
    "sphere": {"center": [0.1, 0.2, -0.1], "radius": 1.1},
    "plane": {"point": [0, -0.3, 0.1], "normal": [0.2, 1, -0.1]},
    "polygon": {"points": L_SHAPE},
    "mesh": TETRA,
    "quadric": {"coefficients": SADDLE, "clip": [[-1, -1, -1], [1, 1, 1]]},
    "ellipsoid": {"center": [0.1, 0, 0], "radii": [1.2, 0.7, 0.9]},
    "cylinder": {"p0": [0, -0.8, 0.1], "p1": [0.2, 0.9, 0], "radius": 0.6, "caps": True},
    "cone": {"p0": [0, -0.8, 0], "r0": 0.9, "p1": [0.3, 1.0, 0.2], "r1": 0.2, "caps": True},
    "paraboloid": {"apex": [0, -0.5, 0], "axis": [0.1, 1, 0.2], "focal": 0.15, "height": 1.2},
    "disk": {"center": [0.1, 0.1, 0], "normal": [1, 2, 3], "radius": 1.0},
    "box": {"min": [-0.7, -0.5, -0.9], "max": [0.8, 0.6, 0.4]},
}
CAMERA = {"origin": [0.3, 1.2, 6.0], "target": [0.1, 0.4, 0.0], "width": 40, "height": 30}


def scene(*shapes: dict[str, Any], **settings: Any) -> clrt.Scene:
    return clrt.load_dict({"shapes": list(shapes), **settings})


def shape(kind: str, turned: bool = False, **extra: Any) -> dict[str, Any]:
    """A shape of SHAPES, with TURN if it is to be turned (a plane takes no transform)."""
    transform = {"transform": TURN} if turned and kind != "plane" else {}
    return {"type": kind, **SHAPES[kind], **transform, **extra}


def rays_towards_the_middle(count: int, distance: float = 5.0) -> tuple[np.ndarray, np.ndarray]:
    """Origins on a sphere, unit directions to points of the box [-1, 1]^3."""
    rng = np.random.default_rng(20240611)
    origin = distance * unit(rng.normal(size=(count, 3)))
    return origin, unit(rng.uniform(-1, 1, (count, 3)) - origin)


def colourful(**settings: Any) -> clrt.Scene:
    """Every kind of shape, every kind of material term, two lights."""
    glass = {"diffuse": 0.0, "fresnel": True, "transmission_color": [0.9, 1, 0.8]}
    shiny = {
        "color": [0.8, 0.4, 0.3],
        "diffuse": 0.6,
        "specular": 0.3,
        "reflection": 0.25,
        "highlight_color": [1, 0.9, 0.7],
    }
    metal = {
        "fresnel": "schlick",
        "diffuse": 0.1,
        "specular": 0.4,
        "reflection": 0.8,
        "reflection_color": [0.9, 0.7, 0.4],
    }
    clear = {
        "diffuse": 0.1,
        "reflection": 0.1,
        "transmission": 0.7,
        "ior": 1.3,
        "emission": [0.02, 0.01, 0.03],
    }
    floor = {"color": {"type": "checker", "size": 0.7}, "reflection": 0.1, "diffuse": 0.8}
    shapes = [
        {"type": "plane", "point": [0, -1, 0], "normal": [0, 1, 0], "material": floor},
        {"type": "sphere", "center": [-1, 0, 0], "radius": 0.8, "material": glass},
        {"type": "ellipsoid", "center": [1, -0.2, 0.4], "radii": [0.5, 0.7, 0.4], "material": clear},
        {
            "type": "cone",
            "p0": [0.2, -1, -1.5],
            "r0": 0.8,
            "p1": [0.2, 1, -1.5],
            "r1": 0.1,
            "caps": True,
            "material": shiny,
        },
        {"type": "box", "min": [1.6, -1, -2], "max": [2.4, 0.4, -1], "material": metal},
        {
            "type": "mesh",
            **TETRA,
            "smooth": True,
            "material": shiny,
            "transform": [{"scale": 0.4}, {"translate": [0, -0.5, 1.3]}],
        },
    ]
    lights = [
        {"type": "point", "position": [3, 5, 4], "intensity": [0.8, 0.7, 0.6], "falloff": "none"},
        {"type": "directional", "direction": [1, -2, -1], "intensity": 0.3},
    ]
    base = {
        "camera": CAMERA,
        "lights": lights,
        "background": [0.1, 0.15, 0.3],
        "ambient": [0.1, 0.09, 0.08],
        "max_depth": 4,
    }
    return scene(*shapes, **{**base, **settings})
