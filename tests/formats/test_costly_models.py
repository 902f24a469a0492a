"""Models that once took far more time or memory than they have bytes."""

from __future__ import annotations

import base64
import json
import struct
import zlib
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import clrt
from clrt.base.errors import LimitError, SceneError
from clrt.flatten.flatten import flatten
from clrt.meshfiles.parts import MOST_GROUPS
from tests.cost import bounded
from tests.model_samples import PICTURE

CORNERS = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]], "<f4").tobytes()
UV = np.array([[0, 0], [1, 0], [0, 1]], "<f4").tobytes()
ROUGH, BASE = "metallicRoughnessTexture", "baseColorTexture"


def png(width: int, height: int, more: bytes = b"") -> bytes:
    """A grey PNG of few bytes, with `more` behind its end."""

    def chunk(kind: bytes, data: bytes) -> bytes:
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    rows = zlib.compress((b"\0" + b"\x80" * width) * height, 9)
    head = chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 0, 0, 0, 0))
    return b"\x89PNG\r\n\x1a\n" + head + chunk(b"IDAT", rows) + chunk(b"IEND", b"") + more


def write(
    folder: Path, materials: list[dict[str, Any]], pictures: list[Any], data: bytes = b"", **more: Any
) -> Path:
    """A triangle of each of the materials, whose texture k is picture k; buffer 0 ends with `data`."""
    buffer = CORNERS + UV + data
    views = [{"buffer": 0, "byteLength": 36}, {"buffer": 0, "byteOffset": 36, "byteLength": 24},
             {"buffer": 0, "byteOffset": 60, "byteLength": len(data)}]  # fmt: skip
    numbers = {"componentType": 5126, "count": 3}
    places = [{"bufferView": 0, "type": "VEC3", **numbers}, {"bufferView": 1, "type": "VEC2", **numbers}]
    table = {
        "asset": {"version": "2.0"},
        "buffers": [{"uri": "data:;base64," + base64.b64encode(buffer).decode()}],
        "bufferViews": views[: 3 if data else 2],
        "accessors": places,
        "meshes": [{"primitives": [
            {"attributes": {"POSITION": 0, "TEXCOORD_0": 1}, "material": k} for k in range(len(materials))
        ]}],
        "nodes": [{"mesh": 0}], "scenes": [{"nodes": [0]}], "materials": materials, "images": pictures,
        "textures": [{"source": k} for k in range(len(pictures))],
    }  # fmt: skip
    path = folder / "a.gltf"
    path.write_text(json.dumps(table | more))
    return path


def textured(slot: str, texture: int = 0) -> dict[str, Any]:
    return {"pbrMetallicRoughness": {slot: {"index": texture}}}


def inside(data: bytes) -> dict[str, Any]:
    return {"uri": "data:image/png;base64," + base64.b64encode(data).decode()}


def test_one_picture_of_many_materials_is_read_once(tmp_path: Path) -> None:
    path = write(tmp_path, [textured(ROUGH)] * 100, [inside(png(2500, 2500))])
    assert bounded("read", path, 40 * 2500 * 2500).error == ""


def test_many_pictures_of_the_same_bytes_count_together(tmp_path: Path) -> None:
    data = png(3000, 3000)
    path = write(tmp_path, [textured(ROUGH, k) for k in range(40)], [{"bufferView": 2}] * 40, data)
    with pytest.raises(LimitError, match=r"a\.gltf: images\[7\]: image_pixels"):
        clrt.load(path)
    path = write(tmp_path, [textured(BASE, k) for k in range(40)], [{"bufferView": 2}] * 40, data)
    scene = clrt.load(path, limits=clrt.Limits(file_bytes=len(data) * 8))
    with pytest.raises(LimitError, match=r"a\.gltf: its pictures together: file_bytes"):
        flatten(scene)


def test_many_materials_and_pictures_of_one_file(tmp_path: Path) -> None:
    count = 600
    pictures = [inside(PICTURE + b"%d" % k) for k in range(count)]
    path = write(tmp_path, [textured(BASE, k) for k in range(count)], pictures)
    # 2 x 2 pixels take a reader of pictures a millisecond, which no bound for bytes knows
    assert bounded("load", path, 2_000_000 * count).error == ""


