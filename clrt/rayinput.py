"""The rays that a caller asks about, checked, as float32, in pieces; and the answers."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from clrt.errors import ClrtError


@dataclass(frozen=True)
class Hits:
    """Answers to n rays. A miss has primitive = shape = -1 and t = inf.

    t: (n,) float32, distance. primitive, shape: (n,) int32. normal: (n, 3) float32, the outward geometric
    unit normal (0 on a miss). u, v: (n,) float32, barycentric weights of a triangle's second and third
    corner, 0 on other primitives.
    """

    t: np.ndarray
    primitive: np.ndarray
    shape: np.ndarray
    normal: np.ndarray
    u: np.ndarray
    v: np.ndarray


def ray_chunks(
    origins: np.ndarray, directions: np.ndarray, t_max: float | np.ndarray, step: int
) -> Iterator[tuple[np.ndarray, ...]]:
    """Origins, directions, t_max and the rays' numbers, `step` at a time; one empty piece for no rays.

    ClrtError for shapes other than (n, 3), (n, 3), and () or (n,).
    """
    with np.errstate(over="ignore"):  # beyond float32: infinite, which misses
        o, d = np.asarray(origins, np.float32), np.asarray(directions, np.float32)
        for name, array in (("origins", o), ("directions", d)):
            if array.ndim != 2 or array.shape[1] != 3:
                raise ClrtError(f"{name}: shape {array.shape} is not (n, 3)")
        if len(o) != len(d):
            raise ClrtError(f"origins and directions: {len(o)} and {len(d)} rays; they must be as many")
        limit = np.asarray(t_max, np.float32)
    if limit.ndim and limit.shape != (len(o),):
        raise ClrtError(f"t_max: shape {limit.shape} is neither a number nor ({len(o)},)")
    limit, numbers = np.broadcast_to(limit, (len(o),)), np.arange(len(o), dtype=np.uint32)
    for start in range(0, max(len(o), 1), step):
        yield tuple(np.ascontiguousarray(a[start : start + step]) for a in (o, d, limit, numbers))
