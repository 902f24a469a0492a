"""Scenes and rays made by chance, or so that rays meet corners and edges exactly."""

from __future__ import annotations

import itertools
import warnings
from typing import Any

import numpy as np

import clrt

Table = dict[str, Any]


def random_scene(seed: int, shapes: int = 25, spectral: bool = False) -> clrt.Scene:
    """A scene without a camera: shapes of all kinds within some 3 units, any materials, 0 to 4 lights.

    spectral: in bands, with media that disperse, absorb and outrank each other.
    """
    generator = np.random.default_rng(seed)
    table = {
        "max_depth": 3, "ambient": _color(generator), "background": _color(generator),
        "ambient_samples": int(generator.choice([0, 0, 3])),
        "min_weight": float(generator.choice([0, 0.01])),
        "shadow": str(generator.choice(["opaque", "tinted"])), "depth_color": _color(generator),
        "one_sided": str(generator.choice(["none", "none", "opaque"])),
        "conformance": str(generator.choice(["none", "none", "spd"])),
        "medium_ior": float(generator.choice([1.0, 1.333])),
        "lights": [_light(generator) for _ in range(generator.integers(0, 5))],
        "shapes": [_shape(generator) for _ in range(shapes)],
    }  # fmt: skip
    if spectral:
        table["spectrum"] = {"bands": int(generator.integers(2, 13)), "group": int(generator.integers(1, 5))}
        for shape in table["shapes"]:
            shape["material"] |= _medium(generator)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", clrt.ClrtWarning)  # chance makes open glass and more
        return clrt.load_dict(table)


def _color(generator: np.random.Generator) -> list[float]:
    return generator.random(3).round(3).tolist()  # type: ignore[no-any-return]


def _vector(generator: np.random.Generator, size: float = 1.5) -> list[float]:
    return (generator.normal(size=3) * size).tolist()  # type: ignore[no-any-return]


def _light(generator: np.random.Generator) -> Table:
    if generator.random() < 0.3:
        return {"type": "directional", "direction": _vector(generator), "intensity": _color(generator)}
    falloff = str(generator.choice(["none", "inverse-square"]))
    return {
        "type": "point", "position": _vector(generator, 3), "falloff": falloff,
        "intensity": _color(generator),
    }  # fmt: skip


def _material(generator: np.random.Generator) -> Table:
    some = generator.random(8)
    table: Table = {
        "color": _color(generator), "diffuse": some[0] * 0.7,
        "specular": some[1], "shininess": 10 ** (4 * some[2] - 1),
        "highlight_color": _color(generator), "reflection_color": _color(generator),
        "transmission_color": _color(generator), "ior": 1 + some[3] if some[4] < 0.8 else 1.0,
        "fresnel": [False, True, "schlick"][generator.integers(3)], "thin": bool(some[4] < 0.2),
    }  # fmt: skip
    if some[5] < 0.6:
        table["reflection"] = some[5]
    if some[6] < 0.6:
        table["transmission"] = some[6]
    return table


def _medium(generator: np.random.Generator) -> Table:
    some = generator.random(4)
    table: Table = {"priority": int(generator.integers(-1, 3))}
    if some[0] < 0.5:
        table["ior"] = str(generator.choice(["BK7", "SF10", "SF11", "silica"]))
    if some[1] < 0.5:
        start = 380 + 300 * some[2]
        table["transmission_color"] = {"band": [start, start + 90]}
    if some[3] < 0.5:
        table["absorption"] = _color(generator)
    return table


def _shape(generator: np.random.Generator) -> Table:
    a, b = _vector(generator), _vector(generator, 0.7)
    size, other = float(generator.uniform(0.1, 0.8)), float(generator.uniform(0.05, 0.6))
    end = [x + y for x, y in zip(a, b, strict=True)]
    caps = bool(generator.random() < 0.5)
    points = np.array(a) + generator.normal(size=(3, 3)) * size
    kinds: list[Table] = [
        {"type": "sphere", "center": a, "radius": size},
        {"type": "plane", "point": [3 * x for x in a], "normal": b},
        {"type": "polygon", "points": points.tolist()},
        {"type": "mesh", "smooth": caps, "vertices": [*points.tolist(), end],
         "faces": [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]},
        {"type": "quadric", "coefficients": [*generator.normal(size=9).tolist(), -other]},
        {"type": "quadric", "coefficients": [1, 1, -1, *generator.normal(size=6).tolist(), -other],
         "clip": [[-1, -size, -1], [size, 1, other]]},
        {"type": "ellipsoid", "center": a, "radii": [size, other, 0.3]},
        {"type": "cylinder", "p0": a, "p1": end, "radius": size, "caps": caps},
        {"type": "cone", "p0": a, "p1": end, "r0": size, "r1": 0.0 if other < 0.2 else other, "caps": caps},
        {"type": "paraboloid", "apex": a, "axis": b, "focal": other, "height": size},
        {"type": "disk", "center": a, "normal": b, "radius": size},
        {"type": "box", "min": a, "max": [x + size for x in a]},
    ]  # fmt: skip
    table = kinds[generator.integers(len(kinds))]
    table["material"] = _material(generator)
    if table["type"] != "plane" and generator.random() < 0.4:
        turn = {"rotate": [_vector(generator), float(generator.uniform(-180, 180))]}
        scale = float(generator.choice([-1.2, 0.7]))
        table["transform"] = [turn, {"scale": [scale] * 3}, {"translate": _vector(generator, 0.5)}]
    if table["type"] in ("sphere", "plane", "polygon", "disk") and generator.random() < 0.4:
        table["material"]["color"] = {"type": "checker", "size": other, "divisions": 9}
    return table


