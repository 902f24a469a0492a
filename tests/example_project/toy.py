"""A renderer of one ball, to be tested."""

import numpy as np


def ball(width: int = 64, height: int = 48, light=(0.5, 0.7, 0.6)) -> np.ndarray:
    """Linear float32 (height, width, 3): a ball in the light of one lamp, from the front."""
    x = (np.arange(width) + 0.5 - width / 2) / (height / 2)
    y = (height / 2 - np.arange(height) - 0.5) / (height / 2)
    inside = 0.64 - x[None, :] ** 2 - y[:, None] ** 2
    z = np.sqrt(np.maximum(inside, 0))
    light = np.array(light) / np.linalg.norm(light)
    cosine = np.maximum(x[None, :] * light[0] + y[:, None] * light[1] + z * light[2], 0) / 0.8
    shade = np.where(inside > 0, 0.1 + 0.8 * cosine, 0.2)
    return (shade[:, :, None] * np.array([0.9, 0.6, 0.3])).astype(np.float32)
