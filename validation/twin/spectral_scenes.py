"""Small scenes whose light has a spectrum: every kind of spectrum, metals, dispersive glass in glass."""

from __future__ import annotations

from typing import Any

Table = dict[str, Any]

_LIGHTS: list[Table] = [
    {"type": "point", "position": [3, 4, 5], "intensity": {"name": "D65", "scale": 25.0},
     "falloff": "inverse-square"},
    {"type": "directional", "direction": [1, -2, -0.7], "intensity": {"blackbody": 3000, "scale": 0.4}},
    {"type": "point", "position": [-4, 1, 2], "intensity": {"line": 545.0, "scale": 0.2}},
]  # fmt: skip
_FLOOR: Table = {
    "type": "plane", "point": [0, -1.2, 0], "normal": [0.02, 1, 0.01],
    "material": {"color": {"type": "checker", "colors": ["patch-13", [0.9, 0.8, 0.1]], "size": 0.37}},
}  # fmt: skip
_BENT: Table = {"diffuse": 0.05, "specular": 0.3, "shininess": 40, "fresnel": True}


def metals() -> Table:
    """Conductors by name and by numbers, on both sides; a tinted one under water; all kinds of spectra."""
    gaussian, band = {"gaussian": [450.0, 30.0], "scale": 0.8}, {"band": [580.0, 640.0]}
    gold = {"diffuse": 0.1, "conductor": "gold", "specular": 0.3, "highlight_color": band}
    numbers = {"eta": [[400, 0.2], [700, 1.5]], "k": 3.0}
    return {
        "spectrum": {"bands": 5, "range": [400, 700], "white_balance": True, "white": "A"},
        "lights": _LIGHTS, "ambient": {"name": "A", "scale": 0.2},
        "background": {"samples": [[400, 0.1], [700, 0.4]]},
        "shapes": [
            _FLOOR,
            {"type": "sphere", "center": [-0.9, -0.2, 0.3], "radius": 0.8, "material": gold},
            {"type": "sphere", "center": [0.9, 0, 0.4], "radius": 0.7,
             "material": {**_BENT, "ior": "water", "absorption": [0.9, 0.2, 0.1]}},
            {"type": "sphere", "center": [0.9, 0, 0.4], "radius": 0.4,
             "material": {"diffuse": 0, "conductor": "copper", "reflection_color": "patch-15"}},
            {"type": "cylinder", "p0": [0, -1.2, -1.2], "p1": [0.2, 1.5, -1.2], "radius": 0.6,
             "material": {"color": gaussian, "conductor": numbers, "reflection": 0.8, "emission": 0.05}},
        ],
    }  # fmt: skip


def dispersion() -> Table:
    """Dispersive glass without lists of media: an incomplete last group, ambient rays, tinted shadows."""
    thin = {**_BENT, "thin": True, "ior": "SF10", "transmission_color": [0.5, 0.9, 0.6]}
    flint = {"diffuse": 0, "reflection": 0.2, "transmission": 0.75, "ior": {"cauchy": [1.6, 0.02]}}
    return {
        "spectrum": {"bands": 5, "group": 2}, "lights": _LIGHTS, "shadow": "tinted",
        "depth_color": [0.3, 0.1, 0.2], "min_weight": 0.01, "max_depth": 3,
        "ambient_samples": 2, "ambient": 0.3,
        "camera": {"origin": [0.3, 0.6, 4.2], "target": [0, -0.1, 0], "width": 24, "height": 18},
        "shapes": [
            _FLOOR,
            {"type": "sphere", "center": [-0.8, 0, 0], "radius": 0.7, "material": {**_BENT, "ior": "SF11"}},
            {"type": "box", "min": [0.3, -0.9, -0.4], "max": [1.2, 0.3, 0.4], "material": flint,
             "transform": [{"rotate": [[0.3, 1, 0], 30]}]},
            {"type": "disk", "center": [0.2, 0.5, 1.2], "normal": [0.3, 0.2, 1], "radius": 0.5,
             "material": thin},
        ],
    }  # fmt: skip


def dispersion_beside() -> Table:
    """A packet meets one material from within dispersive glass and from outside: the last group of bands,
    which the material keeps, speaks for the former alone."""
    blue = {"diffuse": 0, "transmission": 0.8, "transmission_color": {"gaussian": [450, 60]}, "ior": 1.3}
    return {
        "spectrum": {"bands": 8, "group": 3}, "lights": _LIGHTS, "ambient": 0.2, "background": 0.8,
        "depth_color": [0.3, 0.9, 0.2], "min_weight": 0.05, "max_depth": 2, "ambient_samples": 2,
        "camera": {"origin": [0, 0, 4], "target": [0, 0, 0], "width": 24, "height": 18},
        "shapes": [
            _FLOOR,
            {"type": "box", "min": [-2, -2, -1], "max": [0.05, 2, 1.2], "material": {**_BENT, "ior": "SF10"}},
            {"type": "sphere", "center": [0, 0, 0], "radius": 1, "material": {**blue, "priority": 1}},
        ],
    }  # fmt: skip


def dispersion_within() -> Table:
    """The camera in dispersive water: glass, an air bubble and a metal in it, of several priorities."""
    return {
        "spectrum": {"bands": 4}, "lights": _LIGHTS, "ambient": 0.2, "background": [0.1, 0.2, 0.4],
        "max_depth": 3,
        "camera": {"origin": [0, 0.3, 1.3], "target": [0, 0.1, 0], "fov": 70, "width": 24, "height": 18},
        "shapes": [
            _FLOOR,
            {"type": "sphere", "center": [0, 0, 0], "radius": 1.5,
             "material": {"diffuse": 0, "fresnel": True, "ior": "water-dispersive", "absorption": 0.2}},
            {"type": "sphere", "center": [0.3, 0.1, 0], "radius": 0.5,
             "material": {**_BENT, "ior": {"sellmeier": {"B": [1.04], "C": [0.006]}}, "priority": 1}},
            {"type": "sphere", "center": [0.6, 0.1, 0.1], "radius": 0.4,
             "material": {"diffuse": 0, "reflection": 0.2, "transmission": 0.7, "ior": 1.0, "priority": 2}},
            {"type": "sphere", "center": [-0.6, -0.3, -0.2], "radius": 0.4,
             "material": {"diffuse": 0.1, "conductor": "silver", "specular": 0.2}},
        ],
    }  # fmt: skip
