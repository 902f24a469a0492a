"""Good inputs to spoil: a small one of every format that clrt reads."""

from __future__ import annotations

import base64
import json
import struct
import tempfile
import warnings
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any, Final

import numpy as np
import tomli_w

import clrt

from ..scenes import matrix, terms, views
from ..scenes.parts import Table

SIDE: Final = {"width": 12, "height": 9}

NFF: Final = """\
b 0.1 0.2 0.3
v
from 0 1 5
at 0 0 0
up 0 1 0
angle 40
hither 1
resolution 12 9
l 3 4 5 1 0.9 0.8
l -3 4 5
f 0.9 0.3 0.2 0.6 0.3 20 0.2 1.5
s 0 0 0 1
c -2 0 0 0.5 -2 1 0 0.2
f 0.3 0.4 0.9 1 0 0 0 0
p 4
-3 -1 -3
-3 -1 3
3 -1 3
3 -1 -3
pp 3
0 0 -2 0 0 1
1 0 -2 0.1 0 1
0 1 -2 0 0.1 1
"""

THESIS: Final = """\
Width 12
Height 9
Focal 0 20 -30
Ambient 0.6
Light Point 10 40 -20 Spectrum 380 740 Intensity 200
Sphere Point 0 20 0 Radius 8 Surface Spectrum Red Constants 0.6 0.3 0.2 1.3 20
Plane Point 0 0 0 Vector 0 1 0 Surface Spectrum 500 600 Constants 0.8 0.1 0 1 5
Polygon Point -9 5 9 Point 9 5 9 Point 0 25 12 Surface Spectrum Magenta Constants 0.7 0.2 0 1 9
Mesh Polygon Point -9 5 3 Point -5 5 3 Point -7 9 4 Surface None Polygon Point 9 5 3 Point 5 5 3 Point 7 9 4
Surface None Surface Spectrum Red Constants 0.5 0.5 0 1 3
Ellipsoid Center 6 30 4 Radii 2 3 4 Surface Spectrum 380 500 Constants 0.6 0.3 0 1 5
Quadric Constants 1 0 1 0 0 0 0 0 0 -9 Surface Spectrum 600 700 Constants 0.5 0 0 1 1
"""


RESUMED: Final[Table] = {
    "camera": {"origin": [0, 0, 4], "target": [0, 0, 0], **SIDE},
    "lights": [
        {"type": "point", "position": [3, 5, 4]},
        {"type": "spot", "position": [-3, 5, 4], "target": [0, 0, 0], "angle": 25, "penumbra": 0.2},
        {"type": "rectangle", "center": [0, 4, 0], "u": [0.5, 0, 0], "v": [0, 0, 0.5], "samples": 3},
        {"type": "disk", "center": [2, 3, 0], "normal": [-1, -1, 0], "radius": 0.4, "samples": 2},
        {"type": "sphere", "center": [-2, 3, 1], "radius": 0.3, "samples": 2, "two_sided": True},
    ],
    "shapes": [{"type": "sphere", "center": [0, 0, 0], "radius": 1}],
}
"""The scene whose checkpoint is spoiled."""


@cache
def tables() -> tuple[Table, ...]:
    """Scenes of the project's own structure, every kind of shape, material, light and camera among them."""
    found = [scene for module in (terms, views, matrix) for _, scene, _ in module.scenes()]
    plain = [scene for scene in found if not callable(scene) and not isinstance(scene.get("background"), str)]
    return tuple({**scene, "camera": {**scene["camera"], **SIDE}} for scene in plain)


@cache
def meshes() -> dict[str, bytes]:
    """Files of a ball by suffix; some also in the format's other form."""
    import trimesh

    ball = trimesh.creation.icosphere(subdivisions=1)
    ball.vertex_normals  # noqa: B018  (asked for, so that they are written)
    forms: dict[str, dict[str, Any]] = {"obj": {}, "ply": {}, "glb": {}, "stl": {}}
    out = {f".{kind}": _bytes(ball.export(file_type=kind, **options)) for kind, options in forms.items()}
    out[".ascii.ply"] = _bytes(ball.export(file_type="ply", encoding="ascii"))
    out[".ascii.stl"] = _bytes(ball.export(file_type="stl_ascii"))
    parts = trimesh.Scene(ball).export(file_type="gltf", merge_buffers=True)
    out[".gltf"] = _dressed(_self_contained(parts))
    (length,) = struct.unpack_from("<I", out[".glb"], 12)
    text = _dressed(out[".glb"][20 : 20 + length])
    text += b" " * (-len(text) % 4)
    rest = out[".glb"][20 + length :]
    head = struct.pack("<4sIII4s", b"glTF", 2, 20 + len(text) + len(rest), len(text), b"JSON")
    out[".glb"] = head + text + rest
    return out


