"""One still life under three lights: daylight (D65), a filament lamp (A) and a fluorescent tube (F11).

Source: thesis, chapter 3 (light and surfaces as sampled spectra); the lights are CIE standard illuminants,
the 24 patches those of the ColorChecker chart.
What to look at: three booths hold the same things. Under A all is orange, under F11, which has most of its
light in a few narrow lines, the reds fall back and some patches change places: three numbers for a colour
could not tell these lights apart from filters.

    clrt render booths -o booths.png
    python scenes/booths.py scenes/my-booths.json
"""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any

LIGHTS = ("D65", "A", "F11")
WIDTH, HEIGHT, DEPTH, WALL = 2.0, 2.2, 1.8, 0.08
PATCH, GAP = 0.27, 0.03

Vector = tuple[float, float, float]


def booth(light: str, x: float) -> dict[str, list[dict[str, Any]]]:
    """Lights and shapes of the booth whose middle is at x."""
    paint = {"color": 0.55, "diffuse": 0.8}
    shapes: list[dict[str, Any]] = [
        _box((x - WIDTH / 2, 0, -DEPTH - WALL), (x + WIDTH / 2, HEIGHT, -DEPTH), paint),
        _box((x - WIDTH / 2 - WALL, 0, -DEPTH), (x - WIDTH / 2, HEIGHT, 0), paint),
        _box((x + WIDTH / 2, 0, -DEPTH), (x + WIDTH / 2 + WALL, HEIGHT, 0), paint),
        _box((x - WIDTH / 2, HEIGHT, -DEPTH), (x + WIDTH / 2, HEIGHT + WALL, 0), paint),
        _box((x - WIDTH / 2, -WALL, -DEPTH), (x + WIDTH / 2, 0, 0), {"color": 0.7, "diffuse": 0.8}),
    ]
    for number in range(24):
        column, row = number % 6, number // 6
        left = x + (column - 3) * (PATCH + GAP) + GAP / 2
        low = HEIGHT - 0.35 - (row + 1) * (PATCH + GAP)
        corners = [[left, low], [left + PATCH, low], [left + PATCH, low + PATCH], [left, low + PATCH]]
        points = [[a, b, -DEPTH + 0.01] for a, b in corners]
        material = {"color": f"patch-{number + 1}", "diffuse": 1.0}
        shapes.append({"type": "polygon", "points": points, "material": material})
    shapes += [
        _ball((x - 0.55, 0.32, -0.95), 0.32, {"color": 0.85, "diffuse": 0.9}),
        _ball((x + 0.1, 0.26, -0.65), 0.26, {"color": "patch-15", "diffuse": 0.7, "specular": 0.3,
                                                     "shininess": 50}),
        _ball((x + 0.66, 0.24, -0.9), 0.24, {"diffuse": 0.0, "conductor": "gold"}),
    ]
    lamp = {"type": "point", "position": [x, HEIGHT - 0.12, -0.35],
            "intensity": {"name": light, "scale": 0.95}}
    return {"lights": [lamp], "shapes": shapes}


def _box(low: Vector, high: Vector, material: dict[str, Any]) -> dict[str, Any]:
    return {"type": "box", "min": list(low), "max": list(high), "material": material}


def _ball(center: Vector, radius: float, material: dict[str, Any]) -> dict[str, Any]:
    return {"type": "sphere", "center": list(center), "radius": radius, "material": material}


def scene() -> dict[str, Any]:
    """What a scene file would hold."""
    parts = [booth(light, (i - 1) * (WIDTH + 2 * WALL)) for i, light in enumerate(LIGHTS)]
    camera = {"origin": [0.0, 1.3, 17.0], "target": [0.0, 1.1, 0.0], "fov": 22.5,
              "width": 800, "height": 320, "spp": 9}
    return {
        "spectrum": {"bands": 24},
        "max_depth": 3,
        "background": 0.3,
        "camera": camera,
        "lights": [light for part in parts for light in part["lights"]],
        "shapes": [shape for part in parts for shape in part["shapes"]],
    }


if __name__ == "__main__":
    Path(sys.argv[1]).write_text(json.dumps(scene(), indent=1))
