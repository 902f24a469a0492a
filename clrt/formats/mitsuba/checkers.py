"""Mitsuba's checkerboards as checkers of a scene file: point by point is compared which colour lies where."""

from __future__ import annotations

import math
from typing import Any, Final

import numpy as np

from clrt.formats.mitsuba.values import Array, Plugin

Table = dict[str, Any]
_CORNERS: Final = np.array([[-1.0, -1, 0, 1], [1, -1, 0, 1], [1, 1, 0, 1]])
_MOST: Final = 1 << 16  # divisions
_POINTS: Final = 512
_TELLING: Final = 0.98  # share of the points; those at the edges of a square may be on either side


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
    theirs = np.floor(2 * (uv @ to_uv[:2, :2].T + to_uv[:2, 3])).sum(axis=1) % 2 == 1
    alike = float((theirs == ours).mean())
    if alike <= 1 - _TELLING:
        found["colors"] = checker["colors"][::-1]
    return found, "" if max(alike, 1 - alike) >= _TELLING else "the place of a checkerboard"


def _spread() -> Array:
    """Points of the unit square, (n, 2), on no line of any grid."""
    number = np.arange(1, _POINTS + 1)
    return np.stack([number * math.sqrt(2) % 1, number * math.sqrt(3) % 1], axis=1)


def _on_rectangle(matrix: Array, size: float) -> tuple[Array, Array]:
    """u and v there of points of it, and where the second colour lies here (docs/model.md, "Patterns")."""
    uv = _spread()
    corners = (_CORNERS @ matrix.T)[:, :3]
    points = corners[0] + uv @ (corners[1] - corners[0], corners[2] - corners[1])
    normal = np.cross(corners[1] - corners[0], corners[2] - corners[1])
    normal /= np.linalg.norm(normal) or 1.0
    axis = np.eye(3)[int(np.abs(normal).argmin())]
    first = axis - (axis @ normal) * normal
    first /= np.linalg.norm(first)
    places = (points - corners[0]) @ np.stack([first, np.cross(normal, first)], axis=1)
    return uv, np.floor(places / size).sum(axis=1) % 2 == 1


def _on_sphere(matrix: Array, divisions: int) -> tuple[Array, Array]:
    """The same of a sphere, whose poles are on z there and on y here."""
    across, along = _spread().T
    z, angle = 2 * across - 1, 2 * math.pi * along
    level = np.sqrt(1 - z * z)
    local = np.stack([level * np.cos(angle), level * np.sin(angle), z], axis=1)
    x, y, z = (local @ matrix[:3, :3].T / max(np.linalg.norm(matrix[:3, 0]), 1e-300)).T
    uv = np.stack([angle / (2 * math.pi), np.arccos(local[:, 2]) / math.pi], axis=1)
    ours = np.floor((0.5 + np.arctan2(x, -z) / (2 * math.pi)) * divisions)
    return uv, (ours + np.floor(np.arccos(np.clip(y, -1, 1)) / math.pi * divisions / 2)) % 2 == 1
