"""PLY files as trimesh understands them: it knows colours by the names `red`, `green` and `blue` alone.

It keeps the low byte of each, so the numbers of colours are taken from what it read, by their declared type.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cache, partial
from typing import Any, Final

import numpy as np

from clrt.base.errors import show
from clrt.base.limits import written
from clrt.base.mark import unmarked
from clrt.images.file import decode, uncurved
from clrt.meshfiles.broken import BrokenMesh
from clrt.meshfiles.outlines import rows_of
from clrt.meshfiles.plylists import as_text
from clrt.meshfiles.plyuv import hidden

_COLORS: Final = (b"red", b"green", b"blue")
_OTHERS: Final = ((b"diffuse_red", b"diffuse_green", b"diffuse_blue"), (b"r", b"g", b"b"))
_PLACE: Final = (b"x", b"y", b"z")
_OTHER_PLACES: Final = ((b"X", b"Y", b"Z"),)
_PROPERTY: Final = re.compile(rb"(?<=\n)(property[ \t]+)(\w+)([ \t]+)(\w+)(?=[ \t]*\r?\n)")
_WHOLE: Final = rb"u?(?:char|short|int)(?:8|16|32)?"
_WHOLES: Final = re.compile(
    rb"(?<=\n)(property[ \t]+list[ \t]+)(" + _WHOLE + rb")([ \t]+)" + _WHOLE + rb"(?=[ \t])"
)
_ELEMENT: Final = re.compile(rb"(?<=\n)(?=element[ \t])")
_TEXTURE: Final = re.compile(rb"(?i)\ncomment[ \t]+texturefile[ \t]+([^\r\n]+)")
_EDGES: Final = re.compile(rb"\A(element[ \t]+)edge(?=[ \t])")  # of which trimesh makes a graph, at any price
_SOME_EDGES: Final = re.compile(rb"\nelement[ \t]+edge[ \t]+0*[1-9]")
_LIST: Final = re.compile(
    rb"(\nproperty[ \t]+list[ \t]+\w+[ \t]+\w+[ \t]+)([^ \t\r\n]+)(?=[ \t]*\r?(?:\n|\Z))"
)
_CORNERS: Final = (b"vertex_indices", b"vertex_index")
_END: Final = b"end_header"
_OLD: Final = re.compile(rb"(\xef\xbb\xbf)?ply[ \t]*\r(?!\n)")  # lines that end as on old Macintoshes
_HEADER: Final = 1 << 20  # bytes within which a header ends
_DIGITS: Final = 18  # of a number of rows
_COLORED: Final = ("vertex", "face")
_NEAR: Final = 1e-6  # beyond 0 and 1, of floats: rounding
_LISTS: Final = 16  # of a header: trimesh looks at all properties of an element anew for each
_FREE: Final = 1 << 18  # rows and values of a text, each of which takes up to 190 bytes; and besides
_SHARE: Final = 4  # bytes of the file for each


def newlined(data: bytes) -> bytes:
    """The file's data with lines that end in \\n, as trimesh knows them, not in \\r alone."""
    if not _OLD.match(data):
        return data
    end = data.find(_END + b"\r", 0, _HEADER) + len(_END) + 1
    head = data[:end].replace(b"\r", b"\n")
    return head + (data[end:].replace(b"\r", b"\n") if b"\nformat ascii" in head else data[end:])


def plain_ply(data: bytes) -> bytes:
    """The file's data with the usual names of places, colours and corners in its header, and uv of ours.

    Of a text file they are declared as double: trimesh would drop what is too large for their type.
    """
    data = unmarked(data)
    head = header(data)
    if not head:
        raise BrokenMesh(f"its header does not end within {_HEADER} bytes")
    body, head = data[len(head) :], _in_order(head)
    data = head + body
    start = data.find(b"\n", len(head)) + 1 or len(data)
    spelt = as_text(data, start)
    if spelt is not None:
        return plain_ply(spelt)
    elements = [hidden(_named(_EDGES.sub(rb"\1clrt_edge", part))) for part in _ELEMENT.split(head)]
    _check_places(elements)
    text = b"ascii" in b"".join(head.split(b"\n", 2)[1:2]).lower()
    declared = _Declared.of(head)
    if declared.lists > _LISTS:
        raise BrokenMesh(f"its header declares {declared.lists} lists; at most {_LISTS} are read")
    if text:
        declared.check_text(len(data))
        first, *rest = _lines(data[len(head) :], declared)
        declared.check_rows(rest, 1 + head.count(b"\n"))
        rows = [first, *(line for line in rest if not declared.skips(line))]
        return b"".join(map(_widened, elements)) + "\n".join(rows).encode("utf-8", "surrogateescape")
    plain = b"".join(elements)
    return data if plain == head else plain + data[len(head) :]


