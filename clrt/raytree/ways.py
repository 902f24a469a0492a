"""The ways of a tree's rays and feelers as lines from point to point, for drawings."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np

if TYPE_CHECKING:
    from clrt.raytree.tree import RayTree

COLOURS: Final = {
    "camera": (64, 64, 64), "reflection": (214, 39, 40), "transmission": (31, 119, 180),
    "ambient": (148, 103, 189), "light": (230, 170, 20), "blocked": (150, 150, 150),
}  # fmt: skip
"""Red, green, blue (sRGB, 0 to 255) of each kind of ray, and of feelers that arrive or do not."""


class Way(NamedTuple):
    """From one point to another: `kind` of COLOURS, the ray's number, its branch's share of the pixel."""

    kind: str
    ray: int
    start: np.ndarray
    end: np.ndarray
    share: float


def ways(tree: RayTree, feelers: bool = True) -> tuple[list[Way], np.ndarray, np.ndarray]:
    """All ways, and the box (3,), (3,) around them. What meets nothing ends a box's width away."""
    points = [ray.hit.point for ray in tree.rays if ray.hit is not None]
    points += [ray.origin for ray in tree.rays if ray.generation]
    if len(points) < 2:
        points += [root.origin for root in tree.roots]
    low, high = np.min(points, axis=0).astype(float), np.max(points, axis=0).astype(float)
    size = max(float(np.linalg.norm(high - low)), 1e-3 * float(np.abs(points).max()), 1e-6)
    found = []
    for ray in tree.rays:
        start, share = np.array(ray.origin), tree.branch_shares[ray.number]
        if not np.isfinite(start).all():
            continue
        end = _end(start, ray.direction, ray.hit.t if ray.hit else np.inf, size)
        found.append(Way(ray.kind, ray.number, start, end, share))
        for light in ray.lights if feelers else ():
            for way in light.feelers:
                reach = way.distance if way.seen or not way.met else way.met[-1].t
                end = _end(np.array(way.origin), way.direction, min(reach, 2 * size), size)
                kind = "light" if way.seen else "blocked"
                found.append(Way(kind, ray.number, np.array(way.origin), end, share))
    return found, low - 0.05 * size, high + 0.05 * size


def _end(start: np.ndarray, direction: Sequence[float], reach: float, size: float) -> np.ndarray:
    return start + np.array(direction) * (reach if np.isfinite(reach) else size)
