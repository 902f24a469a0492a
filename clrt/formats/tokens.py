"""Words of a text file with their lines, for formats in which white space alone separates."""

from __future__ import annotations

import io
import math
import re
from collections.abc import Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

from clrt.base.errors import SceneError, decimal, located, show
from clrt.base.files import read_text_bytes
from clrt.base.limits import Limits
from clrt.base.mark import unmarked
from clrt.scene.scene import Scene, read_scene


class Tokens:
    """The words of a file in order. `line` is that of the word taken last."""

    def __init__(self, path: Path, limits: Limits) -> None:
        self.source = path.name
        data = io.BytesIO(unmarked(read_text_bytes(path, limits)))
        # line by line: all words at once would take 60 bytes and more for each byte of the file
        self._text = enumerate(io.TextIOWrapper(data, "utf-8", "replace"), 1)
        self._words: list[str] = []  # of the line `_number`
        self._next = self._number = 0
        self.line = 1

    def error(self, text: str) -> SceneError:
        return SceneError(located(self.source, f"line {self.line}", text))

    def peek(self) -> str | None:
        """The word that comes next, None at the end."""
        while self._next == len(self._words):
            number, text = next(self._text, (0, ""))
            if number == 0:
                return None
            self._number, self._words, self._next = number, text.partition("#")[0].split(), 0
        return self._words[self._next]

    def peek_same_line(self) -> str | None:
        """The word that comes next if it stands on the same line as the last one."""
        word = self.peek()
        return word if word is not None and self._number == self.line else None

    def word(self, wanted: str) -> str:
        """The next word; at the end the error says what was `wanted`."""
        word = self.peek()
        if word is None:
            raise self.error(f"the file ends where {wanted} should be")
        self._next += 1
        self.line = self._number
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
            value = decimal(word)
        except ValueError:
            value = math.nan
        if not math.isfinite(value):
            raise self.error(f"{show(word)} is not allowed; {wanted} must be a number")
        return value

    def numbers(self, count: int, wanted: str) -> list[float]:
        if self.peek() is not None and self._next + count <= len(self._words):  # most stand on one line
            with suppress(ValueError):
                values = [*map(decimal, self._words[self._next : self._next + count])]
                if all(map(math.isfinite, values)):
                    self._next += count
                    self.line = self._number
                    return values
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


def build(
    table: dict[str, Any], lines: Mapping[str, int], shape_lines: Sequence[int], path: Path, limits: Limits
) -> Scene:
    """The scene in an importer's dict.

    `lines` says where each part (`lights[3]`) stood in the file, `shape_lines` where each shape did.
    """
    try:
        return read_scene(table, folder=path.parent, source=path.name, limits=limits)
    except SceneError as error:
        rest = str(error).removeprefix(f"{path.name}: ")
        shape = re.match(r"shapes\[(\d+)\]", rest)
        part = re.match(r"lights\[\d+\]|materials\.\w+|camera", rest)
        if shape:
            line = shape_lines[int(shape.group(1))]
        elif part and part.group() in lines:
            line = lines[part.group()]
        else:
            raise
        raise SceneError(located(path.name, f"line {line}", rest)) from None
