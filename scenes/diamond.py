"""A brilliant-cut diamond, whose index is a curve.

Source: M. Tolkowsky, "Diamond Design", 1919 (crown of 34.5, pavilion of 40.75 degrees, table of 53 %); the
index by Peter 1923. The lecture notes name diamond; dispersion they leave out.
What to look at: what enters through the crown is reflected totally by the facets below and comes back out; on
its way it falls apart into colours, the fire. The reflections on the facets themselves stay white.

    clrt render diamond -o diamond.png
    python scenes/diamond.py scenes/my-diamond.json
"""

from __future__ import annotations

import json
import math
import sys
from pathlib import Path
from typing import Any

CROWN, PAVILION, TABLE = math.radians(34.5), math.radians(40.75), 0.53
SIDE_ABOVE, SIDE_BELOW = 0.78, 0.22  # radii at which facets of the crown and the pavilion meet


def brilliant() -> tuple[list[list[float]], list[list[int]]]:
    """Vertices and faces, counter-clockwise from outside, of the 57 facets; the girdle is round (0, 0, 0)."""
    def height(radius: float, turn: float, slope: float) -> float:
        """Of a main facet's plane, which touches the girdle at turn 0."""
        return (1 - radius * math.cos(turn)) * math.tan(slope)

    eighth, half = math.pi / 4, math.pi / 8

    def at(radius: float, turn: float, y: float) -> list[float]:
        return [radius * math.cos(turn), y, radius * math.sin(turn)]

    top, above = height(TABLE, 0, CROWN), height(SIDE_ABOVE, half, CROWN)
    below, culet = -height(SIDE_BELOW, half, PAVILION), -height(0, 0, PAVILION)
    vertices = [at(TABLE, k * eighth, top) for k in range(8)]
    vertices += [at(SIDE_ABOVE, k * eighth + half, above) for k in range(8)]
    vertices += [at(1.0, k * half, 0.0) for k in range(16)]
    vertices += [at(SIDE_BELOW, k * eighth + half, below) for k in range(8)]
    vertices.append([0.0, culet, 0.0])
    faces = [[7 - k for k in range(8)]]
    for k in range(8):
        j = (k + 1) % 8
        side, last_side, girdle, between = 8 + k, 8 + (k - 1) % 8, 16 + 2 * k, 16 + 2 * k + 1
        after, low, last_low = 16 + 2 * j, 32 + k, 32 + (k - 1) % 8
        faces += [[k, j, side], [k, side, girdle, last_side], [side, between, girdle], [side, after, between]]
        faces += [[40, last_low, girdle, low], [low, girdle, between], [low, between, after]]
    return vertices, faces


def scene() -> dict[str, Any]:
    """What a scene file would hold."""
    vertices, faces = brilliant()
    stone = {"diffuse": 0.0, "fresnel": True, "ior": "diamond-dispersive"}
    lying = [{"rotate": ["y", 11.0]}, {"rotate": ["z", -14.0]}, {"translate": [0.0, 0.86, 0.0]}]
    checker = {"type": "checker", "colors": [0.20, 0.09], "size": 0.35}
    floor = {"color": checker, "diffuse": 0.9, "reflection": 0.07}
    return {
        "spectrum": {"bands": 12},
        "max_depth": 7,
        "min_weight": 0.06,
        "background": "studio.exr",
        "ambient": 0.3,
        "camera": {"origin": [0.4, 3.1, 3.4], "target": [0.0, 0.62, 0.0], "fov": 34.0,
                   "width": 360, "height": 300, "spp": 4},
        "lights": [{"type": "point", "position": [-3.0, 6.0, 4.0],
                    "intensity": {"name": "D65", "scale": 0.7}}],
        "shapes": [
            {"type": "plane", "point": [0, 0, 0], "normal": [0, 1, 0], "material": floor},
            {"type": "mesh", "vertices": vertices, "faces": faces, "transform": lying, "material": stone},
        ],
    }  # fmt: skip


if __name__ == "__main__":
    Path(sys.argv[1]).write_text(json.dumps(scene(), indent=1))
