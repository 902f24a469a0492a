"""A shape's transform as a matrix, step by step, by Gohlke's `transformations` as trimesh has them."""

from __future__ import annotations

from functools import reduce
from importlib import import_module
from typing import Any

import numpy as np

AXES = {"x": (1, 0, 0), "y": (0, 1, 0), "z": (0, 0, 1)}


def matrix(transform: Any) -> np.ndarray:
    """(4, 4) of a matrix, a list of steps of which the first acts first, or None."""
    if transform is None or not len(transform):
        return np.eye(4)
    if not isinstance(transform[0], dict):
        return np.array(transform, float)
    steps = [_step(*next(iter(step.items()))) for step in transform]
    return np.asarray(reduce(np.matmul, reversed(steps)))


def _step(kind: str, value: Any) -> np.ndarray:
    transformations = import_module("trimesh.transformations")
    if kind == "translate":
        return np.asarray(transformations.translation_matrix(value))
    if kind == "scale":
        return np.diag([*np.broadcast_to(np.asarray(value, float), (3,)), 1.0])
    axis, degrees = value
    direction = AXES[axis] if isinstance(axis, str) else axis
    return np.asarray(transformations.rotation_matrix(np.deg2rad(degrees), direction))
