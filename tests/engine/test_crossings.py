"""Rays cross a closed surface an odd number of times from within: against exact arithmetic."""

from __future__ import annotations

from fractions import Fraction
from typing import Any

import numpy as np
import pytest
import trimesh

import clrt

GENERIC = np.array([1009, 757, 643])  # a direction through no edge and no corner of what follows


def solid(kind: str, seed: int = 0) -> tuple[np.ndarray, np.ndarray]:
    """Vertices (whole numbers) and triangles of a closed surface that does not meet itself."""
    rng = np.random.default_rng(seed)
    if kind == "box":
        mesh = trimesh.creation.box(extents=(200, 120, 80))
    elif kind == "octahedron":
        mesh = trimesh.convex.convex_hull(100 * np.concatenate([np.eye(3), -np.eye(3)]))
    elif kind == "torus":
        mesh = trimesh.creation.torus(150, 60, major_sections=16, minor_sections=8)
    elif kind == "stairs":  # many faces in common planes, edges in line with others
        return _stairs()
    else:  # a star: every corner is moved along its own direction from the origin
        mesh = trimesh.creation.icosphere(subdivisions=2)
        mesh.vertices *= rng.uniform(60, 250, (len(mesh.vertices), 1))
    return np.rint(mesh.vertices).astype(np.int64), np.asarray(mesh.faces, np.int64)


def _stairs() -> tuple[np.ndarray, np.ndarray]:
    """The outside of a heap of unit cubes of side 40, without the walls between them."""
    cells = {(x, y, z) for x in range(4) for y in range(4) for z in range(4) if x + y + z < 5}
    corners: dict[tuple[int, ...], int] = {}
    faces = []
    for cell in sorted(cells):
        for axis in range(3):
            for side in (0, 1):
                other = list(cell)
                other[axis] += 2 * side - 1
                if tuple(other) in cells:
                    continue
                a, b = (axis + 1) % 3, (axis + 2) % 3
                square = []
                for i, j in ((0, 0), (1, 0), (1, 1), (0, 1)):
                    point = list(cell)
                    point[axis] += side
                    point[a] += i
                    point[b] += j
                    square.append(corners.setdefault(tuple(40 * p for p in point), len(corners)))
                if not side:
                    square.reverse()
                faces += [[square[0], square[1], square[2]], [square[0], square[2], square[3]]]
    return np.array(list(corners)), np.array(faces)


