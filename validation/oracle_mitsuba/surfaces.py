"""Materials, lights and camera of a scene as plain arrays, for the worker."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from . import skies
from .forms import Array
from .hashing import basis, camera_words, combine, mix, on_disk, unit
from .palette import Bands, Colors
from .records import (
    AreaLight,
    Camera,
    Checker,
    DirectionalLight,
    Disk,
    Material,
    Picture,
    Plane,
    Polygon,
    Scene,
    Sphere,
    SpotLight,
)

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


def sensor(camera: Camera, width: int, height: int, scale: float, center: Any = 0.0) -> dict[str, Any]:
    """The camera about `center` as a plugin of Mitsuba's, for pictures of width x height; `scale`: the
    scene's size.

    Mitsuba's camera looks along +z with +x to the left. `near` = 0, which it does not allow, becomes a small
    distance; the worker then moves the rays' origins back into the camera.
    """
    forward = np.subtract(camera.target, camera.origin)
    forward = forward / np.linalg.norm(forward)
    right = np.cross(forward, upright(forward) if camera.up is None else camera.up)
    right /= np.linalg.norm(right)
    up = np.cross(right, forward)
    right = -right if camera.mirror else right
    origin = np.asarray(camera.origin, float) - center
    near = camera.near if camera.near > 0 else 1e-2 * scale
    plugin: dict[str, Any] = {"type": camera.type, "near_clip": near, "far_clip": near + 1e3 * scale}
    stretch = 1.0
    if camera.type == "perspective":
        plugin["fov"] = camera.fov
        plugin["fov_axis"] = "x" if camera.fov_axis == "horizontal" else "y"
        if camera.aperture > 0:  # it has no principal point: `view` moves the samples
            plugin["type"] = "thinlens"
            plugin["aperture_radius"], plugin["focus_distance"] = camera.aperture, focus(camera)
        else:
            plugin["principal_point_offset_x"] = camera.shift[0] / width
            plugin["principal_point_offset_y"] = camera.shift[1] / height
        if camera.K is not None:
            plugin.update(_by_k(camera, thin=camera.aperture > 0))
    else:  # the view is 2 units wide under a scale; it has no principal point, so the camera itself is moved
        stretch = (camera.size if camera.fov_axis == "horizontal" else camera.size * width / height) / 2
        pixel = 2 * stretch / width
        origin = origin + pixel * (camera.shift[0] * right - camera.shift[1] * up)
        origin = origin + (camera.near - near) * forward
    to_world = np.eye(4)
    to_world[:3, 0], to_world[:3, 1] = -stretch * right, stretch * up
    to_world[:3, 2], to_world[:3, 3] = forward, origin
    plugin["to_world"] = to_world
    plugin["film"] = {
        "type": "hdrfilm",
        "width": width,
        "height": height,
        "pixel_format": "rgb",
        "component_format": "float32",
        "rfilter": {"type": camera.filter},
    }
    return plugin


def _by_k(camera: Camera, thin: bool) -> dict[str, Any]:
    """The keys of a plugin for a camera with K, as if its pixels were square: `_narrowed` sees to that."""
    (fx, _, cx), (_, fy, cy), _ = camera.K
    made = {"fov": 2 * np.degrees(np.arctan(camera.width / (2 * fx))), "fov_axis": "x"}
    if not thin:
        made["principal_point_offset_x"] = 0.5 + (camera.shift[0] - cx) / camera.width
        made["principal_point_offset_y"] = (0.5 + (camera.shift[1] - cy) / camera.height) * fx / fy
    return made


def _narrowed(camera: Camera, positions: Array) -> Array:
    """Positions in the picture of a camera whose pixels are as high as they are wide."""
    square = np.array([1.0, 1.0 if camera.K is None else camera.K[0][0] / camera.K[1][1]])
    return 0.5 + (positions - 0.5) * square


def focus(camera: Camera) -> float:
    """How far along the view things are sharp."""
    return camera.focus or float(np.linalg.norm(np.subtract(camera.target, camera.origin)))


def upright(forward: Array) -> Array:
    """The default way up: y, or z for a camera that looks along y."""
    return np.array((0.0, 0.0, 1.0) if np.hypot(forward[0], forward[2]) < 1e-6 else (0.0, 1.0, 0.0))


def view(scene: Scene, width: int, height: int, spp: int, size: float, center: Array) -> dict[str, Any]:
    """The camera's plugin about `center`, samples and their path words.

    `eye`: where its rays start about `center`, None: where Mitsuba starts them, on its near plane. `lens`:
    what its thin lens makes points of the disk of, (spp, h w, 2) from 0 to 1, None for a pinhole. `off`: how
    far samples lie from the middles of their pixels, (spp, h w, 2) pixels, None where all count alike.
    """
    camera = scene.camera
    assert camera is not None
    at_eye = camera.type == "perspective" and camera.near == 0
    positions, off, paths = film_positions(camera, width, height, spp)
    lens, eye = None, np.asarray(camera.origin) - center
    if camera.aperture > 0:
        lens = lens_positions(camera, width * height, spp)
        if camera.type == "perspective":
            positions = positions + np.divide(camera.shift, (width, height))
            if camera.K is not None:
                middle = np.array([camera.K[0][2] / camera.width, camera.K[1][2] / camera.height])
                positions = positions + 0.5 - middle
        eye = eye + on_lens(camera, lens)
    return {
        "sensor": sensor(camera, width, height, size, center),
        "center": center,
        "eye": eye if at_eye else None,
        "lens": lens,
        "positions": _narrowed(camera, positions),
        "off": None if camera.filter == "box" else off,
        "paths": paths,
        "seed": camera.jitter or 0,
    }


def lens_positions(camera: Camera, pixels: int, spp: int) -> Array:
    """The model's two numbers for the lens of every sample, (spp, pixels, 2)."""
    h = combine(combine(np.uint32(camera.jitter or 0), np.arange(pixels)), 0x80000000)
    sample = np.arange(spp, dtype=np.uint32)[:, None]
    with np.errstate(over="ignore"):
        u1 = unit(mix(h + np.uint32(1)) + sample * np.uint32(0x9E3779B9))
        u2 = unit(mix(h + np.uint32(2)) + sample * np.uint32(0x6A09E667))
    return np.stack([u1, u2], -1)


