"""trimesh's questions answered by clrt: against closed forms, and against trimesh's own slow answers."""

from __future__ import annotations

import copy
import pickle
import subprocess
import sys
from typing import Any

import numpy as np
import pytest
import trimesh

import clrt
from clrt.base.errors import ClrtError
from clrt.engine.raymesh import RayMeshIntersector

BOX = trimesh.creation.box(extents=(2, 2, 2))


def rays_at(mesh: Any, n: int, seed: int = 1) -> tuple[np.ndarray, np.ndarray]:
    """From a sphere around the mesh to points inside its box."""
    rng = np.random.default_rng(seed)
    low, high = mesh.bounds
    away = rng.normal(size=(n, 3))
    away *= 1.5 * mesh.scale / np.linalg.norm(away, axis=1, keepdims=True)
    origins = (low + high) / 2 + away
    return origins, (rng.uniform(low, high, (n, 3)) - origins) * rng.uniform(0.1, 10, (n, 1))


def crossings_by_hand(mesh: Any, origin: np.ndarray, direction: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Faces hit and their distances, in float64, by Moeller and Trumbore's solution for every face."""
    d = direction / np.linalg.norm(direction)
    a, b, c = (mesh.triangles[:, k] for k in range(3))
    with np.errstate(divide="ignore", invalid="ignore"):
        p = np.cross(d, c - a)
        inverse = 1 / np.einsum("ij,ij->i", b - a, p)
        u = np.einsum("ij,ij->i", origin - a, p) * inverse
        q = np.cross(origin - a, b - a)
        v = q @ d * inverse
        t = np.einsum("ij,ij->i", c - a, q) * inverse
    hit = (u >= 0) & (v >= 0) & (u + v <= 1) & (t > 0)
    return np.nonzero(hit)[0], t[hit]


@pytest.mark.parametrize("place", [0.0, 1e5], ids=["at the origin", "far from it"])
def test_all_hits_are_those_of_float64(place: float):
    mesh = trimesh.creation.torus(2.0, 0.7, major_sections=40, minor_sections=20)
    mesh.apply_translation([place, -place, place])
    origins, directions = rays_at(mesh, 300)
    ray = RayMeshIntersector(mesh)
    faces, rays = ray.intersects_id(origins, directions)
    points, rays_too, faces_too = ray.intersects_location(origins, directions)
    assert np.array_equal(rays, rays_too) and np.array_equal(faces, faces_too)  # none runs through an edge
    seen = 0
    for i in range(len(origins)):
        expected, t = crossings_by_hand(mesh, origins[i], directions[i])
        order = np.argsort(t)
        assert np.array_equal(faces[rays == i], expected[order])
        along = directions[i] / np.linalg.norm(directions[i])
        wanted = origins[i] + t[order, None] * along
        assert points[rays == i] == pytest.approx(wanted, abs=2e-6 * (1 + place * 1e-9))
        seen = max(seen, len(t))
    assert seen >= 4
    first = ray.intersects_first(origins, directions)
    hits = np.bincount(rays, minlength=len(origins)) > 0
    assert np.array_equal(first >= 0, hits) and np.array_equal(ray.intersects_any(origins, directions), hits)
    lead = np.concatenate([[True], np.diff(rays) != 0])
    assert np.array_equal(first[hits], faces[lead])


def test_a_ray_through_edges_and_corners_enters_once_and_leaves_once():
    """The box's faces are split along diagonals, through whose middle these rays run."""
    ray = RayMeshIntersector(BOX)
    towards = np.array([[1.0, 0, 0], [0, 1, 0], [0, 0, 1], [1, 1, 0], [1, 1, 1]])
    points, rays, _ = ray.intersects_location(-3 * towards, towards)
    assert np.array_equal(rays, np.repeat(np.arange(5), 2))
    assert points == pytest.approx(np.repeat(towards, 2, axis=0) * np.tile([-1, 1], 5)[:, None])
    _, every = ray.intersects_id(-3 * towards, towards)
    assert (np.bincount(every) == 2).all()


def test_an_edge_that_is_only_touched_is_entered_and_left_or_neither():
    """Along y, the octahedron's edge from (1, 0, 0) to (0, 0, 1) is a silhouette."""
    corners = np.concatenate([np.eye(3), -np.eye(3)])
    ray = RayMeshIntersector(trimesh.convex.convex_hull(corners))
    points, _, _ = ray.intersects_location([[0.5, -4, 0.5]], [[0, 1, 0]])
    assert len(points) in (0, 2) and np.allclose(points, [0.5, 0, 0.5], atol=1e-9)


@pytest.mark.parametrize("make", [
    lambda: trimesh.creation.torus(1, 0.3), lambda: trimesh.creation.annulus(0.3, 1, 1),
    trimesh.creation.box, lambda: trimesh.creation.icosphere(subdivisions=2),
])  # fmt: skip
def test_hits_through_edges_and_corners_alternate(make: Any) -> None:
    """Of the annulus 175 in 8,000 did not: a touch came out before in, or three counted as two."""
    mesh, draw, n = make(), np.random.default_rng(0), 4000
    away = draw.normal(size=(n, 3))
    origins = away * (3 + 5 * draw.random((n, 1))) / np.linalg.norm(away, axis=1)[:, None]
    ends = mesh.vertices[mesh.edges_unique[draw.integers(len(mesh.edges_unique), size=n)]]
    weight = np.where(draw.random((n, 1)) < 0.5, 0, draw.random((n, 1)))
    ways = ends[:, 0] * (1 - weight) + ends[:, 1] * weight - origins
    faces, rays, points = RayMeshIntersector(mesh).intersects_id(origins, ways, return_locations=True)
    inwards = np.einsum("ij,ij->i", mesh.face_normals[faces], ways[rays]) < 0
    new = np.diff(rays, prepend=-1) != 0
    assert inwards[new].all() and (np.diff(inwards.astype(int))[~new[1:]] != 0).all(), "in and out in turn"
    assert not (np.bincount(rays, minlength=n) % 2).any() and len(rays) > n
    t = np.einsum("ij,ij->i", points - origins[rays], ways[rays])
    assert (np.diff(t)[~new[1:]] > -1e-5).all()


def test_coincident_faces_are_all_found_and_hits_can_be_limited():
    corners = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0]])
    mesh = trimesh.Trimesh(np.tile(corners, (4, 1)), np.arange(12).reshape(4, 3), process=False)
    ray = RayMeshIntersector(mesh)
    o, d = np.array([[0.2, 0.2, 1.0], [5, 5, 5]]), np.array([[0, 0, -2.0], [0, 0, -1]])
    faces, rays = ray.intersects_id(o, d)
    assert faces.tolist() == [0, 1, 2, 3] and rays.tolist() == [0] * 4
    assert ray.intersects_id(o, d, max_hits=3)[0].tolist() == [0, 1, 2]
    assert ray.intersects_id(o, d, multiple_hits=False)[0].tolist() == [0]
    assert not len(ray.intersects_id(o, d, max_hits=0)[0])
    assert not len(ray.intersects_id(o, d, multiple_hits=False, max_hits=0)[0])
    points, rays, faces = ray.intersects_location(o, d)
    assert points == pytest.approx(np.array([[0.2, 0.2, 0]])) and faces.tolist() == [0]


