"""Render the pictures of the documentation from the scenes that ship.

    python docs/make_contact_sheet.py [contact-sheet] [showcase] [shading-layers] [acne]

writes docs/contact-sheet.png (every scene, small), docs/showcase.png (at its own size),
docs/shading-layers.png (thesis_4_2_shading, term by term) and docs/acne.png (thesis_3_07_acne with and
without the offset of spawned rays); all of them when none is named.
"""

from __future__ import annotations

import sys
from collections.abc import Iterable
from pathlib import Path

import numpy as np
import OpenImageIO as oiio
from numpy.typing import NDArray

import clrt
from clrt import layout
from clrt.base.resources import shipped_scenes
from clrt.formats.shipped import load_scene
from clrt.images.file import encode
from clrt.scene.scene import Scene

HERE = Path(__file__).resolve().parent
CELL, CAPTION, GAP = (300, 225), 22, 8  # pixels: the largest picture, the line below it, the space between
PAPER, INK = 0.012, 0.75  # linear grey

Pixels = NDArray[np.float32]


def fitting_width(scene: Scene) -> int:
    """The width at which a scene's picture fills the cell in one direction and fits in the other."""
    assert scene.camera is not None
    return min(CELL[0], round(CELL[1] * scene.camera.width / scene.camera.height))


def captioned(pixels: Pixels, caption: str) -> Pixels:
    """A picture in the middle of a cell, with its name below; (h, w, 3) linear in and out."""
    width, height = CELL
    cell = np.full((height + CAPTION, width, 3), PAPER, dtype=np.float32)
    top, left = (height - pixels.shape[0]) // 2, (width - pixels.shape[1]) // 2
    cell[top : top + pixels.shape[0], left : left + pixels.shape[1]] = np.clip(pixels, 0.0, 1.0)
    canvas = oiio.ImageBuf(oiio.ImageSpec(width, height + CAPTION, 3, "float"))
    canvas.set_pixels(oiio.ROI(), cell)
    ink, x, y = (INK, INK, INK), width // 2, height + CAPTION - 7
    if not oiio.ImageBufAlgo.render_text(canvas, x, y, caption, 14, "", ink, "center"):
        raise SystemExit(canvas.geterror())
    return np.asarray(canvas.get_pixels(oiio.FLOAT))[..., :3]


def sheet(cells: Iterable[Pixels], columns: int) -> Pixels:
    """Cells in rows, with gaps."""
    pictures = list(cells)
    rows = -(-len(pictures) // columns)
    height, width = pictures[0].shape[0] + GAP, pictures[0].shape[1] + GAP
    paper = np.full((rows * height + GAP, columns * width + GAP, 3), PAPER, dtype=np.float32)
    for i, picture in enumerate(pictures):
        y, x = GAP + i // columns * height, GAP + i % columns * width
        paper[y : y + picture.shape[0], x : x + picture.shape[1]] = picture
    return paper


def write(name: str, pixels: Pixels) -> None:
    """Write linear pixels as an 8-bit PNG beside this script."""
    path = str(HERE / f"{name}.png")
    spec = oiio.ImageSpec(pixels.shape[1], pixels.shape[0], 3, "uint8")
    spec.attribute("png:compressionLevel", 9)
    output = oiio.ImageOutput.create(path)
    if not (output and output.open(path, spec) and output.write_image(encode(pixels)) and output.close()):
        raise SystemExit(f"{path}: {oiio.geterror()}")
    print(path)


def contact_sheet() -> Pixels:
    """Every scene that ships, small, with its name, in the order of scenes.md."""
    text = (HERE / "scenes.md").read_text()
    cells = []
    for name in sorted(shipped_scenes(), key=lambda name: text.index(f"`{name}`")):
        scene = load_scene(name)
        cells.append(captioned(clrt.render(scene, width=fitting_width(scene)).pixels, name))
    return sheet(cells, columns=5)


def showcase() -> Pixels:
    """The showcase at its own size."""
    return clrt.render(load_scene("showcase")).pixels


def shading_layers() -> Pixels:
    """The layers of thesis_4_2_shading and their sum."""
    names = ("emission", "ambient", "diffuse", "highlight", "reflection")
    scene = load_scene("thesis_4_2_shading")
    image = clrt.render(scene, width=fitting_width(scene), layers=names)
    cells = [captioned(image.layers[name], name) for name in names]
    return sheet([*cells, captioned(image.pixels, "all of it")], columns=3)


def acne() -> Pixels:
    """thesis_3_07_acne at one sample, with the offset of spawned rays and without it."""
    scene = load_scene("thesis_3_07_acne")
    width, bounds = fitting_width(scene), {name: getattr(layout, name) for name in ("OFFSET", "ALONG")}
    cells = [captioned(clrt.render(scene, width=width, spp=1).pixels, "with the offset")]
    try:
        for name in bounds:  # constants everywhere else
            setattr(layout, name, 0.0)
        cells.append(captioned(clrt.render(scene, width=width, spp=1).pixels, "without"))
    finally:
        for name, bound in bounds.items():
            setattr(layout, name, bound)
    return sheet(cells, columns=2)


PICTURES = {
    "contact-sheet": contact_sheet,
    "showcase": showcase,
    "shading-layers": shading_layers,
    "acne": acne,
}

if __name__ == "__main__":
    for picture in sys.argv[1:] or PICTURES:
        write(picture, PICTURES[picture]())
