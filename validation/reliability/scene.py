"""A small scene that goes through every pass: by itself, or with files beside it, a mesh and a sky."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from clrt.images.image import Image

TEXT = """
max_depth = 3
ambient = 0.1
ambient_samples = 1
{background}
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
{mesh}
"""
FILES = {"background": 'background = "sky.png"', "mesh": 'file = "corner.obj"'}
ALONE = {
    "background": "background = [0.1, 0.2, 0.3]",
    "mesh": "vertices = [[-2, -1, -1], [2, -1, -1], [0, 2, -2], [0, 1, 0]]\n"
    "faces = [[0, 1, 2], [0, 1, 3], [1, 2, 3], [2, 0, 3]]",
}
MESH = "v -2 -1 -1\nv 2 -1 -1\nv 0 2 -2\nv 0 1 0\nf 1 2 3\nf 1 2 4\nf 2 3 4\nf 3 1 4\n"


def write_scene(folder: Path) -> Path:
    """Write the scene and its files into a folder; the scene's file."""
    (folder / "corner.obj").write_text(MESH)
    Image(np.random.default_rng(1).random((8, 16, 3), np.float32)).save(folder / "sky.png")
    return write_alone(folder, FILES)


def write_alone(folder: Path, parts: dict[str, str] = ALONE) -> Path:
    """Write the scene with its mesh and sky as numbers, or as `parts` have them; its file.

    It starts in half the time, for no library of meshes is imported.
    """
    text = TEXT
    for name, words in parts.items():
        text = text.replace(f"{{{name}}}", words)
    (folder / "scene.toml").write_text(text)
    return folder / "scene.toml"
