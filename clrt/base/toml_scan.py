"""What a TOML file declares, counted before it is parsed.

The parser takes time with the square of a dotted key's parts, 140 bytes for each character of a number, and
about 700 bytes for each table and array that has a name, however short. All are bounded here, in time and
memory linear in the text. What is no TOML is left to the parser, which stops where the syntax ends.
"""

from __future__ import annotations

import re
from typing import Final

import numpy as np

from clrt.base.errors import SceneError, located, show
from clrt.base.limits import Limits, written

# Strings and comments, closed or not: each match is final, so that no text is gone through twice.
_LITERAL: Final = re.compile(
    r"""
    \"{3} (?: [^"\\]++ | \\. | "{1,2}(?!") )*+ (?:"{3,5})?
    | '{3} (?: [^']++ | '{1,2}(?!') )*+ (?:'{3,5})?
    | " (?: [^"\\\n]++ | \\[^\n] )*+ "?
    | ' [^'\n]*+ '?
    | \# [^\n]*+
    """,
    re.VERBOSE | re.DOTALL,
)
_MARK: Final = '"'  # stands for a literal
_DOTTED: Final = r'[\w"-]++(?:[ \t]*+\.[ \t]*+[\w"-]++)++'
_LONG_KEY: Final = re.compile(rf'(?<![\w".-]){_DOTTED}', re.ASCII)
_DOTTED_KEY: Final = re.compile(rf"^[ \t]*+({_DOTTED})[ \t]*+=", re.ASCII | re.MULTILINE)
_INNER_KEY: Final = re.compile(rf'(?<![\w".-])({_DOTTED})[ \t]*+=', re.ASCII)
_LONG_NUMBER: Final = re.compile(r"(?<![\w.+-])[+-]?[0-9][\w.+-]{4300,}+", re.ASCII)  # Python's own limit
_NAMED: Final = re.compile(r"=[ \t]*+[\[{]")


def check(text: str, limits: Limits, source: str) -> None:
    """Raise `LimitError` for tables and arrays too deep or too many, `SceneError` for a number too long."""
    bare = _LITERAL.sub(_MARK, text).encode("ascii", "replace")
    signs = np.frombuffer(bare, np.uint8)
    step = np.zeros(len(signs), np.int8)
    for sign in b"[{":
        step[signs == sign] = 1
    for sign in b"]}":
        step[signs == sign] = -1
    depth = np.cumsum(step, dtype=np.int32)
    limits.check("nesting", 1 + int(depth.max(initial=0)), source)
    outline = bare.decode("ascii")
    parts = max((key.group().count(".") for key in _LONG_KEY.finditer(outline)), default=0) + 1
    limits.check("nesting", parts, source)
    long = _LONG_NUMBER.search(outline)
    if long:
        size = len(long.group())
        what = f"{show(long.group(), 20)} is a number of {written(size)} characters; 4300 are read at most"
        raise SceneError(located(source, "", what))
    opening = np.flatnonzero((step == 1) & (depth == 1)).tolist()
    closing = np.flatnonzero((step == -1) & (depth == 0)).tolist()
    limits.check("tables", _outer_tables(outline, opening, closing), source)
    limits.check("tables", _inner_tables(outline, step, depth), source)


def _outer_tables(outline: str, opening: list[int], closing: list[int]) -> int:
    """How many named tables and arrays the parser would remember at a time, at most, outside of values.

    `opening` and `closing` are the places of the outermost brackets: those of headers and of values. With a
    new item of an array of tables the parser forgets what the last one held.
    """
    most = total = 0
    first: str | None = None  # the first part of the header that holds
    held: dict[str | None, int] = {None: 0}
    end = 0
    for start, stop in zip(opening, closing, strict=False):
        between = outline[end:start]
        found = _dots(between)
        if between.rpartition("\n")[2].strip():  # after `key =`
            found += 1
        else:
            held[first] += found
            total += found
            header = outline[start : stop + 1]
            parts = header.strip("[] \t").split(".")
            first, found = parts[0].strip(), len(parts)
            if first in held and first != _MARK:  # in quotes it may be another
                found -= 1
            if header.startswith("[[") and len(parts) == 1 and first != _MARK:
                total -= held.get(first, 0)
                held[first] = 0
            held.setdefault(first, 0)
        held[first] += found
        total += found
        most = max(most, total)
        end = stop + 1
    return max(most, total + _dots(outline[end:]))


def _dots(outline: str) -> int:
    """How many dots the keys have: each asks for a table."""
    if "." not in outline:
        return 0
    return sum(key.group(1).count(".") for key in _DOTTED_KEY.finditer(outline))


def _inner_tables(outline: str, step: np.ndarray, depth: np.ndarray) -> int:
    """The same within values: of an inline table and those around it together, which end with it."""
    named = np.fromiter((found.end() - 1 for found in _NAMED.finditer(outline)), np.int64)
    dotted = np.fromiter((key.start() for key in _INNER_KEY.finditer(outline)), np.int64)
    dots = np.fromiter((key.group(1).count(".") for key in _INNER_KEY.finditer(outline)), np.int64)
    places = np.concatenate([named, dotted])
    around = np.concatenate([depth[named] - 1, depth[dotted]])  # brackets about each
    weights = np.concatenate([np.ones(len(named), np.int64), dots])
    outer, held = np.zeros(1, np.int64), np.zeros(1, np.int64)  # the brackets of a depth, what they hold
    most = 0
    for level in range(1, int(around.max(initial=0)) + 1):
        brackets = np.flatnonzero((step == 1) & (depth == level))
        which = around == level
        owner = np.searchsorted(brackets, places[which]) - 1
        own = np.bincount(owner, weights[which], len(brackets)).astype(np.int64)
        held = own + held[np.searchsorted(outer, brackets) - 1]
        outer = brackets
        most = max(most, int(held.max()))
    return most
