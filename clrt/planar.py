"""Checks of plane polygons, for the polygon shape and for the n-gons of flat meshes."""

from __future__ import annotations

import numpy as np

FLATNESS = 1e-4
"""How far a polygon's points may lie off its plane, relative to its size (MODEL.md)."""


def newell(corners: np.ndarray) -> np.ndarray:
    """Newell's normals of (..., n, 3) polygons: twice the area long, to where they run counter-clockwise."""
    local = corners - corners[..., :1, :]  # differences first, so that far polygons lose nothing
    return np.cross(local, np.roll(local, -1, axis=-2)).sum(axis=-2)


def flaws(corners: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Which of (m, n, 3) polygons span no area (collinear points), and which are not plane."""
    normals = newell(corners)
    area = np.linalg.norm(normals, axis=-1)
    size = np.linalg.norm(np.ptp(corners, axis=-2), axis=-1)
    flat = area > 1e-7 * size**2
    units = normals / np.where(area > 0, area, 1.0)[:, None]
    off = np.einsum("mnk,mk->mn", corners - corners.mean(axis=-2, keepdims=True), units)
    return ~flat, flat & (np.abs(off).max(axis=-1) > FLATNESS * size)
