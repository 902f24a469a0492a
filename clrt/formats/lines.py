"""In which line of a scene file a place such as `shapes[3].radius` stands.

Parsers give values without places. So this is asked only once something is wrong, of a text that has been
parsed before, and answers with the deepest part of the place that has a line of its own.
"""

from __future__ import annotations

import json
import re
from typing import Final

Steps = tuple[str | int, ...]

_STEP: Final = re.compile(r"\.?([\w-]+)|\[(\d+)\]")
_PLAIN: Final = re.compile(rf"(?:{_STEP.pattern})*")
_KEY: Final = r"""(?:[\w-]+|"[^"\\]*"|'[^']*')"""
_NAME: Final = rf"{_KEY}(?:\s*\.\s*{_KEY})*"
_HEADER: Final = re.compile(rf"\s*(\[\[?)\s*({_NAME})\s*\]\]?\s*(?:#.*)?$")
_ENTRY: Final = re.compile(rf"\s*({_NAME})\s*=(.*)$")
# strings, comments; what could give back a character would take 100 bytes for each
_ASIDE: Final = re.compile(r""""(?:[^"\\]++|\\.)*+"|'[^']*'|#.*""")
_SPACE: Final = re.compile(r"[\s:,]*")


def toml_line(text: str, path: str) -> int | None:
    """The line, from 1 on, of a place in a TOML text; None where it cannot be told."""
    if '"""' in text or "'''" in text:
        return None  # what looks like a key there may be a part of a text
    lines: dict[Steps, int] = {}
    wholes: dict[Steps, int] = {}  # [[shapes]] as a whole, or a of [a.b]: where it begins
    counts: dict[Steps, int] = {}  # tables of each [[array]] so far
    table: Steps = ()
    depth = 0  # of brackets that a value has left open
    for number, line in enumerate(text.split("\n"), 1):
        header, entry = _HEADER.match(line), _ENTRY.match(line)
        if depth == 0 and header:
            table = _table(counts, _names(header[2]), header[1] == "[[")
            lines.setdefault(table, number)
            for end in range(1, len(table)):
                wholes.setdefault(table[:end], number)
        elif depth == 0 and entry:
            names = _names(entry[1])
            for end in range(1, len(names) + 1):
                lines.setdefault((*table, *names[:end]), number)
            depth = _opened(entry[2])
        elif depth:
            depth += _opened(line)
    steps = _steps(path)
    if steps not in lines and steps in wholes and _PLAIN.fullmatch(path):  # not of an item that is not there
        return wholes[steps]
    return next((lines[steps[:end]] for end in range(len(steps), 0, -1) if steps[:end] in lines), None)


def json_line(text: str, path: str) -> int | None:
    """The line, from 1 on, of a place in a JSON text; None where it cannot be told."""
    decoder, at = json.JSONDecoder(), _skip(text, 0)
    found = None
    for step in _steps(path):
        inner = _into(decoder, text, at, step)
        if inner is None:
            break
        found, at = inner
    return None if found is None else text.count("\n", 0, found) + 1


def toml_key(text: str, line: int) -> str:
    """The key or the table that a line of a TOML text names, or "" for none."""
    row = text.split("\n")[line - 1]
    match = _HEADER.match(row) or _ENTRY.match(row)
    return "" if match is None else match[2 if match.re is _HEADER else 1]


def _into(decoder: json.JSONDecoder, text: str, at: int, step: str | int) -> tuple[int, int] | None:
    """Where the entry `step` of the value at `at` begins, key included, and where its value does."""
    if text[at] != ("{" if isinstance(step, str) else "["):
        return None
    at, index = _skip(text, at + 1), 0
    while text[at] not in "}]":
        begin, name = at, index if isinstance(step, int) else ""
        if isinstance(step, str):
            name, at = decoder.raw_decode(text, at)
            at = _skip(text, at)
        if name == step:
            return begin, at
        at, index = _skip(text, decoder.raw_decode(text, at)[1]), index + 1
    return None


def _skip(text: str, at: int) -> int:
    match = _SPACE.match(text, at)
    assert match is not None  # it matches nothing, too
    return match.end()


def _steps(path: str) -> Steps:
    """A path's keys and indices, as far as they are plain."""
    steps: list[str | int] = []
    at = 0
    while match := _STEP.match(path, at):
        steps.append(match[1] if match[1] is not None else int(match[2]))
        at = match.end()
    return tuple(steps)


def _names(dotted: str) -> list[str]:
    return [name.strip("\"'") for name in re.findall(_KEY, dotted)]


def _table(counts: dict[Steps, int], names: list[str], is_item: bool) -> Steps:
    """The place of the table that a header opens, in the last item of each array on its way."""
    place: Steps = ()
    for number, name in enumerate(names, 1):
        place = (*place, name)
        if is_item and number == len(names):
            counts[place] = counts.get(place, 0) + 1
        if place in counts:
            place = (*place, counts[place] - 1)
    return place


def _opened(text: str) -> int:
    """How many more brackets a line opens than it closes."""
    bare = _ASIDE.sub("", text)
    return bare.count("[") + bare.count("{") - bare.count("]") - bare.count("}")
