"""Meshes of quadrics without an end: in the quadric's principal axes each is turned about one or is a graph.

With x along principal axes, scaled and shifted, a quadric that is no ellipsoid reads x1^2 + x2^2 - x3^2 = r
(turned about x3), x1^2 + x2^2 = r or = w (turned about w), or else gives one coordinate as a function of the
other two. Steps grow with the distance, out to `reach`.
"""

from __future__ import annotations

import numpy as np

from .forms import Array
from .meshing import Triangles, spanning, turned

STEPS = 200  # even ones, across three times the scene's size
GROWING = 130  # each way
AROUND = 1024
FAR = 1e6  # times the scene's size
FINEST = 1e-8  # of FAR: the first of the growing steps


def surface(q: Array, middle: Array, size: float) -> Triangles | None:
    """p' q p = 0 for a scene of `size` about `middle` (3,); None for one that has no area.

    Windings are of no meaning.
    """
    values, axes = np.linalg.eigh(q[:3, :3])
    bent = np.abs(values) > 1e-9 * np.abs(q).max()
    axes = np.concatenate([axes[:, bent], axes[:, ~bent]], axis=1)
    values, rank = values[bent], int(bent.sum())
    linear = axes.T @ q[:3, 3]
    center = axes.T @ middle
    center[:rank] = -linear[:rank] / values
    rest = q[3, 3] - np.sum(linear[:rank] ** 2 / values)
    slope = float(np.linalg.norm(linear[rank:]))
    if slope > 1e-12 * np.abs(q).max():  # the last axis is along what is left of the linear part
        left = axes[:, rank:] @ (linear[rank:] / slope)
        others = np.linalg.svd(np.column_stack([axes[:, :rank], left]))[0][:, rank + 1 :]
        axes = np.column_stack([axes[:, :rank], others, left])
        center = np.concatenate([center[:rank], others.T @ middle, [0.0]])
    else:
        slope = 0.0
    if rank and np.count_nonzero(values > 0) < rank / 2:
        values, rest, slope = -values, -rest, -slope  # most squares are positive
    order = np.argsort(-values, kind="stable")
    axes[:, :rank], center[:rank], values = axes[:, order], center[order], values[order]
    scale = np.ones(3)
    scale[:rank] = 1 / np.sqrt(np.abs(values))
    steps = [
        _steps(at, width) for at, width in zip((axes.T @ middle - center) / scale, size / scale, strict=True)
    ]
    found = _unit(np.sign(values), rest, slope, steps)
    if found is None:
        return None
    vertices = (found[0] * scale + center) @ axes.T
    gradient = vertices @ q[:3, :3] + q[:3, 3]
    length = np.linalg.norm(gradient, axis=1, keepdims=True)
    normals = np.where(length > 0, gradient / np.where(length > 0, length, 1.0), (0.0, 0.0, 1.0))
    return Triangles(vertices, spanning(vertices, found[1]), normals)


def _unit(signs: Array, rest: float, slope: float, steps: list[Array]) -> tuple[Array, Array] | None:
    """sum of signs x^2 + 2 slope w + rest = 0, w the last axis: vertices and faces."""
    kind = tuple(int(sign) for sign in signs)
    if kind == (1, 1, -1):
        if rest < 0:  # one sheet
            return turned(AROUND, np.sqrt(steps[2] ** 2 - rest), steps[2])
        out = steps[0][steps[0] >= 0]
        heights = np.sqrt(out**2 + rest)
        return _joined([turned(AROUND, out, heights), turned(AROUND, out, -heights)])
    if kind == (1, 1):
        if slope:
            out = steps[0][steps[0] >= 0]
            return turned(AROUND, out, -(out**2 + rest) / (2 * slope))
        return turned(AROUND, np.full(len(steps[2]), np.sqrt(-rest)), steps[2]) if rest < 0 else None
    if kind == (1, -1):
        if slope:
            return _graph(lambda u, v: (u, v, -(u * u - v * v + rest) / (2 * slope)), steps[0], steps[1])
        if rest > 0:
            halves = [
                _graph(lambda u, w, s=s: (u, s * np.sqrt(u * u + rest), w), steps[0], steps[2])
                for s in (1, -1)
            ]
        else:
            halves = [
                _graph(lambda v, w, s=s: (s * np.sqrt(v * v - rest), v, w), steps[1], steps[2])
                for s in (1, -1)
            ]
        return _joined(halves)
    if kind == (1,):
        if slope:
            return _graph(lambda u, v: (u, v, -(u * u + rest) / (2 * slope)), steps[0], steps[1])
        if rest >= 0:
            return None
        sides = (np.sqrt(-rest), -np.sqrt(-rest))
        return _joined([_graph(lambda u, v, s=s: (s + 0 * u, u, v), steps[1], steps[2]) for s in sides])
    return _graph(lambda u, v: (u, v, 0 * u - rest / (2 * slope)), steps[0], steps[1])


def _steps(middle: float, size: float) -> Array:
    """Where a grid has its lines: evenly about the scene, ever more apart from 0 (which is one) outwards."""
    k = -np.log(FINEST)
    growing = FAR * size * np.sinh(k * np.linspace(0.0, 1.0, GROWING + 1)) / np.sinh(k)
    even = middle + 1.5 * size * np.linspace(-1.0, 1.0, STEPS + 1)
    return np.unique(np.concatenate([-growing, growing, even]))


def _graph(place: object, u: Array, v: Array) -> tuple[Array, Array]:
    assert callable(place)
    columns = np.broadcast_arrays(*place(u[:, None], v[None, :]))
    corner = (np.arange(len(u) - 1)[:, None] * len(v) + np.arange(len(v) - 1)).ravel()
    right, up = corner + 1, corner + len(v)
    faces = np.concatenate([np.stack([corner, right, up + 1], -1), np.stack([corner, up + 1, up], -1)])
    return np.stack(columns, -1).reshape(-1, 3), faces


def _joined(pieces: list[tuple[Array, Array]]) -> tuple[Array, Array]:
    starts = np.cumsum([0, *(len(vertices) for vertices, _ in pieces[:-1])])
    faces = [faces + start for (_, faces), start in zip(pieces, starts, strict=True)]
    return np.concatenate([vertices for vertices, _ in pieces]), np.concatenate(faces)
