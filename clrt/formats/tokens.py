"""Words of a text file with their lines, for formats in which white space alone separates."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from clrt.errors import SceneError, located, show
from clrt.files import read_text_bytes
from clrt.limits import Limits
from clrt.planar import newell
from clrt.scene import Scene, read_scene


class Tokens:
    """The words of a file in order. `line` is that of the word taken last."""

    def __init__(self, path: Path, limits: Limits) -> None:
        self.source = path.name
        text = read_text_bytes(path, limits).decode("utf-8", "replace")
        lines = [line.partition("#")[0].split() for line in text.splitlines()]
        self._words = [word for line in lines for word in line]
        self._lines = [number for number, line in enumerate(lines, 1) for _ in line]
        self._next = 0

    @property
    def line(self) -> int:
        return self._lines[self._next - 1] if self._next else 1

    def error(self, text: str) -> SceneError:
        return SceneError(located(self.source, f"line {self.line}", text))

    def peek(self) -> str | None:
        """The word that comes next, None at the end."""
        return self._words[self._next] if self._next < len(self._words) else None

    def peek_same_line(self) -> str | None:
        """The word that comes next if it stands on the same line as the last one."""
        word = self.peek()
        return word if word is not None and self._lines[self._next] == self.line else None

    def word(self, wanted: str) -> str:
        """The next word; at the end the error says what was `wanted`."""
        word = self.peek()
        if word is None:
            raise self.error(f"the file ends where {wanted} should be")
        self._next += 1
        return word

    def expect(self, *words: str) -> str:
        """The next word, which must be one of `words`."""
        wanted = " or ".join(words)
        word = self.word(wanted)
        if word not in words:
            raise self.error(f"{show(word)} is not allowed; {wanted} should be here")
        return word

    def number(self, wanted: str) -> float:
        word = self.word(f"{wanted} (a number)")
        try:
            value = float(word.replace("_", "?"))  # Python reads 1_0 as 10, other programs do not
        except ValueError:
            value = math.nan
        if not math.isfinite(value):
            raise self.error(f"{show(word)} is not allowed; {wanted} must be a number")
        return value

    def numbers(self, count: int, wanted: str) -> list[float]:
        return [self.number(wanted) for _ in range(count)]

    def integer(self, wanted: str) -> int:
        value = self.number(wanted)
        if value != int(value):
            raise self.error(f"{value:g} is not allowed; {wanted} must be a whole number")
        return int(value)

    def side(self, wanted: str) -> int:
        """A picture's width or height in pixels."""
        side = self.integer(wanted)
        if not 1 <= side <= 1 << 16:
            raise self.error(f"{side} is not allowed; {wanted} must be from 1 to 65536 pixels")
        return side


def build(table: dict[str, Any], lines: Mapping[str, int], path: Path, limits: Limits) -> Scene:
    """The scene in an importer's dict; `lines` says where each part (`shapes[3]`) stood in the file."""
    try:
        return read_scene(table, folder=path.parent, source=path.name, limits=limits)
    except SceneError as error:
        start = re.match(
            r"((?:shapes|lights)\[\d+\]|materials\.\w+|camera)", str(error).removeprefix(f"{path.name}: ")
        )
        if start is None or start.group(1) not in lines:
            raise
        rest = str(error).removeprefix(f"{path.name}: ")
        raise SceneError(located(path.name, f"line {lines[start.group(1)]}", rest)) from None


def same_turn(points: list[list[float]]) -> bool:
    """Whether a polygon's first corner turns the way the whole outline does.

    Formats that take the normal from the first corner mean the other side where it does not.
    """
    if len(points) == 3:
        return True
    corners = np.array(points, np.float64)
    first = np.cross(corners[1] - corners[0], corners[2] - corners[1])
    return bool(first @ newell(corners) >= 0)
