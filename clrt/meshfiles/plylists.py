"""Binary PLY files whose lists have different lengths, as a text: trimesh takes the first row's for all.

Programs that keep faces of any number of corners (Blender, Houdini, MeshLab) write such files.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from struct import Struct, calcsize, error, unpack_from
from typing import Final

from clrt.meshfiles.broken import BrokenMesh

_CODES: Final = {
    "char": "b", "int8": "b", "uchar": "B", "uint8": "B", "short": "h", "int16": "h", "ushort": "H",
    "uint16": "H", "int": "i", "int32": "i", "uint": "I", "uint32": "I", "float": "f", "float32": "f",
    "double": "d", "float64": "d",
}  # fmt: skip
_FORMAT: Final = re.compile(rb"(?<=\n)format[ \t]+binary_(little|big)_endian[ \t]+([0-9.]+)(?=[ \t]*\r?\n)")
_LIST: Final = re.compile(rb"\n(property[ \t]+list[ \t][^\r\n]*?(\w+))(?=[ \t]*\r?\n)")
_KEPT: Final = ("vertex_indices", "vertex_index", "texcoord")
_FREE: Final = 1 << 18  # rows and values, each of which takes up to 190 bytes; and one for two bytes besides
_Part = tuple[Struct, str, bool]
"""What unpacks numbers; the code of a list whose length it unpacks, "" of plain numbers; is it kept."""
_Element = tuple[int, list[_Part], int]
"""How many rows it has, what these are made of, and of how many numbers and lists."""


def as_text(data: bytes, start: int) -> bytes | None:
    """A file whose rows begin at byte `start` as a text; None where trimesh reads, or refuses, it as well."""
    found = _FORMAT.search(data, 0, start)
    if found is None:
        return None
    order = "<" if found[1] == b"little" else ">"
    try:
        elements = list(_elements(data[:start].decode("latin-1"), order))
        lists = any(code for _, parts, _ in elements for _, code, _ in parts)
        many = sum(count * (1 + values) for count, _, values in elements)
        if not lists or many > _FREE + len(data) // 2 or _uniform(data, start, elements, order):
            return None
        rows = list(_rows(data, start, elements, order))
    except (KeyError, ValueError, IndexError, OverflowError):  # types or counts that are none
        return None
    except error:
        raise BrokenMesh("it is shorter than its header declares; it may be cut short") from None
    head = data[: found.start()] + b"format ascii " + found[2] + data[found.end() : start]
    # others are of no use, and trimesh would read them
    head = _LIST.sub(lambda row: row[0] if row[2].decode() in _KEPT else b"", head)
    return head + "\n".join([*rows, ""]).encode()


def _elements(head: str, order: str) -> Iterator[_Element]:
    """The elements that a header declares."""
    for text in re.split(r"\nelement[ \t]", head)[1:]:
        first, *lines = text.splitlines()
        parts: list[_Part] = []
        plain, values = "", 0
        for words in map(str.split, lines):
            values += words[:1] == ["property"]
            if words[:2] == ["property", "list"]:
                parts += [(Struct(order + plain), "", True)] if plain else []
                parts.append((Struct(order + _CODES[words[2]]), _CODES[words[3]], words[4] in _KEPT))
                plain = ""
            elif words[:1] == ["property"]:
                plain += _CODES[words[1]]
        yield int(first.split()[1]), [*parts, *([(Struct(order + plain), "", True)] if plain else [])], values


def _uniform(data: bytes, start: int, elements: list[_Element], order: str) -> bool:
    """Whether the file is as long as it is if each list of an element is as long as the first one is."""
    at = start
    for count, parts, _ in elements:
        at += count * (_row(data, at, parts, order)[0] - at) if count else 0
    return at == len(data)


def _rows(data: bytes, start: int, elements: list[_Element], order: str) -> Iterator[str]:
    """The rows of all elements as lines of a text."""
    at = start
    for count, parts, _ in elements:
        for _ in range(count):
            at, numbers = _row(data, at, parts, order)
            yield " ".join(map(repr, numbers))


def _row(data: bytes, at: int, parts: list[_Part], order: str) -> tuple[int, list[float]]:
    """Where the row at byte `at` ends, and those of its numbers that are kept."""
    numbers: list[float] = []
    for head, code, kept in parts:
        found = head.unpack_from(data, at)
        at += head.size
        if code:
            form = f"{order}{int(found[0])}{code}"  # no count below 0 is one
            found += unpack_from(form, data, at)
            at += calcsize(form)
        numbers += found if kept else ()
    return at, numbers
