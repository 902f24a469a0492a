"""The order in which rays are traced: every ray once, by the way it goes and where it starts."""

from __future__ import annotations

import numpy as np
import pytest

from clrt import layout
from clrt.device.device import Device
from clrt.engine import passes

_PACKET = 16


def keys_of(origins: np.ndarray, directions: np.ndarray) -> np.ndarray:
    """Octant and dominant axis, then the origin's cell along a Morton curve; float32 (n, 3) each."""
    size = np.abs(directions)
    axis = np.argmax(size, axis=1)  # the first of equal ones
    way = axis | ((directions < 0) @ [4, 8, 16])
    low = origins.min(axis=0)
    extent = origins.max(axis=0) - low
    cells = np.divide(np.float32(8), extent, out=np.zeros(3, np.float32), where=extent > 0)
    cell = np.clip((origins - low) * cells, 0, 7).astype(np.int64)
    bits = sum(((cell[:, k] >> bit) & 1) << (3 * bit + k) for k in range(3) for bit in range(3))
    return way << 9 | bits


def arranged(origins: np.ndarray, directions: np.ndarray) -> np.ndarray:
    device = Device()
    n = len(origins)
    queue = passes.adopt(device, origins, directions, np.ones(n, np.float32), np.arange(n, dtype=np.uint32))
    return device.read(passes.arranged(device, queue.rays, n), np.empty(n, np.uint32))


def rays(n: int) -> tuple[np.ndarray, np.ndarray]:
    rng = np.random.default_rng(n)
    directions = rng.normal(size=(n, 3)).astype(np.float32)
    return rng.normal(size=(n, 3)).astype(np.float32), directions


@pytest.mark.parametrize("n", [1, _PACKET - 1, 1000, layout.ARRANGED, 2 * layout.ARRANGED + 77])
def test_rays_stand_by_way_and_origin(n: int):
    origins, directions = rays(n)
    found = arranged(origins, directions)
    for start in range(0, n, layout.ARRANGED):
        block = slice(start, min(start + layout.ARRANGED, n))
        wanted = np.argsort(keys_of(origins[block], directions[block]), kind="stable")
        assert np.array_equal(found[block], start + wanted)


def test_rays_that_are_not_finite_have_a_place():
    origins, directions = rays(3000)
    origins[::7] = np.nan
    origins[1::11, 0] = np.inf
    directions[2::5] = [np.nan, 0, 0]
    directions[3::13] = 0
    assert np.array_equal(np.sort(arranged(origins, directions)), np.arange(3000))
