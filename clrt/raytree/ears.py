"""Ear clipping for drawings, where mapbox_earcut is not installed."""

from __future__ import annotations

from collections import deque

import numpy as np


def clipped(points: np.ndarray, ends: np.ndarray) -> np.ndarray:
    """Triangles (n - 2, 3) of an outline (n, 2): places of corners. `ends` is mapbox_earcut's, of one ring.

    Each test looks at all corners that turn the other way, and a cut changes what its two neighbours are, so
    it takes O(n^2). Where no corner is an ear, as in outlines that cross themselves, any is cut.
    """
    around = points - np.roll(points, 1, axis=0)
    if _cross(points, np.roll(points, -1, axis=0)).sum() < 0:
        points, around = points * (-1, 1), around * (-1, 1)
    reflex = _cross(around, np.roll(around, -1, axis=0)) <= 0
    count = len(points)
    before, after = [*range(-1, count - 1)], [*range(1, count), 0]
    before[0] = count - 1
    there, waiting = [True] * count, deque(range(count))
    found: list[tuple[int, int, int]] = []
    last = 0
    while len(found) < count - 2:
        sure = not waiting
        k = after[last] if sure else waiting.popleft()
        if not there[k]:
            continue
        a, c = before[k], after[k]
        if not sure and (reflex[k] or _holds_some(points[[a, k, c]], points, reflex, (a, c))):
            continue
        found.append((a, k, c))
        there[k] = reflex[k] = False
        after[a], before[c], last = c, a, a
        for side in (a, c):
            here = points[side]
            reflex[side] = _cross(here - points[before[side]], points[after[side]] - here) <= 0
            waiting.append(side)
    return np.array(found)


def _cross(one: np.ndarray, other: np.ndarray) -> np.ndarray:
    return np.asarray(one[..., 0] * other[..., 1] - one[..., 1] * other[..., 0])


def _holds_some(
    corner: np.ndarray, points: np.ndarray, reflex: np.ndarray, but: tuple[int, int]
) -> bool:
    """Whether a reflex corner of the outline, but for two, lies in the triangle."""
    numbers = np.flatnonzero(reflex)
    inside = (numbers != but[0]) & (numbers != but[1])
    of = points[numbers]
    for start, end in zip(corner, np.roll(corner, -1, axis=0), strict=True):
        inside &= _cross(end - start, of - start) >= 0
    return bool(inside.any())
