"""Scene files in and out: one module a format, chosen by the file's suffix."""

from __future__ import annotations

import inspect
import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

from clrt.errors import SceneError, located, show
from clrt.files import open_input
from clrt.formats import mesh, native, nff, thesis
from clrt.limits import Limits
from clrt.meshfile import MESH_SUFFIXES
from clrt.notices import bounded
from clrt.places import listed
from clrt.scene import Scene, read_scene
from clrt.suggest import did_you_mean

LOADERS: dict[str, Callable[..., Scene]] = {
    ".toml": native.load,
    ".json": native.load,
    ".nff": nff.load,
    ".txt": thesis.load,
    **dict.fromkeys(MESH_SUFFIXES, mesh.load),
}
"""By suffix: functions of (path, limits, **options)."""


def load(path: str | Path, *, limits: Limits | None = None, **options: Any) -> Scene:
    """The scene in a file, read as its suffix says.

    .toml and .json are the project's own; .nff takes `conformance` ("none" or "spd"); .txt are scenes of
    the thesis' program; mesh files (.obj .ply .glb .gltf .stl) take `smooth` and get a camera and a light.
    `limits` is what reading may cost. Raises `SceneError` and `LimitError`.
    """
    path = Path(path)
    loader = LOADERS.get(path.suffix.lower())
    if loader is None:
        what = "this is a folder" if os.path.isdir(path) else f"the suffix {show(path.suffix)} is not known"
        text = f"{what}; scenes are {listed(LOADERS)} files"
        raise SceneError(located(str(path), "", text))
    known = [name for name in inspect.signature(loader).parameters if name not in ("path", "limits")]
    for name in options:
        if name not in known:
            text = f"there is no option {name!r} for {path.suffix} files{did_you_mean(name, known)}"
            raise SceneError(located(str(path), "", text))
    with open_input(path):  # or the error of a name that is no regular file's
        pass
    with bounded(path.name):
        return loader(path, limits or Limits(), **options)


def load_dict(
    data: object, *, folder: str | Path | None = None, source: str = "", limits: Limits | None = None
) -> Scene:
    """The scene that a dict describes: the structure of the scene files, lists or numpy arrays alike.

    `folder` is where the files it names are looked up (None: the current folder), `source` the name that
    messages start with. Raises `SceneError` and `LimitError`.
    """
    with bounded(source):
        return read_scene(data, folder=Path(folder) if folder else None, source=source, limits=limits)
