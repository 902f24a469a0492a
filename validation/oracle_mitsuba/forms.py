"""Quadric surfaces as symmetric 4x4 matrices in world space, in float64.

Mitsuba has no cone, paraboloid or general quadric: it gets a mesh, and what it hits there is moved along the
ray to the surface itself.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

Array = np.ndarray


@dataclass(frozen=True, eq=False)
class Form:
    """The surface p' q p = 0 with p = (x, y, z, 1), outside where that is positive.

    Only what `to_object` (4, 4) takes into the closed box from `low` to `high` (3,) belongs to the shape.
    """

    q: Array
    to_object: Array
    low: Array
    high: Array

    def packed(self) -> Array:
        """All numbers in one row (38,): q, to_object, low, high."""
        return np.concatenate([self.q.ravel(), self.to_object.ravel(), self.low, self.high])


def _placed(q: Array, to_world: Array, low: Any = -np.inf, high: Any = np.inf) -> Form:
    """The form of a surface p' q p = 0 in object space."""
    to_object = np.linalg.inv(to_world)
    box = [np.broadcast_to(np.asarray(corner, float), (3,)) for corner in (low, high)]
    return Form(to_object.T @ q @ to_object, to_object, *box)


def plane(point: Any, normal: Any) -> Form:
    """The plane through `point`; `normal` points outwards."""
    n = np.asarray(normal, float) / np.linalg.norm(normal)
    q = np.zeros((4, 4))
    q[3, :3] = q[:3, 3] = n / 2
    q[3, 3] = -n @ np.asarray(point, float)
    return _placed(q, np.eye(4))


def quadric(coefficients: Any, clip: Any, to_world: Array) -> Form:
    """A x^2 + B y^2 + C z^2 + 2D xy + 2E yz + 2F xz + 2G x + 2H y + 2I z + J, kept within `clip`."""
    low, high = (-np.inf, np.inf) if clip is None else clip
    return _placed(matrix(coefficients), to_world, low, high)


def matrix(coefficients: Any) -> Array:
    """The (4, 4) matrix of a quadric's ten coefficients."""
    a, b, c, d, e, f, g, h, i, j = coefficients
    return np.array([[a, d, f, g], [d, b, e, h], [f, e, c, i], [g, h, i, j]], float)


def sphere(to_world: Array, flip: bool = False) -> Form:
    """x^2 + y^2 + z^2 = 1; with `flip` the inside is outside."""
    return _placed(np.diag([1.0, 1.0, 1.0, -1.0]) * (-1.0 if flip else 1.0), to_world)


def cone(r0: float, r1: float, to_world: Array) -> Form:
    """x^2 + y^2 = (r0 + (r1 - r0) z)^2 for 0 <= z <= 1."""
    k = r1 - r0
    q = np.diag([1.0, 1.0, -k * k, -r0 * r0])
    q[2, 3] = q[3, 2] = -r0 * k
    return _placed(q, to_world, (-np.inf, -np.inf, 0.0), (np.inf, np.inf, 1.0))


def paraboloid(to_world: Array) -> Form:
    """x^2 + y^2 = z for 0 <= z <= 1."""
    q = np.diag([1.0, 1.0, 0.0, 0.0])
    q[2, 3] = q[3, 2] = -0.5
    return _placed(q, to_world, (-np.inf, -np.inf, 0.0), (np.inf, np.inf, 1.0))


def ellipsoid_frame(coefficients: Any) -> tuple[Array, bool] | None:
    """Unit sphere to ellipsoid (4, 4), and whether the form is negative outside; None for other quadrics.

    An ellipsoid without points (an imaginary one) has a frame of zeros.
    """
    q = matrix(coefficients)
    block, linear = q[:3, :3], q[:3, 3]
    values, axes = np.linalg.eigh(block)
    if np.abs(values).min() <= 1e-9 * np.abs(values).max() or not (np.all(values > 0) or np.all(values < 0)):
        return None
    center = -np.linalg.solve(block, linear)
    rest = -(q[3, 3] + linear @ center)  # p' block p = rest about the centre
    frame = np.zeros((4, 4))
    if rest * values[0] > 0:
        frame[:3, :3] = axes * np.sqrt(rest / values)
        frame[:3, 3] = center
        frame[3, 3] = 1.0
    return frame, bool(values[0] < 0)
