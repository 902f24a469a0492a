"""What is measured: a terrain, fifty lumpy balls and a sphereflake, large enough to leave every cache; and
two heaps of triangles that are hard on a tree: needles, long and thin, and grains of all sizes.

All surfaces reflect, transmit and gather ambient light, so that one frame gives queues of every kind.
"""

from __future__ import annotations

import math
import runpy
from collections.abc import Callable
from typing import Any, Final

import numpy as np

from clrt.base.resources import scene_folder
from clrt.formats import load_dict
from clrt.scene.scene import Scene

TRIANGLES: Final = 1_000_000
BALLS: Final = 50
LOOSE: Final = 50_000  # triangles
_SETTINGS: Final[dict[str, Any]] = {"background": [0.3, 0.4, 0.5], "ambient": 0.2, "ambient_samples": 1}
_SURFACE: Final[dict[str, Any]] = {
    "color": [0.7, 0.6, 0.5],
    "diffuse": 0.4,
    "specular": 0.3,
    "shininess": 20.0,
    "reflection": 0.3,
    "transmission": 0.3,
    "ior": 1.3,
}
_MIRROR: Final = {**_SURFACE, "transmission": 0.0}
_FILM: Final = {**_SURFACE, "thin": True}  # nothing is inside of a loose triangle
_MATT: Final = {"color": [0.8, 0.7, 0.6], "diffuse": 0.7}
GLASS: Final = "SF10"
GLASS_INDEX: Final = 1.728  # about, in yellow light
_TERRAIN_VIEW: Final = ([9.0, 6.5, 9.0], [0.0, 0.0, 0.0])  # origin, target
_FLAKE_VIEW: Final = ([0.3, 1.6, 3.9], [0.0, 0.05, 0.0])


def terrain(triangles: int = TRIANGLES) -> Scene:
    """About that many triangles over a square of side 20: seven octaves of warped sines."""
    return _scene([_terrain_mesh(triangles, _SURFACE)], *_TERRAIN_VIEW)


def terrain_frame(triangles: int = TRIANGLES, lights: int = 1, max_depth: int = 1) -> Scene:
    """The terrain as a picture: a dull mirror, no ambient rays."""
    return _scene([_terrain_mesh(triangles, _MIRROR)], *_TERRAIN_VIEW, **_frame(lights, max_depth))


def _terrain_mesh(triangles: int, material: dict[str, Any]) -> dict[str, Any]:
    side = max(2, round(math.sqrt(triangles / 2)))
    x, z = np.meshgrid(*(np.linspace(-10.0, 10.0, side + 1),) * 2, indexing="ij")
    rng = np.random.default_rng(3)
    y = np.zeros_like(x)
    for octave in range(7):
        f, (a, b, c, d) = 0.4 * 2**octave, rng.uniform(0.0, 2 * np.pi, 4)
        along = np.sin(f * x + a + np.sin(0.7 * f * z + c))
        y += 1.2 / 1.9**octave * along * np.cos(f * z + b + np.sin(0.6 * f * x + d))
    vertices = np.stack([x, y, z], axis=-1).reshape(-1, 3)
    return {"type": "mesh", "vertices": vertices, "faces": _grid_faces(side, side), "material": material}


def lumps(triangles: int = TRIANGLES) -> Scene:
    """Fifty closed lumpy balls with about that many triangles together, many of them overlapping."""
    rings = max(3, round(math.sqrt(triangles / BALLS / 4)))
    polar, turn = np.meshgrid(
        np.linspace(0.0, np.pi, rings + 1), np.linspace(0.0, 2 * np.pi, 2 * rings + 1), indexing="ij"
    )
    n = np.stack([np.sin(polar) * np.cos(turn), np.cos(polar), np.sin(polar) * np.sin(turn)], axis=-1)
    n = n.reshape(-1, 3)
    rng = np.random.default_rng(5)
    vertices = []
    for ball in range(BALLS):
        lumpy = 1 + 0.08 * np.sin(9 * n[:, 0] + ball) * np.sin(8 * n[:, 1]) * np.sin(7 * n[:, 2])
        vertices.append(n * lumpy[:, None] * rng.uniform(0.4, 1.5) + rng.uniform(-5.0, 5.0, 3))
    faces = _grid_faces(rings, 2 * rings)
    # at the poles one triangle of a square has two equal corners
    across = np.abs(np.cross(*(n[faces[:, k]] - n[faces[:, 0]] for k in (1, 2)))).max(axis=1)
    faces = faces[across > 1e-12]
    every = np.concatenate([faces + ball * len(n) for ball in range(BALLS)])
    mesh = {"type": "mesh", "vertices": np.concatenate(vertices), "faces": every, "material": _SURFACE}
    return _scene([mesh], [0.0, 2.0, 13.0], [0.0, 0.0, 0.0])


def needles(triangles: int = LOOSE) -> Scene:
    """Loose triangles anywhere and any way, fifty times as long as wide: their boxes hold little.

    Of much thinner ones rays meet again what they leave, with us alone: that would be less work.
    """
    rng = np.random.default_rng(7)
    along, across = (_ways(rng, triangles) for _ in range(2))
    return _loose(rng.uniform(-4.0, 4.0, (triangles, 3)), 2.0 * along, 0.04 * across)


