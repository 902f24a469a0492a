"""Scenes as files: the project's own TOML and JSON, as `clrt.formats.native` reads them."""

from __future__ import annotations

import filecmp
import json
import os
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

from clrt.base import notices, toml_scan
from clrt.base.atomic import replacing
from clrt.base.errors import LimitError, SceneError, located, show
from clrt.base.limits import Limits
from clrt.base.places import At
from clrt.scene.mesh import Mesh
from clrt.scene.textures import PICTURED

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
        text = "a scene is saved as .toml or .json (`clrt convert` writes .xml, .pov and .nff, too)"
        raise SceneError(located(str(path), "", text))
    table = moved(scene, path)
    text = tomli_w.dumps(table) if suffix == ".toml" else json.dumps(table, indent=2) + "\n"
    try:
        data = text.encode("utf-8")
    except UnicodeEncodeError as error:
        what = f"{show(text[error.start : error.end])} is half a character; no file can hold it"
        raise SceneError(located(str(path), "", what)) from None
    try:
        Limits().check("text_bytes", len(data))
        if suffix == ".toml":
            toml_scan.check(text, Limits(), "")
    except LimitError as error:  # whoever raised limits may do so again
        notices.warn(str(path), "", f"it is not read again without more than usual: {error}")
    return data


def moved(scene: Scene, path: Path, whole: bool = False) -> dict[str, Any]:
    """The scene's dict with the names of its files as seen from the folder of `path`.

    Meshes that lie elsewhere are in it themselves; `whole`: all are.
    """
    table = scene.to_dict()
    old, new = (scene.folder or Path()).resolve(), Path(os.path.realpath(path)).parent
    if old != new:
        _rename_pictures(scene, table, path, old, new)
    for shape, entry in zip(scene.shapes, table.get("shapes", ()), strict=True):
        if not isinstance(shape, Mesh) or shape.file is None or (old == new and not whole):
            continue
        file = (old / shape.file).resolve()
        if file.is_relative_to(new) and not whole:
            entry["file"] = file.relative_to(new).as_posix()
        else:
            del entry["file"]
            entry.pop("part", None)
            entry |= shape.data().to_dict()
    return table


def _rename_pictures(scene: Scene, table: dict[str, Any], path: Path, old: Path, new: Path) -> None:
    """Name pictures in the scene's dict as seen from the folder `new`."""
    if scene.background_path is not None:
        table["background"] = _seen_from(new, old, str(scene.background), At(str(path), "background"))
    for place, material in _materials(table, At(str(path))):
        for key in (*PICTURED, "normal_map"):
            picture = material.get(key)
            if isinstance(picture, dict) and "file" in picture:
                where = place.key(key).key("file")
                material[key] = picture | {"file": _seen_from(new, old, picture["file"], where)}


def _seen_from(new: Path, old: Path, name: str, at: At) -> str:
    """The name of a file of folder `old` as seen from `new`; SceneError where not even a copy is there."""
    file, there = (old / name).resolve(), (new / name).resolve()
    if file.is_relative_to(new):
        return file.relative_to(new).as_posix()
    if not (there.is_relative_to(new) and there.exists()):
        raise at.says(f"{name!r} is not in {new}; copy the image there, or save the scene in {old}")
    if there.is_file() and file.is_file() and filecmp.cmp(file, there, shallow=False):
        return name
    text = f"{name!r} in {new} is another file than the one in {old}"
    raise at.says(f"{text}; copy the image over it, rename one, or save the scene in {old}")


def _materials(table: dict[str, Any], at: At) -> Iterator[tuple[At, dict[str, Any]]]:
    """The materials of a scene's dict: those by name, and those that shapes have of their own."""
    for name, material in table.get("materials", {}).items():
        yield at.key("materials").key(name), material
    for index, shape in enumerate(table.get("shapes", ())):
        if isinstance(shape.get("material"), dict):
            yield at.key("shapes").item(index).key("material"), shape["material"]