def edges(data: bytes) -> bool:
    """Whether a file has edges, which are not shown."""
    return _SOME_EDGES.search(header(data)) is not None


def has_colors(data: bytes) -> bool:
    """Whether a file has a colour of each vertex or face."""
    return bool(_types(data))


def textures(data: bytes) -> list[str]:
    """The pictures that a header names in a comment, as MeshLab writes them; they are not read."""
    return [name.decode("utf-8", "replace").strip() for name in _TEXTURE.findall(header(data))]


@dataclass(frozen=True)
class PlyColors:
    """Which `types` a PLY declares of red, green and blue, by element; `wanted`: whether they are of use."""

    types: dict[str, tuple[str, ...]]
    wanted: bool

    @staticmethod
    def of(data: bytes, wanted: bool) -> PlyColors:
        """Those of a file that is not yet `plain_ply`."""
        return PlyColors(_types(data), wanted)

    def corners(self, elements: dict[str, Any], faces: np.ndarray) -> Callable[[], np.ndarray]:
        """What gives the linear colours (m, 3, 3) of the corners of `faces`, which trimesh made of a file's
        `elements`. BrokenMesh for numbers that are no colours: at once where they are wanted."""
        element = next(name for name in _COLORED if name in self.types)
        own = cache(partial(self._linear, element, elements[element]["data"]))
        if self.wanted:
            own()
        if element == "vertex":
            return lambda: own()[faces]
        rows = rows_of(elements).reshape(len(faces))
        return lambda: np.repeat(own()[rows][:, None], 3, axis=1)

    def _linear(self, element: str, rows: Any) -> np.ndarray:
        """The linear colours (n, 3), float32, of all rows of an element."""
        columns = []
        for name, kind in zip(("red", "green", "blue"), self.types[element], strict=True):
            values = np.asarray(rows[name]).reshape(-1)
            real = kind.startswith(("float", "double"))
            most = 1 if real else 65535 if kind in ("ushort", "uint16") else 255
            good = (values >= 0) & (values <= most) & (values == np.floor(values))
            if real:
                good = (values >= -_NEAR) & (values <= 1 + _NEAR)
            if not good.all():
                row = int(np.argmin(good))
                numbers = "numbers" if real else "whole numbers"
                text = f"{element} {row} has {name} = {values[row]:g}, declared as {kind}"
                raise BrokenMesh(f"{text}; of that {numbers} from 0 to {most} are colours")
            if real:
                columns.append(uncurved(np.clip(values.astype(np.float64), 0.0, 1.0)))
            else:
                columns.append(decode(values.astype(np.uint16 if most > 255 else np.uint8)))
        return np.stack(columns, axis=1)


@dataclass
class _Declared:
    """How many rows, values in them and lists a header declares, as trimesh reads it; of faces the rows and
    lists, too. Of all elements: name, rows, and of each property whether it is a list."""

    rows: int = 0
    values: int = 0
    lists: int = 0
    faces: tuple[int, int] = (0, 0)
    elements: list[tuple[str, int, list[bool]]] = field(default_factory=list)

    @staticmethod
    def of(head: bytes) -> _Declared:
        found, name, length, lists = _Declared(), "", 0, 0
        for words in map(str.split, head.decode("utf-8", "replace").split("\n")):
            if len(words) == 3 and "element" in words[0]:
                name, count = words[1:]
                if not (count.isascii() and count.isdecimal()) or len(count) > _DIGITS:
                    raise BrokenMesh(f"its header declares {show(count)} of {show(name)}, which is no count")
                length, lists = int(count), 0
                found.rows += length
                found.elements.append((name, length, []))
            elif words and "property" in words[0]:
                found.values += length
                found.lists += "list" in "".join(words[1:2])
                lists += "list" in "".join(words[1:2])
                for *_, kinds in found.elements[-1:]:
                    kinds.append("list" in "".join(words[1:2]))
            if name == "face":
                found.faces = length, lists
        return found

    def check_rows(self, lines: list[str], before: int) -> None:
        """Raise BrokenMesh where rows of a text, whose `lines` stand after `before` others, are not whole."""
        left = iter(enumerate(lines, before + 1))
        for name, count, lists in self.elements:
            for row in range(count):
                number, line = next(left, (0, ""))
                while number and self.skips(line):
                    number, line = next(left, (0, ""))
                if not number:
                    text = f"it has {row} of the {count} rows of {show(name)} that it declares"
                    raise BrokenMesh(f"it ends in line {before + len(lines)}: {text}")
                words = line.split()
                try:
                    least = _needs(words, lists)
                except (ValueError, OverflowError):
                    continue  # trimesh refuses what is no number
                if len(words) < least:
                    text = f"row {row} of {show(name)} has {len(words)} of its {least} numbers"
                    raise BrokenMesh(f"line {number}: {text}")

    def skips(self, line: str) -> bool:
        """Whether a line is no row: empty, where no element's rows are, as three.js once wrote them."""
        return not line.strip() and all(lists for _, _, lists in self.elements)

    def check_text(self, size: int) -> None:
        """Raise BrokenMesh where a text file of `size` bytes declares what would take too much memory, or
        what trimesh does not understand."""
        many, most = self.rows + self.values, _FREE + size // _SHARE
        if many > most:
            text = f"its header declares {written(many)} rows and values in them"
            text += f"; of a text of its size at most {written(most)} are read"
            raise BrokenMesh(f"{text}, save it as binary")
        if self.faces[0] == 1 and self.faces[1] > 1:
            text = f"it has {self.faces[1]} lists of one face, of which a text file may have one"
            raise BrokenMesh(f"{text}; save it as binary, or leave the others out")


