"""What pictures on surfaces cost: of each scene the time with them over the time without.

    python -m docs.measure_picture_cost [ROUNDS]

On one thread, in turns; printed are medians of the ratios of processor times, and quartiles. The sphereflakes
have `globe.png`, or a picture of 8 x 8 texels, on every sphere; the terrain of a million triangles has
4096 x 4096 texels, or 8 x 8, over all of it.
"""

from __future__ import annotations

import shutil
import sys
from collections.abc import Iterator
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, Final

import numpy as np
from msgspec.structs import replace

import clrt
from clrt.base.resources import scene_file
from clrt.bench import scenes
from clrt.images.file import write as write_picture
from clrt.scene.materials import Material
from clrt.scene.mesh import Mesh
from clrt.scene.scene import Scene
from clrt.scene.textures import ImageTexture
from docs.in_turns import ratios

ROUNDS: Final = 11


def painted(scene: Scene, folder: Path, picture: str, how: Any = "linear") -> Scene:
    """The scene with the picture for the colour of every shape; a mesh has it once over x and z."""
    color = ImageTexture(file=picture, filter=how)
    shapes = []
    for shape in scene.shapes:
        if isinstance(shape.material, Material):
            shape = replace(shape, material=replace(shape.material, color=color))
        if isinstance(shape, Mesh):
            flat = np.asarray(shape.vertices)[:, [0, 2]]
            shape = replace(shape, uv=(flat - flat.min(axis=0)) / np.ptp(flat, axis=0))
        shapes.append(shape)
    materials = {name: replace(material, color=color) for name, material in scene.materials.items()}
    return replace(scene, shapes=shapes, materials=materials, folder=folder)


def cases(folder: Path) -> Iterator[tuple[str, Scene, dict[str, Scene], int]]:
    """Name, scene, the same with pictures, and width."""
    rng = np.random.default_rng(1)
    for side in (8, 4096):
        texels = rng.uniform(0.2, 0.9, (side, side, 3)).astype(np.float32)
        write_picture(folder / f"{side}.png", [texels])
    for name in ("globe.png", "studio.exr"):
        shutil.copy(scene_file("showcase").with_name(name), folder)
    for name, scene, width in (
        ("bench's flake", scenes.flake_frame(), 512), ("sphereflake", clrt.load("sphereflake"), 384),
    ):  # fmt: skip
        pictures = {picture: painted(scene, folder, picture) for picture in ("globe.png", "8.png")}
        yield name, scene, pictures, width
    terrain = scenes.terrain_frame()
    ways = [("4096.png", "linear"), ("8.png", "linear"), ("4096.png", "mipmap")]
    yield "terrain", terrain, {f"{p}, {how}": painted(terrain, folder, p, how) for p, how in ways}, 512


def main() -> None:
    """Render them in turns."""
    rounds = int(sys.argv[1]) if len(sys.argv) > 1 else ROUNDS
    settings = clrt.Settings(threads=1)
    with TemporaryDirectory() as folder:
        for name, scene, pictures, width in cases(Path(folder)):
            tracers = [clrt.Tracer(one, settings=settings) for one in (scene, *pictures.values())]
            for tracer in tracers:
                tracer.render(width=width)
            for picture, (_, told) in zip(pictures, ratios(tracers, 0, rounds, width), strict=True):
                print(f"{name:14s} {picture:18s} {told}", flush=True)


if __name__ == "__main__":
    main()
