"""Scenes as commands are told of them: files, names of those that ship, and `-`, which is standard input."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Final

from clrt.base.errors import ClrtError
from clrt.base.resources import scene_file

if TYPE_CHECKING:
    from clrt.base.limits import Limits
    from clrt.scene.scene import Scene

STREAM: Final = "-"
NAME: Final = "standard input"  # what messages call it


def scene_path(name: str) -> Path:
    """Where a scene is; `-` stays itself. SceneError names the nearest of those that ship."""
    return Path(STREAM) if name == STREAM else scene_file(name)


def read(path: Path, limits: Limits | None = None) -> Scene:
    """The scene there. SceneError, LimitError; ClrtError where there is no standard input."""
    from clrt.base.limits import Limits
    from clrt.formats.native import load_stream
    from clrt.formats.shipped import load_scene

    if str(path) != STREAM:
        return load_scene(path, limits=limits)
    if sys.stdin is None or sys.stdin.closed:
        raise ClrtError("-: standard input is closed; give a scene's file or name")
    try:
        return load_stream(sys.stdin.buffer, NAME, limits or Limits())
    except OSError as error:
        raise ClrtError(f"-: standard input cannot be read: {error.strerror or error}") from None


def stem(path: Path) -> str:
    """What a scene is called beside a progress bar and in names of files."""
    return "scene" if str(path) == STREAM else path.stem
