"""Picture files, and scenes with pictures on their surfaces, for tests."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import OpenImageIO as oiio

import clrt

Table = dict[str, Any]


def put(path: Path, pixels: Any, kind: str = "float", names: tuple[str, ...] = ()) -> Path:
    """A picture file (h, w, channels) of samples as they are given."""
    array = np.ascontiguousarray(pixels, {"uint8": np.uint8, "uint16": np.uint16}.get(kind, np.float32))
    height, width, channels = array.shape
    spec = oiio.ImageSpec(width, height, channels, kind)
    if names:
        spec.channelnames = names
    file = oiio.ImageOutput.create(str(path))
    assert file is not None and file.open(str(path), spec) and file.write_image(array) and file.close()
    return path


def image(file: str, **keys: Any) -> Table:
    """A picture as a scene's table says it."""
    return {"type": "image", "file": file, **keys}


def sheet(folder: Path, color: Table, **material: Any) -> clrt.Scene:
    """The plane z = 0, which shines as a picture does: u = x, v = 1 - y."""
    shape = {"type": "plane", "point": [0, 0, 0], "normal": [0, 0, 1]}
    shape["material"] = {"color": 0, "diffuse": 0, "emission": color, **material}
    return clrt.load_dict({"shapes": [shape]}, folder=folder)


def looked_at(scene: clrt.Scene, u: Any, v: Any) -> np.ndarray:
    """What a `sheet` shows (n, 3) at u, v."""
    x, y = np.broadcast_arrays(np.asarray(u, float), 1 - np.asarray(v, float))
    origins = np.stack([x.ravel(), y.ravel(), np.ones(x.size)], axis=1)
    with clrt.Tracer(scene) as tracer:
        return tracer.radiance(origins, np.broadcast_to([0.0, 0.0, -1.0], origins.shape))[0]


def smooth_pictures(folder: Path) -> None:
    """`colors.exr` and `normals.exr`: pictures that go on beyond their edges and have no steps."""
    y, x = np.mgrid[0:32, 0:48] * np.array([2 * np.pi / 32, 2 * np.pi / 48])[:, None, None]
    put(folder / "colors.exr", np.stack([0.5 + 0.4 * np.sin(x + k) * np.cos(y) for k in range(3)], axis=-1))
    leaning = [0.5 + 0.3 * np.sin(x), 0.5 + 0.3 * np.cos(2 * y), np.full(x.shape, 0.9)]
    put(folder / "normals.exr", np.stack(leaning, axis=-1))
