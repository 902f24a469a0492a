"""Write mips.png of scene-files.md anew: `python docs/make_mips.py`. A far floor at one sample a pixel."""

from __future__ import annotations

from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

import clrt
from clrt.images.file import write as write_picture
from docs.make_contact_sheet import captioned, sheet, write


def scene(folder: Path, name: str) -> clrt.Scene:
    """A floor of squares up to its horizon, and a mirror that shows it once more."""
    squares = np.add.outer(np.arange(256) // 16, np.arange(256) // 16) % 2 * 0.7 + 0.15
    rgb = squares[..., None] * np.array([1.0, 0.93, 0.8])
    write_picture(folder / "squares.exr", [np.ascontiguousarray(rgb, np.float32)])
    shown: dict[str, Any] = {"type": "image", "file": "squares.exr", "scale": [0.25, 0.25], "filter": name}
    return clrt.load_dict({
        "camera": {"origin": [0, 0, 1], "target": [0.4, 4, 0.62], "up": [0, 0, 1], "fov": 50, "width": 300,
                   "height": 225},
        "ambient": 1, "background": [0.35, 0.5, 0.7], "shapes": [
            {"type": "plane", "point": [0, 0, 0], "normal": [0, 0, 1],
             "material": {"diffuse": 0, "ambient": 1, "color": shown}},
            {"type": "sphere", "center": [0.9, 4.2, 0.65], "radius": 0.65,
             "material": {"diffuse": 0, "ambient": 0, "reflection": 0.9}},
        ],
    }, folder=folder)  # fmt: skip


def main() -> None:
    """Both pictures side by side."""
    names = "linear", "mipmap"
    with TemporaryDirectory() as folder:
        pixels = [clrt.render(scene(Path(folder), name)).pixels for name in names]
    cells = [captioned(one, f'filter = "{name}"') for one, name in zip(pixels, names, strict=True)]
    write("mips", sheet(cells, columns=2))


if __name__ == "__main__":
    main()
