"""Wide nodes from binary ones: every leaf once, and no other choice of nodes has a smaller sum of areas."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from clrt import layout
from clrt.device.device import Device
from clrt.device.settings import Settings

TRIANGLE = layout.BLOCKS["BLOCK_TRIANGLE"]


def half_area(low: np.ndarray, high: np.ndarray) -> float:
    x, y, z = (high - low)[:3].astype(np.float64)
    return float(x * y + y * z + z * x)


def binary_tree(leaves: int, seed: int) -> np.ndarray:
    """A tree of that many leaves, of one item each, over random boxes; lopsided, as the odds have it."""
    rng = np.random.default_rng(seed)
    nodes = np.zeros(2 * leaves - 1, layout.dtype("BuildNode"))
    low = rng.normal(size=(leaves, 3)) * 3
    boxes = np.stack([low, low + rng.random((leaves, 3))], axis=1).astype(np.float32)
    waiting, used = [(0, 0, leaves)], 1
    while waiting:
        number, start, end = waiting.pop()
        nodes[number]["low"][:3] = boxes[start:end, 0].min(axis=0)
        nodes[number]["high"][:3] = boxes[start:end, 1].max(axis=0)
        nodes[number]["kind"] = TRIANGLE
        if end - start == 1:
            nodes[number]["first"], nodes[number]["count"] = start, 1
            continue
        nodes[number]["first"] = used
        middle = int(rng.integers(start + 1, end))
        waiting += [(used, start, middle), (used + 1, middle, end)]
        used += 2
    return nodes


def least_cost(nodes: np.ndarray) -> float:
    """The least sum of areas of wide nodes, by trying every way."""

    @cache
    def within(n: int, places: int) -> float:
        """Of what is below a node that may take so many places of a wide node."""
        if nodes[n]["count"]:
            return 0.0
        return min(wide(n), spread(n, places))

    @cache
    def spread(n: int, places: int) -> float:
        first = int(nodes[n]["first"])
        ways = (within(first, k) + within(first + 1, places - k) for k in range(1, places))
        return min(ways, default=np.inf)

    @cache
    def wide(n: int) -> float:
        return half_area(nodes[n]["low"], nodes[n]["high"]) + spread(n, layout.WIDE)

    return wide(0)


@pytest.mark.parametrize("leaves", [2, 3, layout.WIDE, layout.WIDE + 1, 40, 300])
def test_the_cheapest_nodes_are_made(leaves: int):
    device = Device(None, Settings())
    binary = binary_tree(leaves, leaves)
    nodes = device.buffer(leaves * layout.dtype("WideNode").itemsize, "WideNode")
    counts = device.buffer(16, "int")
    found = device.buffer(3 * (leaves + 1) * 8, "int2")
    ways = device.buffer(layout.dtype("Ways").itemsize, "Ways")
    arguments = (device.upload(binary), ways, nodes, np.int32(leaves + 1), found, counts)
    device.launch("collapse", 1, *arguments, local_size=1)
    used, blocks = device.read(counts, np.empty(2, np.int32))
    wide = device.read(nodes, np.empty(used, layout.dtype("WideNode")))
    assert blocks == leaves
    items = device.read(found, np.empty((3, leaves + 1, 2), np.int32))[TRIANGLE, :blocks]
    assert sorted(items[:, 0]) == list(range(leaves)) and (items[:, 1] == 1).all()

    planes = wide["planes"].reshape(used, 6, layout.WIDE)
    inner = wide["child"] >= 0
    assert sorted(wide["child"][inner]) == list(range(1, used))
    number, lane = np.nonzero(inner)
    areas = [half_area(planes[n, ::2, k], planes[n, 1::2, k]) for n, k in zip(number, lane, strict=True)]
    cost = half_area(binary[0]["low"], binary[0]["high"]) + sum(areas)
    assert cost == pytest.approx(least_cost(binary), rel=1e-5)