@pytest.mark.parametrize("length", [5e-324, 1e-200, 1e-150, 1.0, 1e150, 1e200, 1.7e308])
def test_directions_of_any_length(length: float):
    ray = RayMeshIntersector(trimesh.creation.icosphere(subdivisions=1))
    origin, direction = [[0.1, 0.2, 5]], [[0, 0, -length]]
    assert ray.intersects_any(origin, direction).tolist() == [True]
    points, _, _ = ray.intersects_location(origin, direction)
    assert points[:, :2] == pytest.approx(np.array([[0.1, 0.2]] * 2)) and (np.diff(points[:, 2]) < -1).all()


def test_mesh_contains_through_the_adapter():
    mesh = trimesh.creation.icosphere(3)
    mesh.ray = RayMeshIntersector(mesh)
    points = np.random.default_rng(3).uniform(-1.2, 1.2, (2000, 3))
    radius = np.linalg.norm(points, axis=1)
    sure = np.abs(radius - 1) > 0.02  # the sphere's faces lie inside it
    assert np.array_equal(mesh.contains(points)[sure], (radius < 1)[sure])


def test_it_follows_the_mesh_and_survives_copies():
    mesh = BOX.copy()
    ray = RayMeshIntersector(mesh, settings=clrt.Settings(tile=16))
    o, d = np.full((50, 3), [0.0, 0, 5]), np.full((50, 3), [0.0, 0, -1])
    assert ray.intersects_any(o, d).all()
    mesh.apply_translation([3, 0, 0])
    assert not ray.intersects_any(o, d).any()
    for other in (copy.deepcopy(ray), pickle.loads(pickle.dumps(ray))):
        assert other.intersects_any(o + np.array([3, 0, 0]), d).all()


