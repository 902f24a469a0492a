"""STL files as trimesh understands them.

It looks for a text's words wherever they stand, in names, too, and passes over a solid that does not end. A
binary file whose length is not the one that it declares is to it a text without faces.
"""

from __future__ import annotations

import re
from typing import Final

from clrt.base.errors import show
from clrt.base.mark import unmarked
from clrt.meshfiles.broken import BrokenMesh, check_narrow

_MOST: Final = 64  # solids that are kept apart: trimesh's time grows with their square
_HEAD: Final = 84  # bytes of a binary file before its triangles: a text and how many there are
_TRIANGLE: Final = 50
_TEXT: Final = re.compile(rb"(?i)facet\s+normal\s")
_ENDS: Final = {b"facet": b"endfacet", b"solid": b"endsolid"}


def plain_stl(data: bytes) -> bytes:
    """A text's solids with their corners alone; together where there are many. A binary file as it is.

    BrokenMesh names the line of a facet that is not whole, and the last one where something does not end; of
    a binary file that has not the bytes that it declares, how many triangles it has.
    """
    if len(data) == _HEAD + _TRIANGLE * int.from_bytes(data[80:_HEAD], "little"):
        return data
    check_narrow(data)
    if b"\0" in data and not _TEXT.search(data):
        raise BrokenMesh(_length(data))
    data = unmarked(data).replace(b"\0", b" ")  # zeros stand behind some texts
    solids: list[list[bytes]] = []
    open_at: dict[bytes, int] = {}  # where what has not ended began
    corners = number = 0
    for number, line in enumerate(data.splitlines(), 1):
        words = line.split()
        word = words[0].lower() if words else b""
        if word == b"vertex":
            if len(words) != 4 or b"solid" not in open_at:
                raise _broken(number, line, "a corner is 'vertex x y z', in a solid")
            solids[-1].append(b"vertex " + b" ".join(words[1:]))
            corners += 1
        elif word in (b"facet", b"solid"):
            if b"facet" in open_at or (word == b"facet" and not solids):
                raise _broken(number, line, "facets stand in a solid, each after the end of the one before")
            open_at[word] = number
            corners = 0
            solids += [[]] if word == b"solid" else []
        elif word in (b"endfacet", b"endsolid"):
            if word == b"endfacet" and corners != 3:
                raise _broken(number, line, f"the facet has {corners} corners, not 3")
            if word == b"endsolid" and (b"facet" in open_at or (solids and len(solids[-1]) % 3)):
                raise _broken(number, line, "the facet before it is not whole")
            open_at.pop(word[3:], None)
    for word, begun in open_at.items():
        text = f"the {word.decode()} of line {begun} has no {_ENDS[word].decode()}"
        raise BrokenMesh(f"it ends in line {number}, and {text}; it may be cut short")
    if not solids:
        return data
    if len(solids) > _MOST:
        solids = [[line for solid in solids for line in solid]]
    return b"".join(b"\n".join([b"solid s", *solid, b"endsolid s\n"]) for solid in solids if solid)


def _length(data: bytes) -> str:
    """What is wrong with a binary file's length."""
    if len(data) < _HEAD:
        return f"it has {len(data)} bytes, the beginning of a binary file {_HEAD}; it may be cut short"
    declared, held = int.from_bytes(data[80:_HEAD], "little"), (len(data) - _HEAD) // _TRIANGLE
    if held < declared:
        return f"it declares {declared} triangles and has {held}; it may be cut short"
    whole = _HEAD + _TRIANGLE * declared
    return f"it declares {declared} triangles, which end at byte {whole}, and has {len(data)}; save it anew"


def _broken(number: int, line: bytes, text: str) -> BrokenMesh:
    return BrokenMesh(f"line {number}: {show(line.decode('latin-1').strip()[:60])}: {text}")
