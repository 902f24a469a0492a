"""The page: its HTML, its style, and one ES module, which is the notebook's widget, too.

The module is the files below, one after the other: they are written and read apart, and nothing builds them.
"""

from __future__ import annotations

from functools import cache
from pathlib import Path
from typing import Final

_HERE: Final = Path(__file__).parent
_PARTS: Final = ("basics.js", "camera.js", "picture.js", "rays.js", "panels.js", "view.js")


@cache
def module() -> str:
    """The ES module; it exports `render({model, el})` as anywidget asks for."""
    return "\n".join((_HERE / name).read_text("utf-8") for name in _PARTS)


@cache
def style() -> str:
    """The style sheet."""
    return (_HERE / "view.css").read_text("utf-8")


@cache
def page() -> str:
    """The page, whose module asks for all else."""
    return (_HERE / "page.html").read_text("utf-8")
