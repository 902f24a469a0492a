"""Write bowl.glb: a glTF model with all that clrt reads of one, to render and to look into.

A wooden table (a texture), a bowl of brass (rough metal), a glass ball (a volume that absorbs), a tiled ball
(a normal map), a lamp that glows, a camera, a spot and a point light. Nothing in it is foreign.

    python scenes/generate_models.py [FOLDER]
"""

from __future__ import annotations

import json
import struct
import sys
import zlib
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
FLOAT, UINT = 5126, 5125


def lathe(profile: list[tuple[float, float]], around: int = 48) -> dict[str, Array]:
    """A profile of (radius, height), from the bottom outside on, turned about the y axis."""
    points = np.array(profile)
    angle = np.arange(around + 1) / around * 2 * np.pi
    way = np.gradient(points, axis=0)
    out = np.stack([way[:, 1], -way[:, 0]], axis=1)
    out /= np.linalg.norm(out, axis=1, keepdims=True)
    place, normal = ([pair[:, :1] * np.cos(angle), pair[:, 1:] + 0 * angle, -pair[:, :1] * np.sin(angle)]
                     for pair in (points, out))  # fmt: skip
    rows, columns = len(points) - 1, around
    u, v = np.meshgrid(angle / (2 * np.pi), np.linspace(1, 0, len(points)))
    corner = (np.arange(rows)[:, None] * (columns + 1) + np.arange(columns)).reshape(-1)
    a, b, c, d = corner, corner + 1, corner + columns + 2, corner + columns + 1
    return {
        "POSITION": np.stack(place, axis=-1).reshape(-1, 3),
        "NORMAL": np.stack(normal, axis=-1).reshape(-1, 3),
        "TEXCOORD_0": np.stack([u, v], axis=-1).reshape(-1, 2),
        "indices": np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)]),
    }


def ball(radius: float, rings: int = 24) -> dict[str, Array]:
    """A ball that stands on the ground."""
    turn = (np.arange(rings + 1) / rings - 0.5) * np.pi
    found = lathe([(radius * np.cos(t), radius * (1 + np.sin(t))) for t in turn.tolist()])
    found["NORMAL"] = (found["POSITION"] - (0, radius, 0)) / radius
    return found


def table(half: float) -> dict[str, Array]:
    corners = np.array([(-1, 1), (1, 1), (1, -1), (-1, -1)], float)
    return {
        "POSITION": np.stack([corners[:, 0] * half, 0 * corners[:, 0], corners[:, 1] * half], axis=1),
        "NORMAL": np.tile([0.0, 1.0, 0.0], (4, 1)),
        "TEXCOORD_0": (corners + 1) / 2 * 3,
        "indices": np.array([(0, 1, 2), (0, 2, 3)]),
    }


def wood(side: int = 128) -> NDArray[np.uint8]:
    """Planks of dark and light rings."""
    y, x = np.mgrid[:side, :side] / side
    plank = np.floor(x * 4)
    ring = 0.5 + 0.5 * np.sin(60 * (x + 0.03 * np.sin(2 * np.pi * (y + plank / 3))) + 4 * plank)
    dark = 0.75 + 0.25 * ring - 0.4 * (np.abs(x * 4 - plank - 0.5) > 0.48)
    return np.asarray(np.floor(dark[..., None] * (176, 116, 66) + 0.5), np.uint8)


def tiles(side: int = 64) -> NDArray[np.uint8]:
    """Normals of pillows, green up."""
    y, x = np.mgrid[:side, :side] / side
    lean = [0.6 * np.sin(2 * np.pi * 8 * x) ** 3, 0.6 * np.sin(2 * np.pi * 4 * y) ** 3]
    normal = np.stack([*lean, np.sqrt(1 - lean[0] ** 2 - lean[1] ** 2)], axis=-1)
    return np.asarray(np.floor(normal * 127 + 128.5), np.uint8)


def png(pixels: NDArray[np.uint8]) -> bytes:
    """A PNG that is not compressed: any zlib writes the same bytes."""
    rows = b"".join(b"\0" + row.tobytes() for row in pixels)
    head = struct.pack(">IIBBBBB", pixels.shape[1], pixels.shape[0], 8, 2, 0, 0, 0)
    chunks = [(b"IHDR", head), (b"IDAT", zlib.compress(rows, 0)), (b"IEND", b"")]
    parts = [struct.pack(">I", len(d)) + k + d + struct.pack(">I", zlib.crc32(k + d)) for k, d in chunks]
    return b"\x89PNG\r\n\x1a\n" + b"".join(parts)


class Writer:
    """The binary chunk, and the views and accessors into it."""

    def __init__(self) -> None:
        self.data, self.views, self.accessors = b"", [], []  # type: bytes, list[Any], list[Any]

    def view(self, data: bytes) -> int:
        self.data += b"\0" * (-len(self.data) % 4)
        self.views.append({"buffer": 0, "byteOffset": len(self.data), "byteLength": len(data)})
        self.data += data
        return len(self.views) - 1

    def accessor(self, rows: Array, kind: str) -> int:
        whole = kind == "SCALAR"
        stored = rows.astype("<u4" if whole else "<f4")
        entry = {"bufferView": self.view(stored.tobytes()), "componentType": UINT if whole else FLOAT}
        count = stored.size if whole else len(stored)
        limits = {"min": stored.min(axis=0).tolist(), "max": stored.max(axis=0).tolist()}
        self.accessors.append({**entry, "count": count, "type": kind, **({} if whole else limits)})
        return len(self.accessors) - 1

    def mesh(self, shape: dict[str, Array], material: int) -> dict[str, Any]:
        kinds = {"POSITION": "VEC3", "NORMAL": "VEC3", "TEXCOORD_0": "VEC2"}
        attributes = {name: self.accessor(shape[name], kind) for name, kind in kinds.items()}
        indices = self.accessor(shape["indices"], "SCALAR")
        return {"primitives": [{"attributes": attributes, "indices": indices, "material": material}]}


