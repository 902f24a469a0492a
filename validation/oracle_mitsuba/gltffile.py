"""glTF 2.0 files: the triangles of the nodes of their scene."""

from __future__ import annotations

import base64
import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any
from urllib.parse import unquote

import numpy as np

from .patches import Array, Patch, Patches, Unreadable, finite

_TYPES = {5121: "<u1", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
_WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3}
_FLOAT = 5126
_HARMLESS = ("KHR_materials_", "KHR_texture_transform", "KHR_lights_punctual")
_MOST = 4096  # parts


def patches(data: bytes, path: Path) -> Patches:
    """What stands at one node and has one material is a part; a node's follow those of its children."""
    file = _File(data, path)
    found: list[tuple[int, Patch]] = []
    parts: dict[tuple[int, int | None], int] = {}
    untold = ""
    for node, matrix, mesh in file.placed():
        forms: dict[int | None, bool] = {}
        for primitive in file.part("meshes", mesh)["primitives"]:
            patch = file.patch(primitive)
            if patch is None:
                continue
            material = primitive.get("material")
            number = parts.setdefault((node, material), len(parts))
            if forms.setdefault(material, patch.uv is not None) != (patch.uv is not None):
                untold = "what has one material at a node has uv, and has none"
            found.append((number, _moved(patch, matrix)))
    return Patches(found, untold or (f"more than {_MOST}" if len(parts) > _MOST else ""))


def _moved(patch: Patch, matrix: Array) -> Patch:
    """A patch in world space, outer sides still outside."""
    turn = matrix[:3, :3]
    corners, normals = patch.corners @ turn.T + matrix[:3, 3], patch.normals
    if normals is not None:
        normals = normals @ np.linalg.inv(turn)
    if np.linalg.det(turn) >= 0:
        return Patch(corners, normals, patch.uv)
    flipped = [None if each is None else each[:, ::-1] for each in (corners, normals, patch.uv)]
    assert flipped[0] is not None
    return Patch(flipped[0], flipped[1], flipped[2])


