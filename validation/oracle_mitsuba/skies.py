"""Backgrounds: as Mitsuba's environments, and as the model reads them."""

from __future__ import annotations

from typing import Any

import numpy as np

from .plugins import rgb

Array = np.ndarray
HALF_TURN = np.diag([-1.0, 1.0, -1.0, 1.0])
"""Mitsuba's envmap has the middle of the image towards +z, the model has it towards -z."""


def environment(background: Any) -> dict[str, Any]:
    """A `constant` emitter for a colour (3,), an `envmap` for the path of a lat-long image or for an image
    (h, w, 3)."""
    if isinstance(background, str):
        background = read(background)
    if background.ndim == 1:
        return {"type": "constant", "radiance": rgb(background)}
    return {"type": "envmap", "bitmap": resampled(background), "to_world": HALF_TURN}


def resampled(image: Array) -> Array:
    """The image (2h + 1, w, 3) that Mitsuba's envmap interpolates to what the image model says of (h, w, 3).

    Both interpolate linearly. Across, both have the centres of w columns at (i + 1/2)/w. Down, the model has
    the centres of h rows at (j + 1/2)/h and clamps; Mitsuba has its first row at 0 and its last one at 1. On
    2h + 1 rows every second row is one of the model's, and the rows between are their means: the same
    function.
    """
    height = len(image)
    padded = np.concatenate([image[:1], image, image[-1:]])
    rows = np.empty((2 * height + 1, *image.shape[1:]))
    rows[1::2] = image
    rows[0::2] = (padded[:-1] + padded[1:]) / 2
    return rows


def read(path: str) -> Array:
    """A picture as linear Rec.709 (h, w, 3), read by Mitsuba."""
    from .engine import mi

    bitmap = mi.Bitmap(path).convert(mi.Bitmap.PixelFormat.RGB, mi.Struct.Type.Float32, srgb_gamma=False)
    return np.array(bitmap, np.float64)


def longitude_latitude(direction: Array) -> tuple[Array, Array]:
    """u and v in [0, 1]: -z is in the middle, u grows towards +x, v from +y downwards."""
    u = 0.5 + np.arctan2(direction[:, 0], -direction[:, 2]) / (2 * np.pi)
    return u, np.arccos(np.clip(direction[:, 1], -1.0, 1.0)) / np.pi


def bilinear(image: Array, direction: Array) -> Array:
    """A lat-long image (h, w, 3) in directions (n, 3)."""
    height, width = image.shape[:2]
    u, v = longitude_latitude(direction)
    x, y = u * width - 0.5, np.clip(v * height - 0.5, 0, height - 1)
    left, top = np.floor(x).astype(int), np.floor(y).astype(int)
    right, low = (left + 1) % width, np.minimum(top + 1, height - 1)
    fx, fy = (x - left)[:, None], (y - top)[:, None]
    left = left % width
    upper = image[top, left] * (1 - fx) + image[top, right] * fx
    lower = image[low, left] * (1 - fx) + image[low, right] * fx
    return np.asarray(upper * (1 - fy) + lower * fy)
