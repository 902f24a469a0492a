"""Scene files in and out: one module a format, chosen by the file's suffix."""

from __future__ import annotations

import inspect
import os
from collections.abc import Callable
from pathlib import Path
from types import NoneType
from typing import Any

from clrt.base import arguments
from clrt.base.errors import SceneError, fault, located, show
from clrt.base.files import open_input
from clrt.base.limits import Limits
from clrt.base.notices import bounded
from clrt.base.places import listed
from clrt.base.suggest import did_you_mean
from clrt.formats import mesh, mitsuba, native, nff, thesis
from clrt.meshfiles.file import MESH_SUFFIXES
from clrt.scene.scene import Scene, read_scene

LOADERS: dict[str, Callable[..., Scene]] = {
    ".toml": native.load,
    ".json": native.load,
    ".nff": nff.load,
    ".txt": thesis.load,
    ".xml": mitsuba.load,
    **dict.fromkeys(MESH_SUFFIXES, mesh.load),
}
"""By suffix: functions of (path, limits, **options)."""


def load_file(path: Path, limits: Limits, **options: Any) -> Scene:
    """The scene in a file, read as its suffix says. Raises `SceneError` and `LimitError`."""
    loader = LOADERS.get(path.suffix.lower())
    if loader is None:
        what = "this is a folder" if os.path.isdir(path) else f"the suffix {show(path.suffix)} is not known"
        text = f"{what}; scenes are {listed(LOADERS)} files"
        raise SceneError(located(str(path), "", text))
    known = [name for name in inspect.signature(loader).parameters if name not in ("path", "limits")]
    for name, value in options.items():
        if name not in known:
            text = f"there is no option {name!r} for {path.suffix} files{did_you_mean(name, known)}"
            raise SceneError(located(str(path), "", text))
        if not isinstance(value, (str, bool, NoneType)):
            raise SceneError(fault(str(path), name, value, "it must be a text, True or False"))
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
