"""Mitsuba's checkerboards as checkers of a scene file: point by point is compared which colour lies where."""

from __future__ import annotations

import math
from typing import Any, Final

import numpy as np

from clrt.base.records import cross
from clrt.formats.mitsuba.values import Array, Plugin

Table = dict[str, Any]
_MOST: Final = 1 << 16  # divisions
_POINTS: Final = 512
_TELLING: Final = 0.98  # share of the points; those at the edges of a square may be on either side
_SPREAD: Final = np.arange(1, _POINTS + 1)[:, None] * (math.sqrt(2), math.sqrt(3)) % 1
"""Points of the unit square, on no line of any grid."""
_LEVEL: Final = 2 * np.sqrt(_SPREAD[:, 0] * (1 - _SPREAD[:, 0]))
_ROUND: Final = np.stack([
    _LEVEL * np.cos(2 * math.pi * _SPREAD[:, 1]), _LEVEL * np.sin(2 * math.pi * _SPREAD[:, 1]),
    2 * _SPREAD[:, 0] - 1,
])  # fmt: skip
"""The same on a sphere (3, n), and u and v there."""
_AROUND: Final = np.stack([_SPREAD[:, 1], np.arccos(_ROUND[2]) / math.pi], axis=1)


def checker_of(checker: Table, plugin: Plugin) -> tuple[Table, str]:
    """The checker that a shape shows there, and what of it is lost; "" where both have the same squares.

    checker: `colors` and `to_uv`, as `Materials.texture` has it; plugin: a rectangle or a sphere.
    """
    to_uv, matrix = checker["to_uv"], plugin.to_world()
    found: Table = {"type": "checker", "colors": checker["colors"]}
    if plugin.type == "rectangle":
        sides = np.linalg.norm(matrix[:3, :2], axis=0)
        across, up = sides / np.maximum(np.linalg.norm(to_uv[:2, :2], axis=1), 1e-9)
        found["size"] = float(max(across, 1e-9))
        if abs(across - up) > 1e-6 * across:
            return found, "the stretch of a checkerboard"
        uv, ours = _on_rectangle(matrix, found["size"])
    else:
        found["divisions"] = int(min(max(round(2 * float(np.linalg.norm(to_uv[0, :2]))), 1), _MOST))
        uv, ours = _on_sphere(matrix, found["divisions"])
    theirs = np.floor(2 * (uv @ to_uv[:2, :2].T + to_uv[:2, 3]))
    alike = np.count_nonzero((theirs + ours).sum(axis=1) % 2 == 0) / _POINTS
    if alike <= 1 - _TELLING:
        found["colors"] = checker["colors"][::-1]
    return found, "" if max(alike, 1 - alike) >= _TELLING else "the place of a checkerboard"


def _on_rectangle(matrix: Array, size: float) -> tuple[Array, Array]:
    """u and v there of points of it, and the square here that each lies in (docs/model.md, "Patterns").

    There may be many rectangles: for three numbers numpy takes longer than Python.
    """
    sides = (2 * matrix[:3, :2].T).tolist()
    normal = cross(*sides)
    length = math.hypot(*normal) or 1.0
    normal = normal[0] / length, normal[1] / length, normal[2] / length
    least = min(range(3), key=lambda axis: abs(normal[axis]))
    first = [(axis == least) - normal[least] * part for axis, part in enumerate(normal)]
    length = math.hypot(*first)
    axes = np.array([first, cross(normal, first)]) / (length * size)
    return _SPREAD, np.floor(_SPREAD @ (np.array(sides) @ axes.T))


def _on_sphere(matrix: Array, divisions: int) -> tuple[Array, Array]:
    """The same of a sphere, whose poles are on z there and on y here."""
    x, y, z = matrix[:3, :3] @ _ROUND / max(np.linalg.norm(matrix[:3, 0]), 1e-300)
    around, down = 0.5 + np.arctan2(x, -z) / (2 * math.pi), np.arccos(np.clip(y, -1, 1)) / math.pi
    return _AROUND, np.floor(np.stack([around * divisions, down * divisions / 2], axis=1))
