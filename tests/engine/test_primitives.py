"""Every primitive, in float64 and on the kernels: inside, outside, grazing, along axes, far, at any scale.

Two checks of a hit. The point it names lies on the surface, and the normal is the surface's there, by the
formulas of `tests/formulas.py`. And it is the right one among all: the oracle's nearest hit.

One tolerance for both. In float32 (unit roundoff u = 2^-24) the kernels trace a ray that is not quite the one
asked for, and a surface that is not quite the one given: normalising rounds the direction by 3 u, parameters
and differences of coordinates are rounded by some u of `reach`, the largest coordinate plus the distance. So
an answer is right when it is the float64 answer to a ray displaced by up to DISPLACEMENT * u * reach; near
silhouettes and edges, where that may be a hit or a miss, either. This bounds the distance at grazing angles
too, where it grows with the inverse of the cosine or with the root of the displacement. The bound is close:
half of it fails on three shapes, a quarter on twenty.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest

import clrt
from clrt.scene.scene import Step
from tests.engines import ENGINES, Engine, Hits, unit
from tests.formulas import surface
from tests.solids import L_SHAPE, SHAPES, TETRA, TURN, scene
from validation.oracle64 import trace64

U = 2.0**-24
DISPLACEMENT = 8.0
TILTS = (0.0, 0.6, 1.0, 1.6)
EDGE_ON = 0.01  # share of rays that may lie in the plane of a face and see past it
SCALES = (1e-3, 1.0, 1e5)
PLACES = ((0, 0, 0), (100, -50, 30))  # in sizes
LENGTHS = ("radius", "radii", "r0", "r1", "focal", "height")
POINTS = ("center", "point", "points", "vertices", "p0", "p1", "apex", "min", "max")

PRISM = {
    "vertices": [[x - 0.6, y - 0.6, z] for z in (-0.5, 0.5) for x, y, _ in L_SHAPE],
    "faces": [
        [5, 4, 3, 2, 1, 0],
        [6, 7, 8, 9, 10, 11],
        *([i, (i + 1) % 6, (i + 1) % 6 + 6, i + 6] for i in range(6)),
    ],
}
KINDS: dict[str, dict[str, Any]] = {
    **{kind: {"type": kind, **keys} for kind, keys in SHAPES.items()},
    "open cylinder": {"type": "cylinder", "p0": [0, -1, 0], "p1": [0, 1, 0], "radius": 0.5},
    "cone with apex": {"type": "cone", "p0": [0, -1, 0], "r0": 1.0, "p1": [0, 1, 0], "r1": 0.0},
    "round quadric": {"type": "quadric", "coefficients": [1, 2, 3, 0.1, 0.2, 0.3, 0.4, 0.1, 0.2, -1]},
    "smooth mesh": {"type": "mesh", **TETRA, "smooth": True},
    "mesh of n-gons": {"type": "mesh", **PRISM},
}
ROUND_ONLY = ("cylinder", "cone", "disk")  # their disks must stay round
TURNED = {
    f"turned {kind}": {
        **keys,
        "transform": [step for step in TURN if "scale" not in step or kind not in ROUND_ONLY],
    }
    for kind, keys in KINDS.items()
    if kind != "plane"
}


@dataclass(frozen=True)
class Rays:
    """Rays as the kernels get them: float32 numbers."""

    origin: np.ndarray
    direction: np.ndarray

    @classmethod
    def of(cls, origin: Any, direction: Any, scale: float, place: Any) -> Rays:
        """Rays given in sizes from the middle of the shape."""
        moved = scale * (np.asarray(origin, float) + place)
        return cls(moved.astype(np.float32).astype(float), np.asarray(direction, np.float32).astype(float))


def placed(keys: dict[str, Any], scale: float, place: Any) -> clrt.Scene:
    """The shape scaled and moved, in its own parameters where it has them."""
    out = dict(keys)
    for name, value in keys.items():
        if name in LENGTHS:
            out[name] = (scale * np.asarray(value, float)).tolist()
        elif name in POINTS:
            out[name] = (scale * (np.asarray(value, float) + place)).tolist()
    if keys["type"] == "quadric" or "transform" in keys:
        steps = [
            *keys.get("transform", []),
            {"scale": scale},
            {"translate": (scale * np.asarray(place)).tolist()},
        ]
        out = {**keys, "transform": steps}
    return scene(out)


def step_matrix(keys: dict[str, Any]) -> np.ndarray:
    """The transform (4, 4) of a shape of the tables above."""
    matrix = np.eye(4)
    for step in keys.get("transform", []):
        matrix = Step(**step).matrix @ matrix
    return matrix


def probes(keys: dict[str, Any]) -> tuple[np.ndarray, np.ndarray]:
    """Origins and directions in sizes: from outside, inside and far off, along the axes, grazing."""
    rng = np.random.default_rng(20240611)
    away = unit(rng.normal(size=(120, 3)))
    aims = rng.uniform(-1, 1, (120, 3))
    grid = np.array([[x, y, z] for x in (-0.45, 0, 0.3) for y in (-0.45, 0, 0.7) for z in (-0.3, 0.05, 0.55)])
    axes = np.concatenate([np.eye(3), -np.eye(3)])
    origins = [5 * away, 0.4 * aims, 300 * away, *(grid - 4 * axis for axis in axes), *([grid] * 6)]
    directions = [aims - 5 * away, away, aims - 300 * away, *([np.tile(axis, (27, 1)) for axis in axes] * 2)]
    hits = trace64(placed(keys, 1.0, (0, 0, 0)), origins[0], directions[0])
    hit = hits.primitive >= 0
    tangent = unit(np.cross(hits.normal[hit], away[hit]))
    height = np.resize([1e-2, 1e-3, 1e-4, 0.0, -1e-4, -1e-3, -1e-2], hit.sum())[:, None]
    origins.append(hits.position[hit] + height * hits.normal[hit] - 2 * tangent)
    directions.append(tangent)
    return np.concatenate(origins), np.concatenate(directions)


def answers64(
    found: clrt.Scene, rays: Rays, step: np.ndarray, depth: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Distances and primitives (copies, n) of the rays, first, and of copies moved by `step`, in float64.

    Moved along the ray, and in eight directions sideways: parallel to it, or tilted so that it crosses the
    ray somewhere about `depth`, where the shape is.
    """
    u = unit(rays.direction)
    a = unit(np.cross(u, np.roll(u, 1, axis=1) + np.array([0.1, 0.2, 0.3])))
    b = np.cross(u, a)
    starts = [rays.origin + s * step[:, None] * u for s in (0, -1, 1)]
    directions = [u] * 3
    for angle in np.arange(8) * np.pi / 4:
        move = step[:, None] * (np.cos(angle) * a + np.sin(angle) * b)
        starts += [rays.origin + move] * len(TILTS)
        directions += [u - tilt * move / depth[:, None] for tilt in TILTS]
    hits = trace64(found, np.concatenate(starts), np.concatenate(directions))
    return hits.t.reshape(len(starts), -1), hits.primitive.reshape(len(starts), -1)


