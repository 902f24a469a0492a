"""Which pixels a tile holds: numbers of pixels along a space-filling curve."""

from __future__ import annotations

from collections.abc import Iterator
from functools import cache

import numpy as np

_CELL = 256  # side of the squares inside which pixels follow the Morton curve


@cache
def _morton_cell() -> np.ndarray:
    """x, y of the pixels of a cell in Morton order: (2, cell * cell) uint32. Neighbours in the order are
    neighbours in the picture, so that the rays of a block stay together on their way through the tree."""
    code = np.arange(_CELL * _CELL, dtype=np.int64)
    x, y = np.zeros_like(code), np.zeros_like(code)
    for bit in range(_CELL.bit_length() - 1):
        x |= (code >> 2 * bit & 1) << bit
        y |= (code >> 2 * bit + 1 & 1) << bit
    return np.stack([x, y]).astype(np.uint32)


def tiles(width: int, height: int, crop: tuple[int, int, int, int], size: int) -> Iterator[np.ndarray]:
    """Lists of at most `size` pixel numbers (y * width + x, uint32) that cover crop = (x, y, w, h)."""
    left, top, crop_width, crop_height = crop
    cell = _morton_cell()
    waiting: list[np.ndarray] = []
    have = 0
    for cell_top in range(0, crop_height, _CELL):
        for cell_left in range(0, crop_width, _CELL):
            x, y = cell
            if cell_left + _CELL > crop_width or cell_top + _CELL > crop_height:
                inside = (x < crop_width - cell_left) & (y < crop_height - cell_top)
                x, y = x[inside], y[inside]
            first = (top + cell_top) * width + left + cell_left
            waiting.append(y * np.uint32(width) + x + np.uint32(first))
            have += len(waiting[-1])
            while have >= size:
                joined = np.concatenate(waiting) if len(waiting) > 1 else waiting[0]
                yield joined[:size]
                waiting, have = [joined[size:]], have - size
    if have:
        yield np.concatenate(waiting)
