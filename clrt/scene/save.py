"""Scenes as files: the project's own TOML and JSON, as `clrt.formats.native` reads them."""

from __future__ import annotations

import json
import os
from pathlib import Path
from typing import TYPE_CHECKING, Any

from clrt.base.atomic import replacing
from clrt.base.errors import SceneError, located, show
from clrt.scene.mesh import Mesh

if TYPE_CHECKING:
    from clrt.scene.scene import Scene


def save(scene: Scene, path: Path) -> None:
    """Write the scene as `Scene.save` promises."""
    data = encoded(scene, path)
    with replacing(path) as temporary:
        temporary.write_bytes(data)


def encoded(scene: Scene, path: Path) -> bytes:
    """What a file of this name holds of the scene: names of other files are as seen from its folder."""
    import tomli_w  # which only those who save need

    suffix = path.suffix.lower()
    if suffix not in (".toml", ".json"):
        text = "a scene is saved as .toml or .json (`clrt convert` writes .xml and .pov, too)"
        raise SceneError(located(str(path), "", text))
    table = _moved(scene, path)
    text = tomli_w.dumps(table) if suffix == ".toml" else json.dumps(table, indent=2) + "\n"
    try:
        return text.encode("utf-8")
    except UnicodeEncodeError as error:
        what = f"{show(text[error.start : error.end])} is half a character; no file can hold it"
        raise SceneError(located(str(path), "", what)) from None


def _moved(scene: Scene, path: Path) -> dict[str, Any]:
    """The scene's dict with the names of its files as seen from the folder of `path`."""
    table = scene.to_dict()
    old, new = (scene.folder or Path()).resolve(), Path(os.path.realpath(path)).parent
    if old == new:
        return table
    if scene.background_path is not None:
        if not scene.background_path.is_relative_to(new):
            text = f"{scene.background!r} is not in {new}; copy the image there, or save the scene in {old}"
            raise SceneError(located(str(path), "background", text))
        table["background"] = scene.background_path.relative_to(new).as_posix()
    for shape, entry in zip(scene.shapes, table.get("shapes", ()), strict=True):
        if not isinstance(shape, Mesh) or shape.file is None:
            continue
        file = (old / shape.file).resolve()
        if file.is_relative_to(new):
            entry["file"] = file.relative_to(new).as_posix()
        else:
            del entry["file"]
            entry.pop("part", None)
            entry |= shape.data().to_dict()
    return table