@dataclass(frozen=True)
class Case:
    """A shape of the tables above, scaled and moved."""

    keys: dict[str, Any]
    scale: float
    place: tuple[float, float, float]

    @property
    def scene(self) -> clrt.Scene:
        return placed(self.keys, self.scale, self.place)

    def off_surface(self, hits: Hits, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """By formula: how far points (n, 3) are off the primitives that were hit, and the normals there."""
        matrix = step_matrix(self.keys)
        inverse = np.linalg.inv(matrix[:3, :3])
        local = (points / self.scale - self.place - matrix[:3, 3]) @ inverse.T
        distance, normal = np.zeros(len(points)), np.zeros_like(points)
        for primitive in np.unique(hits.primitive[hits.primitive >= 0]):
            of = hits.primitive == primitive
            value, gradient = surface(self.keys, int(primitive), local[of])
            gradient = gradient @ inverse
            distance[of], normal[of] = self.scale * value / np.linalg.norm(gradient, axis=1), unit(gradient)
        return distance, normal


def check(engine: Engine, case: Case, rays: Rays) -> tuple[float, float]:
    """Assert that the engine's hits are right; the shares of rays that hit, and whose answer is certain."""
    hits = engine.intersect(case.scene, rays.origin, rays.direction)
    hit = hits.primitive >= 0
    assert (hits.shape == np.where(hit, 0, -1)).all() and (np.isfinite(hits.t) == hit).all()
    depth = np.linalg.norm(rays.origin - case.scale * np.array(case.place), axis=1) + 0.1 * case.scale
    reach = np.max(np.abs(rays.origin), axis=1) + depth + case.scale
    step = DISPLACEMENT * U * np.maximum(reach, np.where(hit, hits.t, 0))

    points = rays.origin + np.where(hit, hits.t, 0)[:, None] * unit(rays.direction)
    distance, normal = case.off_surface(hits, points)
    turned = np.linalg.norm(hits.normal - normal, axis=1)
    assert np.all(np.abs(distance[hit]) <= step[hit]), worst(np.abs(distance) / step, hit)
    # parameters rounded by `step` turn a plane by step / size; where a surface bends, the point counts too
    shifts = [
        case.off_surface(hits, points + sign * step[:, None] * axis)[1]
        for axis in np.eye(3)
        for sign in (-1, 1)
    ]
    slack = (
        2 * np.max([np.linalg.norm(n - normal, axis=1) for n in shifts], axis=0)
        + 4 * step / case.scale
        + 8 * U
    )
    assert np.all(turned[hit] <= slack[hit]), worst(turned / slack, hit)

    t, primitive = answers64(case.scene, rays, step, depth)
    agree = primitive == hits.primitive
    certain = np.all(primitive == primitive[0], axis=0)
    assert agree[0][certain].all(), worst(certain & ~agree[0], certain)
    # in the plane of a face, a ray may pass its near neighbour and meet the far one
    assert np.mean(~agree.any(axis=0)) <= EDGE_ON
    sure = certain & hit
    error = np.zeros(len(step))
    error[sure] = np.abs(hits.t[sure] - t[0, sure]) / (np.ptp(t[:, sure], axis=0) + step[sure])
    assert np.all(error <= 1), worst(error, sure)
    return float(hit.mean()), float(certain.mean())


def worst(ratio: np.ndarray, among: np.ndarray) -> str:
    """The rays, of those looked at, that miss a bound most, for the message."""
    order = np.argsort(-np.where(among, ratio, 0))[:3]
    return f"rays {order.tolist()} are off by {np.asarray(ratio, float)[order].tolist()} of what is allowed"


@pytest.mark.parametrize("kind", [*KINDS, *TURNED])
def test_nearest_hits_and_normals(kind: str) -> None:
    keys = {**KINDS, **TURNED}[kind]
    origin, direction = probes(keys)
    for scale in SCALES:
        for place in PLACES:
            rays = Rays.of(origin, direction, scale, place)
            hit, certain = check(ENGINES["kernels"], Case(keys, scale, place), rays)
            assert hit > 0.05, "the rays must meet the shape"
            assert certain > 0.8, "the tolerance must not excuse everything"


@pytest.mark.parametrize("kind", [*KINDS, *TURNED])
def test_the_oracle_lies_on_the_formulas(kind: str) -> None:
    keys = {**KINDS, **TURNED}[kind]
    rays = Rays.of(*probes(keys), 1.0, PLACES[1])
    check(ENGINES["oracle64"], Case(keys, 1.0, PLACES[1]), rays)


@pytest.mark.parametrize("engine", ENGINES.values(), ids=ENGINES)
@pytest.mark.parametrize("scale", SCALES)
def test_a_ray_in_or_along_a_plane_misses(engine: Engine, scale: float) -> None:
    flat = {
        "plane": {"point": [0, 0, 0], "normal": [0, 1, 0]},
        "disk": {"center": [0, 0, 0], "normal": [0, 1, 0], "radius": 1},
    }
    flat["polygon"] = {"points": [[-1, 0, -1], [-1, 0, 1], [1, 0, 1], [1, 0, -1]]}
    for kind, keys in flat.items():
        rays = Rays.of(
            [[0, 0.3, 0], [0, -0.3, 0], [-2, 0, 0.1], [0, 0, 0]], [[1, 0, 0]] * 4, scale, (0, 0, 0)
        )
        hits = engine.intersect(placed({"type": kind, **keys}, scale, (0, 0, 0)), rays.origin, rays.direction)
        assert hits.primitive.tolist() == [-1] * 4, kind