def _lines(text: bytes, declared: _Declared) -> list[str]:
    """The rest of the header's last line and those with all rows, as trimesh finds them: those after them
    would cost as much as rows."""
    lines = text.decode("utf-8", "surrogateescape").splitlines()
    left = 1 + declared.rows
    if not any(map(declared.skips, lines[1 : left + 1])):
        return lines[:left]
    for at, line in enumerate(lines):
        left -= at == 0 or not declared.skips(line)
        if left == 0:
            return lines[: at + 1]
    return lines


def _needs(words: list[str], lists: list[bool]) -> int:
    """How many words a row of such properties has at least; ValueError where a list's length is none."""
    at = 0
    for many in lists:
        at += 1 + (int(float(words[at])) if many and at < len(words) else 0)
    return at


def header(data: bytes) -> bytes:
    """The header up to its last line, which trimesh knows by a word; empty where it does not end."""
    found = data.find(_END, 0, _HEADER)
    while found >= 0:
        after = data.find(b"\n", found) + 1 or len(data)
        line = data[data.rfind(b"\n", 0, found) + 1 : after]
        if _END.decode() in line.decode("utf-8", "replace").split():
            return data[:found]
        found = data.find(_END, after, _HEADER)
    return b""


def _types(data: bytes) -> dict[str, tuple[str, ...]]:
    """The declared types of red, green and blue of each element that has all three."""
    found = {}
    for element in map(_named, _ELEMENT.split(header(data))):
        kinds = {name: kind.decode() for _, kind, _, name in _PROPERTY.findall(element)}
        called = b"".join(element.split(None, 2)[1:2]).decode("latin-1")
        if called in _COLORED and kinds.keys() >= {*_COLORS}:
            found[called] = tuple(kinds[name] for name in _COLORS)
    return found


def _in_order(head: bytes) -> bytes:
    """The header with its format in the second line, where trimesh looks for it, and without empty lines."""
    first, *lines = head.split(b"\n")
    kept = [line for line in lines[:-1] if line.strip()]
    kept.sort(key=lambda line: line.split()[0] != b"format")
    return b"\n".join([first, *kept, lines[-1]]) if lines else head


def _named(element: bytes) -> bytes:
    """An element of the header with the usual names of places, colours and corners, where it has others."""
    lists = [name for _, name in _LIST.findall(element)]
    if element.split(None, 2)[1:2] == [b"face"] and len(lists) == 1 and lists[0] not in _CORNERS:
        element = _LIST.sub(lambda match: match[1] + _CORNERS[0], element)
    there = {name for *_, name in _PROPERTY.findall(element)}
    usual: dict[bytes, bytes] = {}
    for wanted, others in ((_PLACE, _OTHER_PLACES), (_COLORS, _OTHERS)):
        found = next((names for names in others if there.issuperset(names)), None)
        if found is not None and there.isdisjoint(wanted):
            usual |= zip(found, wanted, strict=True)
    if not usual:
        return element
    return _PROPERTY.sub(lambda match: b"".join(match.groups()[:3]) + usual.get(match[4], match[4]), element)


def _check_places(elements: list[bytes]) -> None:
    """BrokenMesh where vertices have no place."""
    for element in elements:
        names = {name for *_, name in _PROPERTY.findall(element)}
        if element.split(None, 2)[1:2] == [b"vertex"] and not names >= {*_PLACE}:
            there = ", ".join(sorted(name.decode("latin-1") for name in names)) or "none"
            raise BrokenMesh(f"its vertices have no properties x, y and z, but {show(there[:60])}")


def _widened(element: bytes) -> bytes:
    """An element of the header with colours of the type double, and numbers of corners of the type int: of
    others trimesh drops what is too large, or takes its last bits."""
    element = _PROPERTY.sub(
        lambda match: match[1] + (b"double" if match[4] in _COLORS else match[2]) + match[3] + match[4],
        element,
    )
    return _WHOLES.sub(rb"\1int\3int", element)
