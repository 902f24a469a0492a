"""The rainbow in one drop of water.

Source: lecture notes, refraction; Descartes' ray, which leaves a drop 42 degrees from where the light came
from (docs/model.md, number 11).
What to look at: a tube behind the camera stands for the sun. The drop shows it twice: white above, reflected
on the outside, and below, reflected once on the inside. That image is double, for two rays leave the drop in
each direction, until they meet in Descartes' ray: beyond 40.6 degrees from where the light came from no
violet returns, beyond 42.4 no red. So the two lines are coloured, and where they join all colours end one
after the other. That is how rain makes a rainbow.

    clrt render rainbow -o rainbow.png
    python scenes/rainbow.py scenes/my-rainbow.json
"""

from __future__ import annotations

import json
import math
import sys
from pathlib import Path
from typing import Any

ELEVATION = 18.0  # degrees of the tube behind the camera
LONG, THICK, FAR = 22.0, 0.22, 400.0  # half its size in degrees, and how far it is
ANGLE, AWAY, RADIUS = 40.9, 2.0, 0.66  # degrees from the point opposite the tube at which its light returns
EYE = (0.0, 1.6, 0.0)

Vector = list[float]


def towards(angle: float) -> Vector:
    """The direction upwards from the point opposite the tube, by an angle in degrees."""
    up = math.radians(angle - ELEVATION)
    return [0.0, math.sin(up), -math.cos(up)]


def off(start: tuple[float, ...], direction: Vector, distance: float) -> Vector:
    """The point so far from `start`."""
    return [round(s + distance * d, 4) for s, d in zip(start, direction, strict=True)]


def tube() -> list[Vector]:
    """The corners of a strip, seen from the eye."""
    x, y = (FAR * math.tan(math.radians(half)) for half in (LONG, THICK))
    middle, up = off(EYE, towards(0.0), -FAR), towards(90.0)
    return [[round(m + a * x * r + b * y * u, 4) for m, r, u in zip(middle, (1.0, 0.0, 0.0), up, strict=True)]
            for a, b in ((-1, -1), (1, -1), (1, 1), (-1, 1))]  # fmt: skip


def scene() -> dict[str, Any]:
    """What a scene file would hold."""
    below = math.degrees(math.asin(0.86 * RADIUS / AWAY))  # from the drop's middle to its rainbow
    drop = {"type": "sphere", "center": off(EYE, towards(ANGLE + below), AWAY), "radius": RADIUS}
    grass = {"color": {"type": "checker", "colors": [[0.22, 0.30, 0.13], [0.16, 0.23, 0.10]], "size": 2.0}}
    return {
        "spectrum": {"bands": 24},
        "max_depth": 3,
        "min_weight": 0.015,
        "background": [0.09, 0.115, 0.16],
        "ambient": 0.5,
        "camera": {"origin": list(EYE), "target": off(EYE, towards(ANGLE + 0.8 * below), AWAY), "fov": 46.0,
                   "width": 400, "height": 300, "spp": 4},
        "lights": [{"type": "directional", "direction": towards(0.0), "intensity": 0.5}],
        "shapes": [
            {"type": "plane", "point": [0, 0, 0], "normal": [0, 1, 0], "material": grass},
            {"type": "polygon", "points": tube(),
             "material": {"color": 0.0, "emission": {"name": "D65", "scale": 30.0}}},
            {**drop, "material": {"diffuse": 0.0, "fresnel": True, "ior": "water-dispersive"}},
        ],
    }  # fmt: skip


if __name__ == "__main__":
    Path(sys.argv[1]).write_text(json.dumps(scene(), indent=1))
