"""Which pixels a tile holds: numbers of pixels along a space-filling curve."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

_CELL = 256  # side of the squares inside which pixels follow the Morton curve


def _morton_cell() -> np.ndarray:
    """x, y of the pixels of a cell in Morton order: (2, cell * cell) int64. Neighbours in the order are
    neighbours in the picture, so that the rays of a block stay together on their way through the tree."""
    code = np.arange(_CELL * _CELL, dtype=np.int64)
    x, y = np.zeros_like(code), np.zeros_like(code)
    for bit in range(_CELL.bit_length() - 1):
        x |= (code >> 2 * bit & 1) << bit
        y |= (code >> 2 * bit + 1 & 1) << bit
    return np.stack([x, y])


def tiles(width: int, height: int, crop: tuple[int, int, int, int], size: int) -> Iterator[np.ndarray]:
    """Lists of at most `size` pixel numbers (y * width + x, uint32) that cover crop = (x, y, w, h)."""
    left, top, crop_width, crop_height = crop
    cell = _morton_cell()
    waiting: list[np.ndarray] = []
    have = 0
    for cell_top in range(0, crop_height, _CELL):
        for cell_left in range(0, crop_width, _CELL):
            x, y = cell[0] + cell_left, cell[1] + cell_top
            inside = (x < crop_width) & (y < crop_height)
            waiting.append(((y[inside] + top) * width + x[inside] + left).astype(np.uint32))
            have += len(waiting[-1])
            while have >= size:
                joined = np.concatenate(waiting)
                yield joined[:size]
                waiting, have = [joined[size:]], have - size
    if have:
        yield np.concatenate(waiting)
