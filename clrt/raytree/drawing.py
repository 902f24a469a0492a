"""A tree's rays as lines among the outlines of the shapes that they meet: SVG, seen along an axis."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final
from xml.etree.ElementTree import Element, SubElement

import numpy as np

from clrt.raytree.solids import triangles_of
from clrt.raytree.ways import COLOURS, ways
from clrt.raytree.words import heading, percent
from clrt.scene.shapes import Plane

if TYPE_CHECKING:
    from clrt.raytree.tree import RayTree

VIEWS: Final = {"front": (0, 1), "side": (2, 1), "top": (0, 2)}
"""Which axes go right and up; of the top view z comes towards the reader, and so goes down."""
_WIDE: Final = 460.0
_MARGIN: Final = 14.0


def drawing(tree: RayTree, view: str, least: float = 0.0, feelers: bool = True) -> Element:
    """An <svg> of the rays whose branches bring at least the part `least` of the pixel. view: of VIEWS."""
    across, up = VIEWS[view]
    lines, low, high = ways(tree, feelers)
    size = np.maximum(high - low, 1e-9 * np.abs(high).max())
    scale = (_WIDE - 2 * _MARGIN) / max(float(size[across]), float(size[up]) / 1.4)
    tall = float(size[up]) * scale + 2 * _MARGIN
    wide = float(size[across]) * scale + 2 * _MARGIN

    def at(point: np.ndarray) -> np.ndarray:
        x, y = point[..., across] - low[across], point[..., up] - low[up]
        y = y if view == "top" else size[up] - y
        return np.stack([x, y], axis=-1) * scale + _MARGIN

    svg = Element("svg", {
        "xmlns": "http://www.w3.org/2000/svg", "viewBox": f"0 0 {wide:.1f} {tall:.1f}",
        "width": f"{wide:.0f}", "height": f"{tall:.0f}", "role": "img",
    })  # fmt: skip
    SubElement(svg, "title").text = f"the rays from the {view}"
    SubElement(svg, "rect", {"width": "100%", "height": "100%", "fill": "#ffffff"})
    for number in sorted({ray.hit.shape for ray in tree.rays if ray.hit is not None}):
        if number >= len(tree.scene.shapes):  # a light that is seen
            continue
        shape = tree.scene.shapes[number]
        made = triangles_of(shape, low, high)
        if made is None:
            continue
        outline = _hull(at(made[0][np.unique(made[1])]))
        style = {"fill": "#7f8fa0", "fill-opacity": "0.10", "stroke": "#7f8fa0", "stroke-width": "1"}
        if isinstance(shape, Plane):
            style["fill-opacity"] = "0.04"
        polygon = SubElement(svg, "polygon", {"points": _points(outline), **style})
        SubElement(polygon, "title").text = tree.names.shape(number)
    for way in sorted(lines, key=lambda way: way.kind not in ("light", "blocked")):
        if way.share < least:
            continue
        (x1, y1), (x2, y2) = at(way.start), at(way.end)
        thin = way.kind in ("light", "blocked")
        wider = 0.7 if thin else 0.9 + 2.6 * float(np.sqrt(min(max(way.share, 0.0), 1.0)))
        style = {"stroke": "#{:02x}{:02x}{:02x}".format(*COLOURS[way.kind]), "stroke-width": f"{wider:.2f}"}
        if thin:
            style["stroke-dasharray"] = "4 3" if way.kind == "light" else "1 3"
        place = dict(zip(("x1", "y1", "x2", "y2"), (f"{v:.2f}" for v in (x1, y1, x2, y2)), strict=True))
        line = SubElement(svg, "line", {**place, **style})
        about = "" if thin else f", {percent(way.share)} of the pixel"
        SubElement(line, "title").text = f"{way.kind}: {heading(tree, tree.rays[way.ray])}{about}"
    return svg


def _points(outline: np.ndarray) -> str:
    return " ".join(f"{x:.2f},{y:.2f}" for x, y in outline)


def _hull(points: np.ndarray) -> np.ndarray:
    """The convex hull of points (n, 2), by Andrew's monotone chain (1979)."""
    ordered = np.unique(points, axis=0)
    if len(ordered) < 3:
        return ordered

    def half(places: np.ndarray) -> list[np.ndarray]:
        chain: list[np.ndarray] = []
        for point in places:
            while len(chain) > 1:
                (ax, ay), (bx, by) = chain[-1] - chain[-2], point - chain[-2]
                if ax * by - ay * bx > 0:
                    break
                chain.pop()
            chain.append(point)
        return chain[:-1]

    return np.array(half(ordered) + half(ordered[::-1]))
