"""uv of a PLY: of vertices, by all usual names, or of corners, `texcoord` lists of faces as MeshLab has them.

trimesh would take vertices apart by their uv, and leave normals with the places that these had before. So uv
are hidden from it by other names.
"""

from __future__ import annotations

import re
from typing import Any, Final

import numpy as np

from clrt.meshfiles.outlines import corners_of

_PAIRS: Final = ((b"texture_u", b"texture_v"), (b"texture_s", b"texture_t"), (b"u", b"v"), (b"s", b"t"))
_LISTED: Final = b"texcoord"
_PROPERTY: Final = re.compile(
    rb"(?<=\n)(property[ \t]+(?:list[ \t]+\w+[ \t]+)?\w+[ \t]+)(\w+)(?=[ \t]*\r?(?:\n|\Z))"
)
_HIDDEN: Final = "clrt_"
ODD: Final = "texcoord of faces that have not two numbers for each corner are left out"


def hidden(element: bytes) -> bytes:
    """An element of a header, in which uv have names of ours."""
    names = {*sum(_PAIRS, ())} if element.split(None, 2)[1:2] == [b"vertex"] else {_LISTED}
    return _PROPERTY.sub(
        lambda found: found[1] + (_HIDDEN.encode() if found[2] in names else b"") + found[2], element
    )


def of_vertices(elements: dict[str, Any]) -> np.ndarray | None:
    """The uv (n, 2) of vertices of a PLY's `elements`, as trimesh read them; None where they have none."""
    vertex = elements.get("vertex", {})
    for pair in _PAIRS:
        u, v = (_HIDDEN + name.decode() for name in pair)
        if {u, v} <= {*vertex.get("properties", ())}:
            columns = [np.asarray(vertex["data"][name], np.float64).reshape(-1) for name in (u, v)]
            return np.stack(columns, axis=1)
    return None


def has_corners(elements: dict[str, Any]) -> bool:
    """Whether corners have uv."""
    return _HIDDEN + _LISTED.decode() in elements.get("face", {}).get("properties", ())


def taken_apart(elements: dict[str, Any]) -> tuple[np.ndarray, np.ndarray, np.ndarray] | None:
    """A PLY's `elements` with a vertex for each uv that it has: of each new vertex the old one (n,) and the
    uv (n, 2), and the triangles (m, 3), in trimesh's order. None where lists are not two numbers a corner."""
    from trimesh.geometry import triangulate_quads

    rows = elements["face"].get("data")
    lists = () if rows is None else rows[_HIDDEN + _LISTED.decode()]
    if isinstance(lists, np.ndarray) and lists.dtype.names:
        lists = lists["f1"]
    faces = corners_of(elements)
    sizes = [len(corners) for corners in faces]
    if [len(uv) for uv in lists] != [2 * size for size in sizes] or not sizes:
        return None
    keys = np.column_stack([np.concatenate([*faces]), np.concatenate([*lists]).reshape(-1, 2)])
    _, first, new = np.unique(keys, axis=0, return_index=True, return_inverse=True)
    ends = np.cumsum(sizes)
    triangles = triangulate_quads([*map(np.arange, ends - sizes, ends)])
    return keys[first, 0].astype(np.int64), keys[first, 1:], new.reshape(-1)[triangles]
