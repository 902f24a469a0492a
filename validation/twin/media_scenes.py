"""The self-test's scenes of media: in one another, around the camera, and cut by the plane of its rays."""

from __future__ import annotations

from typing import Any

Table = dict[str, Any]

_GLASS: Table = {"diffuse": 0.1, "fresnel": True, "transmission_color": [0.9, 1, 0.8], "absorption": 0.1}
_DROP: Table = {"diffuse": 0.05, "reflection": 0.2, "transmission": 0.8, "ior": "water"}
_WATER: Table = {**_DROP, "absorption": [0.9, 0.3, 0.1], "priority": 2}
_FOG: Table = {"diffuse": 0, "fresnel": True, "ior": 1.05, "absorption": [0.05, 0.1, 0.2], "priority": -1}
_AIR: Table = {"diffuse": 0, "fresnel": True, "ior": "air", "priority": 3}
_ICE: Table = {**_DROP, "ior": "ice", "absorption": 0.4, "priority": 1}
_COAT: Table = {"color": [0.8, 0.3, 0.2], "fresnel": True, "transmission": 0, "reflection": 1}
_PANE: Table = {"diffuse": 0.1, "fresnel": True, "thin": True, "transmission_color": [0.5, 0.9, 0.6]}
_FLOOR: Table = {"color": {"type": "checker", "colors": [[0.9, 0.8, 0.1], 0.2], "size": 0.37}}
_WEDGE: Table = {
    "vertices": [[-0.8, -0.2, -0.3], [0.9, -0.3, -0.2], [0.1, 1, -0.1], [0.1, 0.3, 1]],
    "faces": [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]],
}


def media() -> Table:
    """All priorities, clear and coloured, meshes and half-spaces, open and opaque surfaces among them."""
    rod = {"p0": [-1, -1, 0.5], "p1": [-0.8, 1, 0.3], "radius": 0.3, "caps": True}
    cup = {"p0": [-0.5, -0.5, 0.7], "r0": 0.2, "p1": [-0.4, 0.6, 0.8], "r1": 0.45, "caps": True}
    pane = {"center": [0.3, 0.1, 0.3], "normal": [0.2, 1, 0.3], "radius": 1.1}
    return {"max_depth": 5, "shapes": [
        {"type": "ellipsoid", "center": [0.3, 0.6, 4], "radii": [1.5, 1, 1.2], "material": _FOG},
        {"type": "box", "min": [-1.4, -1, -0.6], "max": [0.9, 0.3, 0.9], "material": _GLASS},
        {"type": "sphere", "center": [0.3, 0, 0.3], "radius": 0.8, "material": _WATER},
        {"type": "sphere", "center": [0.5, 0.1, 0.5], "radius": 0.3, "material": _AIR},
        {"type": "sphere", "center": [0.9, 0.2, 0.4], "radius": 0.5, "material": _GLASS},
        {"type": "sphere", "center": [0, -0.2, 0.2], "radius": 0.2, "material": _COAT},
        {"type": "disk", **pane, "material": _PANE},
        {"type": "cylinder", **rod, "material": _ICE}, {"type": "cone", **cup, "material": _WATER},
        {"type": "mesh", **_WEDGE, "material": _ICE, "transform": [{"translate": [0.2, 0.3, 0]}]},
        {"type": "plane", "point": [0, -0.8, 0], "normal": [0, 1, 0.1], "material": _DROP},
        {"type": "plane", "point": [0, -1.6, 0], "normal": [0, 1, 0], "material": _FLOOR},
    ]}  # fmt: skip


def media_within() -> Table:
    """Rays that start within many lists, with tinted feelers and ambient rays."""
    place = {"origin": [0.3, 0.6, 4.2], "target": [0, -0.1, 0], "width": 24, "height": 18}
    camera = {**place, "type": "orthographic", "size": 4, "near": 3.8}
    return {**media(), "camera": camera, "shadow": "tinted", "ambient_samples": 2, "max_depth": 3}
