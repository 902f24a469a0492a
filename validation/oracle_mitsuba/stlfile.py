"""STL files, binary and text: triangles without normals of their vertices."""

from __future__ import annotations

import re

import numpy as np

from .patches import Patch, Patches, Unreadable, finite

_ROW = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
_FACET = (b"facet", b"outer", b"vertex", b"vertex", b"vertex", b"endloop", b"endfacet")


def patches(data: bytes) -> Patches:
    """The triangles. Solids of a text are not numbered."""
    count = int.from_bytes(data[80:84], "little")
    if len(data) == 84 + _ROW.itemsize * count:
        corners, solids = np.frombuffer(data, _ROW, count, 84)["corners"].astype(float), 1
    else:
        rows, solids = _text(data)
        corners = np.array(rows, float).reshape(-1, 3, 3)
    return Patches([(0, Patch(finite(corners, "corners")))], "several solids" if solids > 1 else "")


def _text(data: bytes) -> tuple[list[list[float]], int]:
    """The corners, and how many solids they are of."""
    rows: list[list[float]] = []
    place, solids, within = 0, 0, False
    for number, line in enumerate(data.removeprefix(b"\xef\xbb\xbf").splitlines(), 1):
        words = line.split()
        key = words[0].lower() if words else b""
        if place == 0 and key in (b"solid", b"endsolid") and within == (key == b"endsolid"):
            within = not within
            solids += within
        elif within and key == _FACET[place]:
            if key == b"vertex":
                if len(words) != 4 or re.search(rb"_", line):
                    raise Unreadable(f"line {number}: a corner that is not three numbers")
                rows.append([float(word) for word in words[1:]])
            place = (place + 1) % len(_FACET)
        elif words:
            raise Unreadable(f"line {number}: {line.decode('latin-1').strip()[:40]}")
    if within or not solids:
        raise Unreadable("a text that does not end, or no text")
    return rows, solids
