"""STL files as trimesh understands them.

It looks for a text's words wherever they stand, in names, too, and passes over a solid that does not end.
"""

from __future__ import annotations

from typing import Final

from clrt.base.errors import show
from clrt.base.mark import unmarked
from clrt.meshfiles.broken import BrokenMesh

_MOST: Final = 64  # solids that are kept apart: trimesh's time grows with their square
_ENDS: Final = {b"facet": b"endfacet", b"solid": b"endsolid"}


def plain_stl(data: bytes) -> bytes:
    """A text's solids with their corners alone; together where there are many. A binary file as it is.

    BrokenMesh names the line of a facet that is not whole, and the last one where something does not end.
    """
    if len(data) == 84 + 50 * int.from_bytes(data[80:84], "little") or b"\0" in data:
        return data
    data = unmarked(data)
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


def _broken(number: int, line: bytes, text: str) -> BrokenMesh:
    return BrokenMesh(f"line {number}: {show(line.decode('latin-1').strip()[:60])}: {text}")
