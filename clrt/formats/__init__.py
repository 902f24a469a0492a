"""Scene files in and out: one module a format, chosen by the file's suffix."""

from __future__ import annotations

import inspect
import os
from collections.abc import Callable
from importlib import import_module
from pathlib import Path
from types import NoneType
from typing import Any, Final

from clrt.base import arguments
from clrt.base.errors import SceneError, fault, located, show
from clrt.base.files import open_input
from clrt.base.limits import Limits
from clrt.base.notices import bounded
from clrt.base.places import listed
from clrt.base.suggest import did_you_mean
from clrt.meshfiles import SUFFIXES
from clrt.scene.scene import Scene, read_scene

READERS: Final = {
    ".toml": "native",
    ".json": "native",
    ".nff": "nff.reader",
    ".txt": "thesis",
    ".xml": "mitsuba.scene",
    **dict.fromkeys(SUFFIXES, "mesh"),
}
"""By suffix: the module whose `load` is a function of (path, limits, **options); imported when needed."""


def load_file(path: Path, limits: Limits, **options: Any) -> Scene:
    """The scene in a file, read as its suffix says. Raises `SceneError` and `LimitError`."""
    reader = READERS.get(path.suffix.lower())
    if reader is None:
        what = "this is a folder" if os.path.isdir(path) else f"the suffix {show(path.suffix)} is not known"
        text = f"{what}; scenes are {listed(READERS)} files"
        raise SceneError(located(str(path), "", text))
    loader: Callable[..., Scene] = import_module(f"clrt.formats.{reader}").load
    asked = inspect.signature(loader).parameters
    known = [name for name in asked if name not in ("path", "limits")]
    for name, value in options.items():
        if name not in known:
            text = f"there is no option {name!r} for {path.suffix} files{did_you_mean(name, known)}"
            raise SceneError(located(str(path), "", text))
        flag = "bool" in str(asked[name].annotation)
        if not isinstance(value, (bool if flag else str, NoneType)):
            right = "it must be True, False or None" if flag else "it must be a text or None"
            raise SceneError(fault(str(path), name, value, right))
    with open_input(path):  # or the error of a name that is no regular file's
        pass
    with bounded(path.name):
        return loader(path, limits, **options)


@arguments.public
def load_dict(
    data: object, *, folder: str | Path | None = None, source: str = "", limits: Limits | None = None
) -> Scene:
    """The scene that a dict describes: the structure of the scene files, lists or numpy arrays alike.

    `folder` is where the files it names are looked up (None: the current folder), `source` the name that
    messages start with, `limits` what reading may cost. Raises `SceneError` and `LimitError`, and ClrtError
    for arguments of another kind.
    """
    limits = arguments.optional_instance("limits", limits, Limits)
    where = arguments.optional_path("folder", folder)
    source = arguments.text("source", source)
    with bounded(source):
        return read_scene(data, folder=where, source=source, limits=limits)
