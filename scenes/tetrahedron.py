"""A recursive tetrahedron: 1024 tetrahedra, 4096 triangles.

Source: the idea of "tetra" in E. Haines, "A proposal for standard graphics environments", IEEE CG&A 7(11),
1987 (a Sierpinski tetrahedron); the view, the colours and the light are this project's own.
What to look at: light falls through the gaps, so the shadow on the floor is the fractal once more, seen from
the lamp.

    clrt render tetrahedron -o tetrahedron.png
    python scenes/tetrahedron.py scenes/my-tetrahedron.json
"""

from __future__ import annotations

import json
import math
import sys
from pathlib import Path
from typing import Any

LEVELS = 5
SIDE = 4.0
FACES = ((0, 1, 2), (0, 2, 3), (0, 3, 1), (1, 3, 2))

Vector = tuple[float, float, float]

SETTINGS: dict[str, Any] = {
    "max_depth": 3,
    "background": "sky.exr",
    "ambient": [0.20, 0.22, 0.26],
    "camera": {
        "origin": [1.0, 2.6, 8.2],
        "target": [0.15, 1.42, 0.0],
        "fov": 40.0,
        "width": 640,
        "height": 480,
        "spp": 9,
    },
    "materials": {
        "floor": {"color": [0.68, 0.64, 0.60], "diffuse": 0.8, "reflection": 0.10},
        "tetra": {
            "color": [0.85, 0.42, 0.10],
            "diffuse": 0.7,
            "specular": 0.3,
            "shininess": 30.0,
            "reflection": 0.15,
            "reflection_color": [1.0, 0.75, 0.45],
        },
    },
    "lights": [
        {"type": "point", "position": [-5.0, 6.5, 4.0], "intensity": [0.82, 0.76, 0.66]},
        {"type": "point", "position": [6.0, 4.0, 5.0], "intensity": [0.18, 0.22, 0.30]},
    ],
}


def corners() -> list[Vector]:
    """The apex and the three base corners of a regular tetrahedron that stands on y = 0."""
    ring = SIDE / math.sqrt(3.0)
    base = [
        (ring * math.cos(turn), 0.0, -ring * math.sin(turn))
        for turn in (math.radians(80.0 + 120.0 * k) for k in range(3))
    ]
    return [(0.0, SIDE * math.sqrt(2.0 / 3.0), 0.0), *base]


def divide(points: list[Vector], level: int, cells: list[list[Vector]]) -> None:
    """Add the cells of a tetrahedron: one at each of its four corners, half as large."""
    if level == 0:
        cells.append(points)
        return
    for p in points:
        half = [((p[0] + q[0]) / 2.0, (p[1] + q[1]) / 2.0, (p[2] + q[2]) / 2.0) for q in points]
        divide(half, level - 1, cells)


def scene() -> dict[str, Any]:
    """The scene as a dict for clrt.load_dict."""
    cells: list[list[Vector]] = []
    divide(corners(), LEVELS, cells)
    vertices: list[list[float]] = []
    faces: list[list[int]] = []
    for cell in cells:
        first = len(vertices)
        vertices += [[round(v, 6) for v in p] for p in cell]
        faces += [[first + i for i in face] for face in FACES]
    shapes = [
        {"type": "plane", "point": [0.0, -0.02, 0.0], "normal": [0.0, 1.0, 0.0], "material": "floor"},
        {"type": "mesh", "vertices": vertices, "faces": faces, "material": "tetra"},
    ]
    return {**SETTINGS, "shapes": shapes}


if __name__ == "__main__":
    text = json.dumps(scene(), indent=1) + "\n"
    if len(sys.argv) > 1:
        Path(sys.argv[1]).write_text(text)
    else:
        sys.stdout.write(text)
