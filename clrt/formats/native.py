"""The project's own scene files: TOML and JSON of the same structure."""

from __future__ import annotations

import json
import os
import re
from pathlib import Path
from typing import Any, NoReturn

import tomli
import tomli_w

from clrt.atomic import replacing
from clrt.collector import no_collections
from clrt.errors import LimitError, SceneError, located, show
from clrt.files import read_text_bytes
from clrt.formats import toml_scan
from clrt.formats.lines import json_line, toml_key, toml_line
from clrt.limits import Limits
from clrt.places import At, PlacedError
from clrt.scene import Mesh, Scene, read_scene


def load(path: Path, limits: Limits) -> Scene:
    """The scene in a .toml or .json file."""
    source = path.name
    toml = path.suffix.lower() == ".toml"
    text = _text(read_text_bytes(path, limits), source)
    try:
        with no_collections():
            if toml:
                toml_scan.check(text, limits, source)
                table = tomli.loads(text)
            else:
                table = _parse_json(text)
    except RecursionError:
        raise LimitError(located(source, "", f"nesting: deeper than the limit of {limits.nesting}")) from None
    except ValueError as error:  # TOML and JSON errors both carry the line
        raise SceneError(located(source, "", f"wrong syntax: {error}{_named(text, error)}")) from None
    del text  # as large as what is made of it now
    limits.check("nesting", _depth(table, limits.nesting + 1), source)
    try:
        return read_scene(table, folder=path.parent, source=source, limits=limits)
    except PlacedError as error:
        text = _text(read_text_bytes(path, limits), source)
        line = (toml_line if toml else json_line)(text, error.path)
        if line is None or error.at.source != source:
            raise
        raise PlacedError(At(f"{source}:{line}", error.at.path), error.text) from None


def save(scene: Scene, path: Path) -> None:
    """Write the scene as `Scene.save` promises."""
    suffix = path.suffix.lower()
    if suffix not in (".toml", ".json"):
        text = "a scene is saved as .toml or .json (`clrt convert` writes Mitsuba's .xml, too)"
        raise SceneError(located(str(path), "", text))
    table = _moved(scene, path)
    text = tomli_w.dumps(table) if suffix == ".toml" else json.dumps(table, indent=2) + "\n"
    try:
        data = text.encode("utf-8")
    except UnicodeEncodeError as error:
        what = f"{show(text[error.start : error.end])} is half a character; no file can hold it"
        raise SceneError(located(str(path), "", what)) from None
    with replacing(path) as temporary:
        temporary.write_bytes(data)


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
            entry |= shape.data().to_dict()
    return table


def _text(data: bytes, source: str) -> str:
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = data.count(b"\n", 0, error.start) + 1
        raise SceneError(located(source, "", f"line {line} is not UTF-8 text")) from None


def _named(text: str, error: ValueError) -> str:
    """'; ...' on what stands twice, where a TOML error says no more than its line."""
    place = re.search(r"(?:overwrite|twice|mutate).*\(at line (\d+), column", str(error))
    name = toml_key(text, int(place[1])) if place else ""
    return f"; {show(name)} is there already" if name else ""


def _parse_json(text: str) -> Any:
    return json.loads(text, object_pairs_hook=_unique, parse_constant=_no_constant)


def _unique(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    table = dict(pairs)
    if len(table) < len(pairs):
        seen: set[str] = set()
        twice = next(key for key, _ in pairs if key in seen or seen.add(key))  # type: ignore[func-returns-value]
        raise ValueError(f"the key {show(twice)} stands twice in one table")
    return table


def _no_constant(name: str) -> NoReturn:
    raise ValueError(f"{name} is not allowed; numbers must be finite")


def _depth(value: Any, most: int) -> int:
    """How deeply tables and lists are nested; counts no further than `most`."""
    level, depth = [value] if isinstance(value, (dict, list)) else [], 1
    while level and depth < most:
        level = [
            item
            for part in level
            for item in (part.values() if isinstance(part, dict) else part)
            if isinstance(item, (dict, list))
        ]
        depth += bool(level)
    return depth
