"""PLY files as trimesh understands them: it knows colours by the names `red`, `green` and `blue` alone."""

from __future__ import annotations

import re
from typing import Final

_COLORS: Final = (b"red", b"green", b"blue")
_OTHERS: Final = ((b"diffuse_red", b"diffuse_green", b"diffuse_blue"), (b"r", b"g", b"b"))
_PROPERTY: Final = re.compile(rb"(?<=\n)(property[ \t]+\w+[ \t]+)(\w+)(?=[ \t]*\r?\n)")
_ELEMENT: Final = re.compile(rb"(?<=\n)(?=element[ \t])")
_HEADER: Final = 4096  # bytes within which a PLY says that it has colours


def plain_ply(data: bytes) -> bytes:
    """The file's data with the usual names of colours in its header, where they have others."""
    end = data.find(b"end_header", 0, _HEADER)
    head = data[: max(end, 0)]
    plain = b"".join(map(_named, _ELEMENT.split(head)))
    return data if plain == head else plain + data[end:]


def has_colors(data: bytes) -> bool:
    """Whether `plain_ply` data has a colour of each vertex or face."""
    return re.search(rb"^property\s+\w+\s+red\b", data[:_HEADER], re.MULTILINE) is not None


def _named(element: bytes) -> bytes:
    """An element of the header with the usual names of its colours, unless they stand there, too."""
    there = {name for _, name in _PROPERTY.findall(element)}
    found = next((names for names in _OTHERS if there.issuperset(names)), None)
    if found is None or not there.isdisjoint(_COLORS):
        return element
    usual = dict(zip(found, _COLORS, strict=True))
    return _PROPERTY.sub(lambda match: match[1] + usual.get(match[2], match[2]), element)