def grains(triangles: int = LOOSE) -> Scene:
    """Loose triangles of sides from 0.002 to 2, as many of each size: the large ones are everywhere."""
    rng = np.random.default_rng(11)
    size = 0.002 * 1000.0 ** rng.random((triangles, 1))
    sides = (size * _ways(rng, triangles) for _ in range(2))
    return _loose(rng.uniform(-4.0, 4.0, (triangles, 3)), *sides)


def _ways(rng: np.random.Generator, n: int) -> np.ndarray:
    """Random directions, (n, 3)."""
    found = rng.normal(size=(n, 3))
    return np.asarray(found / np.linalg.norm(found, axis=1, keepdims=True))


def _loose(corner: np.ndarray, first: np.ndarray, second: np.ndarray) -> Scene:
    """Triangles of a corner and two sides, (n, 3) each."""
    vertices = np.stack([corner, corner + first, corner + second], axis=1).reshape(-1, 3)
    faces = np.arange(len(vertices), dtype=np.int32).reshape(-1, 3)
    mesh = {"type": "mesh", "vertices": vertices, "faces": faces, "material": _FILM}
    return _scene([mesh], [0.0, 2.0, 13.0], [0.0, 0.0, 0.0])


def flake(levels: int = 4) -> Scene:
    """The spheres of the shipped sphereflake (7381 at its four levels, 91 at two), all of one material."""
    return _scene(_flake_spheres(levels), *_FLAKE_VIEW)


def flake_frame(lights: int = 3, max_depth: int = 4, levels: int = 4, bands: int | None = None) -> Scene:
    """The sphereflake as a picture: mirrors in front of a plain background, no ambient rays; None: in RGB."""
    settings = _frame(lights, max_depth) | _spectrum(bands)
    return _scene(_flake_spheres(levels, _MIRROR), *_FLAKE_VIEW, **settings)


def glass_ball(ior: str | float, bands: int | None, group: int = 1) -> Scene:
    """A ball of Fresnel glass on 8 % of the picture, between a floor and a wall; bands None: in RGB.

    `group`: bands that dispersion bends together.
    """
    glass = {"diffuse": 0.0, "fresnel": True, "ior": ior}
    shapes: list[dict[str, Any]] = [
        {"type": "plane", "point": [0, 0, 0], "normal": [0, 1, 0], "material": _MATT},
        {"type": "plane", "point": [0, 0, -2], "normal": [0, 0, 1], "material": _MATT},
        {"type": "sphere", "center": [0, 0.7, 0], "radius": 0.56, "material": glass},
    ]
    settings = _frame(1, max_depth=6) | _spectrum(bands, group)
    return _scene(shapes, [0.0, 1.2, 4.0], [0.0, 0.6, 0.0], **settings)


def _spectrum(bands: int | None, group: int = 1) -> dict[str, Any]:
    return {"spectrum": {"bands": bands, "group": group}} if bands else {}


def _frame(lights: int, max_depth: int) -> dict[str, Any]:
    places = ([6.0, 14.0, 4.0], [-8.0, 6.0, 7.0], [3.0, -4.0, 9.0])
    around = [
        {"type": "point", "position": places[i % 3], "intensity": 1.0 / max(lights, 1)} for i in range(lights)
    ]
    return {"lights": around, "max_depth": max_depth, "ambient_samples": 0}


def _flake_spheres(levels: int, material: dict[str, Any] = _SURFACE) -> list[dict[str, Any]]:
    names = runpy.run_path(str(scene_folder() / "sphereflake.py"), run_name="clrt_scene")
    shapes: list[dict[str, Any]] = []
    names["grow"]((0.0, 0.0, 0.0), 1.0, names["AXIS"], names["LEVELS"] - levels, shapes)
    return [{**shape, "material": material} for shape in shapes]


WHOLE: Final[dict[str, Callable[..., Scene]]] = {"terrain": terrain, "lumps": lumps, "flake": flake}
SCENES: Final = {**WHOLE, "needles": needles, "grains": grains}  # of WHOLE all passes are timed


def make(name: str, quick: bool = False) -> Scene:
    """One of SCENES; `quick` makes it small (some 10^4 triangles, 91 spheres)."""
    small = {"flake": 2}.get(name, 20_000)
    return SCENES[name](small) if quick else SCENES[name]()


def _grid_faces(rows: int, columns: int) -> np.ndarray:
    """Two triangles for each square of a grid of (rows + 1) x (columns + 1) vertices, (2 rows columns, 3)."""
    i = np.arange((rows + 1) * (columns + 1), dtype=np.int32).reshape(rows + 1, columns + 1)
    a, b, c, d = (corner.ravel() for corner in (i[:-1, :-1], i[1:, :-1], i[1:, 1:], i[:-1, 1:]))
    return np.stack([a, d, c, a, c, b], axis=1).reshape(-1, 3)


def _scene(shapes: list[dict[str, Any]], origin: list[float], target: list[float], **settings: Any) -> Scene:
    camera = {"origin": origin, "target": target, "fov": 48.0, "width": 512, "height": 512}
    light = {"type": "point", "position": [6.0, 14.0, 4.0]}
    return load_dict({**_SETTINGS, "lights": [light], "camera": camera, "shapes": shapes, **settings})
