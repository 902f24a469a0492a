"""Materials and lights of a scene as plain arrays, for the worker."""

from __future__ import annotations

from typing import Any

import numpy as np

from . import skies
from .forms import Array
from .hashing import basis
from .palette import Bands, Colors
from .records import AreaLight, Checker, DirectionalLight, Material, Picture, Scene, SpotLight
from .shapes import Disk, Plane, Polygon, Sphere

Palette = Colors | Bands
COLORS = Colors()

PLAIN, SQUARES, GLOBE = 0, 1, 2


def materials(scene: Scene, palette: Palette = COLORS) -> dict[str, Array]:
    """One row a shape, one a light, and a last one for misses: coefficients, tints, flags and checkers in the
    model's letters."""
    rows = [_row(palette, shape, scene.material_of(shape)) for shape in scene.shapes]
    rows += [
        _row(palette, None, Material(color=0.0, diffuse=0.0, emission=light.intensity))
        for light in scene.lights
    ]
    rows.append(_row(palette, None, Material()))
    return {name: np.array([row[name] for row in rows]) for name in rows[0]}


def _row(palette: Palette, shape: Any, material: Any) -> dict[str, Any]:
    metal = material.conductor
    n, k = (np.ones(3), np.zeros(3)) if metal is None else palette.metal(metal)
    checker = material.color if isinstance(material.color, Checker) else None
    first, second = checker.colors if checker else (material.color, material.color)
    first, second, highlight, mirror, tint, light = (
        0.0 if isinstance(value, Picture) else value  # `pictures` has it
        for value in (first, second, material.highlight_color, material.reflection_color,
                      material.transmission_color, material.emission)
    )  # fmt: skip
    pattern = PLAIN if checker is None else GLOBE if isinstance(shape, Sphere) else SQUARES
    origin, across, up = squares(shape) if pattern == SQUARES else np.zeros((3, 3))
    return {
        "F": palette.reflectance(first),
        "F2": palette.reflectance(second),
        "ka": material.ka,
        "kd": material.diffuse,
        "ks": material.specular,
        "m": material.shininess,
        "kr": material.kr,
        "kt": material.kt,
        "eta": palette.eta(material),
        "H": palette.reflectance(highlight),
        "M": palette.reflectance(mirror),
        "Tt": palette.reflectance(tint),
        "e": palette.light(light),
        "thin": bool(material.thin),
        "fresnel": material.fresnel is True,
        "schlick": material.fresnel == "schlick",
        "conductor": metal is not None,
        "alpha": material.alpha,
        "n": n,
        "k": k,
        "pattern": pattern,
        "size": checker.size if checker else 1.0,
        "divisions": checker.divisions if checker else 1,
        "origin": origin,
        "across": across,
        "up": up,
    }


def squares(shape: Any) -> tuple[Array, Array, Array]:
    """Where a checker of squares starts in world space, and the directions of its two sides."""
    matrix = shape.matrix
    if isinstance(shape, Polygon):
        points = np.asarray(shape.points)
        local = points - points[0]
        start, normal = points[0], np.sum(np.cross(local, np.roll(local, -1, axis=0)), axis=0)
    elif isinstance(shape, Disk):
        start, normal = np.asarray(shape.center), np.asarray(shape.normal, float)
    else:
        assert isinstance(shape, Plane)
        start, normal = np.asarray(shape.point), np.asarray(shape.normal, float)
    normal = normal @ np.linalg.inv(matrix[:3, :3])
    normal /= np.linalg.norm(normal)
    axis = np.eye(3)[np.argmin(np.abs(normal))]
    across = axis - (axis @ normal) * normal
    across /= np.linalg.norm(across)
    return matrix[:3, :3] @ start + matrix[:3, 3], across, np.cross(normal, across)


def media(scene: Scene, palette: Palette = COLORS) -> dict[str, Array]:
    """What media.Media takes: by shape, and by medium with the surroundings last."""
    materials = [scene.material_of(shape) for shape in scene.shapes]
    bounding = [m.kt > 0 and not m.thin and scene.conformance == "none" for m in materials]
    distinct: list[Any] = []
    for material, bounds in zip(materials, bounding, strict=True):
        if bounds and material not in distinct:
            distinct.append(material)
    number = [distinct.index(m) if bounds else -1 for m, bounds in zip(materials, bounding, strict=True)]
    sigma = [palette.absorption(m.absorption) for m in distinct]
    return {
        "number": np.array([*number, *(-1 for _ in scene.lights), -1]),
        "priority": np.array([*(float(m.priority) for m in distinct), -np.inf]),
        "eta": np.array([*(palette.eta(m) for m in distinct), float(scene.medium_ior)]),
        "sigma": np.array([*sigma, (0.0, 0.0, 0.0)]),
    }


