"""How often meshes wind around points: the sum of solid angles, though it is asked seldom."""

from __future__ import annotations

import time

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from clrt.flatten import winding


def ball(divisions: int) -> tuple[np.ndarray, np.ndarray]:
    """A closed mesh around the origin, outward: vertices (v, 3), triangles (t, 3)."""
    n, m = divisions, 2 * divisions
    polar, around = np.meshgrid(np.pi * np.arange(1, n) / n, 2 * np.pi * np.arange(m) / m, indexing="ij")
    ring = np.stack([np.sin(polar) * np.cos(around), np.sin(polar) * np.sin(around), np.cos(polar)], axis=-1)
    vertices = np.concatenate([ring.reshape(-1, 3), [[0, 0, 1], [0, 0, -1]]])
    at = np.arange((n - 1) * m).reshape(n - 1, m)
    here, there, south, beyond = at[:-1], np.roll(at[:-1], -1, 1), at[1:], np.roll(at[1:], -1, 1)
    sides = np.concatenate([np.stack([here, south, beyond], -1), np.stack([here, beyond, there], -1)])
    top = np.stack([np.full(m, len(vertices) - 2), at[0], np.roll(at[0], -1)], -1)
    foot = np.stack([np.full(m, len(vertices) - 1), np.roll(at[-1], -1), at[-1]], -1)
    return vertices, np.concatenate([sides.reshape(-1, 3), top, foot])


def placed(seed: int, kind: str) -> tuple[np.ndarray, np.ndarray]:
    """Some bodies in one another, some turned inside out. split: no vertex is shared; tube: without ends,
    so that what closes them meets within."""
    random = np.random.default_rng(seed)
    vertices, triangles = ball(int(random.integers(2, 9)))
    if kind == "tube":
        vertices, triangles = ball(8)
        triangles = triangles[np.abs(vertices[triangles][..., 2].mean(axis=1)) < 0.75]
    parts, faces = [], []
    for k in range(int(random.integers(1, 4))):
        parts.append(vertices @ np.diag(random.uniform(0.3, 1.5, 3)) + random.normal(size=3) * 0.3)
        turned = triangles[:, ::-1] if random.random() < 0.3 else triangles
        faces.append(turned + k * len(vertices))
    all_vertices, all_faces = np.concatenate(parts), np.concatenate(faces)
    if kind == "split":
        all_vertices = all_vertices[all_faces].reshape(-1, 3)
        all_faces = np.arange(all_faces.size).reshape(-1, 3)
    if kind == "open":
        all_faces = all_faces[1:]
    return all_vertices, all_faces


def where(random: np.random.Generator, kind: str, vertices: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Points (200, 3): anywhere, in a plane or on a line with vertices, on what `kind` names or very near."""
    points = random.uniform(-1.6, 1.6, (200, 3))
    if kind == "plane":
        points[:, 2] = vertices[0, 2]
    elif kind == "line":
        points[:, 1:] = vertices[0, 1:]
    elif kind == "lattice":
        points = np.round(points * 4) / 4
    elif kind != "anywhere":
        weights = random.dirichlet([1, 1, 1], 200)
        if kind == "edges":
            weights[:, 2] = 0
        if kind == "corners":
            weights = np.eye(3)[random.integers(0, 3, 200)]
        on = np.einsum("nk,nkj->nj", weights, vertices[triangles[random.integers(0, len(triangles), 200)]])
        points = on + random.choice([0, 1e-15, 1e-9, 1e-4], (200, 1)) * random.normal(size=(200, 3))
    return points


KINDS = ["anywhere", "plane", "line", "lattice", "faces", "edges", "corners"]


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 10**6), st.sampled_from(["whole", "split", "open", "tube"]), st.sampled_from(KINDS))
def test_it_is_the_sum_of_solid_angles(seed: int, mesh: str, points: str) -> None:
    vertices, triangles = placed(seed, mesh)
    at = where(np.random.default_rng(seed), points, vertices, triangles)
    found = winding.winding_numbers(vertices, triangles, at)
    assert np.array_equal(found, winding._summed(vertices[triangles], at))
    fan = winding._closed(vertices, triangles)[1]
    assert len(fan) == 3 if mesh == "open" else (len(fan) > 0) == (mesh == "tube")


def grid(divisions: int) -> tuple[np.ndarray, np.ndarray]:
    """The ball from 0 to 2 pi and from 0 to pi: its seam, and its poles, meet in all but the last bit."""
    n, m = 2 * divisions + 1, divisions + 1
    u, v = np.meshgrid(np.linspace(0, 2 * np.pi, n), np.linspace(0, np.pi, m), indexing="ij")
    vertices = np.stack([np.sin(v) * np.cos(u), np.sin(v) * np.sin(u), np.cos(v)], axis=-1).reshape(-1, 3)
    at = np.arange(n * m).reshape(n, m)
    a, b, c, d = at[:-1, :-1], at[1:, :-1], at[1:, 1:], at[:-1, 1:]
    faces = np.concatenate([np.stack([a, d, c], -1).reshape(-1, 3), np.stack([a, c, b], -1).reshape(-1, 3)])
    return vertices, faces


def test_few_points_are_asked(monkeypatch: pytest.MonkeyPatch) -> None:
    """Though a mesh is cut by their plane; whether corners are shared, or nearly, or not; with holes."""
    asked, summed = [], winding._summed
    monkeypatch.setattr(winding, "_summed", lambda corners, at: asked.append(len(at)) or summed(corners, at))
    vertices, triangles = ball(40)
    y, x = np.mgrid[-1.3:1.3:90j, -1.3:1.3:120j]
    at = np.stack([x.ravel(), y.ravel(), np.zeros(x.size)], axis=1)
    split = vertices[triangles].reshape(-1, 3), np.arange(triangles.size).reshape(-1, 3)
    holes = vertices, np.delete(triangles, np.arange(7, len(triangles), 500), axis=0)
    for mesh, rim in (((vertices, triangles), 0), (split, 0), (grid(40), 0), (holes, 39)):
        asked.clear()
        inside = winding.winding_numbers(*mesh, at)
        assert len(winding._closed(*mesh)[1]) == rim
        assert sum(asked) < 20 and inside.mean() == pytest.approx(np.pi / 2.6**2, abs=0.01)


def test_it_takes_time_in_proportion_to_neither_product() -> None:
    """Four times as many points, or triangles, take at most six times as long."""

    def took(divisions: int, rows: int) -> float:
        vertices, triangles = ball(divisions)
        y, x = np.mgrid[-1.3 : 1.3 : rows * 1j, -1.3 : 1.3 : rows * 1j]
        at = np.stack([x.ravel(), y.ravel(), np.full(x.size, 0.1)], axis=1)
        times = []
        for _ in range(3):
            start = time.process_time()
            winding.winding_numbers(vertices, triangles, at)
            times.append(time.process_time() - start)
        return min(times)

    base = took(100, 100)
    assert took(200, 100) < 6 * base + 0.05 and took(100, 200) < 6 * base + 0.05
    assert base < 2  # 400 million pairs would take 40 s
