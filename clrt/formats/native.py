"""The project's own scene files: TOML and JSON of the same structure."""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Iterable
from functools import partial
from pathlib import Path
from typing import Any, BinaryIO, Final, NoReturn, TypeVar

import tomli

from clrt.base import toml_scan
from clrt.base.collector import no_collections
from clrt.base.errors import LimitError, SceneError, located, show
from clrt.base.files import read_text_bytes
from clrt.base.limits import Limits
from clrt.base.mark import unmarked
from clrt.base.notices import bounded
from clrt.base.places import At, PlacedError
from clrt.base.unique import unique
from clrt.formats.lines import json_line, toml_key, toml_line
from clrt.scene.scene import Scene, edited, read_scene

T = TypeVar("T")

_MOST_DIGITS: Final = 6  # of how many values a range asks for
_DEEP: Final = "nesting: deeper than Python's own readers follow, whatever the limit"


def load(path: Path, limits: Limits) -> Scene:
    """The scene in a .toml or .json file."""
    toml = path.suffix.lower() == ".toml"
    fetch = partial(read_text_bytes, path, limits)
    return _read(fetch, toml, path.name, limits, partial(_scene, path.parent, path.name, limits))


def load_other(path: Path, limits: Limits, make: Callable[[Any], T]) -> T:
    """What `make` makes of the tables in another .toml or .json file; faults name their lines."""
    with bounded(path.name):
        fetch = partial(read_text_bytes, path, limits)
        return _read(fetch, path.suffix.lower() == ".toml", path.name, limits, make)


def load_stream(stream: BinaryIO, source: str, limits: Limits) -> Scene:
    """The scene that comes from a stream, as TOML, or as JSON if it begins with a brace.

    Files that it names are looked up in the current folder. LimitError for more than `limits.text_bytes`.
    """
    data = stream.read(limits.text_bytes + 1)
    limits.check("text_bytes", len(data), source)
    toml = not unmarked(data).lstrip().startswith(b"{")
    with bounded(source):
        return _read(lambda: data, toml, source, limits, partial(_scene, Path(), source, limits))


def load_text(text: str, source: str, folder: Path, limits: Limits) -> Scene:
    """The scene that a text of JSON describes."""
    return _read(lambda: text.encode(), False, source, limits, partial(_scene, folder, source, limits))


def _scene(folder: Path, source: str, limits: Limits, table: Any) -> Scene:
    return read_scene(table, folder=folder, source=source, limits=limits)


def _read(
    fetch: Callable[[], bytes], toml: bool, source: str, limits: Limits, make: Callable[[Any], T]
) -> T:
    text = _text(fetch(), source)
    try:
        with no_collections():
            if toml:
                toml_scan.check(text, limits, source)
                table = tomli.loads(text)
            else:
                table = _parse_json(text)
    except RecursionError:
        raise LimitError(located(source, "", _DEEP)) from None
    except ValueError as error:  # TOML and JSON errors both carry the line
        raise SceneError(located(source, "", f"wrong syntax: {error}{_named(text, error)}")) from None
    del text  # as large as what is made of it now
    limits.check("nesting", _depth(table, limits.nesting + 1), source)
    try:
        return make(table)
    except PlacedError as error:
        text = _text(fetch(), source)
        line = (toml_line if toml else json_line)(text, error.path)
        if line is None or error.at.source != source:
            raise
        raise PlacedError(At(f"{source}:{line}", error.at.path), error.text) from None


def with_values(scene: Scene, given: Iterable[tuple[str, str]]) -> Scene:
    """A scene with other values at some places (`Scene.replace`), each as TOML writes it, else a text."""
    changes = {place: _value(text, scene.limits, place) for place, text in given}
    return edited(scene, changes) if changes else scene


def value_list(text: str, limits: Limits, source: str) -> list[Any]:
    """Several values: `20:60:5` (5 from 20 to 60), or as TOML writes them with commas between, else texts."""
    number = r"\s*([+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?)\s*"
    found = re.fullmatch(rf"{number}:{number}:\s*([0-9]+)\s*", text)
    if found:
        first, last, digits = float(found[1]), float(found[2]), found[3].lstrip("0")
        if not 1 <= len(digits) <= _MOST_DIGITS:
            asked = "too many values" if digits else "no value"
            right = f"FIRST:LAST:COUNT, COUNT from 1 to {10**_MOST_DIGITS - 1}"
            raise SceneError(located(source, "", f"{show(text)} asks for {asked}; {right}"))
        count = int(digits)
        step = (last - first) / max(count - 1, 1)
        values = [first + step * k for k in range(count)]
        plain = all(end.lstrip("+-").isdecimal() for end in found.groups()[:2]) and step == int(step)
        return [int(value) for value in values] if plain else values
    if text.count(":") in (1, 2) and re.match(r"\s*[+-]?[0-9.][^,\"']*:", text):
        right = "FIRST:LAST:COUNT are two numbers and how many values, such as 20:60:5"
        raise SceneError(located(source, "", f"{show(text)} is no range; {right}"))
    values = _value(f"[{text}]", limits, source)
    if isinstance(values, list) and values:
        return values
    return [_value(part.strip(), limits, source) for part in text.split(",")]


def _value(text: str, limits: Limits, source: str) -> Any:
    """One value: 30, [0, 1, 0], true, {color = 0.5}, "glass", glass."""
    line = f"x = {text}"
    try:
        toml_scan.check(line, limits, source)
        table = tomli.loads(line)
    except RecursionError:
        raise LimitError(located(source, "", _DEEP)) from None
    except ValueError:
        return text
    return table["x"] if len(table) == 1 else text


def _text(data: bytes, source: str) -> str:
    data = unmarked(data)
    try:
        return data.decode("utf-8")
    except UnicodeDecodeError as error:
        line = data.count(b"\n", 0, error.start) + 1
        raise SceneError(located(source, "", f"line {line} is not UTF-8 text")) from None


def _named(text: str, error: ValueError) -> str:
    """'; ...' on what stands twice, or on a backslash, where an error says no more than its line."""
    if re.search(r"hex value|escape", str(error)):
        return '; within "" a backslash begins an escape: write names of files with /'
    place = re.search(r"(?:overwrite|twice|mutate).*\(at line (\d+), column", str(error))
    name = toml_key(text, int(place[1])) if place else ""
    return f"; {show(name)} is there already" if name else ""


def _parse_json(text: str) -> Any:
    return json.loads(text, object_pairs_hook=unique, parse_constant=_no_constant)


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
