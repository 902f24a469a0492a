"""The scene as the user means it: cameras, lights, materials and shapes, checked.

Its classes are public here (`from clrt.scene import Material, PointLight, Scene`), imported when first used.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from clrt.scene.scene import *  # noqa: F403


if not TYPE_CHECKING:  # to whom each name that there is not would be one, of type Any

    def __getattr__(name: str) -> Any:
        # names of modules of this room are asked for here, too, before they are imported
        if name[:1].isupper():
            home = import_module("clrt.scene.scene")
            if name in home.__all__:
                return getattr(home, name)
        raise AttributeError(f"module 'clrt.scene' has no attribute {name!r}")


def __dir__() -> list[str]:
    home = import_module("clrt.scene.scene")
    return sorted({*globals(), *(name for name in home.__all__ if name[:1].isupper())})
