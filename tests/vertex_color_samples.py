"""Three triangles with a colour at each corner: as a PLY file, and what is seen of them."""

from __future__ import annotations

from pathlib import Path

import numpy as np

import clrt
from clrt.images.file import decode

CORNERS = [(0, 0, 255, 0, 0), (3, 0, 0, 255, 0), (3, 2, 0, 0, 255), (0, 2, 255, 255, 255), (0, 4, 9, 80, 200)]
FACES = [(0, 1, 2), (0, 2, 3), (3, 2, 4)]
VIEW = {
    "camera": {"type": "orthographic", "origin": [1.5, 2, 5], "target": [1.5, 2, 0], "size": 4.2, "width": 21,
               "height": 21},
    "ambient": 1.0,
}  # fmt: skip


def write_ply(path: Path, faces: bool = False) -> Path:
    """Three triangles in the plane z = 0, with a colour at each corner, or on each face."""
    color = "property uchar red\nproperty uchar green\nproperty uchar blue\n"
    head = f"ply\nformat ascii 1.0\nelement vertex {len(CORNERS)}\n" + "".join(
        f"property float {axis}\n" for axis in "xyz"
    )
    head += "" if faces else color
    head += f"element face {len(FACES)}\nproperty list uchar int vertex_indices\n" + (color if faces else "")
    rows = [f"{x} {y} 0" + ("" if faces else f" {r} {g} {b}") for x, y, r, g, b in CORNERS]
    rows += [f"3 {a} {b} {c}" + (" {} {} {}".format(*CORNERS[a][2:]) if faces else "") for a, b, c in FACES]
    path.write_text(f"{head}end_header\n" + "\n".join(rows) + "\n")
    return path


def expected(x: np.ndarray, y: np.ndarray, flat: bool = False) -> np.ndarray:
    """The linear colours at points of the plane; NaN beside the triangles."""
    places = np.array([corner[:2] for corner in CORNERS], float)
    colors = decode(np.array([corner[2:] for corner in CORNERS], np.uint8)).astype(float)
    out = np.full((*x.shape, 3), np.nan)
    for face in FACES:
        a, b, c = places[list(face)]
        sides, way = np.stack([b - a, c - a], axis=1), np.stack([x - a[0], y - a[1]])
        inner = np.linalg.solve(sides, way.reshape(2, -1))
        u, v = inner.reshape(2, *x.shape)
        own = colors[list(face)]
        shown = own[:1] if flat else np.stack([1 - u - v, u, v], axis=-1) @ own
        inside = (u > 1e-6) & (v > 1e-6) & (u + v < 1 - 1e-6)
        out[inside] = np.broadcast_to(shown, out.shape)[inside]
    return out


def seen(scene: clrt.Scene) -> tuple[np.ndarray, np.ndarray]:
    """The colours of the surface in every pixel, and what they are by the corners."""
    view = clrt.load_dict({**VIEW, "shapes": []})
    scene = scene.replace({"camera": view.camera, "lights": [], "ambient": 1.0})
    image = clrt.render(scene, layers=("albedo", "position"))
    return np.asarray(image.layers["albedo"]), np.asarray(image.layers["position"])
