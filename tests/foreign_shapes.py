"""The shapes of the models that tests/foreign_models.py and tests/foreign_gltf.py write."""

from __future__ import annotations

from pathlib import Path
from typing import Final

import numpy as np

SCENES: Final = Path(__file__).parents[1] / "scenes"


def knot(bumps: int = 96, around: int = 24) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """A trefoil: vertices (n, 3), quads (m, 4), linear-to-the-eye colours (n, 3) uint8 along it."""
    t = np.linspace(0, 2 * np.pi, bumps, endpoint=False)
    path = np.stack([np.sin(t) + 2 * np.sin(2 * t), np.cos(t) - 2 * np.cos(2 * t), -np.sin(3 * t)], axis=1)
    ahead = np.roll(path, -1, axis=0) - np.roll(path, 1, axis=0)
    ahead /= np.linalg.norm(ahead, axis=1, keepdims=True)
    side = np.cross(ahead, [0.0, 0.0, 1.0])
    side /= np.linalg.norm(side, axis=1, keepdims=True)
    up = np.cross(side, ahead)
    s = np.linspace(0, 2 * np.pi, around, endpoint=False)
    ring = np.cos(s)[None, :, None] * side[:, None] + np.sin(s)[None, :, None] * up[:, None]
    vertices = (path[:, None] + 0.55 * ring).reshape(-1, 3)
    i, j = np.meshgrid(np.arange(bumps), np.arange(around), indexing="ij")
    corners = [(i, j), (i, j + 1), (i + 1, j + 1), (i + 1, j)]
    quads = np.stack([(a % bumps) * around + b % around for a, b in corners], axis=-1).reshape(-1, 4)
    phase = np.repeat(t, around)[:, None] + np.array([0.0, 2.1, 4.2])
    return vertices, quads, np.round(127.5 + 120 * np.cos(phase)).astype(np.uint8)


def ball(rows: int = 24, columns: int = 48) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """A sphere with a seam: vertices, uv with v = 0 at the bottom, triangles."""
    u, v = np.meshgrid(np.linspace(0, 1, columns + 1), np.linspace(0, 1, rows + 1))
    theta, phi = np.pi * (1 - v.ravel()), 2 * np.pi * u.ravel()
    vertices = np.stack([np.sin(theta) * np.cos(phi), np.cos(theta), -np.sin(theta) * np.sin(phi)], axis=1)
    i, j = np.meshgrid(np.arange(rows), np.arange(columns), indexing="ij")
    a = (i * (columns + 1) + j).ravel()
    triangles = np.concatenate(
        [np.stack([a, a + 1, a + columns + 2], 1), np.stack([a, a + columns + 2, a + columns + 1], 1)]
    )
    area = np.linalg.norm(
        np.cross(
            vertices[triangles[:, 1]] - vertices[triangles[:, 0]],
            vertices[triangles[:, 2]] - vertices[triangles[:, 0]],
        ),
        axis=1,
    )
    return vertices, np.stack([u.ravel(), v.ravel()], axis=1), triangles[area > 1e-12]