def on_the_grid() -> clrt.Scene:
    """Shapes with small whole coordinates, so that `grid_rays` touch corners, edges and rims exactly."""
    square = [[-1, -1], [1, -1], [1, 1], [-1, 1]]
    ell = [[-2, -2], [2, -2], [2, 0], [0, 0], [0, 2], [-2, 2]]  # concave
    octahedron = {
        "vertices": [[5, 0, 0], [9, 0, 0], [7, -2, 0], [7, 2, 0], [7, 0, -2], [7, 0, 2]],
        "faces": [[0, 2, 5], [0, 5, 3], [0, 3, 4], [0, 4, 2], [1, 5, 2], [1, 3, 5], [1, 4, 3], [1, 2, 4]],
    }
    below = [{"translate": [0, -4, 0]}]
    glass = {"transmission": 0.5, "reflection": 0.2, "diffuse": 0.3}
    return clrt.load_dict({
        "background": 0.5, "min_weight": 0.2, "lights": [{"type": "point", "position": [2, 2, 2]}],
        "materials": {"glass": glass, "check": {"color": {"type": "checker"}}},
        "shapes": [
            {"type": "sphere", "center": [0, 0, 0], "radius": 1, "material": "glass"},
            {"type": "polygon", "points": [[x, y, 4] for x, y in ell], "material": "check"},
            {"type": "polygon", "points": [[x, y, -4] for x, y in square[:3]]},
            {"type": "polygon", "points": [[x, y, -4] for x, y in [square[0], *square[2:]]]},
            {"type": "disk", "center": [0, 4, 0], "normal": [0, 1, 0], "radius": 2, "material": "check"},
            {"type": "cylinder", "p0": [-4, -1, 0], "p1": [-4, 1, 0], "radius": 1},
            {"type": "quadric", "coefficients": [1, 1, -1, 0, 0, 0, 0, 0, 0, 0], "transform": below,
             "clip": [[-1, -1, -1], [1, 1, 1]]},
            {"type": "mesh", **octahedron, "material": "glass"},
            {"type": "plane", "point": [0, 0, -6], "normal": [0, 0, 1], "material": "check"},
        ],
    })  # fmt: skip


def grid_rays() -> tuple[np.ndarray, np.ndarray]:
    """Axis-parallel and diagonal rays from all half-integer places around `on_the_grid`: (n, 3) each."""
    place = np.arange(-9, 9.5, 0.5)
    origins, directions = [], []
    for axis, sign in itertools.product(range(3), (-1.0, 1.0)):
        u, v = (g.ravel() for g in np.meshgrid(place, place))
        o, d = np.zeros((len(u), 3)), np.zeros((len(u), 3))
        o[:, (axis + 1) % 3], o[:, (axis + 2) % 3], o[:, axis] = u, v, -10 * sign
        d[:, axis] = sign
        diagonal = d.copy()
        diagonal[:, (axis + 1) % 3] = sign
        origins += [o, o]
        directions += [d, diagonal]
    return np.concatenate(origins).astype(np.float32), np.concatenate(directions).astype(np.float32)


def crowd(kind: str, n: int, seed: int, scale: float = 1.0) -> clrt.Scene:
    """`n` primitives within some 3 units, times `scale`; a tenth of them stand twice at the same place."""
    generator = np.random.default_rng(seed)
    place = generator.normal(size=(n, 3)) * scale
    size = 10 ** generator.uniform(-2.5, -0.5, n) * scale
    twice = generator.integers(0, n, n // 10)
    place[: len(twice)], size[: len(twice)] = place[twice], size[twice]
    shapes: list[Table] = []
    if kind == "triangles":
        corners = place[:, None] + generator.normal(size=(n, 3, 3)) * size[:, None, None]
        corners[: len(twice)] = corners[twice]
        faces = np.arange(3 * n).reshape(n, 3).tolist()
        shapes.append({"type": "mesh", "vertices": corners.reshape(-1, 3).tolist(), "faces": faces})
    for i, (p, r) in enumerate(zip(place.tolist(), size.tolist(), strict=True)):
        other = [x + r for x in p]
        if kind == "concentric spheres":
            shapes.append({"type": "sphere", "center": [0, 0, 0], "radius": r})
        elif kind == "spheres" or (kind == "mixed" and i % 5 == 0):
            shapes.append({"type": "sphere", "center": p, "radius": r})
        elif kind == "mixed":
            shapes.append([
                {"type": "disk", "center": p, "normal": other, "radius": r},
                {"type": "box", "min": p, "max": other},
                {"type": "cylinder", "p0": p, "p1": other, "radius": r},
                {"type": "mesh", "vertices": [p, other, place[i - 1].tolist()], "faces": [[0, 1, 2]]},
            ][i % 5 - 1])  # fmt: skip
    return clrt.load_dict({"shapes": shapes})


def crowd_rays(n: int, seed: int, scale: float = 1.0) -> tuple[np.ndarray, np.ndarray]:
    """Rays for `crowd`: a third from one point and side by side, a third parallel to axes, a third anyhow."""
    generator = np.random.default_rng(seed)
    origins = generator.normal(size=(n, 3)) * 2
    directions = generator.normal(size=(n, 3))
    eye = n // 3
    origins[:eye] = 0, 0, 6
    x, y = generator.uniform(-0.5, 0.5, (2, eye))
    directions[:eye] = np.c_[np.sort(x), y, -np.ones(eye)]
    directions[eye : 2 * eye] = np.eye(3)[generator.integers(0, 3, eye)] * generator.choice([-1, 1], (eye, 1))
    return (origins * scale).astype(np.float32), directions.astype(np.float32)
