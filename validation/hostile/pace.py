"""How slow the core is that this process runs on: bounds in seconds are those of a core of pace 1.

Reading a scene is Python's loops and numpy's calls on small arrays. A Zen 3 does the one as fast as a Zen 5
and takes twice as long for the other, and a core whose other half is busy does both more slowly.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Final

import numpy as np

# What pace 1 is, in seconds of processor time: a core of a Zen 5 that does nothing beside takes so long for
# the loop; the calls have what makes the readers of a Zen 3 as far from their bounds as those of a Zen 5 are
LOOP: Final = 0.0385
CALLS: Final = 0.018
_TIMES: Final = 3  # the least counts: what runs beside makes a piece slower, never faster


def pace() -> float:
    """How many times as long as at pace 1 the slower of two known pieces of work takes; at least 1."""
    return max(1.0, _least(_loop) / LOOP, _least(_calls) / CALLS)


def _least(piece: Callable[[], None]) -> float:
    def once() -> float:
        start = time.process_time()
        piece()
        return time.process_time() - start

    return min(once() for _ in range(_TIMES))


def _loop() -> None:
    found: dict[int, list[object]] = {}
    for n in range(200_000):
        found[n & 1023] = [n, str(n)]


def _calls() -> None:
    corners, faces = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0]]), np.array([[0, 1, 2]])
    for _ in range(3000):
        across = corners[faces[:, 0]] * corners[faces[:, 1]]
        np.flatnonzero(~(np.abs(across) <= 1.0).all(axis=1))
        np.add.at(corners, faces[:, 2], across)
        np.concatenate([across, corners]).astype(np.float32)
