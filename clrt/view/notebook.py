"""The live view in notebooks, where anywidget is installed (extra `[notebook]`)."""

from __future__ import annotations

import importlib.util
import os
import sys
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from clrt.base import arguments
from clrt.base.arguments import public
from clrt.base.errors import MissingPackage
from clrt.base.install import install_extra
from clrt.engine.tracer import Tracer
from clrt.formats.shipped import as_scene
from clrt.scene.scene import Scene
from clrt.view.session import without_camera

if TYPE_CHECKING:
    from clrt.view.widget import View
else:
    View = Any  # whose module needs anywidget: hints can be asked for without it


@public
def widget(
    scene: Scene | Mapping[str, Any] | str | os.PathLike[str], device: int | str | None = None
) -> View:
    """A notebook's widget that shows a scene as `clrt view` does; its `scene` is the one that is shown.

    scene: as `clrt.Tracer` takes it, with a camera. device: likewise. It makes a `Tracer` of its own. Raises
    what that raises, and ClrtError without anywidget (the extra `[notebook]`).
    """
    device, made = arguments.device("device", device), as_scene(scene)
    if made.camera is None:
        raise without_camera(made)
    if importlib.util.find_spec("anywidget") is None:
        raise MissingPackage(f"widget: needs anywidget; install it with: {install_extra('notebook')}")
    from clrt.view.widget import View

    return View(made, lambda: Tracer(made, device))


def live(shown: Any) -> dict[str, Any]:
    """The widget of a Scene or a Tracer as a notebook takes it; nothing elsewhere, or without a camera."""
    if "ipykernel" not in sys.modules or importlib.util.find_spec("anywidget") is None:
        return {}
    scene = shown.scene if isinstance(shown, Tracer) else shown
    if scene.camera is None:
        return {}
    # a tracer of its own: what sliders change is no change of the user's
    own = (shown.device.info.index, shown.settings) if isinstance(shown, Tracer) else ()
    from clrt.view.widget import View

    made = View(scene, lambda: Tracer(scene, *own))._repr_mimebundle_()
    bundle = made[0] if isinstance(made, tuple) else made
    return {kind: data for kind, data in (bundle or {}).items() if kind.startswith("application/")}
