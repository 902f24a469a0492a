"""Sphereflake: 7381 spheres, each with nine smaller ones.

Source: the idea of "balls" in E. Haines, "A proposal for standard graphics environments", IEEE CG&A 7(11),
1987; the arrangement, the colours and the light are this project's own.
What to look at: every sphere mirrors its neighbours, so the flake goes on inside itself; the colour changes
with each of the five sizes, and 1 + 9 + 81 + 729 + 6561 = 7381.

    clrt render sphereflake -o sphereflake.png
    python scenes/sphereflake.py scenes/my-sphereflake.json
"""

from __future__ import annotations

import json
import math
import sys
from pathlib import Path
from typing import Any

LEVELS = 4
SHRINK = 1.0 / 3.0
AXIS = (0.25, 0.92, 0.3018278)  # of the root, a unit vector: leans to the right and to the front
MATERIALS = ("root", "first", "second", "third", "fourth")

Vector = tuple[float, float, float]


def mirror(color: list[float], reflection: float) -> dict[str, Any]:
    """A polished coloured material."""
    return {
        "color": color,
        "diffuse": 0.45,
        "specular": 0.4,
        "shininess": 90.0,
        "reflection": reflection,
        "reflection_color": [0.5 + 0.5 * c for c in color],
    }


SETTINGS: dict[str, Any] = {
    "max_depth": 4,
    "min_weight": 0.01,
    "background": "studio.exr",
    "ambient": [0.16, 0.18, 0.21],
    "camera": {
        "origin": [0.6, 2.3, 5.6],
        "target": [0.0, 0.05, 0.0],
        "fov": 38.5,
        "width": 600,
        "height": 600,
        "spp": 4,
    },
    "materials": {
        "floor": {
            "color": [0.22, 0.24, 0.27],
            "diffuse": 0.6,
            "reflection": 0.4,
            "reflection_color": 0.15,
            "fresnel": "schlick",
        },
        "root": mirror([0.06, 0.24, 0.30], 0.5),
        "first": mirror([0.10, 0.45, 0.45], 0.45),
        "second": mirror([0.85, 0.62, 0.25], 0.4),
        "third": mirror([0.90, 0.40, 0.20], 0.35),
        "fourth": mirror([0.85, 0.80, 0.70], 0.3),
    },
    "lights": [
        {"type": "point", "position": [-5.0, 7.0, 6.0], "intensity": [1.0, 0.90, 0.76]},
        {"type": "point", "position": [6.0, 3.5, 1.0], "intensity": [0.28, 0.40, 0.52]},
    ],
}


def frame(axis: Vector) -> tuple[Vector, Vector]:
    """Two unit vectors that complete a unit axis to a right-handed frame (Duff et al. 2017)."""
    x, y, z = axis
    sign = math.copysign(1.0, z)
    a = -1.0 / (sign + z)
    b = x * y * a
    return (1.0 + sign * x * x * a, sign * b, -sign * x), (b, sign + y * y * a, -y)


def children(axis: Vector) -> list[Vector]:
    """Unit directions of the nine children: six around the equator, three higher up."""
    u, v = frame(axis)
    rings = [(math.pi / 2, k * math.pi / 3) for k in range(6)]
    rings += [(math.radians(36.0), math.pi / 6 + k * 2 * math.pi / 3) for k in range(3)]
    directions = []
    for polar, turn in rings:
        s, c = math.sin(polar), math.cos(polar)
        a, b = s * math.cos(turn), s * math.sin(turn)
        x, y, z = (a * u[k] + b * v[k] + c * axis[k] for k in range(3))
        directions.append((x, y, z))
    return directions


def grow(center: Vector, radius: float, axis: Vector, level: int, shapes: list[dict[str, Any]]) -> None:
    """Add a sphere and, below the last level, its children; each child's axis points away from its parent."""
    shapes.append(
        {
            "type": "sphere",
            "center": [round(v, 6) for v in center],
            "radius": round(radius, 7),
            "material": MATERIALS[level],
        }
    )
    if level == LEVELS:
        return
    reach = radius * (1.0 + SHRINK)
    for d in children(axis):
        place = (center[0] + reach * d[0], center[1] + reach * d[1], center[2] + reach * d[2])
        grow(place, radius * SHRINK, d, level + 1, shapes)


def scene() -> dict[str, Any]:
    """The scene as a dict for clrt.load_dict."""
    disk = {"type": "disk", "center": [0.0, -1.45, 0.0], "normal": [0.0, 1.0, 0.0], "radius": 7.0}
    shapes: list[dict[str, Any]] = [{**disk, "material": "floor"}]
    grow((0.0, 0.0, 0.0), 1.0, AXIS, 0, shapes)
    return {**SETTINGS, "shapes": shapes}


if __name__ == "__main__":
    text = json.dumps(scene(), indent=1) + "\n"
    if len(sys.argv) > 1:
        Path(sys.argv[1]).write_text(text)
    else:
        sys.stdout.write(text)
