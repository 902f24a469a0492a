"""The rays that a caller asks about, checked, as float32, in pieces; and the answers."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final

import numpy as np

from clrt.base.arguments import array, rays
from clrt.base.errors import ClrtError
from clrt.base.limits import Limits

HIT_BYTES: Final = 2 * 44  # of a ray in `Hits`, and of what they are made from
SEEN_BYTES: Final = 2 * 5
LIGHT_BYTES: Final = 2 * 12


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
    origins: np.ndarray,
    directions: np.ndarray,
    t_max: float | np.ndarray,
    step: int,
    limits: Limits,
    answer: int,
) -> Iterator[tuple[np.ndarray, ...]]:
    """Origins, directions, t_max and the rays' numbers, `step` at a time; one empty piece for no rays.

    What is beyond float32 becomes infinite, and misses. ClrtError for shapes other than (n, 3), (n, 3), and
    () or (n,), and for what are no real numbers; LimitError where the answers, `answer` bytes a ray, need
    more than `limits` allow.
    """
    o, d = rays(origins, directions, np.float32)
    limit = array("t_max", t_max, np.float32, f"() or ({len(o)},)")
    if limit.ndim and limit.shape != (len(o),):
        raise ClrtError(f"t_max: shape {limit.shape} is neither a number nor ({len(o)},)")
    limits.check("host_bytes", len(o) * answer, place="rays")
    limit, numbers = np.broadcast_to(limit, (len(o),)), np.arange(len(o), dtype=np.uint32)
    for start in range(0, max(len(o), 1), step):
        yield tuple(np.ascontiguousarray(a[start : start + step]) for a in (o, d, limit, numbers))
