"""A tree of rays as one page for any browser: no script, nothing from elsewhere, all texts as texts."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final
from xml.etree.ElementTree import Element, SubElement, tostring

import numpy as np

from clrt.base.errors import legible
from clrt.raytree.drawing import VIEWS, drawing
from clrt.raytree.ways import COLOURS
from clrt.raytree.words import heading, lines, percent, summary, title

if TYPE_CHECKING:
    from clrt.raytree.tree import Ray, RayTree

_NESTED: Final = 100  # generations within each other; browsers cut what is nested deeper
_OPEN: Final = 0.01  # part of the pixel that a branch brings which is unfolded at first
_DRAWN: Final = 2000  # rays that a drawing can hold and still be read
_POLICY: Final = "default-src 'none'; style-src 'unsafe-inline'; img-src data:"
_STYLE: Final = """
:root { color-scheme: light dark }
body { font: 14px/1.45 system-ui, sans-serif; margin: 1.5em auto; max-width: 75em; padding: 0 1em }
h1 { font-size: 1.25em } details { margin-left: 1.1em; border-left: 2px solid #8886; padding-left: .5em }
summary { cursor: pointer } ul { margin: .1em 0 .4em; padding-left: 1.6em }
.share { display: inline-block; min-width: 4em; padding-right: .4em; font-variant-numeric: tabular-nums;
font-weight: 600 }
.bar { display: inline-block; height: .6em; background: #4a90d9 } .swatch { display: inline-block; width: 3em;
height: 3em; border: 1px solid #888; vertical-align: middle; margin-right: 1em }
.views { display: grid; grid-template-columns: repeat(auto-fit, minmax(min(100%, 17em), 1fr)); gap: 1em }
.views svg { max-width: 100%; max-height: 24em; height: auto }
.kind { font-weight: 600 } .dim { opacity: .65 }
"""


def page(tree: RayTree) -> str:
    """The whole page."""
    html = Element("html", {"lang": "en"})
    head = SubElement(html, "head")
    SubElement(head, "meta", {"charset": "utf-8"})
    SubElement(head, "meta", {"http-equiv": "Content-Security-Policy", "content": _POLICY})
    SubElement(head, "meta", {"name": "viewport", "content": "width=device-width, initial-scale=1"})
    SubElement(head, "title").text = title(tree)
    SubElement(head, "style").text = _STYLE
    SubElement(html, "body").append(_content(tree))
    return f"<!DOCTYPE html>\n{_text(html)}\n"


def fragment(tree: RayTree) -> str:
    """What a notebook shows: the same without head and style."""
    return _text(_content(tree))


def _text(element: Element) -> str:
    """As HTML, without characters that turn the direction of writing, or that no HTML can hold."""
    return str(legible(tostring(element, encoding="unicode", method="html")))


def _content(tree: RayTree) -> Element:
    main = Element("main")
    SubElement(main, "h1").text = title(tree)
    about = SubElement(main, "p")
    SubElement(about, "span", {"class": "swatch", "style": f"background: {_css(tree.value)}"})
    SubElement(about, "span").text = summary(tree)
    key = SubElement(main, "p")
    for kind, colour in COLOURS.items():
        text = {"light": "feeler that arrives", "blocked": "feeler that does not"}.get(kind, f"{kind} ray")
        entry = SubElement(key, "span", {"style": "white-space: nowrap; margin-right: .7em"})
        entry.tail = " "
        mark = SubElement(entry, "span", {"style": "color: rgb({}, {}, {})".format(*colour)})
        mark.text, mark.tail = "\u2501 ", text
    if len(tree.rays) <= _DRAWN:
        views = SubElement(main, "div", {"class": "views"})
        for view in VIEWS:
            figure = SubElement(views, "div")
            figure.append(drawing(tree, view))
            SubElement(figure, "div", {"class": "dim"}).text = f"from the {view}"
    else:
        SubElement(main, "p").text = f"Too many rays to draw: {len(tree.rays)}."
    SubElement(main, "h2").text = "The rays"
    _branches(tree, main)
    return main


def _branches(tree: RayTree, main: Element) -> None:
    todo: list[tuple[Ray, Element]] = [(root, main) for root in reversed(tree.roots)]
    while todo:
        ray, above = todo.pop()
        branch = tree.branch_shares[ray.number]
        own = SubElement(above, "details", {"id": f"ray-{ray.number}"})
        if branch >= _OPEN:
            own.set("open", "open")
        line = SubElement(own, "summary")
        SubElement(line, "span", {"class": "share"}).text = percent(branch)
        width = f"width: {max(0.0, min(6 * branch, 6.0)):.2f}em"
        SubElement(line, "span", {"class": "bar", "style": width}).tail = " "
        colour = "color: rgb({}, {}, {})".format(*COLOURS[ray.kind])
        SubElement(line, "span", {"class": "kind", "style": colour}).text = "\u25cf "
        SubElement(line, "span").text = heading(tree, ray)
        items = SubElement(own, "ul")
        for found in lines(tree, ray):
            item = SubElement(items, "li", {} if found.colour else {"class": "dim"})
            if found.colour:
                SubElement(item, "span", {"class": "share"}).text = percent(found.share)
            text = f"{found.text}: {found.colour}" if found.colour else found.text
            SubElement(item, "span").text = text
        inner = own if ray.generation < _NESTED else above
        todo += [(child, inner) for child in reversed(ray.children)]


def _css(value: np.ndarray) -> str:
    """A linear colour as a browser shows it."""
    linear = np.clip(np.nan_to_num(value.astype(float)), 0, 1)
    shown = np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)
    return "rgb({}, {}, {})".format(*np.round(255 * shown).astype(int).tolist())
