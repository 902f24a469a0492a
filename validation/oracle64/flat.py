"""Planes, disks, polygons and triangles: the distance to a plane, and a test whether the point is inside."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .batch import Batch
from .vectors import Array, Bools, Ints, across, apply, dot, unit


@dataclass(frozen=True)
class Planes(Batch):
    """(p - point).normal = 0; behind the normal is inside."""

    point: Array
    normal: Array

    def roots(self, which: Ints, origin: Array, direction: Array) -> Array:
        """A ray parallel to the plane, or in it, gets an infinite or NaN distance: a miss."""
        normal = self.normal[which]
        t = dot(self.point[which] - origin, normal) / dot(direction, normal)
        return np.where(self.inside(which, origin, direction, t), t, np.nan)[:, None]

    def inside(self, which: Ints, origin: Array, direction: Array, t: Array) -> Bools:
        """Whether the ray meets the plane within the primitive."""
        return np.ones(len(which), bool)

    def outward(self, which: Ints, point: Array, direction: Array) -> Array:
        return self.normal[which]

    def project(self, which: Ints, point: Array) -> Array:
        normal = self.normal[which]
        return np.asarray(point - dot(point - self.point[which], normal)[:, None] * normal)


@dataclass(frozen=True)
class Disks(Planes):
    """A disk round `point`: `inverse` takes offsets from there to where the disk has radius 1."""

    inverse: Array  # (n, 3, 3)

    def inside(self, which: Ints, origin: Array, direction: Array, t: Array) -> Bools:
        x = apply(self.inverse[which], origin + t[:, None] * direction - self.point[which])
        return np.asarray(dot(x, x) <= 1.0)


@dataclass(frozen=True)
class Polygons(Planes):
    """Polygons of as many corners each; even-odd, so concave ones and holes need no special case."""

    corners: Array  # (n, k, 3)

    def at_edge(self, which: Ints, point: Array, near: Array) -> Bools:
        return _at_edge(self.corners[which], point, near)

    def inside(self, which: Ints, origin: Array, direction: Array, t: Array) -> Bools:
        """The crossing number round the ray itself, in the plane that the corners are sheared to along it.

        There the ray is the point 0. `edge` changes sign exactly when an edge is reversed, so polygons that
        share an edge agree on which side of it the ray passes. An edge itself belongs to both.
        """
        x, y = sheared(origin, direction, self.corners[which])
        x_next, y_next = np.roll(x, -1, axis=1), np.roll(y, -1, axis=1)
        edge = x * y_next - x_next * y
        toggles = ((y >= 0) != (y_next >= 0)) & np.where(y_next > y, edge > 0, edge < 0)
        on = (edge == 0) & (x * x_next + y * y_next <= 0)
        return np.asarray(across(np.logical_xor, toggles) | across(np.logical_or, on))


@dataclass(frozen=True)
class Triangles(Planes):
    """Triangles; `smooth` ones interpolate the unit normals `corner_normals` at their corners."""

    corners: Array  # (n, 3, 3)
    corner_normals: Array  # (n, 3, 3)
    smooth: Bools

    def at_edge(self, which: Ints, point: Array, near: Array) -> Bools:
        return _at_edge(self.corners[which], point, near)

    def inside(self, which: Ints, origin: Array, direction: Array, t: Array) -> Bools:
        """Edge functions in sheared space (Woop, Benthin, Wald 2013); an edge belongs to the triangle."""
        x, y = sheared(origin, direction, self.corners[which])
        x_next, y_next = np.roll(x, -1, axis=1), np.roll(y, -1, axis=1)
        edge = x_next * y - x * y_next
        return np.asarray(across(np.logical_and, edge >= 0) | across(np.logical_and, edge <= 0))

    def shading_normal(self, which: Ints, point: Array, outward: Array) -> Array:
        """The corners' normals weighted by barycentric coordinates."""
        spokes = self.corners[which] - point[:, None]
        spans = np.cross(np.roll(spokes, -1, axis=1), np.roll(spokes, -2, axis=1))
        weights = dot(spans, self.normal[which][:, None])  # twice the area opposite to each corner
        weights /= weights.sum(axis=1)[:, None]
        interpolated = unit(np.einsum("ni,nij->nj", weights, self.corner_normals[which]))
        usable = self.smooth[which] & np.isfinite(interpolated).all(axis=1)
        return np.where(usable[:, None], interpolated, outward)


def _at_edge(corners: Array, point: Array, near: Array) -> Bools:
    """Whether points (m, 3) lie nearer than `near` (m,) to a line through neighbours of corners (m, k, 3)."""
    way, along = point[:, None] - corners, np.roll(corners, -1, axis=1) - corners
    beside = np.cross(way, along)
    return np.asarray((dot(beside, beside) <= near[:, None] ** 2 * dot(along, along)).any(axis=1))


def sheared(origin: Array, direction: Array, corners: Array) -> tuple[Array, Array]:
    """Corners (m, k, 3) relative to rays (m, 3), sheared along them onto two axes: x, y (m, k)."""
    rows = np.arange(len(origin))
    z = np.argmax(np.abs(direction), axis=1)
    x, y = (z + 1) % 3, (z + 2) % 3
    offset = corners - origin[:, None]
    depth = offset[rows, :, z]
    slope_x, slope_y = direction[rows, x] / direction[rows, z], direction[rows, y] / direction[rows, z]
    return offset[rows, :, x] - slope_x[:, None] * depth, offset[rows, :, y] - slope_y[:, None] * depth


def newell_normal(corners: Array) -> Array:
    """Newell's unit normal (..., 3) of polygons (..., k, 3): seen from there they run counter-clockwise."""
    offset = corners - corners[..., :1, :]
    return unit(np.sum(np.cross(offset, np.roll(offset, -1, axis=-2)), axis=-2))
