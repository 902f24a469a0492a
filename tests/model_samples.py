"""glTF models written by hand: triangles with the materials, cameras and lights that a test is about."""

from __future__ import annotations

import base64
import json
import struct
from pathlib import Path
from typing import Any

import numpy as np

import clrt
from clrt.scene.scene import Mesh, Scene

FLOOR = ((-4.0, 0.0, 4.0), (4.0, 0.0, 4.0), (0.0, 0.0, -4.0))
WALL = ((-1.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 2.0, 0.0))
YELLOW = [1, 0.75, 0.25, 1]
METAL = {"name": "gold", "pbrMetallicRoughness": {"baseColorFactor": YELLOW, "roughnessFactor": 0}}
POINT = {"type": "point", "color": [1, 0.5, 0.25], "intensity": 20}
SUN = {"type": "directional", "intensity": 2}
SPOT = {"type": "spot", "intensity": 50, "spot": {"innerConeAngle": 0.25, "outerConeAngle": 0.5}}
CAMERA = {"type": "perspective", "perspective": {"yfov": 0.75, "aspectRatio": 1.5, "znear": 0.5}}
LIGHTS = "KHR_lights_punctual"


PICTURE = base64.b64decode(
    "iVBORw0KGgoAAAANSUhEUgAAAAIAAAACCAIAAAD91JpzAAAAFklEQVR4nGP438DA8L+BoYHhv4ODAwAodAU+LXdj"
    "cAAAAABJRU5ErkJggg=="
)
"""A PNG of 2 x 2 texels."""


def model(
    materials: list[dict[str, Any]],
    nodes: tuple[dict[str, Any], ...] = (),
    lights: tuple[dict[str, Any], ...] = (),
    **more: Any,
) -> dict[str, Any]:
    """A document: `FLOOR` without a material, and `WALL` of each of the materials, 2 apart, then `nodes`."""
    count = range(len(materials))
    walls = [{"mesh": 1 + k, "name": f"wall {k}", "translation": [2.0 * k, 0.0, 0.0]} for k in count]
    shown = [{"attributes": {"POSITION": 1}, "material": k} for k in count]
    everything = [{"mesh": 0, "name": "floor"}, *walls, *nodes]
    return {
        "asset": {"version": "2.0"},
        "scenes": [{"nodes": list(range(len(everything)))}],
        "nodes": everything,
        "meshes": [
            {"primitives": [{"attributes": {"POSITION": 0}}]},
            *({"primitives": [primitive]} for primitive in shown),
        ],
        **({"materials": materials} if materials else {}),
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"},
            {"bufferView": 0, "byteOffset": 36, "componentType": 5126, "count": 3, "type": "VEC3"},
        ],
        "bufferViews": [{"buffer": 0, "byteLength": 72}],
        "buffers": [{"byteLength": 72}],
        **({"extensions": {LIGHTS: {"lights": list(lights)}}} if lights else {}),
        **more,
    }


def shining(light: int, **more: Any) -> dict[str, Any]:
    """A node with a light."""
    return {"extensions": {LIGHTS: {"light": light}}, **more}


def write_glb(path: Path, table: dict[str, Any], data: bytes | None = None) -> Path:
    """The document as a .glb with its binary chunk: the corners of the two triangles, or other `data`."""
    corners = np.array([FLOOR, WALL], "<f4").tobytes() if data is None else data
    text = json.dumps(table).encode()
    chunks = [(b"JSON", text + b" " * (-len(text) % 4)), (b"BIN\0", corners + b"\0" * (-len(corners) % 4))]
    body = b"".join(struct.pack("<I4s", len(part), kind) + part for kind, part in chunks)
    path.write_bytes(b"glTF" + struct.pack("<II", 2, 12 + len(body)) + body)
    return path


PLASTIC = {
    "name": "plastic",
    "pbrMetallicRoughness": {
        "baseColorFactor": [0.8, 0.1, 0.05, 0.3], "metallicFactor": 0.0, "roughnessFactor": 0.4,
    },
}  # fmt: skip
GLASS = {
    "name": "glass",
    "pbrMetallicRoughness": {"metallicFactor": 0, "roughnessFactor": 0},
    "extensions": {
        "KHR_materials_transmission": {"transmissionFactor": 1},
        "KHR_materials_ior": {"ior": 1.4},
        "KHR_materials_volume": {
            "thicknessFactor": 1, "attenuationColor": [0.5, 1, 0], "attenuationDistance": 2,
        },
    },
}  # fmt: skip


def corners(scene: Scene) -> list[list[list[float]]]:
    """The vertices of all meshes."""
    return [shape.data().vertices.tolist() for shape in scene.shapes if isinstance(shape, Mesh)]


def lobe(roughness: float) -> dict[str, float]:
    alpha = max(roughness**2, 0.05)
    return {"specular": 0.25 / alpha**2, "shininess": max(1.0, 0.5 / alpha**2 - 0.5)}


def metal_rough(base: list[float], metallic: float, roughness: float, **more: Any) -> dict[str, Any]:
    return {
        "pbrMetallicRoughness": {
            "baseColorFactor": [*base, 1], "metallicFactor": metallic, "roughnessFactor": roughness,
        }, **more,
    }  # fmt: skip


UV = ((0.0, 0.0), (1.0, 0.0), (0.0, 1.0))
DATA = f"data:image/png;base64,{base64.b64encode(PICTURE).decode()}"
BASE = {"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}, "metallicFactor": 0}}


def textured(
    material: dict[str, Any], images: tuple[dict[str, Any], ...] = ({"bufferView": 1},), **more: Any
) -> dict[str, Any]:
    """A model of one material whose wall has uv; texture i shows image i."""
    table = model([material])
    table["meshes"][1]["primitives"][0]["attributes"]["TEXCOORD_0"] = 2
    table["accessors"].append(
        {"bufferView": 0, "byteOffset": 72, "componentType": 5126, "count": 3, "type": "VEC2"}
    )
    table["buffers"][0]["byteLength"] = 96 + len(PICTURE)
    table["bufferViews"] = [
        {"buffer": 0, "byteLength": 96}, {"buffer": 0, "byteOffset": 96, "byteLength": len(PICTURE)},
    ]  # fmt: skip
    return {
        **table, "images": list(images), "textures": [{"source": k} for k in range(len(images))], **more,
    }  # fmt: skip


def write(path: Path, table: dict[str, Any]) -> Path:
    corners = np.array([FLOOR, WALL], "<f4").tobytes() + np.array(UV, "<f4").tobytes()
    return write_glb(path, table, corners + PICTURE)


def load(tmp_path: Path, table: dict[str, Any], **options: Any) -> Scene:
    return clrt.load(write(tmp_path / "a.glb", table), **options)
