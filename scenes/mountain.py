"""A fractal mountain with four glass spheres over a lake.

Source: the idea of "mount" in E. Haines, "A proposal for standard graphics environments", IEEE CG&A 7(11),
1987; the terrain is a diamond-square surface (Fournier, Fussell, Carpenter 1982) around a peak.
What to look at: the spheres turn the landscape upside down; the lake mirrors it. Rock, meadow and snow are
three meshes with the normals of the whole, cut by height and steepness: 131072 triangles less those that the
lake hides.

    clrt render mountain -o mountain.png
    python scenes/mountain.py scenes/my-mountain.json
"""

from __future__ import annotations

import json
import math
import random
import sys
from pathlib import Path
from typing import Any

LEVELS = 8
SIZE = 16.0
SEED = 1982
ROUGHNESS = 0.53
SPHERES = (
    ([-1.30, 1.40, 5.0], 0.54),
    ([-0.15, 0.72, 5.8], 0.44),
    ([1.25, 1.65, 4.8], 0.62),
    ([2.05, 0.70, 5.6], 0.40),
)

Grid = list[list[float]]

SETTINGS: dict[str, Any] = {
    "max_depth": 6,
    "min_weight": 0.01,
    "background": "sky.exr",
    "ambient": [0.17, 0.20, 0.25],
    "shadow": "tinted",
    "camera": {
        "origin": [0.4, 2.2, 11.4],
        "target": [0.3, 1.35, 0.0],
        "fov": 42.0,
        "width": 640,
        "height": 480,
        "spp": 9,
    },
    "materials": {
        "lake": {
            "color": [0.045, 0.19, 0.25],
            "diffuse": 0.3,
            "reflection": 0.7,
            "reflection_color": 0.04,
            "fresnel": "schlick",
        },
        "rock": {"color": [0.34, 0.29, 0.25]},
        "meadow": {"color": [0.20, 0.30, 0.09]},
        "snow": {"color": [0.88, 0.90, 0.94]},
        "glass": {
            "diffuse": 0.0,
            "specular": 0.5,
            "shininess": 300.0,
            "fresnel": True,
            "ior": "glass",
        },
    },
    "lights": [
        {"type": "directional", "direction": [-0.75, -0.6, -0.25], "intensity": [0.92, 0.84, 0.70]},
    ],
}


def diamond_square(levels: int, seed: int) -> Grid:
    """A square of (2^levels + 1)^2 heights; the random steps shrink by ROUGHNESS a level."""
    n = 2**levels
    source = random.Random(seed)
    height = [[0.0] * (n + 1) for _ in range(n + 1)]
    step, scale = n, 1.0
    while step > 1:
        half = step // 2
        for y in range(half, n, step):
            for x in range(half, n, step):
                around = [height[y + i][x + j] for i in (-half, half) for j in (-half, half)]
                height[y][x] = sum(around) / 4.0 + scale * (source.random() - 0.5)
        for y in range(0, n + 1, half):
            for x in range((y + half) % step, n + 1, step):
                near = [(y - half, x), (y + half, x), (y, x - half), (y, x + half)]
                around = [height[i][j] for i, j in near if 0 <= i <= n and 0 <= j <= n]
                height[y][x] = sum(around) / len(around) + scale * (source.random() - 0.5)
        step, scale = half, scale * ROUGHNESS
    return height


def terrain() -> tuple[list[list[float]], list[list[int]]]:
    """Vertices and triangles: the fractal, lifted towards a peak and lowered below the lake in front."""
    n = 2**LEVELS
    fractal = diamond_square(LEVELS, SEED)
    vertices = []
    for i in range(n + 1):
        for j in range(n + 1):
            x, z = (j / n - 0.5) * SIZE, (i / n - 0.5) * SIZE
            peak = 2.9 * math.exp(-0.20 * ((x + 1.0) ** 2 + (z + 1.5) ** 2))
            ridge = 1.7 * math.exp(-0.10 * ((x - 4.5) ** 2 + 1.5 * (z + 3.0) ** 2))
            shore = 0.30 * max(0.0, z + 1.0)
            y = peak + ridge + 4.2 * fractal[i][j] - 0.35 - shore
            vertices.append([round(x, 5), round(y, 5), round(z, 5)])
    faces = []
    for i in range(n):
        for j in range(n):
            a = i * (n + 1) + j
            b, c, d = a + 1, a + n + 1, a + n + 2
            faces += [[a, c, b], [b, c, d]]
    return vertices, faces


def normals(vertices: list[list[float]]) -> list[list[float]]:
    """Smooth normals of the grid by central differences, one a vertex."""
    n = 2**LEVELS + 1
    result = []
    for i in range(n):
        for j in range(n):
            west, east = vertices[i * n + max(j - 1, 0)], vertices[i * n + min(j + 1, n - 1)]
            north, south = vertices[max(i - 1, 0) * n + j], vertices[min(i + 1, n - 1) * n + j]
            dx = (east[1] - west[1]) / (east[0] - west[0])
            dz = (south[1] - north[1]) / (south[2] - north[2])
            result.append([round(-dx, 4), 1.0, round(-dz, 4)])
    return result


def cover(a: list[float], b: list[float], c: list[float]) -> str:
    """What grows on a triangle: snow high up, meadow where it is low and level, rock elsewhere."""
    u, v = [b[k] - a[k] for k in range(3)], [c[k] - a[k] for k in range(3)]
    up = u[2] * v[0] - u[0] * v[2]
    area = math.hypot(u[1] * v[2] - u[2] * v[1], up, u[0] * v[1] - u[1] * v[0])
    level, height = up / area, (a[1] + b[1] + c[1]) / 3.0
    if height + 1.6 * (level - 0.75) > 2.0:
        return "snow"
    return "meadow" if height - 2.0 * (level - 0.75) < 0.75 else "rock"


def scene() -> dict[str, Any]:
    """The scene as a dict for clrt.load_dict."""
    vertices, faces = terrain()
    upright = normals(vertices)
    covers: dict[str, list[list[int]]] = {"rock": [], "meadow": [], "snow": []}
    for face in faces:
        corners = [vertices[k] for k in face]
        if max(corner[1] for corner in corners) > -0.3:  # what the lake hides is left out
            covers[cover(*corners)].append(face)
    shapes: list[dict[str, Any]] = [
        {"type": "plane", "point": [0.0, 0.0, 0.0], "normal": [0.0, 1.0, 0.0], "material": "lake"}
    ]
    for name, part in covers.items():
        used = sorted({k for face in part for k in face})
        place = {k: i for i, k in enumerate(used)}
        renumbered = [[place[k] for k in face] for face in part]
        mesh: dict[str, Any] = {"type": "mesh", "name": name, "material": name, "faces": renumbered}
        mesh["vertices"], mesh["normals"] = [vertices[k] for k in used], [upright[k] for k in used]
        shapes.append(mesh)
    for center, radius in SPHERES:
        shapes.append({"type": "sphere", "center": center, "radius": radius, "material": "glass"})
    return {**SETTINGS, "shapes": shapes}


if __name__ == "__main__":
    text = json.dumps(scene(), indent=1) + "\n"
    if len(sys.argv) > 1:
        Path(sys.argv[1]).write_text(text)
    else:
        sys.stdout.write(text)
