"""From pixels to rays, and from directions to the background."""

from __future__ import annotations

from typing import Any

import numpy as np

from clrt.images.image import read_image
from clrt.scene.scene import Camera, Scene

from .palette import Palette
from .surfaces import longitude_latitude
from .vectors import Array, dot, unit


def camera_rays(
    camera: Camera, width: int, height: int, x: Array, y: Array, lens: tuple[Array, Array]
) -> tuple[Array, Array]:
    """Origins and directions (n, 3) through the points x, y (n,) of the image: pixel 0 is [0, 1), y down.

    lens: points (n,), (n,) of the unit disk, where on the lens rays start if there is one.
    """
    forward, right, up = basis(camera)
    by_width = camera.fov_axis == "horizontal"
    half = camera.size / 2 if camera.type == "orthographic" else np.tan(np.radians(camera.fov) / 2)
    half_width, half_height = (half, half * height / width) if by_width else (half * width / height, half)
    x = x + camera.shift[0] * (width / camera.width)
    y = y + camera.shift[1] * (height / camera.height)
    to_right = (2 * x / width - 1) * half_width
    to_top = (1 - 2 * y / height) * half_height
    if camera.has_k:  # the inverse of K, of a picture of the size that it is for
        matrix = np.linalg.inv(np.array(camera.K, float))
        to_right = matrix[0, 0] * x * camera.width / width + matrix[0, 2]
        to_top = -(matrix[1, 1] * y * camera.height / height + matrix[1, 2])
    across, down = to_right[:, None] * right, to_top[:, None] * up
    origin = np.broadcast_to(np.asarray(camera.origin, float), across.shape)
    if camera.aperture > 0:
        return _through_lens(camera, origin, across + down, lens)
    if camera.type == "orthographic":
        return origin + across + down + camera.near * forward, np.broadcast_to(forward, across.shape)
    direction = unit(forward + across + down)
    return origin + (camera.near / dot(direction, forward[None]))[:, None] * direction, direction


def cones(camera: Camera, width: int, height: int, grid: int, direction: Array) -> Array:
    """Cones (n, 2) of camera rays, width at their origins and growth: those of a sample's part of a pixel."""
    half = camera.size / 2 if camera.type == "orthographic" else np.tan(np.radians(camera.fov) / 2)
    sides = np.full(2, 2 * half / (width if camera.fov_axis == "horizontal" else height))
    if camera.has_k:
        focal = np.array(camera.K, float)[[0, 1], [0, 1]]
        sides = np.array([camera.width / width, camera.height / height]) / focal
    side = sides.max() / grid
    if camera.type == "orthographic":
        return np.tile([side, 0.0], (len(direction), 1))
    grown = side * (direction @ basis(camera)[0])
    return np.stack([np.full(len(direction), side * camera.near), grown], axis=1)


def _through_lens(
    camera: Camera, origin: Array, in_view: Array, lens: tuple[Array, Array]
) -> tuple[Array, Array]:
    """Rays from the lens through the points in focus that the pinhole sees at the same places."""
    forward, right, up = basis(camera)
    distance = camera.focus or float(np.linalg.norm(np.subtract(camera.target, camera.origin)))
    if camera.type == "orthographic":
        origin = origin + in_view
        sharp = origin + distance * forward
    else:
        sharp = origin + distance * (forward + in_view)
    start = origin + camera.aperture * (lens[0][:, None] * right + lens[1][:, None] * up)
    direction = unit(sharp - start)
    return start + (camera.near / dot(direction, forward[None]))[:, None] * direction, direction


def basis(camera: Camera) -> tuple[Array, Array, Array]:
    """Unit vectors forward, right, up of the image; `right` is negated in a mirrored one."""
    if camera.has_pose:
        right, down, forward = unit(np.array(camera.pose, float)[:3, :3].T)
        return forward, right, -down
    forward = unit(np.asarray(camera.target, float) - np.asarray(camera.origin, float))
    given = camera.up
    if given is None:
        given = (0.0, 0.0, 1.0) if np.linalg.norm(np.cross(forward, (0, 1, 0))) < 1e-6 else (0.0, 1.0, 0.0)
    right = unit(np.cross(forward, given))
    return forward, -right if camera.mirror else right, np.cross(right, forward)


def background_image(scene: Scene) -> Array | None:
    """The lat-long image (h, w, 3) in linear Rec.709, or None; `at_bands` puts it in its name's place."""
    if isinstance(scene.background, np.ndarray):
        return scene.background
    path = scene.background_path
    return None if path is None else read_image(path).astype(float)


class Background:
    """What a ray sees that meets nothing: a colour, or a lat-long image around the scene."""

    def __init__(self, scene: Scene, palette: Palette) -> None:
        value: Any = background_image(scene)
        self.color = palette.light(scene.background) if value is None else None
        self.image = None if value is None else palette.light_image(value)

    def __call__(self, direction: Array) -> Array:
        """Radiance (n, bands) from directions (n, 3); 0 from a direction that is none."""
        if self.image is None:
            return np.broadcast_to(np.asarray(self.color), (len(direction), len(np.asarray(self.color))))
        height, width = self.image.shape[:2]
        valid = np.isfinite(direction).all(axis=1, keepdims=True)
        direction = np.where(valid, direction, 1.0)
        u, v = longitude_latitude(direction)
        x, y = u * width - 0.5, v * height - 0.5
        column, row = np.floor(x), np.floor(y)
        right_share, low_share = (x - column)[:, None], (y - row)[:, None]
        columns = [(column + i).astype(int) % width for i in (0, 1)]
        rows = [np.clip(row + i, 0, height - 1).astype(int) for i in (0, 1)]
        texels = [[self.image[r, c] for c in columns] for r in rows]
        upper, lower = ((1 - right_share) * left + right_share * right for left, right in texels)
        return np.where(valid, (1 - low_share) * upper + low_share * lower, 0.0)