def _dressed(text: bytes) -> bytes:
    """A document with a material, its pictures, a camera and a light besides."""
    tree = json.loads(text)
    primitive = tree["meshes"][0]["primitives"][0]
    places = tree["accessors"][primitive["attributes"]["POSITION"]]
    primitive["attributes"]["TEXCOORD_0"] = len(tree["accessors"])
    tree["accessors"].append({**{k: v for k, v in places.items() if k not in ("min", "max")}, "type": "VEC2"})
    primitive["material"] = 0
    picture = base64.b64encode(images()[".png"]).decode()
    lamp = {"type": "spot", "intensity": 40.0, "color": [1.0, 0.9, 0.8], "range": 50.0,
            "spot": {"innerConeAngle": 0.2, "outerConeAngle": 0.6}}  # fmt: skip
    glass = {
        "KHR_materials_transmission": {"transmissionFactor": 0.5}, "KHR_materials_ior": {"ior": 1.4},
        "KHR_materials_volume": {
            "thicknessFactor": 1.0, "attenuationDistance": 2.0, "attenuationColor": [0.9, 0.5, 0.5],
        },
    }  # fmt: skip
    metal = {
        "baseColorFactor": [0.9, 0.5, 0.2, 1.0], "metallicFactor": 0.5, "roughnessFactor": 0.4,
        "baseColorTexture": {"index": 0}, "metallicRoughnessTexture": {"index": 0},
    }  # fmt: skip
    tree["materials"] = [{
        "name": "m", "pbrMetallicRoughness": metal, "extensions": glass, "emissiveFactor": [0.1, 0.0, 0.0],
        "normalTexture": {"index": 0, "scale": 0.5}, "alphaMode": "MASK",
    }]  # fmt: skip
    tree["images"] = [{"uri": f"data:image/png;base64,{picture}", "mimeType": "image/png"}]
    tree["samplers"] = [{"wrapS": 10497, "wrapT": 10497, "magFilter": 9728}]
    tree["textures"] = [{"source": 0, "sampler": 0}]
    lens = {"yfov": 0.8, "znear": 0.1, "aspectRatio": 1.5}
    tree["cameras"] = [{"type": "perspective", "perspective": lens}]
    tree["extensions"] = {"KHR_lights_punctual": {"lights": [lamp]}}
    first = len(tree["nodes"])
    tree["nodes"] += [
        {"camera": 0, "translation": [0.0, 0.0, 5.0]},
        {"extensions": {"KHR_lights_punctual": {"light": 0}}, "translation": [1.0, 2.0, 4.0]},
    ]
    tree["scenes"][0]["nodes"] += [first, first + 1]
    return json.dumps(tree).encode()


def _self_contained(parts: dict[str, bytes]) -> bytes:
    tree = json.loads(parts["model.gltf"])
    for buffer in tree["buffers"]:
        coded = base64.b64encode(parts[buffer["uri"]]).decode()
        buffer["uri"] = f"data:application/octet-stream;base64,{coded}"
    return json.dumps(tree).encode()


def _bytes(exported: str | bytes) -> bytes:
    return exported.encode() if isinstance(exported, str) else exported


@cache
def images() -> dict[str, bytes]:
    """Small pictures by suffix."""
    import OpenImageIO as oiio

    pixels = np.linspace(0, 1, 8 * 16 * 3).reshape(8, 16, 3)
    out: dict[str, bytes] = {}
    with tempfile.TemporaryDirectory() as folder:
        for suffix in (".png", ".jpg", ".exr", ".hdr", ".bmp", ".tif"):
            path = Path(folder, f"x{suffix}")
            kind = "float" if suffix in (".exr", ".hdr") else "uint8"
            writer = oiio.ImageOutput.create(str(path))
            assert writer
            writer.open(str(path), oiio.ImageSpec(16, 8, 3, kind))
            writer.write_image(pixels.astype(np.float32))
            writer.close()
            out[suffix] = path.read_bytes()
    return out


@cache
def layered() -> bytes:
    """An .exr with layers, mattes among them."""
    with tempfile.TemporaryDirectory() as folder:
        wanted = ["depth", "shape", "normal", "crypto_shape", "crypto_material"]
        path = Path(folder, "x.exr")
        clrt.render(clrt.load_dict(RESUMED), layers=wanted, width=16, height=8).save(path)
        return path.read_bytes()


@cache
def checkpoint() -> bytes:
    """The finished checkpoint of RESUMED."""
    with tempfile.TemporaryDirectory() as folder:
        clrt.render(clrt.load_dict(RESUMED), checkpoint=Path(folder, "part.ck"))
        return Path(folder, "part.ck").read_bytes()


def as_toml(table: Table) -> bytes:
    """The table as TOML; values that TOML has no word for (None) become JSON's."""
    try:
        return tomli_w.dumps(table).encode("utf-8", "surrogatepass")
    except (TypeError, ValueError, AttributeError, RecursionError):
        return as_json(table)


def as_json(table: Table) -> bytes:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            return json.dumps(table, default=str).encode("utf-8", "surrogatepass")
        except (RecursionError, ValueError):
            return b"{}"


WRITERS: Final[dict[str, Callable[[Table], bytes]]] = {".toml": as_toml, ".json": as_json}

__all__ = ["NFF", "RESUMED", "THESIS", "WRITERS", "checkpoint", "images", "meshes", "tables"]
