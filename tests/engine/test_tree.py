"""Input that is hard on a tree: it must build, in bounded time, and give what brute force gives."""

from __future__ import annotations

import mmap
import time

import numpy as np
import pytest

import clrt
from clrt.base.resources import validation_module
from clrt.device import hugepages
from clrt.device.device import Device

trace32 = validation_module("twin.picture").trace32
RNG = np.random.default_rng(20240603)


def spheres(centers: np.ndarray, radii: np.ndarray) -> list[dict]:
    pairs = zip(centers.tolist(), radii.tolist(), strict=True)
    return [{"type": "sphere", "center": center, "radius": radius} for center, radius in pairs]


def mesh(vertices: np.ndarray, faces: np.ndarray) -> dict:
    return {"type": "mesh", "vertices": vertices, "faces": faces}


def rays(n: int, size: float, seed: int = 1) -> tuple[np.ndarray, np.ndarray]:
    random = np.random.default_rng(seed)  # its own: which tests ran before in this process changes nothing
    origins = random.normal(size=(n, 3)) * 3 * size
    return origins.astype(np.float32), (random.normal(size=(n, 3)) * 0.4 * size - origins).astype(np.float32)


PLACES = RNG.normal(size=(40, 3)).tolist()
SHAPES = {
    "nothing": [],
    "one sphere": spheres(np.zeros((1, 3)), np.ones(1)),
    "equal spheres": spheres(np.zeros((300, 3)), np.ones(300)),
    "one centre": spheres(np.zeros((300, 3)), np.linspace(0.01, 1, 300)),
    "in a row": spheres(np.geomspace(1e-6, 1, 300)[:, None] * [1, 0, 0], np.full(300, 0.05)),
    "huge and tiny": spheres(RNG.normal(size=(300, 3)), 10.0 ** RNG.uniform(-6, 3, 300)),
    "all kinds": [
        *spheres(RNG.normal(size=(40, 3)), np.full(40, 0.1)),
        mesh(RNG.normal(size=(120, 3)), np.arange(120).reshape(-1, 3)),
        *({"type": "disk", "center": c, "normal": [0, 1, 0.3], "radius": 0.2} for c in PLACES[:20]),
        *({"type": "ellipsoid", "center": c, "radii": [0.1, 0.2, 0.3]} for c in PLACES[20:]),
        {"type": "plane", "point": [0, -2, 0], "normal": [0, 1, 0]},
    ],
    "flat mesh": [mesh(RNG.uniform(-1, 1, (300, 3)) * [1, 0, 1], np.arange(300).reshape(-1, 3))],
    "points": [mesh(np.repeat(RNG.normal(size=(50, 3)), 3, 0), np.arange(150).reshape(-1, 3))],
}


@pytest.mark.parametrize("name", SHAPES)
def test_the_tree_gives_what_brute_force_gives(name: str) -> None:
    tracer = clrt.Tracer(clrt.load_dict({"shapes": SHAPES[name]}))
    origins, directions = rays(4000, 1.0)
    ours, theirs = tracer.intersect(origins, directions), trace32(tracer.flat, origins, directions)
    assert np.array_equal(ours.primitive, theirs.primitive)
    assert np.array_equal(ours.t.view(np.uint32), theirs.t.view(np.uint32))
    assert np.array_equal(tracer.occluded(origins, directions), theirs.primitive >= 0)
    if name not in ("nothing", "points"):
        assert (theirs.primitive >= 0).sum() > 20


@pytest.mark.parametrize("thickness", [(1e-6, 1e-3), (1e-4, 1e-4)])
def test_of_slivers_within_rounding_the_tree_gives_the_nearest(thickness: tuple[float, float]) -> None:
    """After rounding a sliver's distance says little, and the box of one along an axis says much."""
    random = np.random.default_rng(2)
    corners = random.uniform(-1, 1, (300, 3)) * [1, *thickness]
    tracer = clrt.Tracer(clrt.load_dict({"shapes": [mesh(corners, np.arange(300).reshape(-1, 3))]}))
    origins = (0.5 * random.normal(size=(20_000, 3))).astype(np.float32)
    weights = random.dirichlet([1, 1, 1], len(origins))[..., None]
    aims = (corners.reshape(-1, 3, 3)[random.integers(0, 100, len(origins))] * weights).sum(axis=1)
    directions = (aims - origins).astype(np.float32)
    ours, theirs = tracer.intersect(origins, directions), trace32(tracer.flat, origins, directions)
    assert (theirs.primitive >= 0).mean() > 0.99
    assert np.array_equal(ours.primitive, theirs.primitive)
    assert np.array_equal(ours.t.view(np.uint32), theirs.t.view(np.uint32))
    assert np.array_equal(tracer.occluded(origins, directions), theirs.primitive >= 0)


def test_a_million_equal_triangles_build_and_render_in_bounded_time() -> None:
    vertices = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]], np.float64)
    scene = clrt.load_dict({"shapes": [mesh(vertices, np.tile([0, 1, 2], (1_000_000, 1)))]})
    start = time.process_time()
    tracer = clrt.Tracer(scene)
    # every leaf must be looked at: 125,000 blocks a ray
    hits = tracer.intersect([[0.2, 0.2, 3], [0.9, 0.9, 3]], [[0, 0, -1], [0, 0, -1]])
    assert time.process_time() - start < 20  # measured 2
    assert hits.primitive.tolist() == [0, -1]
    assert hits.t.tolist() == pytest.approx([3, np.inf], rel=1e-6)


def test_large_pages_are_a_hint_that_keeps_what_a_buffer_holds() -> None:
    device = Device()
    values = np.random.default_rng(1).integers(0, 256, 5 * hugepages.PAGE + 12_345, np.uint8)
    buffer = device.buffer(values.nbytes)
    device.write(buffer, values)
    taken = hugepages.ask(device.queue, buffer, values.nbytes)
    assert not taken or (hasattr(mmap, "MADV_HUGEPAGE") and device.info.kind == "CPU")
    assert np.array_equal(device.read(buffer, np.empty_like(values)), values)
    assert not hugepages.ask(device.queue, buffer, hugepages.PAGE)


def test_what_the_builder_no_longer_needs_is_free_for_the_leaves() -> None:
    n = 1 << 18  # 448 bytes each: 496 were taken; ten million fit into the limit that there is
    corners = np.random.default_rng(1).random((n, 1, 3)) + 0.01 * np.random.default_rng(2).random((n, 3, 3))
    scene = {"shapes": [mesh(corners.reshape(-1, 3), np.arange(3 * n).reshape(-1, 3))]}
    limits = clrt.Limits(device_bytes=448 * n)
    assert clrt.Tracer(scene, settings=clrt.Settings(limits=limits)).flat.hash
