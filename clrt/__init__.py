"""clrt: a Whitted ray tracer in OpenCL, driven from Python. Public names, each imported when first used.

Lazily, so that `clrt --help` need not wait for numpy, OpenCL and the picture library.
"""

from __future__ import annotations

from clrt.base import interrupts

if interrupts.is_program():
    interrupts.install()  # before anything else: what is interrupted while it begins must end well, too

from importlib import import_module
from typing import TYPE_CHECKING, Any

from clrt.base import display
from clrt.version import __version__

if TYPE_CHECKING:
    from clrt.base.errors import ClrtError, ClrtWarning, DeviceError, LimitError, SceneError
    from clrt.base.limits import Limits
    from clrt.cluster.pictures import render, sweep
    from clrt.device.info import DeviceInfo
    from clrt.device.platforms import devices
    from clrt.device.settings import Settings
    from clrt.engine.answers import Crossings, Hits
    from clrt.engine.campath import camera_path, turntable
    from clrt.engine.raymesh import RayMeshIntersector
    from clrt.engine.tracer import Tracer
    from clrt.formats import load_dict
    from clrt.formats.shipped import load
    from clrt.images.image import Image, read_image
    from clrt.images.views import views
    from clrt.judging.verdict import Verdict, compare
    from clrt.raytree.tree import RayTree
    from clrt.scene.camera import Camera
    from clrt.scene.scene import Scene
    from clrt.view.notebook import widget

_HOMES = {
    "clrt.base.errors": ("ClrtError", "ClrtWarning", "DeviceError", "LimitError", "SceneError"),
    "clrt.formats": ("load_dict",),
    "clrt.images.image": ("Image", "read_image"),
    "clrt.images.views": ("views",),
    "clrt.base.limits": ("Limits",),
    "clrt.device.info": ("DeviceInfo",),
    "clrt.device.platforms": ("devices",),
    "clrt.engine.raymesh": ("RayMeshIntersector",),
    "clrt.engine.campath": ("camera_path", "turntable"),
    "clrt.scene.camera": ("Camera",),
    "clrt.scene.scene": ("Scene",),
    "clrt.device.settings": ("Settings",),
    "clrt.formats.shipped": ("load",),
    "clrt.judging.verdict": ("Verdict", "compare"),
    "clrt.engine.answers": ("Crossings", "Hits"),
    "clrt.raytree.tree": ("RayTree",),
    "clrt.engine.tracer": ("Tracer",),
    "clrt.cluster.pictures": ("render", "sweep"),
    "clrt.view.notebook": ("widget",),
}
_HOME = {name: home for home, names in _HOMES.items() for name in names}

__all__ = [
    "Camera", "ClrtError", "ClrtWarning", "Crossings", "DeviceError", "DeviceInfo", "Hits", "Image",
    "LimitError", "Limits", "RayMeshIntersector", "RayTree", "Scene", "SceneError", "Settings", "Tracer",
    "Verdict", "__version__", "camera_path", "compare", "devices", "load", "load_dict", "read_image",
    "render", "sweep", "turntable", "views", "widget",
]  # fmt: skip


if not TYPE_CHECKING:  # to whom each name that there is not would be one, of type Any

    def __getattr__(name: str) -> Any:
        if name not in _HOME:
            raise AttributeError(f"module 'clrt' has no attribute {name!r}")
        value = getattr(import_module(_HOME[name]), name)
        globals()[name] = value
        return value


def _live(shown: Any) -> dict[str, Any]:
    from clrt.view.notebook import live

    return live(shown)


display.live = _live


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
