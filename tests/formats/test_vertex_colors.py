"""Colours of a PLY's vertices and faces: linear between corners, one on a face."""

from __future__ import annotations

import runpy
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import clrt
from clrt.base.limits import Limits
from clrt.base.resources import scene_folder
from clrt.images.file import decode
from validation.oracle64 import render64

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


@pytest.mark.parametrize("faces", [False, True])
def test_colors_of_vertices_and_faces(faces: bool, tmp_path: Path) -> None:
    scene = clrt.load(write_ply(tmp_path / "scan.ply", faces))
    albedo, position = seen(scene)
    right = expected(position[..., 0], position[..., 1], faces)
    known = np.isfinite(right).all(axis=-1)
    assert known.sum() > 100
    # places in a picture of 4 texels are rounded by some 4 x 2^-23; colours change by 1 a texel
    np.testing.assert_allclose(albedo[known], 0.8 * right[known], atol=4e-6)


def test_the_picture_returns_from_a_scene_file(tmp_path: Path) -> None:
    """As `clrt convert scan.ply scan.toml` writes it; the same bits, and those of the float64 oracle."""
    scene = clrt.load(write_ply(tmp_path / "scan.ply"))
    scene.save(tmp_path / "scan.toml")
    again = clrt.load(tmp_path / "scan.toml")
    table = again.to_dict()["shapes"][0]
    assert table["file"] == "scan.ply" and table["part"] == 0
    assert table["material"]["color"] == {"type": "image", "file": "scan.ply", "part": 0, "wrap": "clamp"}
    small = {"camera.width": 24, "camera.height": 18}
    one, other = (clrt.render(part.replace(small)) for part in (scene, again))
    assert one.hash == other.hash
    oracle = render64(scene.replace(small))
    assert np.quantile(np.abs(oracle.pixels - one.pixels), 0.95) <= 1e-5  # edges aside


def test_what_is_not_there_is_said(tmp_path: Path) -> None:
    write_ply(tmp_path / "scan.ply")
    mesh: dict[str, Any] = {"type": "mesh", "file": "scan.ply", "part": 0}
    image = {"type": "image", "file": "scan.ply"}

    def load(number: int | None, limits: Limits | None = None) -> None:
        color = image if number is None else image | {"part": number}
        table = {**VIEW, "shapes": [mesh | {"material": {"color": color}}]}
        clrt.render(clrt.load_dict(table, folder=tmp_path, limits=limits))

    with pytest.raises(clrt.ClrtError, match="of a model's file say which picture"):
        load(None)
    with pytest.raises(clrt.ClrtError, match=r"images\[1\] is not there; it has its colours"):
        load(1)
    with pytest.raises(clrt.LimitError, match="texture_bytes"):
        load(0, Limits(texture_bytes=100))
    text = (tmp_path / "scan.ply").read_text().replace("uchar red", "uchar rod")
    (tmp_path / "scan.ply").write_text(text)
    with pytest.raises(clrt.ClrtError, match="uv"):
        load(0)
    mesh.clear()
    mesh.update({"type": "sphere", "center": [0, 0, 0], "radius": 1})
    with pytest.raises(clrt.ClrtError, match="it has no colours of vertices or faces"):
        load(0)


def test_the_shell_is_what_its_script_writes() -> None:
    """But for the last bits of sines, which differ between machines."""
    script = runpy.run_path(str(scene_folder() / "generate_shell.py"))
    vertices, _, triangles, _ = script["shell"]()
    (shell,) = clrt.load(scene_folder() / "shell.ply").shapes
    found = shell.data().vertices  # type: ignore[union-attr]
    np.testing.assert_allclose(found, vertices[triangles.reshape(-1)], atol=1e-6)