def on_lens(camera: Camera, lens: Array) -> Array:
    """Where rays start from the lens's middle (..., 3)."""
    rows = -sensor(camera, 1, 1, 1.0)["to_world"][:3, 0], sensor(camera, 1, 1, 1.0)["to_world"][:3, 1]
    right, up = (row / np.linalg.norm(row) for row in rows)
    x, y = on_disk(lens[..., 0], lens[..., 1])
    return np.asarray(camera.aperture * (x[..., None] * right + y[..., None] * up))


def bent(camera: Camera, origin: Array, direction: Array, lens: Array) -> tuple[Array, Array]:
    """Rays of a camera without a lens, as the lens sends them: Mitsuba's orthographic camera has none."""
    off = on_lens(camera, lens)
    direction = direction * focus(camera) - off
    return origin + off * (1 - camera.near / focus(camera)), direction / np.linalg.norm(
        direction, axis=-1, keepdims=True
    )


def film_positions(camera: Camera, width: int, height: int, spp: int) -> tuple[Array, Array, Array]:
    """Where in the image (0 to 1) every sample lies, (spp, h w, 2), how far from the middle of its pixel, in
    pixels, and its path word (spp, h w) uint32."""
    n = math.isqrt(spp)
    if n * n != spp:
        raise ValueError(f"spp = {spp} is not a square number")
    pixel = np.arange(width * height)
    corner = np.stack([pixel % width, pixel // width], -1).astype(float)
    path = np.stack([camera_words(camera.jitter or 0, pixel, sample) for sample in range(spp)])
    grid = np.stack([(i % n, i // n) for i in range(spp)]).astype(float)[:, None]
    inner: Any = 0.5
    if camera.jitter is not None and (n > 1 or camera.filter == "box"):
        inner = np.stack([unit(mix(path + np.uint32(1))), unit(mix(path + np.uint32(2)))], -1)
    reach = {"box": 0.5, "tent": 1.0, "gaussian": 2.0, "mitchell": 2.0}[camera.filter]
    off = reach * (2 * (grid + inner) / n - 1) + np.zeros((spp, width * height, 2))
    return (corner + 0.5 + off) / (width, height), off, path
