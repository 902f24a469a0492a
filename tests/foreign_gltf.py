"""glTF models with extensions as exporters write them, each made here."""

from __future__ import annotations

import io
import json
import struct
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image

from tests.foreign_shapes import SCENES, ball


def _glb(path: Path, tree: dict[str, Any], chunks: list[bytes]) -> Path:
    """A GLB of a document whose buffer views are the chunks."""
    views, data = [], b""
    for chunk in chunks:
        views.append({"buffer": 0, "byteOffset": len(data), "byteLength": len(chunk)})
        data += chunk + bytes(-len(chunk) % 4)
    tree = {
        "asset": {"version": "2.0", "generator": "by hand"},
        **tree,
        "bufferViews": views,
        "buffers": [{"byteLength": len(data)}],
    }
    text = json.dumps(tree).encode()
    text += b" " * (-len(text) % 4)
    head = struct.pack("<III", 0x46546C67, 2, 28 + len(text) + len(data))
    path.write_bytes(
        head
        + struct.pack("<II", len(text), 0x4E4F534A)
        + text
        + struct.pack("<II", len(data), 0x4E4942)
        + data
    )
    return path


def _arrays(*arrays: np.ndarray) -> tuple[list[bytes], list[dict[str, Any]]]:
    kinds = {("f", 3): (5126, "VEC3"), ("f", 2): (5126, "VEC2"), ("u", 1): (5125, "SCALAR")}
    accessors = []
    for number, array in enumerate(arrays):
        component, kind = kinds[array.dtype.kind, array.shape[1] if array.ndim > 1 else 1]
        accessors.append(
            {"bufferView": number, "componentType": component, "count": len(array), "type": kind}
        )
    return [array.tobytes() for array in arrays], accessors


def khr_materials(folder: Path) -> Path:
    """glTF with lamps, glass of a volume, its index, strong emission, a metal and a clear sheet."""
    vertices, _, faces = ball()
    ground = np.array([[-6, -1, 4], [6, -1, 4], [6, -1, -6], [-6, -1, -6]], "<f4")
    chunks, accessors = _arrays(
        vertices.astype("<f4"), faces.astype("<u4").reshape(-1), ground, np.array([0, 1, 2, 0, 2, 3], "<u4")
    )
    sphere = {"POSITION": 0, "NORMAL": 0}
    meshes = [{"primitives": [{"attributes": sphere, "indices": 1, "material": k}]} for k in range(4)]
    meshes += [{"primitives": [{"attributes": {"POSITION": 2}, "indices": 3, "material": 4}]}]
    ext = "KHR_materials_"
    glass = {
        ext + "transmission": {"transmissionFactor": 1},
        ext + "ior": {"ior": 1.45},
        ext + "volume": {"thicknessFactor": 1, "attenuationColor": [0.5, 0.9, 0.7], "attenuationDistance": 1},
    }
    materials = [
        {
            "name": "glass",
            "pbrMetallicRoughness": {"metallicFactor": 0, "roughnessFactor": 0},
            "extensions": glass,
        },
        {
            "name": "lamp",
            "emissiveFactor": [1, 0.6, 0.2],
            "extensions": {ext + "emissive_strength": {"emissiveStrength": 2}},
        },
        {
            "name": "gold",
            "pbrMetallicRoughness": {"baseColorFactor": [1, 0.76, 0.33, 1], "roughnessFactor": 0.2},
        },
        {
            "name": "red",
            "pbrMetallicRoughness": {
                "baseColorFactor": [0.7, 0.05, 0.04, 1],
                "metallicFactor": 0,
                "roughnessFactor": 0.3,
            },
        },
        {
            "name": "ground",
            "pbrMetallicRoughness": {"baseColorFactor": [0.5, 0.5, 0.5, 1], "metallicFactor": 0},
        },
    ]
    lights = [{"type": "point", "intensity": 60, "name": "Light"}, {"type": "directional", "intensity": 1.5}]
    places = [[-1.1, 0, 1.2], [-2.6, 0, -1.6], [0.4, 0, -2.2], [1.6, 0, 0.4]]
    nodes: list[dict[str, Any]] = [
        {"mesh": k, "translation": at, "name": f"Ball.00{k}"} for k, at in enumerate(places)
    ]
    nodes += [
        {"mesh": 4, "name": "Ground"},
        {"translation": [2, 5, 4], "extensions": {"KHR_lights_punctual": {"light": 0}}},
        {"rotation": [-0.5, 0.2, 0, 0.84], "extensions": {"KHR_lights_punctual": {"light": 1}}},
        {"translation": [0, 2.2, 8], "rotation": [-0.13, 0, 0, 0.9915], "camera": 0, "name": "Camera"},
    ]
    return _glb(
        folder / "khr.glb",
        {
            "scene": 0,
            "scenes": [{"nodes": list(range(len(nodes)))}],
            "nodes": nodes,
            "meshes": meshes,
            "materials": materials,
            "accessors": accessors,
            "extensions": {"KHR_lights_punctual": {"lights": lights}},
            "cameras": [
                {"type": "perspective", "perspective": {"yfov": 0.62, "aspectRatio": 4 / 3, "znear": 0.1}}
            ],
            "extensionsUsed": ["KHR_lights_punctual", *glass, ext + "emissive_strength"],
        },
        chunks,
    )


def khr_textures(folder: Path) -> Path:
    """glTF with a moved and repeated picture, and a ball whose dents are a sparse accessor."""
    vertices, uv, faces = ball()
    picture = io.BytesIO()
    Image.open(SCENES / "tiles.png").convert("RGB").save(picture, "PNG")
    dented = np.flatnonzero(vertices @ [0.3, 0.5, 0.81] > 0.86)
    dents = (vertices[dented] * 0.72).astype("<f4")
    down = np.stack([uv[:, 0], 1 - uv[:, 1]], axis=1).astype("<f4")
    chunks, accessors = _arrays(vertices.astype("<f4"), faces.astype("<u4").reshape(-1), down)
    sparse = {
        "count": len(dented),
        "indices": {"bufferView": 3, "componentType": 5125},
        "values": {"bufferView": 4},
    }
    accessors.append(accessors[0] | {"sparse": sparse})
    chunks += [dented.astype("<u4").tobytes(), dents.tobytes(), picture.getvalue()]
    info = {"index": 0, "extensions": {"KHR_texture_transform": {"scale": [4, 2], "offset": [0.1, 0.25]}}}
    material = {
        "name": "tiles",
        "pbrMetallicRoughness": {"baseColorTexture": info, "metallicFactor": 0, "roughnessFactor": 0.25},
    }
    shown = [
        {"attributes": {"POSITION": number, "TEXCOORD_0": 2}, "indices": 1, "material": 0}
        for number in (0, 3)
    ]
    return _glb(
        folder / "textures.glb",
        {
            "scene": 0,
            "scenes": [{"nodes": [0, 1]}],
            "meshes": [{"primitives": [one]} for one in shown],
            "nodes": [{"mesh": 0, "translation": [-1.1, 0, 0]}, {"mesh": 1, "translation": [1.1, 0, 0]}],
            "materials": [material],
            "textures": [{"source": 0, "sampler": 0}],
            "samplers": [{"wrapS": 10497}],
            "images": [{"bufferView": 5, "mimeType": "image/png"}],
            "accessors": accessors,
            "extensionsUsed": ["KHR_texture_transform"],
        },
        chunks,
    )
