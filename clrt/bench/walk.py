"""What a walk through the tree cannot avoid, counted on the host from the tree as the device built it.

A single ray must test the boxes of every node that it enters before its nearest hit, and every block of the
leaves among them; a front-to-back walk that always guesses right does no more. Packets share nodes between
rays, and so can do with less: the count measures the rays' work, not the kernel's.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np

from clrt import layout
from clrt.device.device import Device
from clrt.engine.world import World

_NODE, _BLOCK = layout.dtype("WideNode").itemsize, layout.dtype("TriangleBlock").itemsize
# operations for the boxes of a node (6 multiply-adds and 7 comparisons each), and for the eight
# primitives of a block: a watertight triangle takes 18 for the corners, 9 for the edges, 11 for the
# distance, a sphere 21
_NODE_FLOPS: Final = layout.WIDE * 19.0
_BLOCK_FLOPS: Final = {
    layout.BLOCKS["BLOCK_TRIANGLE"]: 8 * 38.0,
    layout.BLOCKS["BLOCK_SPHERE"]: 8 * 21.0,
    layout.BLOCKS["BLOCK_OTHER"]: 8 * 30.0,
}


@dataclass(frozen=True)
class Walk:
    """Means a ray: nodes and blocks visited, operations; `tree_bytes`: nodes and blocks of the whole tree."""

    nodes: float
    blocks: float
    flops: float
    tree_bytes: int

    def nbytes(self, rays: int) -> float:
        """Bytes of the tree that `rays` must see at least: what each visits, or all of it once."""
        return min(float(self.tree_bytes), rays * (self.nodes * _NODE + self.blocks * _BLOCK))


def read_nodes(device: Device, world: World) -> np.ndarray:
    """The tree's nodes, dtype WideNode, from the device."""
    section = dict(zip(layout.world(world.flat.ray_format.images), world.arguments, strict=True))
    info = device.read(section["scene"], np.empty(1, layout.dtype("SceneInfo")))
    return device.read(section["nodes"], np.empty(int(info["nodes"][0]), layout.dtype("WideNode")))


def count_visits(nodes: np.ndarray, origins: np.ndarray, directions: np.ndarray, t: np.ndarray) -> Walk:
    """Visits of rays (n, 3), (n, 3) whose nearest hits are at distance t, (n,)."""
    planes = nodes["planes"].reshape(-1, 6, layout.WIDE)
    leaves = (nodes["child"] < 0) & (planes[:, 0] <= planes[:, 1])  # an empty place has an inverted box
    total = len(nodes) * _NODE + int(leaves.sum()) * _BLOCK
    with np.errstate(divide="ignore"):
        inverse = 1.0 / directions
    ray, node = np.arange(len(t)), np.zeros(len(t) if len(nodes) else 0, np.int64)
    visited, blocks, flops = 0, 0, 0.0
    while len(node):
        visited += len(node)
        flops += len(node) * _NODE_FLOPS
        met = _boxes_met(planes[node], origins[ray], inverse[ray], t[ray])
        child = nodes["child"][node]
        at, lane = np.nonzero(met)
        reference = child[at, lane]
        leaf = reference < 0
        blocks += int(leaf.sum())
        flops += sum(_BLOCK_FLOPS[int(kind)] for kind in ~reference[leaf] & 3)
        ray, node = ray[at][~leaf], reference[~leaf].astype(np.int64)
    n = max(len(t), 1)
    return Walk(visited / n, blocks / n, flops / n, total)


def _boxes_met(planes: np.ndarray, origin: np.ndarray, inverse: np.ndarray, t: np.ndarray) -> np.ndarray:
    """(k, WIDE) bool: which of a node's boxes a ray enters before t; `planes` is (k, 6, WIDE)."""
    near, far = np.zeros((len(t), layout.WIDE)), np.repeat(t[:, None], layout.WIDE, axis=1)
    with np.errstate(invalid="ignore"):  # 0 * inf where a ray runs in a plane of a box: no bound
        for axis in range(3):
            low = (planes[:, 2 * axis] - origin[:, axis, None]) * inverse[:, axis, None]
            high = (planes[:, 2 * axis + 1] - origin[:, axis, None]) * inverse[:, axis, None]
            near, far = np.fmax(near, np.fmin(low, high)), np.fmin(far, np.fmax(low, high))
    return (near <= far) & (planes[:, 0] <= planes[:, 1])