def inside(vertices: np.ndarray, faces: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Whether points (n, 3) of whole numbers lie within a closed surface: exact, along GENERIC."""
    found = []
    for point in points:
        a, b, c = (vertices[faces[:, k]] - point for k in range(3))
        sides = np.stack([np.cross(u, v) @ GENERIC for u, v in ((b, c), (c, a), (a, b))])
        signs = np.sign(sides)
        assert not ((signs == 0).any(axis=0) & (np.abs(signs.sum(axis=0)) > 0)).any(), "not generic"
        volume = np.einsum("ij,ij->i", a, np.cross(b, c))
        covered = (sides > 0).all(axis=0) | (sides < 0).all(axis=0)
        ahead = np.sign(volume) * np.sign(sides[0]) > 0
        found.append(np.count_nonzero(covered & ahead) % 2 == 1)
    return np.array(found)


def hard_rays(vertices: np.ndarray, faces: np.ndarray, n: int, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Origins (whole numbers) off the surface; directions to corners, to points of edges, along faces."""
    rng = np.random.default_rng(seed)
    low, high = vertices.min(axis=0) - 30, vertices.max(axis=0) + 30
    origins = rng.integers(low, high + 1, (n, 3))
    corner = vertices[rng.integers(len(vertices), size=n)]
    face = faces[rng.integers(len(faces), size=n)]
    a, b = vertices[face[:, 0]], vertices[face[:, 1]]
    aims = np.stack([corner - origins, a + b - 2 * origins, b - a, rng.integers(-1, 2, (n, 3))])
    directions = aims[rng.integers(4, size=n), np.arange(n)]
    # some start in the plane of a face, or on the line of an edge
    planar = rng.random(n) < 0.3
    origins[planar] = (a + 3 * (a - b))[planar]
    kept = (directions != 0).any(axis=1) & (distance(vertices, faces, origins) > 0.5)
    return origins[kept], directions[kept]


def distance(vertices: np.ndarray, faces: np.ndarray, points: np.ndarray) -> np.ndarray:
    mesh = trimesh.Trimesh(vertices, faces, process=False)
    return trimesh.proximity.closest_point_naive(mesh, points)[1]


def tracer(vertices: np.ndarray, faces: np.ndarray, scale: float = 1.0, **settings: Any) -> clrt.Tracer:
    mesh = {"type": "mesh", "vertices": vertices * scale, "faces": faces}
    return clrt.Tracer({"shapes": [mesh]}, settings=clrt.Settings(**settings))


@pytest.mark.parametrize("scale", [1.0, 0.1], ids=["whole numbers", "rounded"])
@pytest.mark.parametrize("kind", ["box", "octahedron", "torus", "stairs", "star"])
def test_parity_tells_inside_from_outside(kind: str, scale: float) -> None:
    """Rounded, rays pass corners and edges by less than what single precision tells apart."""
    vertices, faces = solid(kind)
    origins, directions = hard_rays(vertices, faces, 2000, seed=1)
    expected = inside(vertices, faces, origins)
    assert expected.any() and not expected.all()
    made = tracer(vertices, faces, scale)
    counts = made.count_hits(origins * scale, directions)
    wrong = counts % 2 != expected
    assert not wrong.any(), (np.count_nonzero(wrong), origins[wrong][:3], directions[wrong][:3])
    assert np.array_equal(made.all_hits(origins * scale, directions, fields=["t"]).counts, counts)


@pytest.mark.parametrize("scale", [1.0, 0.1], ids=["whole numbers", "rounded"])
def test_polygons_and_triangles_together_are_as_closed(scale: float) -> None:
    """Every other square of a heap of cubes is two triangles; some are shapes of their own."""
    vertices, faces = solid("stairs")
    squares = [[*faces[k], faces[k + 1][2]] for k in range(0, len(faces), 2)]
    mixed: list[list[int]] = []
    for number, square in enumerate(squares):
        mixed += [square] if number % 2 else faces[2 * number : 2 * number + 2].tolist()
    alone = [{"type": "polygon", "points": (vertices[square] * scale).tolist()} for square in squares[:30]]
    mixed = mixed[sum(1 + (number % 2 == 0) for number in range(30)) :]
    mesh = {"type": "mesh", "vertices": vertices * scale, "faces": mixed}
    made = clrt.Tracer({"shapes": [mesh, *alone]})
    origins, directions = hard_rays(vertices, faces, 2000, seed=2)
    expected = inside(vertices, faces, origins)
    counts = made.count_hits(origins * scale, directions)
    assert np.array_equal(counts % 2, expected) and counts.max() > 2


def side(u: np.ndarray, v: np.ndarray) -> int:
    """On which side of an edge from u to v the point (d, d^2) lies, for d > 0 smaller than all else."""
    (ux, uy), (vx, vy) = ([Fraction(float(x)) for x in p[:2]] for p in (u, v))
    for term in (ux * vy - uy * vx, uy - vy, vx - ux):
        if term:
            return 1 if term > 0 else -1
    return 0


def test_edges_that_rounding_cannot_tell_from_the_ray_are_decided_exactly() -> None:
    """Triangles one behind the other, with edges that pass the ray by less than a product's last place."""
    rng = np.random.default_rng(4)
    n = 3000
    u = (rng.normal(size=(n, 2)) * 10.0 ** rng.integers(-3, 4, (n, 1))).astype(np.float32)
    v = (-u * rng.uniform(0.3, 3, (n, 1)).astype(np.float32)).astype(np.float32)  # nearly through 0, 0
    v[::5] = -u[::5]  # exactly
    w = rng.normal(size=(n, 2)).astype(np.float32) * np.float32(5)
    w[::7] = 0  # a corner on the ray
    w[1::7, 0] = 0
    flat = np.stack([u, v, w], axis=1)
    vertices = np.concatenate([flat, np.broadcast_to(np.arange(n)[:, None, None], (n, 3, 1))], axis=2)
    made = tracer(vertices.reshape(-1, 3), np.arange(3 * n).reshape(n, 3))
    expected = []
    for number, (a, b, c) in enumerate(flat):
        sides = {side(c, b), side(a, c), side(b, a)}
        if sides in ({1}, {-1}):
            expected.append(number)
    with np.errstate(under="ignore"):
        doubtful = u[:, 0] * v[:, 1] == u[:, 1] * v[:, 0]
    assert np.count_nonzero(doubtful) > 500 and 500 < len(expected) < n - 500
    found = made.all_hits([0, 0, -1], [0, 0, 1])
    assert found.primitive.tolist() == expected
    assert found.t == pytest.approx(np.array(expected) + 1, rel=1e-6)
    assert made.count_hits([0, 0, -1], [0, 0, 3]) == len(expected)


@pytest.mark.parametrize("shape", [
    {"type": "sphere", "center": [0, 0, 0], "radius": 1},
    {"type": "ellipsoid", "center": [0, 0, 0], "radii": [1, 1, 1]},
    {"type": "ellipsoid", "center": [0, 0, 0], "radii": [2, 1, 0.5]},
    {"type": "ellipsoid", "center": [3, 0, 0], "radii": [0.3, 0.3, 0.7]},
], ids=["sphere", "ball", "ellipsoid", "elsewhere"])  # fmt: skip
def test_a_surface_that_is_touched_is_crossed_twice_or_not_at_all(shape: dict[str, Any]) -> None:
    rng = np.random.default_rng(6)
    n = 100_000
    normal, across = (v / np.linalg.norm(v, axis=1, keepdims=True) for v in rng.normal(size=(2, n, 3)))
    across = np.cross(normal, across)
    axes = np.array(shape.get("radii", [1, 1, 1]))
    away = rng.uniform(0.5, 3, (n, 1))
    near = np.where(rng.random((n, 1)) < 0.3, 1.0, 1 + rng.uniform(-2e-7, 2e-7, (n, 1)))
    origins = (normal * near - across * away) * axes + shape["center"]
    counts = clrt.Tracer({"shapes": [shape]}).count_hits(origins, across * axes)
    assert set(np.unique(counts)) == {0, 2}


SOLIDS: dict[str, dict[str, Any]] = {
    "box": {"type": "box", "min": [-0.7, -0.4, -1.1], "max": [0.5, 0.9, 0.6]},
    "cylinder": {"type": "cylinder", "p0": [-0.3, -0.8, 0.2], "p1": [0.4, 0.7, -0.1], "radius": 0.6},
    "cone": {"type": "cone", "p0": [0.1, -0.8, 0.2], "r0": 0.9, "p1": [-0.2, 0.9, 0], "r1": 0},
    "truncated cone": {"type": "cone", "p0": [0.1, -0.8, 0.2], "r0": 0.8, "p1": [-0.2, 0.7, 0], "r1": 0.3},
}


class Round:
    """A capped cylinder or cone, in double precision: its axis, and the radius along it."""

    def __init__(self, shape: dict[str, Any]) -> None:
        p0, p1 = (np.array(shape[end], np.float32).astype(float) for end in ("p0", "p1"))
        self.p0, self.height = p0, float(np.linalg.norm(p1 - p0))
        self.axis = (p1 - p0) / self.height
        ends = [shape.get(name, shape.get("radius")) for name in ("r0", "r1")]
        self.r0, self.r1 = (float(np.float32(radius)) for radius in ends)

    def at(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Height above p0, and distance from the axis."""
        z = (points - self.p0) @ self.axis
        return z, np.linalg.norm(points - self.p0 - z[..., None] * self.axis, axis=-1)

    def inside(self, points: np.ndarray) -> np.ndarray:
        z, r = self.at(points)
        return (z > 0) & (z < self.height) & (r < self.r0 + (self.r1 - self.r0) * z / self.height)

    def rim(self, turn: np.ndarray, top: np.ndarray) -> np.ndarray:
        """Points of both rims; those of a tip are one."""
        u = np.cross(self.axis, [0.3, 0.1, 0.9])
        u /= np.linalg.norm(u)
        v = np.cross(self.axis, u)
        r, z = np.where(top, self.r1, self.r0), np.where(top, self.height, 0)
        around = np.cos(turn)[:, None] * u + np.sin(turn)[:, None] * v
        return self.p0 + z[:, None] * self.axis + r[:, None] * around

    def away(self, origins: np.ndarray, directions: np.ndarray) -> np.ndarray:
        """How far rays pass from both rims, or a tip: from 20,000 points of each."""
        turn = np.linspace(0, 2 * np.pi, 20_000)
        unit = directions / np.linalg.norm(directions, axis=1, keepdims=True)
        points = np.concatenate([self.rim(turn, np.full(len(turn), top)) for top in (False, True)])
        to = points - origins[:, None]
        return np.linalg.norm(np.cross(to, unit[:, None]), axis=2).min(axis=1)


def random_rays(n: int) -> tuple[np.ndarray, np.ndarray]:
    rng = np.random.default_rng(7)
    origins = rng.uniform(-1.2, 1.2, (n, 3)).astype(np.float32).astype(float)
    return origins, rng.normal(size=(n, 3)).astype(np.float32).astype(float)


def test_parity_of_a_box() -> None:
    """Its edges are crossed by no random ray, but within rounding by some: there it is as closed."""
    box = SOLIDS["box"]
    low, high = (np.array(box[name], np.float32) for name in ("min", "max"))
    origins, directions = random_rays(200_000)
    expected = ((origins > low) & (origins < high)).all(axis=1)
    assert 0.1 < expected.mean() < 0.9
    counts = clrt.Tracer({"shapes": [box]}).count_hits(origins, directions)
    assert np.array_equal(counts % 2 == 1, expected) and counts.max() == 2


@pytest.mark.parametrize("kind", ["cylinder", "cone", "truncated cone"])
def test_parity_of_capped_shapes_is_wrong_at_most_at_a_rim(kind: str) -> None:
    """Two of three primitives meet there, each computed alone; a tip is one, too."""
    solid, shape = Round(SOLIDS[kind]), {**SOLIDS[kind], "caps": True}
    made = clrt.Tracer({"shapes": [shape]})
    origins, directions = random_rays(200_000)
    expected = solid.inside(origins)
    assert 0.05 < expected.mean() < 0.9
    counts = made.count_hits(origins, directions)
    wrong = np.flatnonzero((counts % 2 == 1) != expected)
    assert counts.max() == 2 and len(wrong) <= 1, "two of five million random rays were"
    assert (solid.away(origins[wrong], directions[wrong]) < 1e-3).all(), wrong


@pytest.mark.parametrize("kind", ["cylinder", "truncated cone"])
def test_of_rays_at_the_very_rim_about_half_are_counted_wrong(kind: str) -> None:
    """As docs/queries.md says."""
    solid, shape = Round(SOLIDS[kind]), {**SOLIDS[kind], "caps": True}
    origins, _ = random_rays(20_000)
    rng = np.random.default_rng(8)
    aims = solid.rim(rng.uniform(0, 2 * np.pi, len(origins)), rng.random(len(origins)) < 0.5)
    counts = clrt.Tracer({"shapes": [shape]}).count_hits(origins, aims - origins)
    share = np.mean((counts % 2 == 1) != solid.inside(origins))
    assert 0.4 < share < 0.6
