"""The oracle's hits and normals against what is known without it: closed forms, brute force."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import clrt
from tests.engines import unit
from tests.solids import SHAPES, TETRA, TURN, rays_towards_the_middle, scene, shape
from validation.oracle64 import radiance64, trace64

RNG_SEED = 20240612
CLOSED = ("sphere", "mesh", "ellipsoid", "cylinder", "cone", "box")


@pytest.mark.parametrize("turned", [False, True], ids=["as is", "turned"])
@pytest.mark.parametrize("kind", SHAPES)
def test_normals_are_those_of_the_surface_that_is_hit(kind: str, turned: bool) -> None:
    """The hits of three rays side by side span the tangent plane."""
    found = scene(shape(kind, turned))
    origin, direction = rays_towards_the_middle(4000)
    step = 1e-5
    a = unit(np.cross(direction, [0.48, 0.6, 0.64]))
    b = np.cross(direction, a)
    hits = [
        trace64(found, origin + offset, direction)
        for offset in (0 * a, step * a, step * b, -step * a, -step * b)
    ]
    together = np.all([h.primitive == hits[0].primitive for h in hits], axis=0) & (hits[0].primitive >= 0)
    steep = np.abs(np.einsum("ij,ij->i", hits[0].normal, direction)) > 0.2
    kept = together & steep
    assert kept.sum() > 200
    spanned = np.cross(hits[1].position - hits[3].position, hits[2].position - hits[4].position)[kept]
    along = np.abs(np.einsum("ij,ij->i", unit(spanned), hits[0].normal[kept]))
    # central differences: the error is of third order, (1e-5)^2 times curvatures up to 20, over the cosine
    assert along.min() > 1 - 1e-6
    assert np.linalg.norm(hits[0].normal[kept], axis=1) == pytest.approx(1, abs=1e-12)


@pytest.mark.parametrize("turned", [False, True], ids=["as is", "turned and mirrored"])
@pytest.mark.parametrize("kind", CLOSED)
def test_outward_normals_point_out_of_closed_shapes(kind: str, turned: bool) -> None:
    """A ray from a point off the hit along the normal crosses the surface an even number of times."""
    mirrored = [*TURN, {"scale": [-1, 1, 1]}] if turned and kind not in ("cylinder", "cone") else None
    found = scene({**shape(kind), **({"transform": mirrored} if mirrored else {})})
    origin, direction = rays_towards_the_middle(300)
    hits = trace64(found, origin, direction)
    hit = hits.primitive >= 0
    assert hit.sum() > 80
    for side, parity in ((1e-6, 0), (-1e-6, 1)):
        start = hits.position[hit] + side * hits.normal[hit]
        assert (crossings(found, start, unit([[0.36, 0.48, 0.8]])) % 2 == parity).all()


def crossings(found: clrt.Scene, start: np.ndarray, direction: np.ndarray) -> np.ndarray:
    """How often rays cross the scene's surfaces."""
    start, direction = start.copy(), np.broadcast_to(direction, start.shape)
    count = np.zeros(len(start), int)
    alive = np.ones(len(start), bool)
    while alive.any():
        hits = trace64(found, start[alive], direction[alive])
        count[np.flatnonzero(alive)[hits.primitive >= 0]] += 1
        start[alive] = np.where(hits.primitive[:, None] >= 0, hits.position + 1e-9 * direction[alive], np.nan)
        alive &= np.isfinite(start[:, 0])
    return count


def test_hits_of_simple_shapes_in_closed_form() -> None:
    cases = [
        (shape("sphere"), [0.1, 0.2, -5], [0, 0, 1], 4.9 - 1.1, [0, 0, -1]),
        (shape("plane"), [0, 3, 0.1], [0, -1, 0], 3.3, unit([0.2, 1, -0.1])),
        (shape("box"), [3, 0.1, 0.2], [-1, 0, 0], 2.2, [1, 0, 0]),
        (shape("box"), [0, 0, 0], [0, 0, -1], 0.9, [0, 0, -1]),
        (shape("ellipsoid"), [0.1, 4, 0], [0, -1, 0], 3.3, [0, 1, 0]),
        (
            {"type": "cylinder", "p0": [0, 0, 0], "p1": [0, 2, 0], "radius": 0.5},
            [0.3, 1, -3],
            [0, 0, 1],
            2.6,
            [0.6, 0, -0.8],
        ),
        (
            {"type": "cone", "p0": [0, 0, 0], "r0": 1, "p1": [0, 1, 0], "r1": 0},
            [3, 0.5, 0],
            [-1, 0, 0],
            2.5,
            unit([1, 1, 0]),
        ),
        (
            {"type": "paraboloid", "apex": [0, 0, 0], "axis": [0, 2, 0], "focal": 0.25, "height": 4},
            [1, 9, 0],
            [0, -1, 0],
            8,
            unit([2, -1, 0]),
        ),
        (shape("disk"), [0.1, 0.1, 5], [0, 0, -1], 5, unit([1, 2, 3])),
    ]
    for data, origin, direction, t, normal in cases:
        hits = trace64(scene(data), origin, direction)
        assert hits.t == pytest.approx([t], abs=1e-12), data
        assert hits.normal[0] == pytest.approx(normal, abs=1e-12), data


