"""Write shell.ply: a sea shell, a tube that winds and grows, with normals and colours (sRGB) at its vertices.

    python scenes/generate_shell.py [FOLDER]
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

TURNS, ALONG, AROUND = 6.0, 340, 22
GROWTH = 0.095  # of the logarithm of the radius, a radian
CREAM, ROSE, BROWN = (246, 232, 208), (214, 128, 104), (92, 36, 18)


def shell() -> tuple[Array, Array, NDArray[np.int32], NDArray[np.uint8]]:
    """Vertices and unit normals (n, 3), triangles (m, 3), counter-clockwise from outside, colours (n, 3)."""
    t = np.linspace(0.0, 2 * np.pi * TURNS, ALONG)[:, None]
    s = np.linspace(0.0, 2 * np.pi, AROUND, endpoint=False)[None, :]
    size = np.exp(GROWTH * (t - 2 * np.pi * TURNS))
    ribs = 1.0 + 0.03 * np.cos(8 * t)
    out = size * (1.0 + 0.60 * ribs * np.cos(s))
    up = size * (-2.1 + 0.62 * ribs * np.sin(s))
    vertices = np.stack([out * np.cos(t), up + 0.0 * t, out * np.sin(t)], axis=2)
    along = np.gradient(vertices, axis=0)
    around = np.roll(vertices, -1, axis=1) - np.roll(vertices, 1, axis=1)
    normals = np.cross(around, along)
    normals /= np.linalg.norm(normals, axis=2, keepdims=True)
    i, j = np.meshgrid(np.arange(ALONG - 1), np.arange(AROUND), indexing="ij")
    a, b = i * AROUND + j, i * AROUND + (j + 1) % AROUND
    low = np.stack([a, b, b + AROUND], axis=2).reshape(-1, 3)
    high = np.stack([a, b + AROUND, a + AROUND], axis=2).reshape(-1, 3)
    triangles = np.concatenate([low, high]).astype(np.int32)
    return vertices.reshape(-1, 3), normals.reshape(-1, 3), triangles, colors(t, s)


def colors(t: Array, s: Array) -> NDArray[np.uint8]:
    """Cream, with rose bands that wind along and brown flames that cross them."""
    bands = (0.5 + 0.5 * np.cos(3 * s + 0.4)) ** 2 + 0.0 * t
    across = np.cos(7 * t + 1.6 * np.sin(2 * s))
    flames = np.clip(3.0 * across - 1.2, 0.0, 1.0) * np.clip(0.9 + 0.6 * np.sin(s - 1.0), 0.0, 1.0)
    base = np.array(CREAM) + bands[..., None] * 0.6 * np.subtract(ROSE, CREAM)
    whole = base + flames[..., None] * (np.array(BROWN) - base)
    return np.round(whole).astype(np.uint8).reshape(-1, 3)


def ply(vertices: Array, normals: Array, triangles: NDArray[np.int32], rgb: NDArray[np.uint8]) -> bytes:
    """A binary PLY file."""
    rows = np.zeros(len(vertices), [("at", "<f4", 3), ("normal", "<f4", 3), ("rgb", "u1", 3)])
    rows["at"], rows["normal"], rows["rgb"] = vertices, normals, rgb
    faces = np.zeros(len(triangles), [("count", "u1"), ("corners", "<i4", 3)])
    faces["count"], faces["corners"] = 3, triangles
    names = [f"float {name}" for name in ("x", "y", "z", "nx", "ny", "nz")]
    names += [f"uchar {name}" for name in ("red", "green", "blue")]
    head = ["ply", "format binary_little_endian 1.0", "comment clrt", f"element vertex {len(rows)}"]
    head += [f"property {name}" for name in names]
    head += [f"element face {len(faces)}", "property list uchar int vertex_indices", "end_header", ""]
    return "\n".join(head).encode() + rows.tobytes() + faces.tobytes()


if __name__ == "__main__":
    folder = Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).parent
    (folder / "shell.ply").write_bytes(ply(*shell()))
