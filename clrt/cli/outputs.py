"""Files that a command writes: none of them may take the place of what it reads, or of another one."""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

from clrt.base.errors import ClrtError

if TYPE_CHECKING:
    from clrt.scene.scene import Scene

Name = str | os.PathLike[str]


def check_apart(outputs: Mapping[str, Name], inputs: Mapping[str, Name]) -> None:
    """ClrtError where an output (by option) is one of the inputs (by what they are) or another output."""
    taken = {_place(file): what for what, file in inputs.items()}
    for option, file in outputs.items():
        what = taken.setdefault(_place(file), f"the file of {option}")
        if what != f"the file of {option}":
            raise ClrtError(f"{os.fspath(file)}: is {what}; give {option} a file of its own")


def check_spares(outputs: Mapping[str, Name], scene: Scene) -> None:
    """ClrtError where an output would take the place of a picture or a mesh that the scene names."""
    from clrt.scene.mesh import Mesh

    folder = scene.folder or Path()
    names = [scene.background_path] if scene.background_path else []
    names += [folder / shape.file for shape in scene.shapes if isinstance(shape, Mesh) and shape.file]
    check_apart(outputs, {f"{name}, which the scene reads": name for name in names})


def _place(file: Name) -> tuple[int, int] | str:
    """What two names of one file have in common; of one that is not there yet, its path."""
    try:
        status = os.stat(file)
    except (OSError, ValueError):
        return os.path.realpath(file)
    return status.st_dev, status.st_ino
