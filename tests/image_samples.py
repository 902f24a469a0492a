"""Pictures to save and to read."""

from __future__ import annotations

import numpy as np

from clrt.images.image import Image


def gradient(height: int = 5, width: int = 7) -> np.ndarray:
    """Pixels of which no two rows, columns or channels are equal, some of them outside [0, 1]."""
    y, x, channel = np.mgrid[0:height, 0:width, 0:3]
    return (0.031 * x + 0.17 * y + 0.4 * channel - 0.2).astype(np.float32)


def picture(**more: object) -> Image:
    return Image(gradient(), **more)  # type: ignore[arg-type]


def decode_by_hand(values: np.ndarray) -> np.ndarray:
    """Linear float32 of sRGB bytes."""
    curve = [v / 12.92 if v <= 0.04045 else ((v + 0.055) / 1.055) ** 2.4 for v in np.arange(256) / 255]
    return np.array(curve, np.float32)[values]
