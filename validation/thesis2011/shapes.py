"""The shapes of the thesis program in float64: where rays meet them, and their outward normals."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

import numpy as np

from clrt.scene.scene import Ellipsoid, Mesh, Plane, Polygon, Quadric, Shape, Sphere


def unit(vectors: np.ndarray) -> np.ndarray:
    """Vectors (n, 3) at length 1."""
    return vectors / np.linalg.norm(vectors, axis=-1, keepdims=True)


class Form(Protocol):
    """One or more primitives of a kind."""

    count: int

    def nearest(self, o: np.ndarray, d: np.ndarray, low: float) -> tuple[np.ndarray, np.ndarray]:
        """Parameters above `low` of the first hits along d from o (inf: none), and which primitive, (n,)."""
        ...

    def normals(self, point: np.ndarray, which: np.ndarray) -> np.ndarray:
        """Outward unit normals (n, 3) at points of primitives."""
        ...


class Spheres:
    """All spheres of a scene."""

    def __init__(self, shapes: Sequence[Sphere]) -> None:
        self.center = np.array([s.center for s in shapes], float)
        self.radius = np.array([s.radius for s in shapes], float)
        self.count = len(shapes)

    def nearest(self, o: np.ndarray, d: np.ndarray, low: float) -> tuple[np.ndarray, np.ndarray]:
        a = (d * d).sum(axis=1)[:, None]
        b = (d * o).sum(axis=1)[:, None] - d @ self.center.T
        c = (o * o).sum(axis=1)[:, None] - 2 * o @ self.center.T
        c += (self.center**2).sum(axis=1) - self.radius**2
        square = b * b - a * c
        root = np.sqrt(np.where(square >= 0, square, np.nan))
        near, far = (-b - root) / a, (-b + root) / a
        t = np.where(near > low, near, np.where(far > low, far, np.inf))
        which = t.argmin(axis=1)
        return t[np.arange(len(o)), which], which

    def normals(self, point: np.ndarray, which: np.ndarray) -> np.ndarray:
        return unit(point - self.center[which])


class Flat:
    """A plane, or polygons in planes: a crossing number without the largest axis of the normal."""

    def __init__(
        self, normals: np.ndarray, points: Sequence[np.ndarray], bounded: bool, at_once: bool
    ) -> None:
        self.normal = unit(np.asarray(normals, float))
        self.points = points
        self.bounded = bounded
        self.at_once = at_once
        self.count = 1

    def nearest(self, o: np.ndarray, d: np.ndarray, low: float) -> tuple[np.ndarray, np.ndarray]:
        t = np.full(len(o), np.inf)
        for normal, points in zip(self.normal, self.points, strict=True):
            height, slope = (points[0] - o) @ normal, d @ normal
            found = np.divide(height, slope, out=np.full(len(o), np.inf), where=slope != 0)
            if self.at_once:
                found = np.where((slope == 0) & (height == 0), low, found)
            counts = found >= low if self.at_once else found > low
            if self.bounded:
                where = o + np.where(counts & np.isfinite(found), found, 0.0)[:, None] * d
                counts &= _within(np.delete(where, np.abs(normal).argmax(), 1), points, normal)
            t = np.where(counts & (found < t), found, t)
        return t, np.zeros(len(o), int)

    def normals(self, point: np.ndarray, which: np.ndarray) -> np.ndarray:
        if len(self.normal) == 1:
            return np.broadcast_to(self.normal[0], point.shape)
        away = np.stack([np.abs((point - p[0]) @ n) for n, p in zip(self.normal, self.points, strict=True)])
        return self.normal[away.argmin(axis=0)]


def _within(flat: np.ndarray, points: np.ndarray, normal: np.ndarray) -> np.ndarray:
    """Whether points (n, 2) lie in the polygon seen along the same axis: an odd number of edges crossed."""
    corner = np.delete(points, np.abs(normal).argmax(), 1)
    inside = np.zeros(len(flat), bool)
    for (x0, y0), (x1, y1) in zip(corner, np.roll(corner, -1, axis=0), strict=True):
        spans = (y0 > flat[:, 1]) != (y1 > flat[:, 1])
        if y0 != y1:
            inside ^= spans & (flat[:, 0] < x0 + (flat[:, 1] - y0) * (x1 - x0) / (y1 - y0))
    return inside


class Second:
    """A quadric x.Qx + 2 g.x + j = 0."""

    def __init__(self, q: np.ndarray, g: np.ndarray, j: float, strict: bool) -> None:
        self.q, self.g, self.j = q, g, j
        self.strict = strict
        self.count = 1

    def nearest(self, o: np.ndarray, d: np.ndarray, low: float) -> tuple[np.ndarray, np.ndarray]:
        a = ((d @ self.q) * d).sum(axis=1)
        b = ((o @ self.q) * d).sum(axis=1) + d @ self.g
        c = ((o @ self.q) * o).sum(axis=1) + 2 * o @ self.g + self.j
        square = b * b - a * c
        with np.errstate(divide="ignore", invalid="ignore"):
            root = np.sqrt(square)
            q = -(b + np.where(b >= 0, root, -root))
            roots = np.sort(np.stack([q / a, c / q]), axis=0)
        roots = np.where(np.isfinite(roots) & (roots > low), roots, np.inf)
        t = roots.min(axis=0)
        if self.strict:
            t = np.where(a == 0, np.inf, t)
        return t, np.zeros(len(o), int)

    def normals(self, point: np.ndarray, which: np.ndarray) -> np.ndarray:
        return unit(point @ self.q + self.g)


def form_of(shape: Shape, strict_quadric: bool, plane_at_once: bool) -> Form:
    """A shape other than a sphere; the flags are the faults that concern it."""
    if isinstance(shape, Plane):
        return Flat(np.array([shape.normal]), [np.array([shape.point], float)], False, plane_at_once)
    if isinstance(shape, Polygon):
        return _polygons([np.array(shape.points, float)], plane_at_once)
    if isinstance(shape, Mesh):
        data = shape.data()
        return _polygons([np.asarray(data.vertices, float)[list(face)] for face in data.faces], plane_at_once)
    if isinstance(shape, Ellipsoid):
        q = np.diag(1 / np.array(shape.radii, float) ** 2)
        center = np.array(shape.center, float)
        return Second(q, -q @ center, center @ q @ center - 1, strict_quadric)
    assert isinstance(shape, Quadric), shape.type
    a, b, c, d, e, f, g, h, i, j = shape.coefficients
    return Second(np.array([[a, d, f], [d, b, e], [f, e, c]]), np.array([g, h, i]), j, strict_quadric)


def _polygons(corners: Sequence[np.ndarray], at_once: bool) -> Flat:
    normals = [np.cross(p[1] - p[0], p[2] - p[1]) for p in corners]
    return Flat(np.array(normals), corners, True, at_once)