def surface(name: str, base: list[float], metallic: float, roughness: float, **more: Any) -> dict[str, Any]:
    inner = {"baseColorFactor": [*base, 1.0], "metallicFactor": metallic, "roughnessFactor": roughness}
    return {"name": name, "pbrMetallicRoughness": inner, **more}


def document(writer: Writer) -> dict[str, Any]:
    """The model; its numbers go to `writer`."""
    glass = {
        "KHR_materials_transmission": {"transmissionFactor": 1.0}, "KHR_materials_ior": {"ior": 1.5},
        "KHR_materials_volume": {
            "thicknessFactor": 1.0, "attenuationColor": [0.35, 0.75, 0.6], "attenuationDistance": 1.0,
        },
    }  # fmt: skip
    materials = [
        surface("wood", [1.0, 1.0, 1.0], 0.0, 0.35),
        surface("brass", [0.91, 0.78, 0.42], 1.0, 0.15),
        surface("glass", [1.0, 1.0, 1.0], 0.0, 0.0, extensions=glass),
        surface("tiles", [0.7, 0.08, 0.05], 0.0, 0.2, normalTexture={"index": 1}),
        surface("glow", [0.1, 0.1, 0.1], 0.0, 1.0, emissiveFactor=[1.0, 0.8, 0.5], extensions={
            "KHR_materials_emissive_strength": {"emissiveStrength": 1.5}}),
    ]  # fmt: skip
    materials[0]["pbrMetallicRoughness"]["baseColorTexture"] = {"index": 0}
    bowl = [(0.02, 0.0), (0.4, 0.02), (0.75, 0.2), (0.95, 0.5), (1.0, 0.72), (0.96, 0.74), (0.9, 0.52),
            (0.7, 0.26), (0.4, 0.1), (0.02, 0.07)]  # fmt: skip
    shapes = [table(6.0), lathe(bowl), ball(0.8), ball(0.7), ball(0.3)]
    names = ["table", "bowl", "glass ball", "tiled ball", "lamp"]
    places = [(0, 0, 0), (-1.7, 0, -0.4), (0.2, 0, 0.9), (1.6, 0, -0.7), (-1.7, 0.35, -0.4)]
    nodes: list[dict[str, Any]] = [
        {"name": name, "mesh": k, "translation": [float(part) for part in place]}
        for k, (name, place) in enumerate(zip(names, places, strict=True))
    ]
    down, half = np.radians(-17.0), np.sqrt(0.5)
    nodes += [
        {"name": "Camera", "camera": 0, "translation": [0.0, 2.9, 7.2],
         "rotation": [float(np.sin(down / 2)), 0.0, 0.0, float(np.cos(down / 2))]},
        {"name": "Spot", "translation": [1.0, 6.0, 0.5], "rotation": [-float(half), 0.0, 0.0, float(half)],
         "extensions": {"KHR_lights_punctual": {"light": 0}}},
        {"name": "Window", "translation": [-5.0, 4.0, 5.0],
         "extensions": {"KHR_lights_punctual": {"light": 1}}},
    ]  # fmt: skip
    lights = [
        {"type": "spot", "intensity": 90.0, "color": [1.0, 0.95, 0.85],
         "spot": {"innerConeAngle": 0.3, "outerConeAngle": 0.75}},
        {"type": "point", "intensity": 75.0, "color": [0.8, 0.9, 1.0]},
    ]  # fmt: skip
    pictures = [writer.view(png(pixels)) for pixels in (wood(), tiles())]
    meshes = [writer.mesh(shape, k) for k, shape in enumerate(shapes)]
    used = ["KHR_lights_punctual", *glass, "KHR_materials_emissive_strength"]
    return {
        "asset": {"version": "2.0", "generator": "clrt, scenes/generate_models.py"}, "extensionsUsed": used,
        "scene": 0, "scenes": [{"nodes": list(range(len(nodes)))}], "nodes": nodes, "meshes": meshes,
        "materials": materials, "textures": [{"source": 0}, {"source": 1}],
        "images": [{"bufferView": view, "mimeType": "image/png"} for view in pictures],
        "cameras": [{"type": "perspective", "perspective": {"yfov": 0.5, "aspectRatio": 1.6, "znear": 0.1}}],
        "extensions": {"KHR_lights_punctual": {"lights": lights}},
        "accessors": writer.accessors, "bufferViews": writer.views,
        "buffers": [{"byteLength": len(writer.data)}],
    }  # fmt: skip


def glb() -> bytes:
    """The file."""
    writer = Writer()
    text = json.dumps(document(writer), separators=(",", ":")).encode()
    text += b" " * (-len(text) % 4)
    data = writer.data + b"\0" * (-len(writer.data) % 4)
    head = struct.pack("<4sII", b"glTF", 2, 28 + len(text) + len(data))
    chunks = ((b"JSON", text), (b"BIN\0", data))
    return head + b"".join(struct.pack("<I4s", len(chunk), kind) + chunk for kind, chunk in chunks)


def main() -> None:
    folder = Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).resolve().parent
    (folder / "bowl.glb").write_bytes(glb())


if __name__ == "__main__":
    main()
