"""Mip levels of a picture: smaller ones, each the mean of what it covers of the one before."""

from __future__ import annotations

from typing import Final

import numpy as np

_ROWS: Final = 64  # of a smaller picture at a time: in float64 a large one would need much memory


def level_sizes(height: int, width: int) -> list[tuple[int, int]]:
    """Heights and widths of the smaller pictures, the largest first, down to one texel; none of one texel."""
    sizes = []
    while max(height, width) > 1:
        height, width = max(1, height // 2), max(1, width // 2)
        sizes.append((height, width))
    return sizes


def halved(texels: np.ndarray) -> np.ndarray:
    """The next level of a picture float32 (height, width, channels).

    Half as many rows and columns, rounded down but at least one. Each texel is the mean of its own part of
    the picture: two texels along each side, and shares of three where their number is odd. Sums are
    float64, so equal texels give their bits.
    """
    height, width = texels.shape[:2]
    rows, columns = max(1, height // 2), max(1, width // 2)
    out = np.empty((rows, columns, texels.shape[2]), np.float32)
    for start in range(0, rows, _ROWS):
        end = min(start + _ROWS, rows)
        across = _means(texels[2 * start : 2 * end + height % 2].astype(np.float64), height, start)
        out[start:end] = _means(across.swapaxes(0, 1), width, 0).swapaxes(0, 1)
    return out


def _means(values: np.ndarray, count: int, start: int) -> np.ndarray:
    """Means of pairs of rows of a picture of `count`, from pair `start` on; `values`: the rows of these."""
    if count == 1:
        return values
    half = count // 2
    if count % 2 == 0:
        return np.asarray((values[0::2] + values[1::2]) / 2)
    first, middle, last = values[0:-1:2], values[1::2], values[2::2]
    i = np.arange(start, start + len(middle)).reshape(-1, *(1,) * (values.ndim - 1))
    return np.asarray(((half - i) * first + half * middle + (i + 1) * last) / count)