def test_parts_that_a_scene_names_one_by_one(tmp_path: Path) -> None:
    write(tmp_path, [{}] * 1500, [])
    shapes = [{"type": "mesh", "file": "a.gltf", "part": k} for k in range(1500)]
    (tmp_path / "a.json").write_text(json.dumps({"shapes": shapes}))
    assert bounded("load", tmp_path / "a.json").error == ""


def test_more_materials_than_shapes_of_their_own(tmp_path: Path) -> None:
    path = write(tmp_path, [{}] * (MOST_GROUPS + 1), [])
    with pytest.raises(SceneError, match=rf"it shows {MOST_GROUPS + 1} materials; at most {MOST_GROUPS} are"):
        clrt.load(path)


def test_a_tint_each_of_one_picture(tmp_path: Path) -> None:
    (tmp_path / "a.png").write_bytes(PICTURE)
    ball = {"type": "sphere", "center": [0, 0, 0], "radius": 1}
    colors = [{"type": "image", "file": "a.png", "tint": [k / 3000, 1, 1]} for k in range(3000)]
    shapes = [{**ball, "material": {"color": color}} for color in colors]
    (tmp_path / "a.json").write_text(json.dumps({"shapes": shapes}))
    assert bounded("load", tmp_path / "a.json").error == ""
    textures = flatten(clrt.load(tmp_path / "a.json")).textures
    assert textures["first"].tolist() == list(range(0, 12_000, 4))


def test_colours_of_vertices_that_are_not_there(tmp_path: Path) -> None:
    numbers = {"componentType": 5126, "count": 3}
    places = [{"bufferView": 0, "type": "VEC3", **numbers}, {"bufferView": 1, "type": "VEC2", **numbers}]
    sparse = {"count": 1, "indices": {"bufferView": 0, "componentType": 5121}, "values": {"bufferView": 0}}
    shown = [{"primitives": [{"attributes": {"POSITION": 0, "COLOR_0": 2}}]}]
    many = {"componentType": 5126, "count": 60_000_000, "type": "VEC3", "sparse": sparse}
    path = write(tmp_path, [], [], accessors=[*places, many], meshes=shown)
    assert r"accessors[2] has not one colour for each of 3 vertices" in bounded("load", path).error
    found = {"bufferView": 2, "type": "VEC3", **numbers}
    wrong = np.array([np.nan, *[1.0] * 8], "<f4").tobytes()
    path = write(tmp_path, [], [], wrong, accessors=[*places, found], meshes=shown)
    with pytest.raises(SceneError, match=r"accessors\[2\] holds colours that are not finite"):
        clrt.load(path)


def library(folder: Path, head: str, mtl: str) -> Path:
    pytest.importorskip("trimesh", reason="needs the optional dependency clrt[mesh]")
    (folder / "a.mtl").write_text(mtl)
    (folder / "t.png").write_bytes(PICTURE)
    path = folder / "a.obj"
    path.write_text(f"{head}v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nusemtl m\nf 1/1 2/2 3/3\n")
    return path


def test_a_library_of_many_names_is_read_once(tmp_path: Path) -> None:
    head = "".join(f"mtllib {'./' * (k % 50)}a.mtl\n" for k in range(400))
    path = library(tmp_path, head, "newmtl m\n" + "Kd 0.5 0.25 1\n" * 20_000)
    assert bounded("read", path).error == ""
    assert clrt.load(path).materials["m"].color == (0.5, 0.25, 1.0)


def test_pictures_of_a_library_are_looked_for_where_they_are_used(tmp_path: Path) -> None:
    path = library(tmp_path, "mtllib a.mtl\n", "newmtl m\n" + "map_Kd ././././t.png\n" * 40_000)
    assert bounded("read", path).error == ""
    path = library(tmp_path, "mtllib a.mtl\n", "newmtl other\nmap_Kd /etc/passwd\nnewmtl m\nKd 1 1 1\n")
    assert clrt.load(path).materials["m"].color == (1.0, 1.0, 1.0)


def test_a_model_is_read_once_however_it_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    write(tmp_path, [{}, {}], [])
    monkeypatch.chdir(tmp_path)
    opened: list[object] = []
    monkeypatch.setattr("clrt.meshfiles.file.read_mesh_file", lambda *given: opened.append(given))
    assert len(clrt.load("a.gltf").shapes) == 2 and not opened
