"""The rays along which a caller asks for light, checked, as float32, in pieces."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

import numpy as np

from clrt.base.arguments import array, rays
from clrt.base.errors import ClrtError
from clrt.base.limits import Limits

LIGHT_BYTES: Final = 2 * 12  # of a ray: what arrives along it, and what that is made from


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
