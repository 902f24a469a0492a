"""What is in a scene, as a page for notebooks: no script, all texts as texts."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable
from typing import TYPE_CHECKING, Any, Final
from xml.etree.ElementTree import Element, SubElement, tostring

from clrt.base.errors import legible

if TYPE_CHECKING:
    from clrt.scene.scene import Scene

_NAMED: Final = 20  # materials


def summary(scene: Scene) -> Element:
    """A table of the scene's camera, shapes, materials, lights."""
    top = Element("div", {"class": "clrt-scene"})
    SubElement(SubElement(top, "p"), "strong").text = scene.source or "a scene"
    camera, names = scene.camera, list(scene.materials)
    more = f" and {len(names) - _NAMED} more" if len(names) > _NAMED else ""
    rows = {
        "camera": "none" if camera is None else f"{camera.type}, {camera.width} x {camera.height} pixels",
        "shapes": counted(scene.shapes) + f"; {sum(shape.primitives for shape in scene.shapes)} primitives",
        "lights": counted(scene.lights),
        "materials": ", ".join(names[:_NAMED]) + more or "none with a name",
        "bounces": str(scene.max_depth),
    }
    table = SubElement(top, "table")
    for name, text in rows.items():
        row = SubElement(table, "tr")
        SubElement(row, "th", {"style": "text-align: left"}).text = name
        SubElement(row, "td", {"style": "text-align: left"}).text = text
    return top


def counted(records: Iterable[Any]) -> str:
    """How many of each type: "2 disk, 5 sphere"."""
    counts = Counter(record.type for record in records)
    return ", ".join(f"{count} {kind}" for kind, count in sorted(counts.items())) or "none"


def html(element: Element) -> str:
    """As HTML, without characters that turn the direction of writing, or that no HTML can hold."""
    return str(legible(tostring(element, encoding="unicode", method="html")))
