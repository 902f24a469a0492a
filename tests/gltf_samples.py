"""Random glTF files: nodes that turn, stretch and mirror, strips and fans, what is sparse, skins."""

from __future__ import annotations

import base64
import json
import random
import struct
from pathlib import Path
from typing import Any

import numpy as np

Rng = random.Random


def gltf(rng: Rng, path: Path) -> bytes:
    """What a .gltf holds, or a .glb."""
    stored = _Stored(rng)
    meshes = [_mesh(rng, stored) for _ in range(rng.randint(1, 3))]
    nodes, roots = _nodes(rng, len(meshes))
    materials = [{"pbrMetallicRoughness": {"baseColorFactor": [k / 4, 1, 0, 1]}} for k in range(3)]
    document = {
        "asset": {"version": "2.0"}, "meshes": meshes, "nodes": nodes, "materials": materials,
        "scenes": [{"nodes": roots}], "scene": 0, "accessors": stored.accessors, "bufferViews": stored.views,
    }  # fmt: skip
    if rng.random() < 0.1:
        stored.make_sparse()
    if rng.random() < 0.1 and "mesh" in nodes[0]:
        document["skins"] = [{"joints": [0]}]
        nodes[0]["skin"] = 0
    held = bytes(stored.held) + bytes(-len(stored.held) % 4)
    buffer: dict[str, Any] = {"byteLength": len(held)}
    if path.suffix != ".glb":
        buffer["uri"] = "data:application/octet-stream;base64," + base64.b64encode(held).decode()
        return rng.choice([b"", b"\xef\xbb\xbf"]) + json.dumps(document | {"buffers": [buffer]}).encode()
    text = json.dumps(document | {"buffers": [buffer]}).encode()
    text += b" " * (-len(text) % 4)
    chunks = struct.pack("<I4s", len(text), b"JSON") + text + struct.pack("<I4s", len(held), b"BIN\0") + held
    return struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks


class _Stored:
    """Numbers in a buffer, some of them with bytes of others between."""

    def __init__(self, rng: Rng) -> None:
        self._rng = rng
        self.held = bytearray()
        self.views: list[dict[str, Any]] = []
        self.accessors: list[dict[str, Any]] = []

    def view(self, values: np.ndarray, between: int = 0) -> int:
        """The number of a view of its own."""
        self.held.extend(bytes(-len(self.held) % 4))
        start = len(self.held)
        for row in values.reshape(len(values), -1):
            self.held.extend(row.tobytes() + bytes(between))
        self.views.append({"buffer": 0, "byteOffset": start, "byteLength": len(self.held) - start})
        if between:
            self.views[-1]["byteStride"] = values[0].nbytes + between
        return len(self.views) - 1

    def accessor(self, values: np.ndarray, kind: str, code: int) -> int:
        """The number of an accessor."""
        view = self.view(values, 0 if kind == "SCALAR" else self._rng.choice([0, 4]))
        self.accessors.append({"bufferView": view, "componentType": code, "count": len(values), "type": kind})
        return len(self.accessors) - 1

    def make_sparse(self) -> None:
        """Let the first positions have a corner elsewhere, or all be 0 but for that."""
        numbers, values = self.view(np.array([1], np.uint8)), self.view(np.full((1, 3), 2.0, np.float32))
        first = self.accessors[0]
        first["sparse"] = {
            "count": 1,
            "indices": {"bufferView": numbers, "componentType": 5121},
            "values": {"bufferView": values},
        }
        if self._rng.random() < 0.5:
            del first["bufferView"]


def _mesh(rng: Rng, stored: _Stored) -> dict[str, Any]:
    primitives = []
    normals, uv = rng.random() < 0.4, rng.random() < 0.4
    for _ in range(rng.randint(1, 3)):
        points = np.array(some(rng, 3 * rng.choice([3, 6, 9])), np.float32).reshape(-1, 3)
        attributes = {"POSITION": stored.accessor(points, "VEC3", 5126)}
        if normals != (rng.random() < 0.05):
            attributes["NORMAL"] = stored.accessor(points[::-1].copy(), "VEC3", 5126)
        if uv != (rng.random() < 0.05):
            attributes["TEXCOORD_0"] = stored.accessor(points[:, :2].copy(), "VEC2", 5126)
        primitive: dict[str, Any] = {"attributes": attributes}
        if rng.random() < 0.6:
            code, kind = rng.choice([(5121, "u1"), (5123, "<u2"), (5125, "<u4")])
            most = min(len(points), rng.choice([3, 6]))  # none from both sides: their normals cancel out
            order = np.array(rng.sample(range(len(points)), most), kind)
            primitive["indices"] = stored.accessor(order, "SCALAR", code)
        if rng.random() < 0.4:
            primitive["mode"] = rng.choice([4, 5, 6, 1, 0])
        if rng.random() < 0.7:
            primitive["material"] = rng.randrange(3)
        primitives.append(primitive)
    return {"primitives": primitives}


def _nodes(rng: Rng, meshes: int) -> tuple[list[dict[str, Any]], list[int]]:
    """Nodes, and which of them are below none."""
    nodes: list[dict[str, Any]] = []
    roots = []
    for number in range(rng.randint(1, 6)):
        node: dict[str, Any] = {"mesh": rng.randrange(meshes)} if rng.random() < 0.7 else {}
        if rng.random() < 0.3:
            matrix = np.eye(4)
            matrix[:3] += [[rng.uniform(-0.4, 0.4) for _ in range(4)] for _ in range(3)]
            node["matrix"] = matrix.T.reshape(-1).tolist()
        else:
            turn = np.array([rng.gauss(0, 1) for _ in range(4)])
            steps = {
                "translation": some(rng, 3),
                "rotation": (turn / np.linalg.norm(turn)).tolist(),
                "scale": [rng.choice([-1, 1]) * x for x in some(rng, 3)],
            }
            node |= {key: value for key, value in steps.items() if rng.random() < 0.5}
        nodes.append(node)
        if number and rng.random() < 0.5:
            nodes[rng.randrange(number)].setdefault("children", []).append(number)
        else:
            roots.append(number)
    return nodes, roots


def some(rng: Rng, count: int) -> list[float]:
    """Numbers that are not small."""
    return [round(rng.uniform(0.05, 1), 4) for _ in range(count)]
