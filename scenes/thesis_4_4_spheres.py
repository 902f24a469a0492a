"""More than 700 spheres from a script: a vase of marbles, wound around a golden-angle spiral.

Source: thesis, figure 4.4 ("the geometry for this image was generated with a python script ... over 700
spheres").
What to look at: 760 marbles follow the spiral of a pine cone (phyllotaxis: each one turned by the golden
angle); they mirror one another and the golden sphere that rests on the vase.

    clrt render thesis_4_4_spheres -o spheres.png
    python scenes/thesis_4_4_spheres.py spheres.json
"""

from __future__ import annotations

import json
import math
import sys
from pathlib import Path
from typing import Any

GOLDEN_ANGLE = math.pi * (3.0 - math.sqrt(5.0))
MARBLES = 760
HEIGHT = 5.2


def glossy(color: list[float]) -> dict[str, Any]:
    """A coloured material that mirrors a little."""
    return {"color": color, "diffuse": 0.7, "specular": 0.3, "shininess": 70.0, "reflection": 0.2}


SETTINGS: dict[str, Any] = {
    "max_depth": 4,
    "min_weight": 0.004,
    "background": "studio.exr",
    "ambient": 0.25,
    "camera": {
        "origin": [0.0, 5.0, 13.5],
        "target": [0.0, 3.65, 0.0],
        "fov": 38.0,
        "fov_axis": "vertical",
        "width": 512,
        "height": 640,
        "spp": 9,
    },
    "materials": {
        "floor": {"color": [0.42, 0.40, 0.40], "diffuse": 0.7, "reflection": 0.25},
        "crown": {
            "color": [0.9, 0.75, 0.45],
            "diffuse": 0.1,
            "specular": 0.7,
            "shininess": 150.0,
            "reflection": 0.8,
            "reflection_color": [1.0, 0.86, 0.6],
        },
        "coral": glossy([0.88, 0.28, 0.20]),
        "teal": glossy([0.02, 0.33, 0.38]),
        "pearl": glossy([0.86, 0.82, 0.74]),
    },
    "lights": [
        {"type": "point", "position": [-7.0, 12.0, 10.0], "intensity": [0.85, 0.78, 0.66]},
        {"type": "point", "position": [9.0, 6.0, 4.0], "intensity": [0.22, 0.30, 0.42]},
    ],
}


def profile(y: float) -> float:
    """The vase's radius at height `y`, 0 to 1: a foot, a belly, a neck, a lip."""
    return 1.2 + 0.5 * math.sin(2.3 * math.pi * y - 0.55)


def heights() -> list[float]:
    """The marbles' heights, 0 to 1, at equal steps of the vase's area, so that they are evenly dense."""
    steps = 4000
    area = [profile(i / steps) for i in range(steps + 1)]
    total, passed = sum(area), 0.0
    found: list[float] = []
    for i, a in enumerate(area):
        passed += a
        if passed / total * MARBLES >= len(found) + 0.5:
            found.append(i / steps)
    return found


def scene() -> dict[str, Any]:
    """The scene as a dict for clrt.load_dict."""
    shapes: list[dict[str, Any]] = [
        {"type": "plane", "point": [0.0, 0.0, 0.0], "normal": [0.0, 1.0, 0.0], "material": "floor"},
        {"type": "sphere", "center": [0.0, HEIGHT + 0.99, 0.0], "radius": 1.5, "material": "crown"},
    ]
    for k, y in enumerate(heights()):
        turn = k * GOLDEN_ANGLE
        radius = 0.062 * math.sqrt(profile(y)) + 0.05
        place = profile(y)
        center = [place * math.cos(turn), 0.14 + y * HEIGHT, place * math.sin(turn)]
        shapes.append(
            {
                "type": "sphere",
                "center": [round(v, 5) for v in center],
                "radius": round(radius, 5),
                "material": "pearl" if k % 8 == 0 else ("coral", "teal", "pearl")[k % 3],
            }
        )
    return {**SETTINGS, "shapes": shapes}


if __name__ == "__main__":
    text = json.dumps(scene(), indent=1) + "\n"
    if len(sys.argv) > 1:
        Path(sys.argv[1]).write_text(text)
    else:
        sys.stdout.write(text)