def test_a_clip_box_cuts_in_object_space() -> None:
    """The unit sphere about (1, 0, 0) as a quadric, of which 0.5 <= x <= 1.5 is kept, then turned to y."""
    form = [1, 1, 1, 0, 0, 0, -1, 0, 0, 0]
    belt = {"type": "quadric", "coefficients": form, "clip": [[0.5, -1, -1], [1.5, 1, 1]]}
    turned = scene({**belt, "transform": [{"rotate": ["z", 90]}]})
    heights = [0.49, 0.51, 1.0, 1.49, 1.51]
    down = trace64(turned, [[0, y, 5] for y in heights], [[0, 0, -1]] * 5)
    half = np.sqrt(1 - (np.array(heights) - 1) ** 2)
    assert down.t == pytest.approx(np.where([0, 1, 1, 1, 0], 5 - half, np.inf), abs=1e-12)
    # through the open ends along the axis, and to the inner side of the belt
    assert trace64(turned, [0, 5, 0], [0, -1, 0]).primitive.tolist() == [-1]
    within = trace64(turned, [0, 5, 0], [0.22, -1, 0])
    assert within.primitive.tolist() == [0] and 0.5 < within.position[0, 1] < 1.5 and within.normal[0, 1] < 0


def test_an_apex_faces_the_ray() -> None:
    """From outside and from inside; the cone stands anywhere, so the apex is hit to rounding only."""
    for place in ([0, 0, 0], [10.1, -3.7, 2.3]):
        base = np.array(place)
        top = base + np.array([0, 1.3, 0])
        for r0, r1 in ((0.7, 0.0), (0.0, 0.7)):
            ends = (base, top) if r1 == 0 else (top, base)
            cone = scene({"type": "cone", "p0": list(ends[0]), "r0": r0, "p1": list(ends[1]), "r1": r1})
            hits = trace64(
                cone, [top + np.array([0, 2.7, 0]), top - np.array([0, 0.5, 0])], [[0, -1, 0], [0, 1, 0]]
            )
            assert hits.t == pytest.approx([2.7, 0.5], abs=1e-12)
            assert hits.normal == pytest.approx(np.array([[0, 1, 0], [0, -1, 0]]), abs=1e-12)


@pytest.mark.parametrize("direction", [[0, 0, 0], [np.nan, 0, 1]])
def test_a_direction_that_is_none_misses(direction: list[float]) -> None:
    hits = trace64(scene(*(shape(kind) for kind in SHAPES)), [0, 0, 9], direction)
    assert hits.primitive.tolist() == [-1] and hits.shape.tolist() == [-1] and np.isinf(hits.t).all()
    light, _ = radiance64(scene(background=0.5), [0, 0, 9], [0, 0, 1])
    assert light.tolist() == [[0.5] * 3]


def test_primitives_count_in_scene_order_and_equals_go_to_the_lowest() -> None:
    ball = {"type": "sphere", "center": [0, 0, -9], "radius": 1.0}
    found = scene(
        shape("cone"), shape("box"), shape("cylinder", caps=False), shape("mesh"),
        ball, ball,
        shape("box", transform=[{"translate": [50, 0, 0]}]),
    )  # fmt: skip
    # 3 + 6 + 1 + 4, then the spheres are 14 and 15, the sides of the second box 16 to 21
    assert trace64(found, [0, 0, -20], [0, 0, 1]).primitive.tolist() == [14]
    corners = np.array([[50, 0, 0]] * 6)
    sides = np.concatenate([[-axis, axis] for axis in np.eye(3)])
    hits = trace64(found, corners, sides)
    assert hits.primitive.tolist() == [16, 17, 18, 19, 20, 21]
    assert hits.shape.tolist() == [6] * 6
    assert np.allclose(hits.normal, sides)


def test_the_tree_gives_what_brute_force_gives() -> None:
    rng = np.random.default_rng(RNG_SEED)
    many: list[dict[str, Any]] = []
    for kind in ("sphere", "cone", "polygon", "disk", "ellipsoid"):
        for _ in range(40):
            move = [{"scale": 0.3}, {"rotate": [list(rng.normal(size=3)), 90 * rng.uniform()]}]
            many.append(shape(kind, transform=[*move, {"translate": list(rng.uniform(-2, 2, 3))}]))
    found = scene(*many, shape("plane"))
    origin, direction = rays_towards_the_middle(1500)
    axes = np.repeat(np.concatenate([np.eye(3), -np.eye(3)]), 40, axis=0)
    origin = np.concatenate([origin, rng.uniform(-2, 2, (len(axes), 3))])
    direction = np.concatenate([direction, axes])
    by_tree = trace64(found, origin, direction, leaf=1)
    by_force = trace64(found, origin, direction, leaf=10**9)
    assert (by_tree.t == by_force.t).all() and (by_tree.primitive == by_force.primitive).all()
    assert len(np.unique(by_tree.primitive)) > 150


def test_no_ray_slips_through_a_closed_mesh() -> None:
    """From the middle every ray hits, also those aimed exactly at edges and corners."""
    rng = np.random.default_rng(RNG_SEED)
    vertices, faces = np.array(TETRA["vertices"], float), np.array(TETRA["faces"])
    a, b = vertices[faces[:, 0]], vertices[faces[:, 1]]
    along = rng.uniform(0, 1, (500, 4, 1))
    targets = np.concatenate([(a + along * (b - a)).reshape(-1, 3), vertices])
    hits = trace64(scene(shape("mesh")), np.zeros_like(targets), targets)
    assert (hits.primitive >= 0).all()
    assert hits.t == pytest.approx(np.linalg.norm(targets, axis=1), rel=1e-12)
