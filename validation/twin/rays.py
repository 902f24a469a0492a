"""Rays that meet scenes in every way, the twin's and others."""

from __future__ import annotations

import numpy as np


def difficult_rays(n: int, seed: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Origins, directions (n, 3) and t_max (n,) float32 that meet the scenes in every way.

    From outside, inside and far away; parallel to axes and in planes; of any length; with numbers that are
    zero, infinite or NaN. Half of them go side by side, so that packets hold rays of one kind and of all.
    """
    generator = np.random.default_rng(seed)

    def some(share: float) -> np.ndarray:
        return generator.random(n) < share

    origins = generator.normal(size=(n, 3)) * generator.choice([0.3, 1.5, 5.0, 2e3], (n, 1))
    together = some(0.5)
    origins[together] = origins[0] / np.linalg.norm(origins[0]) * 5
    directions = generator.normal(size=(n, 3)) * 0.7 - origins
    grid = some(0.15)
    origins[grid] = np.round(origins[grid] * 4) / 4
    axes = some(0.15)
    directions[axes] = generator.integers(-1, 2, (np.count_nonzero(axes), 3))
    directions *= generator.choice([1.0, 1e-12, 1e12], (n, 1), p=[0.9, 0.05, 0.05])
    t_max = np.where(some(0.2), np.linalg.norm(origins, axis=1) * generator.random(n), np.inf)
    for value in (np.nan, np.inf, 0.0, -1.0, 1e30, 3e38):
        for numbers in (origins, directions):
            rows = np.flatnonzero(some(0.001))
            numbers[rows, generator.integers(0, 3, len(rows))] = value
        t_max[some(0.001)] = value
    order = np.argsort(~together, kind="stable")
    o, d, limit = (numbers[order].astype(np.float32) for numbers in (origins, directions, t_max))
    return o, d, limit
