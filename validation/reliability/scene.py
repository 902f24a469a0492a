"""A small scene that goes through every pass, with files beside it: a mesh and a sky."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from clrt.images.image import Image

TEXT = """
max_depth = 3
ambient = 0.1
ambient_samples = 1
background = "sky.png"
[camera]
origin = [0.0, 1.0, 4.0]
target = [0.0, 0.0, 0.0]
width = 24
height = 18
[materials.glass]
diffuse = 0.2
reflection = 0.3
transmission = 0.5
[[lights]]
type = "point"
position = [3.0, 5.0, 4.0]
[[shapes]]
type = "sphere"
center = [0.0, 0.0, 0.0]
radius = 1.0
material = "glass"
[[shapes]]
type = "plane"
point = [0.0, -1.0, 0.0]
normal = [0.0, 1.0, 0.0]
[[shapes]]
type = "mesh"
file = "corner.obj"
"""
MESH = "v -2 -1 -1\nv 2 -1 -1\nv 0 2 -2\nv 0 1 0\nf 1 2 3\nf 1 2 4\nf 2 3 4\nf 3 1 4\n"


def write_scene(folder: Path) -> Path:
    """Write the scene and its files into a folder; the scene's file."""
    (folder / "corner.obj").write_text(MESH)
    Image(np.random.default_rng(1).random((8, 16, 3), np.float32)).save(folder / "sky.png")
    (folder / "scene.toml").write_text(TEXT)
    return folder / "scene.toml"
