"""Spheres and quadrics."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .batch import Batch
from .vectors import Array, Ints, across, apply, apply_transposed, dot, unit

SLACK = 1e-12  # a clip box is closed: a root on its face must not fall out by rounding; relative to the box


@dataclass(frozen=True)
class Spheres(Batch):
    """|p - center| = radius; outward is away from the centre."""

    center: Array
    radius: Array

    def roots(self, which: Ints, origin: Array, direction: Array) -> Array:
        """Half-b quadratic about the point nearest to the centre (Haines et al., Ray Tracing Gems, ch. 7)."""
        away = origin - self.center[which]
        b = -dot(away, direction)
        nearest = away + b[:, None] * direction
        discriminant = self.radius[which] ** 2 - dot(nearest, nearest)
        q = b + np.copysign(np.sqrt(discriminant), b)
        length = np.sqrt(dot(away, away))
        c = (length - self.radius[which]) * (length + self.radius[which])
        return np.stack([c / q, q], axis=1)

    def outward(self, which: Ints, point: Array, direction: Array) -> Array:
        return unit(point - self.center[which])

    def project(self, which: Ints, point: Array) -> Array:
        return np.asarray(self.center[which] + self.radius[which, None] * self.outward(which, point, point))


@dataclass(frozen=True)
class Quadrics(Batch):
    """F(x) = x.Qx + 2 g.x + J = 0 and clip_low <= x <= clip_high in a frame of each primitive's own.

    `x = inverse (p - position)` for a point p of the world, so any affine transform will do and t
    stays the distance in the world. Outward is where F grows; where it has no gradient (a cone's apex), -u.
    """

    inverse: Array  # (n, 3, 3)
    position: Array
    form: Array  # Q, symmetric (n, 3, 3)
    gradient: Array  # g
    constant: Array  # J
    clip_low: Array
    clip_high: Array

    def roots(self, which: Ints, origin: Array, direction: Array) -> Array:
        """Stable roots about the point of the ray nearest to the frame's origin."""
        start = apply(self.inverse[which], origin - self.position[which])
        along = apply(self.inverse[which], direction)
        shift = -dot(start, along) / dot(along, along)
        near = start + shift[:, None] * along
        q, g = self.form[which], self.gradient[which]
        slope = apply(q, near) + g
        a = dot(along, apply(q, along))
        b = dot(along, slope)
        c = dot(near, slope + g) + self.constant[which]
        k = -(b + np.copysign(np.sqrt(b * b - a * c), b))
        # a = 0 leaves one root: k/a is then infinite, or NaN where k is 0 too
        roots = np.stack([c / k, k / a], axis=1)
        x = near[:, None] + roots[..., None] * along[:, None]
        low, high = self.clip_low[which], self.clip_high[which]
        clips = np.stack([self.clip_low, self.clip_high])
        largest = np.max(np.abs(np.where(np.isfinite(clips), clips, 0.0)), axis=(0, 2))
        slack = SLACK * largest[which, None, None]
        inside = across(np.logical_and, (x >= low[:, None] - slack) & (x <= high[:, None] + slack))
        return np.where(inside, roots + shift[:, None], np.nan)

    def _local(self, which: Ints, point: Array) -> tuple[Array, Array, Array]:
        """Local coordinates, half the gradient of F there, and what its rounding scales with."""
        position, inverse, form, gradient = (
            field[which] for field in (self.position, self.inverse, self.form, self.gradient)
        )
        x = apply(inverse, point - position)
        size = apply(np.abs(inverse), np.abs(point) + np.abs(position))
        terms = apply(np.abs(form), size) + np.abs(gradient)
        return x, apply(form, x) + gradient, across(np.maximum, terms)

    def outward(self, which: Ints, point: Array, direction: Array) -> Array:
        _, half, terms = self._local(which, point)
        normal = unit(apply_transposed(self.inverse[which], half))
        # below the rounding of its terms: no gradient
        flat = across(np.maximum, np.abs(half)) <= 1e-12 * terms
        return np.where(flat[:, None], -direction, normal)

    def project(self, which: Ints, point: Array) -> Array:
        """Two Newton steps along the gradient; a point without gradient stays."""
        for _ in range(2):
            x, half, terms = self._local(which, point)
            value = dot(x, half + self.gradient[which]) + self.constant[which]
            steep = across(np.maximum, np.abs(half)) > 1e-12 * terms
            step = np.where(steep, value / np.where(steep, 2 * dot(half, half), 1.0), 0.0)
            moved = x - step[:, None] * half
            point = point + np.linalg.solve(self.inverse[which], (moved - x)[..., None])[..., 0]
        return point