def lights(scene: Scene, palette: Palette = COLORS) -> list[dict[str, Any]]:
    """Each light's `type`, `near` (bool: it has a place), `at` (that, or a unit direction to it),
    `intensity` (3,), `falloff` (bool), and what only its kind has."""
    return [_light(light, palette) for light in scene.lights]


def _light(light: Any, palette: Palette) -> dict[str, Any]:
    found = {"type": light.type, "near": True, "intensity": palette.light(light.intensity)}
    if isinstance(light, DirectionalLight):
        at = np.asarray(light.direction, float)
        return found | {"near": False, "at": -at / np.linalg.norm(at), "falloff": False}
    if isinstance(light, AreaLight):
        return found | {"falloff": True} | _extent(light)
    found |= {"at": np.asarray(light.position, float), "falloff": light.falloff == "inverse-square"}
    if isinstance(light, SpotLight):
        axis = np.subtract(light.target, light.position)
        found |= {"axis": axis / np.linalg.norm(axis), "angle": light.angle, "penumbra": light.penumbra}
    return found


def _extent(light: AreaLight) -> dict[str, Any]:
    """Middle, half sides `u`, `v` or radii across each other, normal and `area`; of a sphere `radius`."""
    found = {name: getattr(light, name) for name in ("samples", "two_sided", "visible", "radius")}
    found["at"] = np.asarray(light.center, float)
    if light.type == "rectangle":
        u, v = np.asarray(light.u, float), np.asarray(light.v, float)
        normal = np.cross(u, v)
        return found | {"u": u, "v": v, "area": 4 * np.linalg.norm(normal), "normal": _length_1(normal)}
    if light.type == "disk":
        normal = _length_1(np.asarray(light.normal, float))
        u, v = (light.radius * side[0] for side in basis(normal[None]))
        return found | {"u": u, "v": v, "area": np.pi * light.radius**2, "normal": normal}
    return found


def _length_1(v: Array) -> Array:
    return np.asarray(v / np.linalg.norm(v))


def emitter(light: dict[str, Any], center: Array, color: Any) -> dict[str, Any]:
    """Mitsuba's plugin for a light, about `center`; `color` makes three numbers a plugin.

    An intensity of pi I on a reflectance of F kd sends I F kd.
    """
    strength = color(np.pi * light["intensity"])
    if not light["near"]:
        return {"type": "directional", "direction": (-light["at"]).tolist(), "irradiance": strength}
    place = light["at"] - center
    if "samples" in light:
        return _area_emitter(light, place, color(light["intensity"]))
    if light["type"] == "point":
        return {"type": "point", "position": place.tolist(), "intensity": strength}
    to_world = np.eye(4)
    across = np.cross(np.eye(3)[np.argmin(np.abs(light["axis"]))], light["axis"])
    to_world[:3, 0] = across / np.linalg.norm(across)
    to_world[:3, 1] = np.cross(light["axis"], to_world[:3, 0])
    to_world[:3, 2], to_world[:3, 3] = light["axis"], place
    cone = {"cutoff_angle": light["angle"], "beam_width": light["angle"] * (1 - light["penumbra"])}
    return {"type": "spot", "to_world": to_world, "intensity": strength, **cone}


def _area_emitter(light: dict[str, Any], place: Array, radiance: Any) -> dict[str, Any]:
    """A black shape that shines on one side."""
    black = {"type": "diffuse", "reflectance": {"type": "rgb", "value": [0.0, 0.0, 0.0]}}
    inner = {"bsdf": black, "emitter": {"type": "area", "radiance": radiance}}
    if light["type"] == "sphere":
        return {"type": "sphere", "center": place.tolist(), "radius": float(light["radius"]), **inner}
    to_world = np.eye(4)
    sides = (light["u"], light["v"], light["normal"], place)
    for column, side in enumerate(sides):
        to_world[:3, column] = side
    return {"type": light["type"], "to_world": to_world, **inner}


def settings(scene: Scene, palette: Palette = COLORS) -> dict[str, Any]:
    """What the model reads of the scene besides."""
    return {
        "max_depth": scene.max_depth,
        "min_weight": scene.min_weight if scene.conformance == "none" else 0.0,
        "depth_color": palette.light(scene.depth_color),
        "ambient": palette.light(scene.ambient),
        "ambient_samples": scene.ambient_samples,
        "medium_ior": float(scene.medium_ior),
        "hides_backs": scene.one_sided == "opaque",
        "tinted": scene.shadow == "tinted",
        "background": background(scene, palette),
    }


def background(scene: Scene, palette: Palette = COLORS) -> Any:
    """A colour (3,), or a lat-long image: its path (str), or what three bands see of it (h, w, 3)."""
    path = scene.background_path
    if path is None:
        return palette.light(scene.background)
    return str(path) if palette is COLORS else palette.background(skies.read(str(path)))
