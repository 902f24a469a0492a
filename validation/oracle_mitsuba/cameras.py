"""The camera of a scene as plain arrays and as a plugin of Mitsuba's."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from .forms import Array
from .hashing import camera_words, combine, mix, on_disk, unit
from .records import Camera, Scene


def sensor(
    camera: Camera, width: int, height: int, scale: float, center: Any = 0.0, near: float | None = None
) -> dict[str, Any]:
    """The camera about `center` as a plugin of Mitsuba's, for pictures of width x height; `scale`: the
    scene's size.

    Mitsuba's camera looks along +z with +x to the left. The camera's `near` = 0, which it does not allow,
    becomes a hundredth of the scene, and the worker moves the rays' origins back into the camera; or so much
    of the distance to the target as `near` says.
    """
    forward = np.subtract(camera.target, camera.origin)
    forward = forward / np.linalg.norm(forward)
    right = np.cross(forward, upright(forward) if camera.up is None else camera.up)
    right /= np.linalg.norm(right)
    up = np.cross(right, forward)
    right = -right if camera.mirror else right
    origin = np.asarray(camera.origin, float) - center
    away = float(np.linalg.norm(np.subtract(camera.target, camera.origin)))
    least = 1e-2 * scale if near is None else min(1e-2 * scale, near * away)
    near = camera.near if camera.near > 0 else least
    plugin: dict[str, Any] = {"type": camera.type, "near_clip": near, "far_clip": near + 1e3 * scale}
    stretch = 1.0
    if camera.type == "perspective":
        plugin["fov"] = camera.fov
        plugin["fov_axis"] = "x" if camera.fov_axis == "horizontal" else "y"
        if camera.aperture > 0:  # it has no principal point: `view` moves the samples
            plugin["type"] = "thinlens"
            plugin["aperture_radius"], plugin["focus_distance"] = camera.aperture, focus(camera)
        else:
            plugin["principal_point_offset_x"] = camera.shift[0] / camera.width
            plugin["principal_point_offset_y"] = camera.shift[1] / camera.height
        if camera.K is not None:
            plugin.update(_by_k(camera, thin=camera.aperture > 0))
    else:  # the view is 2 units wide under a scale; it has no principal point, so the camera itself is moved
        stretch = (camera.size if camera.fov_axis == "horizontal" else camera.size * width / height) / 2
        across, down = np.divide(camera.shift, (camera.width, camera.height))
        origin = origin + 2 * stretch * (across * right - down * height / width * up)
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


def cones(camera: Camera, direction: Array) -> Array:
    """Cones (n, 2) of rays of these directions, as wide as a sample's part of a pixel: width, and growth."""
    forward = np.subtract(camera.target, camera.origin)
    forward = forward / np.linalg.norm(forward)
    flat = camera.type == "orthographic"
    across = camera.size if flat else 2 * np.tan(np.radians(camera.fov) / 2)
    side = across / (camera.width if camera.fov_axis == "horizontal" else camera.height)
    if camera.K is not None:
        side = 1 / min(camera.K[0][0], camera.K[1][1])
    side = side / math.isqrt(camera.spp)
    grows = np.zeros(len(direction)) if flat else side * (direction @ forward)
    return np.stack([np.full(len(direction), side if flat else side * camera.near), grows], 1)


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
            positions = positions + np.divide(camera.shift, (camera.width, camera.height))
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
