"""What this room has to know of each kind of shape, and whether it does."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Final

from clrt.base.errors import SceneError, located
from clrt.flatten.inside import _INSIDE
from clrt.flatten.mapping import _MAP
from clrt.flatten.shapes import _ADD
from clrt.scene.scene import Scene

TABLES: Final[dict[str, Mapping[type, Any]]] = {
    "_ADD in clrt/flatten/shapes.py": _ADD,
    "_INSIDE in clrt/flatten/inside.py": _INSIDE,
    "_MAP in clrt/flatten/mapping.py": _MAP,
}


def check_entries(scene: Scene) -> None:
    """Raise SceneError for a shape that has no entry in one of the tables, asked for or not."""
    for kind in dict.fromkeys(map(type, scene.shapes)):
        lacking = [where for where, table in TABLES.items() if kind not in table]
        if lacking:
            first = next(number for number, shape in enumerate(scene.shapes) if type(shape) is kind)
            text = f"a {kind.__name__} has no entry in {', '.join(lacking)}; see docs/adding-a-primitive.md"
            raise SceneError(located(scene.source, f"shapes[{first}]", text))
