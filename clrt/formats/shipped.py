"""Scenes by what the user calls them: files, dicts, and the names of those that ship with the package."""

from __future__ import annotations

import os
import runpy
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from clrt.base import arguments
from clrt.base.arguments import public
from clrt.base.errors import ClrtError, SceneError, fault, located
from clrt.base.limits import Limits
from clrt.base.resources import scene_file, shipped_scenes
from clrt.formats import load_dict, load_file
from clrt.scene.scene import Scene


@public
def load(path: str | os.PathLike[str], *, limits: Limits | None = None, **options: Any) -> Scene:
    """The scene in a file, read as its suffix says, or the shipped scene of that name.

    Files: .toml and .json are the project's own; .nff takes `conformance` ("none" or "spd"); .txt are scenes
    of the thesis' program, .xml Mitsuba's; models (.obj .ply .glb .gltf .stl) take `smooth` (True, False,
    None) and `camera`, the name of one of theirs, and get a camera and a light where they have none. Names
    are those that `clrt scenes` lists, such as "showcase"; where there is no such file,
    "scenes/showcase.toml" means the same. Of .py files only those that ship with clrt are run.
    `limits` is what reading may cost. Raises `SceneError` and `LimitError`, and ClrtError for arguments of
    another kind.
    """
    file = scene_file(os.fspath(arguments.path("path", path)))
    limits = arguments.optional_instance("limits", limits, Limits)
    if file.suffix == ".py" and file.resolve() in shipped_scenes().values():
        if options:
            text = f"there is no option {next(iter(options))!r} for scenes that are generated"
            raise SceneError(located(str(file), "", text))
        return generate(file, limits)
    return load_file(file, limits, **options)


def load_scene(name: str | Path, limits: Limits | None = None) -> Scene:
    """As `load`, without options."""
    return load(name, limits=limits)


def as_scene(scene: object, limits: Limits | None = None) -> Scene:
    """What stands for a scene, as one: a Scene, a dict as `load_dict` takes it, or what `load` takes."""
    if isinstance(scene, Scene):
        return scene
    if isinstance(scene, Mapping):
        return load_dict(scene, limits=limits)
    if isinstance(scene, (str, os.PathLike)):
        return load(scene, limits=limits)
    right = "it must be a clrt.Scene, a dict of the scene files' structure, a file or a shipped scene's name"
    raise ClrtError(fault("", "scene", scene, right))


def generate(script: Path, limits: Limits | None = None) -> Scene:
    """The scene that a script's `scene() -> dict` describes; the files it names lie beside the script."""
    # Unlike an import, this leaves no __pycache__ in a folder that may be read-only.
    names = runpy.run_path(str(script), run_name="clrt_scene")
    return load_dict(names["scene"](), folder=script.parent, source=script.name, limits=limits)
