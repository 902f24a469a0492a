"""Scene files in and out: one module a format, chosen by the file's suffix."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from clrt.errors import SceneError, located
from clrt.formats import native
from clrt.limits import Limits
from clrt.scene import Scene, read_scene


def load(path: str | Path, *, limits: Limits | None = None, **options: Any) -> Scene:
    """The scene in a file. Raises `SceneError` and `LimitError`."""
    path = Path(path)
    if path.suffix.lower() in (".toml", ".json"):
        return native.load(path, limits or Limits())
    raise SceneError(located(str(path), "", "no known suffix"))


def load_dict(
    data: object, *, folder: str | Path | None = None, source: str = "", limits: Limits | None = None
) -> Scene:
    """The scene that a dict describes: the structure of the scene files, lists or numpy arrays alike."""
    return read_scene(data, folder=Path(folder) if folder else None, source=source, limits=limits)