class _File:
    """A file's document, and the bytes of its buffers."""

    def __init__(self, data: bytes, path: Path) -> None:
        self._path, self._chunk = path, b""
        if data[:4] == b"glTF":
            size = int.from_bytes(data[12:16], "little")
            self._chunk = data[28 + size :]
            data = data[20 : 20 + size]
        self._document = json.loads(data.decode("utf-8-sig"))
        for name in self._document.get("extensionsRequired", ()):
            if not name.startswith(_HARMLESS):
                raise Unreadable(f"the extension {name[:40]}")

    def part(self, kind: str, number: int) -> Any:
        """One of the document's objects."""
        held = self._document.get(kind, ())
        if not isinstance(number, int) or not 0 <= number < len(held):
            raise Unreadable(f"{kind}[{number}], which is not there")
        return held[number]

    def placed(self) -> Iterator[tuple[int, Array, int]]:
        """The nodes that have a mesh, their matrices to the world, and the numbers of the meshes."""
        scene = self.part("scenes", self._document.get("scene", 0))
        met: list[tuple[int, Array, int]] = []
        seen: set[int] = set()
        left = [(number, np.eye(4)) for number in scene.get("nodes", ())]
        while left:
            number, above = left.pop()
            node = self.part("nodes", number)
            if number in seen:
                raise Unreadable(f"nodes[{number}] below two nodes")
            seen.add(number)
            matrix = above @ _matrix(node)
            left += [(child, matrix) for child in node.get("children", ())]
            if set(node.get("extensions", ())) - {"KHR_lights_punctual"}:
                raise Unreadable(f"extensions of nodes[{number}]")
            if "mesh" in node:
                weights = [*node.get("weights", ()), *self.part("meshes", node["mesh"]).get("weights", ())]
                if "skin" in node or any(weights):
                    raise Unreadable(f"nodes[{number}]: skins and morph targets")
                met.append((number, matrix, node["mesh"]))
        return reversed(met)  # it was walked from the last child to the first, a node before its children

    def patch(self, primitive: Any) -> Patch | None:
        """A primitive's triangles where its mesh is; None where it has none."""
        attributes, mode = primitive["attributes"], primitive.get("mode", 4)
        if mode in (0, 1, 2, 3) or "POSITION" not in attributes:
            return None
        if set(primitive.get("extensions", ())) - {"KHR_materials_variants"}:
            raise Unreadable("extensions of a primitive")
        points = self._floats(attributes["POSITION"], "VEC3")
        corners = np.arange(len(points))
        if "indices" in primitive:
            corners = self._accessor(primitive["indices"], "SCALAR", (5121, 5123, 5125))[:, 0].astype(int)
        rows = _triangles(corners, mode)
        if not len(rows):
            return None
        if corners.max() >= len(points):
            raise Unreadable(f"a face of vertex {corners.max()} of {len(points)}")
        normals = self._floats(attributes["NORMAL"], "VEC3") if "NORMAL" in attributes else None
        uv = self._floats(attributes["TEXCOORD_0"], "VEC2") if "TEXCOORD_0" in attributes else None
        if any(each is not None and len(each) != len(points) for each in (normals, uv)):
            raise Unreadable("not one normal or uv for each vertex")
        taken = [None if each is None else each[rows] for each in (normals, uv)]
        return Patch(points[rows], *taken)

    def _floats(self, number: int, kind: str) -> Array:
        """Numbers as they are; whole ones only where they are said to be parts of the largest."""
        kinds = (_FLOAT, 5121, 5123) if kind == "VEC2" else (_FLOAT,)
        values = self._accessor(number, kind, kinds)
        if values.dtype.kind == "f":
            return finite(values.astype(float), f"accessors[{number}]: numbers")
        if not self.part("accessors", number).get("normalized"):
            raise Unreadable(f"accessors[{number}]: whole numbers")
        return values / float(np.iinfo(values.dtype).max)

    def _accessor(self, number: int, kind: str, allowed: tuple[int, ...]) -> Array:
        said = self.part("accessors", number)
        if "sparse" in said or "bufferView" not in said:
            raise Unreadable(f"accessors[{number}]: sparse")
        if said.get("componentType") not in allowed or said.get("type") != kind:
            raise Unreadable(f"accessors[{number}]: numbers of another type")
        view = self.part("bufferViews", said["bufferView"])
        if view.get("extensions"):
            raise Unreadable(f"accessors[{number}]: compressed")
        width, dtype = _WIDTHS[kind], np.dtype(_TYPES[said["componentType"]])
        stride = view.get("byteStride", width * dtype.itemsize)
        start, count = view.get("byteOffset", 0), said["count"]
        held = memoryview(self._buffer(view["buffer"]))[start : start + view["byteLength"]]
        return np.ndarray((count, width), dtype, held, said.get("byteOffset", 0), (stride, dtype.itemsize))

    def _buffer(self, number: int) -> bytes:
        uri = self.part("buffers", number).get("uri")
        if uri is None:
            if number or not self._chunk:
                raise Unreadable(f"buffers[{number}] without bytes")
            return self._chunk
        if not uri.startswith("data:"):
            return (self._path.parent / unquote(uri)).read_bytes()
        head, _, text = uri.partition(",")
        if not head.endswith(";base64"):
            raise Unreadable("data that are not base64")
        return base64.b64decode(text, validate=True)


def _triangles(corners: Array, mode: int) -> Array:
    """Corners as triangles (m, 3): each three, a strip, or a fan."""
    if mode == 4 and len(corners) % 3 == 0:
        return corners.reshape(-1, 3)
    if mode not in (5, 6):
        raise Unreadable(f"{len(corners)} corners of mode {mode}")
    second = np.arange(1, max(len(corners) - 1, 1))
    if mode == 6:
        return corners[np.stack([0 * second, second, second + 1], axis=1)]
    turned = second % 2 == 0  # every other one, so that all have one side out
    last = np.where(turned, [second + 1, second], [second, second + 1])
    return corners[np.stack([second - 1, *last], axis=1)]


def _matrix(node: Any) -> Array:
    """Of a node to the one above it."""
    steps = [name for name in ("translation", "rotation", "scale") if name in node]
    if "matrix" in node:
        if steps:
            raise Unreadable("a node with a matrix and more")
        return np.array(node["matrix"], float).reshape(4, 4).T
    x, y, z, w = node.get("rotation", (0.0, 0.0, 0.0, 1.0))
    if abs(x * x + y * y + z * z + w * w - 1) > 1e-3:
        raise Unreadable("a rotation that is none")
    # i, j, k turned: q i q* and so on, by the products of quaternions, over q q*
    length = x * x + y * y + z * z + w * w
    turn = np.array([
        [w * w + x * x - y * y - z * z, 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), w * w - x * x + y * y - z * z, 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), w * w - x * x - y * y + z * z],
    ])  # fmt: skip
    matrix = np.eye(4)
    matrix[:3, :3] = turn / length * np.array(node.get("scale", (1.0, 1.0, 1.0)), float)
    matrix[:3, 3] = node.get("translation", (0.0, 0.0, 0.0))
    return matrix
