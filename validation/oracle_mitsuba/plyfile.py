"""PLY files (Turk, "The PLY Polygon File Format"), text and binary: vertices and faces."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from .patches import Array, Patch, Patches, Unreadable, fans, finite, linear

_TYPES = {
    "char": "i1", "uchar": "u1", "short": "i2", "ushort": "u2", "int": "i4", "uint": "u4", "float": "f4",
    "double": "f8", "int8": "i1", "uint8": "u1", "int16": "i2", "uint16": "u2", "int32": "i4", "uint32": "u4",
    "float32": "f4", "float64": "f8",
}  # fmt: skip
_ORDERS = {"ascii": "", "binary_little_endian": "<", "binary_big_endian": ">"}
_LISTS = ("vertex_index", "vertex_indices")
_UV = (("texture_u", "texture_v"), ("texture_s", "texture_t"), ("u", "v"), ("s", "t"))
_COLORS = (("red", "green", "blue"), ("diffuse_red", "diffuse_green", "diffuse_blue"), ("r", "g", "b"))
_WHOLE = {"u1": 255.0, "u2": 65535.0}


@dataclass
class _Element:
    """`kinds`: by property its type; of a list that of its length and that of its numbers."""

    name: str
    count: int
    kinds: dict[str, tuple[str, ...]] = field(default_factory=dict)
    columns: dict[str, Any] = field(default_factory=dict)

    def read_text(self, words: list[list[str]]) -> None:
        """Take the first rows of what is left."""
        rows, words[:] = words[: self.count], words[self.count :]
        if len(rows) < self.count:
            raise Unreadable(f"{len(rows)} of {self.count} rows of {self.name}")
        columns: list[list[Any]] = [[] for _ in self.kinds]
        for row in rows:
            at = 0
            for column, kind in zip(columns, self.kinds.values(), strict=True):
                size = int(row[at]) if len(kind) == 2 else 1
                at += len(kind) - 1
                found = [_number(word, kind[-1]) for word in row[at : at + size]]
                if len(found) < size or size < 0:
                    raise Unreadable(f"a row of {self.name} that is cut short")
                column.append(found if len(kind) == 2 else found[0])
                at += size
            if at != len(row):
                raise Unreadable(f"a row of {self.name} with more than it declares")
        self._keep(columns)

    def read_binary(self, data: bytes, at: int, order: str) -> int:
        """Take the rows that begin at a byte; returns where what follows begins."""
        if all(len(kind) == 1 for kind in self.kinds.values()):
            row = np.dtype([(name, order + kind[0]) for name, kind in self.kinds.items()])
            rows = np.frombuffer(data, row, self.count, at)
            self.columns = {name: rows[name] for name in self.kinds}
            return at + self.count * row.itemsize
        columns: list[list[Any]] = [[] for _ in self.kinds]
        for _ in range(self.count):
            for column, kind in zip(columns, self.kinds.values(), strict=True):
                size = 1
                if len(kind) == 2:
                    size = int(np.frombuffer(data, order + kind[0], 1, at)[0])
                    at += np.dtype(kind[0]).itemsize
                found = np.frombuffer(data, order + kind[-1], size, at)
                at += found.nbytes
                column.append(found.tolist() if len(kind) == 2 else found[0])
        self._keep(columns)
        return at

    def _keep(self, columns: list[list[Any]]) -> None:
        for (name, kind), column in zip(self.kinds.items(), columns, strict=True):
            self.columns[name] = column if len(kind) == 2 else np.array(column, float)

    def group(self, names: tuple[tuple[str, ...], ...]) -> Array | None:
        """The first of some groups of properties that are there, (n, k)."""
        found = next((group for group in names if all(name in self.kinds for name in group)), None)
        if found is None or not self.count:
            return None
        if any(len(self.kinds[name]) == 2 for name in found):
            raise Unreadable(f"a list {found[0]}")
        return np.stack([np.asarray(self.columns[name], float) for name in found], axis=1)

    def colors(self) -> Array | None:
        """Linear colours, (n, 3)."""
        stated = self.group(_COLORS)
        if stated is None:
            return None
        group = next(group for group in _COLORS if all(name in self.kinds for name in group))
        kinds = {self.kinds[name][0] for name in group}
        most = [_WHOLE.get(kind, 1.0) for kind in kinds if kind in _WHOLE or kind.startswith("f")]
        if len(kinds) > 1 or not most or not ((stated >= 0) & (stated <= most[0])).all():
            raise Unreadable("colours of other types, or beyond them")
        return linear(stated / most[0])


def patches(data: bytes) -> Patches:
    """The faces. A PLY has one part."""
    order, elements, start = _header(data.removeprefix(b"\xef\xbb\xbf"))
    data = data.removeprefix(b"\xef\xbb\xbf")
    if order:
        for element in elements:
            start = element.read_binary(data, start, order)
        if start != len(data):
            raise Unreadable(f"{len(data) - start} bytes behind its rows")
    else:
        words = [words for line in data[start:].splitlines() if (words := line.decode("latin-1").split())]
        for element in elements:
            element.read_text(words)
    by_name = {element.name: element for element in elements}
    if not {"vertex", "face"} <= by_name.keys() or len(by_name) < len(elements):
        raise Unreadable("no vertices or faces, or more than one element of a name")
    return Patches([(0, _patch(by_name["vertex"], by_name["face"]))])


def _header(data: bytes) -> tuple[str, list[_Element], int]:
    """The order of bytes ("" of a text), the elements, and where the first row begins."""
    order, at, elements = None, 0, list[_Element]()
    for number in range(1000):
        end = data.find(b"\n", at)
        words = data[at:end].decode("latin-1").split() if end >= 0 else []
        at = end + 1
        if number == 0 and words != ["ply"]:
            break
        if words[:1] == ["format"] and words[1:2] and words[1] in _ORDERS:
            order = _ORDERS[words[1]]
        elif words[:1] == ["element"] and len(words) == 3:
            elements.append(_Element(words[1], int(words[2])))
        elif words[:1] == ["property"] and elements and len(words) in (3, 5):
            if words[-1] in elements[-1].kinds or (len(words) == 5) != (words[1] == "list"):
                break
            elements[-1].kinds[words[-1]] = tuple(_TYPES[kind] for kind in words[1:-1] if kind != "list")
        elif words == ["end_header"] and order is not None:
            return order, elements, at
        elif words[:1] not in (["ply"], ["comment"], ["obj_info"]):
            break
    raise Unreadable(f"its header, line {number + 1}")


def _number(word: str, kind: str) -> float:
    if "_" in word:
        raise Unreadable(f"a number {word[:20]}")
    return int(word) if kind[0] in "iu" else float(word)


def _patch(vertex: _Element, face: _Element) -> Patch:
    points, normals = vertex.group((("x", "y", "z"),)), vertex.group((("nx", "ny", "nz"),))
    lists = [name for name in _LISTS if len(face.kinds.get(name, ())) == 2]
    if points is None or len(lists) != 1 or sum(len(kind) == 2 for kind in face.kinds.values()) > 1:
        raise Unreadable("no vertices, or no faces of one list of vertices")
    faces = face.columns[lists[0]]
    numbers = np.concatenate([np.zeros(0, int), *(np.asarray(each, int) for each in faces)])
    if len(numbers) and (numbers.min() < 0 or numbers.max() >= len(points)):
        raise Unreadable(f"a face of vertices that are not among the {len(points)}")
    rows = fans(finite(points, "vertices"), faces)
    uv = vertex.group(_UV)
    colors = vertex.colors()
    if colors is not None:
        colors = colors[rows]
    else:
        of_faces = face.colors()
        sizes = [max(len(each) - 2, 0) for each in faces]
        colors = None if of_faces is None else np.repeat(of_faces, sizes, axis=0)
    flat = None if uv is None else uv[rows] * (1, -1) + (0, 1)  # v = 0 is at the bottom there
    return Patch(points[rows], None if normals is None else normals[rows], flat, colors)
