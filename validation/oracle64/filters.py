"""Where in a pixel its samples lie, and what each counts for: reconstruction filters in float64."""

from __future__ import annotations

import numpy as np

from clrt.scene.scene import Camera

from . import hashing
from .vectors import Array, Ints

REACH = {"box": 0.5, "tent": 1.0, "gaussian": 2.0, "mitchell": 2.0}  # pixels from a pixel's middle


def weight(name: str, x: Array) -> Array:
    """The filter along one axis, x pixels from the middle of a pixel."""
    x = np.abs(x)
    if name == "box":
        return np.ones_like(x)
    if name == "tent":
        return np.maximum(0, 1 - x)
    if name == "gaussian":
        return np.maximum(0, np.exp(-2 * x**2) - np.exp(-2 * 2.0**2))
    b = c = 1 / 3  # Mitchell and Netravali 1988
    inner = (12 - 9 * b - 6 * c) * x**3 + (-18 + 12 * b + 6 * c) * x**2 + (6 - 2 * b)
    outer = (-b - 6 * c) * x**3 + (6 * b + 30 * c) * x**2 + (-12 * b - 48 * c) * x + (8 * b + 24 * c)
    return np.where(x < 1, inner, np.where(x < 2, outer, 0)) / 6


def offsets(camera: Camera, grid: int, pixel: Ints, sample: Ints) -> tuple[Array, Array]:
    """How far from the middles of their pixels samples lie, to the right and down, in pixels."""
    h = hashing.camera_path(camera.jitter or 0, pixel, sample)
    alone = grid == 1 and camera.filter != "box"
    place = (0.5, 0.5) if camera.jitter is None or alone else hashing.jitter(h)
    reach = REACH[camera.filter]
    x = (np.asarray(sample) % grid + place[0]) / grid
    y = (np.asarray(sample) // grid + place[1]) / grid
    return reach * (2 * x - 1), reach * (2 * y - 1)


def shares(camera: Camera, grid: int, pixels: int) -> Array:
    """What each sample counts for in its pixel, (grid**2, pixels): they sum to 1."""
    sample, pixel = np.divmod(np.arange(grid * grid * pixels), pixels)
    x, y = offsets(camera, grid, pixel, sample)
    weights = (weight(camera.filter, x) * weight(camera.filter, y)).reshape(grid * grid, pixels)
    whole = weights.sum(axis=0)
    cancelled = ~(whole > np.abs(weights).sum(axis=0) / 4)
    return np.where(cancelled, 1 / grid**2, weights / np.where(cancelled, 1, whole))
