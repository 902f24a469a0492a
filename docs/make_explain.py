"""Draw the pictures of docs/explain.md: `python docs/make_explain.py`.

explain.png is the glass sphere of the showcase with five places marked, explain-rays.svg the rays of these.
"""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any
from xml.etree.ElementTree import Element, SubElement, tostring

import numpy as np
import OpenImageIO as oiio

import clrt
from clrt.images.file import encode
from clrt.raytree.drawing import drawing
from clrt.raytree.ways import COLOURS

HERE = Path(__file__).resolve().parent
CROP = (680, 220, 400, 380)  # of the showcase at its own size
LARGER = 2
LEAST = 0.02  # part of the pixel that a branch brings which is drawn


def places() -> list[tuple[int, int]]:
    """The pixels that the page explains, in its order."""
    page = (HERE / "explain.md").read_text("utf-8")
    found = re.findall(r"^    \$ clrt explain showcase (\d+) (\d+) --spp 1", page, re.M)
    return [(int(x), int(y)) for x, y in found]


def marked(pixels: Any, at: list[tuple[int, int]]) -> Any:
    """The picture, enlarged, with a ring and a number at each place."""
    shown = pixels.repeat(LARGER, 0).repeat(LARGER, 1).astype(np.float32)
    height, width = shown.shape[:2]
    rows, columns = np.mgrid[:height, :width]
    for x, y in at:
        away = np.hypot(columns - (x - CROP[0] + 0.5) * LARGER, rows - (y - CROP[1] + 0.5) * LARGER)
        shown[(away > 13) & (away < 18)] = 0.0
        shown[(away > 14) & (away < 17)] = (1.0, 0.9, 0.1)
    canvas = oiio.ImageBuf(oiio.ImageSpec(width, height, 3, "float"))
    canvas.set_pixels(oiio.ROI(), np.clip(shown, 0, 1))
    for number, (x, y) in enumerate(at, 1):
        crowded = any(0 < (u - x) * LARGER < 60 and abs(v - y) * LARGER < 30 for u, v in at)
        left, base = (x - CROP[0]) * LARGER + (-36 if crowded else 22), (y - CROP[1]) * LARGER + 10
        for shift, ink in ((1, (0.0, 0.0, 0.0)), (0, (1.0, 0.9, 0.1))):
            oiio.ImageBufAlgo.render_text(canvas, left + shift, base + shift, str(number), 26, "", ink)
    return np.asarray(canvas.get_pixels(oiio.FLOAT))[..., :3]


def panels(trees: list[clrt.RayTree]) -> Element:
    """The rays of each place from the side, below each other."""
    sheet = Element("svg", {"xmlns": "http://www.w3.org/2000/svg", "font-family": "sans-serif"})
    SubElement(sheet, "rect", {"width": "100%", "height": "100%", "fill": "#ffffff"})
    x = y = tallest = widest = 0.0
    for number, tree in enumerate(trees, 1):
        part = drawing(tree, "side", LEAST, feelers=False)
        wide, tall = float(part.get("width", "0")), float(part.get("height", "0"))
        if number % 2:
            x, y, tallest = 0.0, y + tallest, 0.0
        part.set("x", str(x))
        part.set("y", str(y + 22))
        label = SubElement(sheet, "text", {"x": str(x + 10), "y": str(y + 17), "font-size": "15"})
        label.text = f"{number}: pixel ({tree.x}, {tree.y})"
        sheet.append(part)
        x, tallest, widest = x + wide + 10, max(tallest, tall + 26), max(widest, x + wide)
    for k, kind in enumerate(("camera", "reflection", "transmission")):
        colour = "#{:02x}{:02x}{:02x}".format(*COLOURS[kind])
        where = {"x": str(x + 20), "y": str(y + 50 + 22 * k), "font-size": "14", "fill": colour}
        SubElement(sheet, "text", where).text = f"\u2501 {kind} ray"
    sheet.set("viewBox", f"0 0 {widest:.0f} {y + tallest:.0f}")
    sheet.set("width", f"{widest:.0f}")
    return sheet


def main() -> None:
    tracer = clrt.Tracer("showcase")
    at = places()
    assert len(at) == 5
    picture = marked(tracer.render(crop=CROP).pixels, at)
    oiio_file = oiio.ImageOutput.create(str(HERE / "explain.png"))
    eight = encode(picture, 0.0)
    oiio_file.open(str(HERE / "explain.png"), oiio.ImageSpec(eight.shape[1], eight.shape[0], 3, "uint8"))
    oiio_file.write_image(eight)
    oiio_file.close()
    sheet = panels([tracer.explain(x, y, spp=1) for x, y in at])
    (HERE / "explain-rays.svg").write_text(tostring(sheet, encoding="unicode") + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
