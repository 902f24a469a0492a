"""A tree of boxes over a batch of primitives: it skips what a ray cannot meet, and never anything else.

Boxes are widened by far more than float64 rounds, so the hits are those of brute force; tests compare them.
Many rays go through the tree together, one node at a time, so that numpy does the work.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from .batch import Batch
from .vectors import Array, Bools, Ints, across

LEAF = 8  # primitives in a leaf; a batch of no more needs no boxes
PAIRS = 1 << 18  # rays times primitives that are tested at once: what bounds the memory
PADDING = 1e-6  # of a box's largest |coordinate|

Visit = Callable[[Ints, Ints], None]  # (rays, rows of the batch): all of them may meet


@dataclass(frozen=True)
class Node:
    """Either two children, or the rows of a batch, in increasing order."""

    low: Array
    high: Array
    rows: Ints
    children: tuple[Node, ...] = ()


def build(batch: Batch, leaf: int = LEAF) -> list[Node]:
    """Trees that together hold the batch: one for the finite primitives, a leaf for the infinite ones."""
    finite = np.isfinite(batch.low).all(axis=1) & np.isfinite(batch.high).all(axis=1)
    rows = np.arange(len(batch.ids))
    roots = [_node(batch, rows[finite], leaf)] if finite.any() else []
    return roots + ([_node(batch, rows[~finite], len(rows))] if not finite.all() else [])


def _node(batch: Batch, rows: Ints, leaf: int) -> Node:
    low, high = batch.low[rows].min(axis=0), batch.high[rows].max(axis=0)
    size = np.maximum(np.abs(low), np.abs(high)).max()
    low, high = low - PADDING * size, high + PADDING * size
    if len(rows) <= leaf:
        return Node(low, high, np.sort(rows))
    center = batch.low[rows] + batch.high[rows]
    axis = np.argmax(np.ptp(center, axis=0))
    order = rows[np.argsort(center[:, axis], kind="stable")]
    halves = np.split(order, [len(order) // 2])
    return Node(low, high, rows[:0], tuple(_node(batch, half, leaf) for half in halves))


def walk(roots: list[Node], origin: Array, direction: Array, reach: Array, visit: Visit) -> None:
    """Calls `visit` for every leaf that some rays meet at 0 <= t <= `reach` (n,), which it may shorten."""
    with np.errstate(all="ignore"):
        slope = 1.0 / direction
    heading = np.mean(direction, axis=0) if len(direction) else np.zeros(3)
    everything = np.arange(len(origin))
    stack = [(root, everything) for root in reversed(roots)]
    while stack:
        node, rays = stack.pop()
        rays = rays[_meets(node, origin[rays], slope[rays], reach[rays])]
        if not rays.size:
            continue
        if node.rows.size:
            for some in np.array_split(rays, -(-rays.size * node.rows.size // PAIRS)):
                visit(some, node.rows)
        # the child that most rays meet first on top, so that it shortens `reach` for the other
        stack += [(child, rays) for child in sorted(node.children, key=lambda c: -(c.low + c.high) @ heading)]


def _meets(node: Node, origin: Array, slope: Array, reach: Array) -> Bools:
    """Slab test (Kay, Kajiya 1986); a NaN (origin on a face, ray along it) counts as inside."""
    with np.errstate(all="ignore"):
        first, second = (node.low - origin) * slope, (node.high - origin) * slope
    near = across(np.fmax, np.fmin(first, second))
    far = across(np.fmin, np.fmax(first, second))
    return ~(near > far) & ~(far < 0) & ~(near > reach)
