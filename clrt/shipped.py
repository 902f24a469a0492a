"""The scenes that ship with the package, loaded by name: files, and scripts that generate the large ones."""

from __future__ import annotations

import runpy
from pathlib import Path

from clrt.formats import load, load_dict
from clrt.limits import Limits
from clrt.resources import scene_file, shipped_scenes
from clrt.scene import Scene


def load_scene(name: str | Path, limits: Limits | None = None) -> Scene:
    """The scene of a file, or of a shipped scene's name. Raises `SceneError` and `LimitError`.

    Only scripts that ship with the package are run; any other .py file is an error, as for `clrt.load`.
    """
    file = scene_file(str(name))
    if file.suffix == ".py" and file.resolve() in shipped_scenes().values():
        return generate(file, limits)
    return load(file, limits=limits)


def generate(script: Path, limits: Limits | None = None) -> Scene:
    """The scene that a script's `scene() -> dict` describes; the files it names lie beside the script."""
    # Unlike an import, this leaves no __pycache__ in a folder that may be read-only.
    names = runpy.run_path(str(script), run_name="clrt_scene")
    return load_dict(names["scene"](), folder=script.parent, source=script.name, limits=limits)