def test_what_cannot_hit_misses():
    ray = RayMeshIntersector(BOX)
    o = np.array([[0, 0, 5.0], [0, 0, 5], [np.inf, 0, 0], [0, 0, np.nan], [0, 0, 5]])
    d = np.array([[0, 0, 0.0], [np.nan, 0, -1], [0, 0, 1], [0, 0, -1], [0, 0, 1]])
    assert ray.intersects_first(o, d).tolist() == [-1] * 5
    assert len(ray.intersects_id(o, d)[0]) == 0
    nothing = np.zeros((0, 3))
    assert ray.intersects_first(nothing, nothing).shape == (0,)
    assert ray.intersects_location(nothing, nothing)[0].shape == (0, 3)
    empty = RayMeshIntersector(trimesh.Trimesh())
    assert empty.intersects_first(o, d).tolist() == [-1] * 5
    for origins, directions in ((o, d[:3]), (o[:, :2], d), (o[0], d[0])):
        with pytest.raises(ClrtError, match="ray_"):
            ray.intersects_any(origins, directions)


def test_the_tracer_does_not_need_trimesh():
    """Only who has a trimesh mesh needs trimesh."""
    code = "import sys; sys.modules['trimesh'] = None; import clrt.engine.raymesh"
    subprocess.run([sys.executable, "-c", code], check=True)


def test_inside_is_told_from_outside_for_every_point():
    """Rows of points whose lines run through corners and edges; a surface that is open, by majority."""
    ray = RayMeshIntersector(BOX)
    axis = np.linspace(-2, 2, 17)[:-1] + 0.1
    points = np.stack(np.meshgrid(axis, axis, axis), axis=-1).reshape(-1, 3)
    assert np.array_equal(ray.contains_points(points), (np.abs(points) < 1).all(axis=1))
    opened = trimesh.Trimesh(BOX.vertices, BOX.faces[BOX.face_normals @ [0, 0, 1.0] < 0.5])
    found = RayMeshIntersector(opened).contains_points([[0, 0, -0.9], [0, 0, 0.999], [0, 0, 1.01], [3, 0, 0]])
    assert found.tolist()[0] and found.tolist()[2:] == [False, False]
    assert RayMeshIntersector(trimesh.Trimesh()).contains_points(points[:3]).tolist() == [False] * 3
    assert ray.contains_points(np.zeros((0, 3))).shape == (0,)


@pytest.mark.parametrize("face", [[0, 1, 7], [0, 1, -1]])
def test_faces_of_vertices_that_are_not_there_are_an_error(face: list[int]) -> None:
    mesh = trimesh.Trimesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [face], process=False)
    with pytest.raises(clrt.ClrtError, match=r"faces"):
        clrt.RayMeshIntersector(mesh).intersects_any([[0, 0, 9]], [[0, 0, -1]])
    with pytest.raises(clrt.ClrtError, match=r"faces"):
        clrt.RayMeshIntersector(mesh).contains_points([[0, 0, 9]])


def test_limits_of_the_settings_hold() -> None:
    settings = clrt.Settings(limits=clrt.Limits(primitives=3))
    asked = clrt.RayMeshIntersector(trimesh.creation.box(), settings=settings)
    with pytest.raises(clrt.LimitError, match="primitives"):
        asked.intersects_any([[0, 0, 9]], [[0, 0, -1]])
