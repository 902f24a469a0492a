"""glTF files: what is read of them, and that what they declare is summed before it is made."""

from __future__ import annotations

import base64
import json
import re
import struct
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import clrt
from clrt.base.errors import LimitError, SceneError
from clrt.base.limits import Limits
from clrt.base.places import At
from clrt.meshfiles.file import read_mesh_file
from clrt.meshfiles.gltf.document import Node
from clrt.meshfiles.gltf.nodes import matrix_of

TRIANGLE = ((0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0))
POSITIONS = {"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"}
INDICES = {"bufferView": 0, "componentType": 5123, "count": 3, "type": "SCALAR"}
SHOWN = {"attributes": {"POSITION": 0}}


def data_uri(data: bytes) -> str:
    return f"data:application/octet-stream;base64,{base64.b64encode(data).decode()}"


def document(data: bytes = np.array(TRIANGLE, "<f4").tobytes(), **changes: Any) -> dict[str, Any]:
    """A triangle, or something else in its place."""
    return {
        "asset": {"version": "2.0"},
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [SHOWN]}],
        "accessors": [POSITIONS],
        "bufferViews": [{"buffer": 0, "byteLength": len(data)}],
        "buffers": [{"uri": data_uri(data), "byteLength": len(data)}],
        **changes,
    }


def write(folder: Path, table: dict[str, Any] | str) -> Path:
    path = folder / "a.gltf"
    path.write_text(table if isinstance(table, str) else json.dumps(table, separators=(",", ":")))
    return path


def read(path: Path, smooth: bool | None = None) -> Any:
    return read_mesh_file(path, At(), Limits(), smooth)


def glb(table: dict[str, Any] | str, *chunks: tuple[bytes, bytes], version: int = 2) -> bytes:
    text = (table if isinstance(table, str) else json.dumps(table)).encode()
    parts = [(b"JSON", text), *chunks] if text else list(chunks)
    body = b"".join(struct.pack("<I4s", len(part), kind) + part for kind, part in parts)
    return b"glTF" + struct.pack("<II", version, 12 + len(body)) + body


def test_strides_offsets_and_sparse_values(tmp_path: Path) -> None:
    rows = np.zeros((3, 5), "<f4")
    rows[:, 1:4] = TRIANGLE
    data = rows.tobytes() + struct.pack("<B3x3f", 1, 7, 8, 9)
    sparse = {
        "count": 1, "indices": {"bufferView": 1, "componentType": 5121},
        "values": {"bufferView": 1, "byteOffset": 4},
    }  # fmt: skip
    views = [
        {"buffer": 0, "byteLength": 60, "byteStride": 20},
        {"buffer": 0, "byteOffset": 60, "byteLength": 16},
    ]
    position = {**POSITIONS, "byteOffset": 4, "sparse": sparse}
    table = document(data, bufferViews=views, accessors=[position])
    vertices, faces, normals, _ = read(write(tmp_path, table))
    assert vertices.tolist() == [[0, 0, 0], [7, 8, 9], [0, 1, 0]] and faces.tolist() == [[0, 1, 2]]
    assert normals is None
    zeros = {**POSITIONS, "sparse": sparse}
    del zeros["bufferView"]
    vertices, _, _, _ = read(write(tmp_path, document(data, bufferViews=views, accessors=[zeros])))
    assert vertices.tolist() == [[0, 0, 0], [7, 8, 9], [0, 0, 0]]
    none = {**POSITIONS, "byteOffset": 4, "sparse": {**sparse, "count": 0}}
    vertices, _, _, _ = read(write(tmp_path, document(data, bufferViews=views, accessors=[none])))
    assert vertices.tolist() == [list(corner) for corner in TRIANGLE]


@pytest.mark.parametrize(
    ("mode", "faces"),
    [(4, [[3, 2, 1], [0, 1, 2]]), (5, [[3, 2, 1], [0, 1, 2], [1, 0, 1], [2, 1, 0]]),
     (6, [[3, 2, 1], [3, 1, 0], [3, 0, 1], [3, 1, 2]]), (1, None)],
)  # fmt: skip
def test_triangles_strips_and_fans(tmp_path: Path, mode: int, faces: list[list[int]] | None) -> None:
    data = np.array([*TRIANGLE, (1, 1, 0)], "<f4").tobytes() + struct.pack("<6H", 3, 2, 1, 0, 1, 2)
    table = document(
        data,
        accessors=[
            {**POSITIONS, "count": 4},
            {"bufferView": 0, "byteOffset": 48, "componentType": 5123, "count": 6, "type": "SCALAR"},
        ],
        meshes=[{"primitives": [{**SHOWN, "indices": 1, "mode": mode}]}],
    )
    if faces is None:
        with pytest.raises(SceneError, match="has no faces"):
            read(write(tmp_path, table))
    else:
        assert read(write(tmp_path, table))[1].tolist() == faces


def test_whole_numbers_are_scaled_where_the_file_says_so(tmp_path: Path) -> None:
    data = struct.pack("<9bx", 0, 0, 0, 127, 0, 0, 0, -128, 0) + np.array(TRIANGLE, "<f4").tobytes()
    plain = {**POSITIONS, "componentType": 5120}
    for normalized, expected in ((False, [[0, 0, 0], [127, 0, 0], [0, -128, 0]]),
                                 (True, [[0, 0, 0], [1, 0, 0], [0, -1, 0]])):  # fmt: skip
        table = document(data, accessors=[{**plain, "normalized": normalized}])
        assert read(write(tmp_path, table))[0].tolist() == expected


@pytest.mark.parametrize(
    ("normalized", "required", "expected"),
    [(False, True, [3, 0]), (True, True, [3 / 65535, 0]), (False, False, [3 / 65535, 0])],
)
def test_quantized_uv_are_scaled_where_the_file_says_so(
    tmp_path: Path, normalized: bool, required: bool, expected: list[float]
) -> None:
    data = np.array(TRIANGLE, "<f4").tobytes() + struct.pack("<6H", 3, 0, 0, 1, 1, 1)
    uv = {"bufferView": 0, "byteOffset": 36, "componentType": 5123, "count": 3, "type": "VEC2"}
    table = document(
        data,
        accessors=[POSITIONS, {**uv, "normalized": normalized}],
        meshes=[{"primitives": [{"attributes": {"POSITION": 0, "TEXCOORD_0": 1}}]}],
        extensionsRequired=["KHR_mesh_quantization"] if required else [],
    )
    assert read(write(tmp_path, table))[3][0].tolist() == expected


def test_nodes_move_turn_scale_and_mirror(tmp_path: Path) -> None:
    normals = np.array([[0, 0, 2]] * 3, "<f4").tobytes()
    half = 0.5**0.5
    table = document(
        np.array(TRIANGLE, "<f4").tobytes() + normals,
        accessors=[POSITIONS, {**POSITIONS, "byteOffset": 36}],
        meshes=[{"primitives": [{"attributes": {"POSITION": 0, "NORMAL": 1}}]}],
        nodes=[
            {"children": [1, 2], "translation": [0, 0, 5]},
            {"mesh": 0, "rotation": [0, 0, 3 * half, 3 * half], "scale": [2, 2, 2]},
            {"mesh": 0, "matrix": [-1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, *[1] * 4]},
        ],
    )
    vertices, faces, turned, _ = read(write(tmp_path, table))
    mirrored = [[1, 1, 6], [0, 1, 6], [1, 2, 6]]
    np.testing.assert_allclose(vertices, [*mirrored, [0, 0, 5], [0, 2, 5], [-2, 0, 5]], atol=1e-15)
    assert faces.tolist() == [[2, 1, 0], [3, 4, 5]]
    np.testing.assert_allclose(turned, [[0, 0, 1]] * 6, atol=1e-15)


def test_a_rotation_of_zeros_turns_nothing_and_what_no_scene_shows_moves_nothing(tmp_path: Path) -> None:
    nodes = [{"mesh": 0, "rotation": [0, 0, 0, 0]}, {"children": [2], "scale": [9, 9, 9]}, {"mesh": 0}]
    table = document(nodes=nodes, scenes=[{"nodes": [0]}, {"nodes": [1]}], scene=0)
    assert read(write(tmp_path, table))[0].tolist() == np.array(TRIANGLE).tolist()


def test_colours_warn_once_for_all_shapes_of_a_file(tmp_path: Path) -> None:
    table = document(meshes=[{"primitives": [{"attributes": {"POSITION": 0, "COLOR_0": 0}}]}])
    shapes = [{"type": "mesh", "file": write(tmp_path, table).name}] * 300
    with pytest.warns(clrt.ClrtWarning, match="its materials and colours are ignored") as said:
        scene = clrt.load_dict({"shapes": shapes}, folder=tmp_path)
    assert len(said) == 1
    first, second = scene.shapes[:2]
    assert first.data() is second.data()  # type: ignore[attr-defined]


@pytest.mark.parametrize(
    ("changes", "says"),
    [
        ({"nodes": [{"mesh": 0, "skin": 0, "translation": [100, 0, 0]}]}, "skins"),
        ({"nodes": [{"mesh": 0, "weights": [0, 0.5]}]}, "morph targets"),
        ({"meshes": [{"primitives": [SHOWN], "weights": [1]}]}, "morph targets"),
        ({"nodes": [{"mesh": 0, "extensions": {"EXT_mesh_gpu_instancing": {}}}]}, "instances"),
        ({"nodes": [{"mesh": 0, "skin": 0, "weights": [1]}]}, "skins and morph targets"),
        ({"nodes": [{"mesh": 0, "extensions": {"EXT_other": {}}}]}, ""),
        # the node's own weights come first
        ({"nodes": [{"mesh": 0, "weights": [0]}], "meshes": [{"primitives": [SHOWN], "weights": [1]}]}, ""),
        ({"nodes": [{"mesh": 0, "weights": [0]}, {"skin": 0}], "skins": [{"joints": [1]}]}, ""),
    ],
)
def test_what_would_move_a_mesh_and_is_left_out(
    tmp_path: Path, changes: dict[str, Any], says: str, recwarn: pytest.WarningsRecorder
) -> None:
    """A mesh with a skin stands where it was modelled: the specification, 3.7.4."""
    assert read(write(tmp_path, document(**changes)))[0].tolist() == [list(corner) for corner in TRIANGLE]
    told = [f"a.gltf: its {says} are left out; save it with them applied"] if says else []
    assert [str(warning.message) for warning in recwarn] == told


@pytest.mark.parametrize(
    "name",
    ["KHR_materials_unlit", "KHR_texture_transform", "EXT_texture_webp", "KHR_mesh_quantization",
     "KHR_lights_punctual", "KHR_draco_mesh_compression"],
)  # fmt: skip
def test_extensions_of_what_is_not_read_may_be_required(tmp_path: Path, name: str) -> None:
    assert len(read(write(tmp_path, document(extensionsRequired=[name])))[1]) == 1


def test_the_meshes_of_a_scene_count_together(tmp_path: Path) -> None:
    shape = {"type": "mesh", "file": write(tmp_path, document()).name}
    other = {"type": "mesh", "vertices": TRIANGLE, "faces": [[0, 1, 2]]}
    for shapes, place in (([shape] * 3, r"\[0\]\.file"), ([shape, shape, other], r"\[2\]\.vertices")):
        with pytest.raises(LimitError, match=rf"shapes{place}: vertices: 9 is above the limit of 8"):
            clrt.load_dict({"shapes": shapes}, folder=tmp_path, limits=Limits(vertices=8))
    smooth = [shape, {**shape, "smooth": False}, {**shape, "smooth": True}]
    with pytest.raises(LimitError, match=r"shapes\[2\]\.file: primitives: 3 is above the limit of 2"):
        clrt.load_dict({"shapes": smooth}, folder=tmp_path, limits=Limits(primitives=2))
    with pytest.raises(LimitError, match=r"shapes\[0\]\.file: primitives: 3 is above the limit of 2"):
        clrt.load_dict({"shapes": [shape] * 3}, folder=tmp_path, limits=Limits(primitives=2))


CHUNK = (b"BIN\0", np.array(TRIANGLE, "<f4").tobytes())


def test_binary_files(tmp_path: Path) -> None:
    path = tmp_path / "a.glb"
    path.write_bytes(glb(document(buffers=[{}]), (b"MORE", b"xyz"), CHUNK, CHUNK))
    assert read(path)[0].tolist() == [list(corner) for corner in TRIANGLE]
    padded = (CHUNK[0], CHUNK[1] + bytes(3))
    path.write_bytes(glb(document(buffers=[{"byteLength": 36}]), padded))
    assert read(path)[0].tolist() == [list(corner) for corner in TRIANGLE]
    whole = glb(document(buffers=[{}]), CHUNK)
    for data, says in (
        (glb(document(buffers=[{}])), r"buffers\[0\] has no data"),
        (glb(document(buffers=[{"byteLength": 40}]), CHUNK), "byteLength is 40, and it has 36 bytes"),
        (whole[:-1], f"says {len(whole)} bytes, and it has {len(whole) - 1}$"),
        (whole[:8] + b"\xff" * 4 + whole[12:], "says 4294967295 bytes"),
        (re.sub(rb"....(?=BIN)", b"\xf0" * 4, whole, flags=re.DOTALL), "before its last chunk"),
        (glb("", CHUNK), "has no JSON chunk"),
        (glb(document(), version=1), "only glTF of version 2"),
        (b"glTF", "does not begin as a .glb file"),
        (glb("[" * 100_000), "Expected `object`"),
        (glb(document()).replace(b"2.0", b"1.0"), "only glTF of version 2"),
        (b"x" * 40, "does not begin as a .glb file"),
        (glb(document()).replace(b"data:app", b"data:\xffpp"), "is not that of a glTF file"),
    ):
        path.write_bytes(data)
        with pytest.raises(SceneError, match=f"a.glb cannot be read as a mesh: .*{says}"):
            read(path)


def test_nested_brackets_and_one_part_at_two_places(tmp_path: Path) -> None:
    with pytest.raises(SceneError, match="its JSON is nested too deeply"):
        read(write(tmp_path, '{"extras":' + "[" * 100_000))
    table = document(meshes=[{"primitives": [SHOWN, SHOWN]}])
    assert read(write(tmp_path, table))[1].tolist() == [[0, 1, 2], [3, 4, 5]]


def test_a_byte_order_mark_is_passed_over(tmp_path: Path) -> None:
    assert len(read(write(tmp_path, "\ufeff" + json.dumps(document())))[1]) == 1


def test_the_last_row_of_a_matrix_may_be_rounded() -> None:
    rounded = (1.0, 0, 0, 1e-7, 0, 1, 0, 0, 0, 0, 1, 0, 2, 3, 4, 1.0000001)
    found = matrix_of(Node(matrix=rounded), 0, np.eye(4))
    assert found[3].tolist() == [0, 0, 0, 1] and found[:3, 3].tolist() == [2, 3, 4]


STATED_BY_NULL = {
    "nodes": [{"mesh": 0, "name": None, "matrix": None, "extensions": {"KHR_lights_punctual": {"light": 0}}},
              {"camera": 0}],
    "scenes": [{"nodes": [0, 1], "name": None}],
    "accessors": [{**POSITIONS, "byteOffset": None, "normalized": None}],
    "materials": [{"pbrMetallicRoughness": None, "name": "null: null"}],
    "meshes": [{"primitives": [{**SHOWN, "material": 0, "indices": None}]}],
    "cameras": [{"type": "orthographic", "orthographic": {"xmag": 2, "ymag": 1, "znear": -1, "zfar": 9},
                 "perspective": None, "name": None}],
    "extensions": {"KHR_lights_punctual": {"lights": [{"type": "point", "range": 0, "spot": None}]}},
    "extensionsUsed": ["KHR_lights_punctual"],
}  # fmt: skip


def test_null_and_zeros_are_what_is_not_stated(tmp_path: Path) -> None:
    """As exporters of three.js, Babylon, Poly and gltf-vscode wrote them."""
    table = document(**STATED_BY_NULL)
    table["bufferViews"][0]["byteStride"] = 0
    scene = clrt.load(write(tmp_path, table))
    (light,), (mesh,) = scene.lights, scene.shapes
    assert light.type == "point" and scene.camera is not None
    assert (scene.camera.type, scene.camera.near, scene.camera.size) == ("orthographic", 0, 4)
    assert mesh.data().vertices.tolist() == [[0, 0, 0], [1, 0, 0], [0, 1, 0]]
    assert "null: null" in scene.materials
    for wrong in ({"nodes": [None]}, {"nodes": [{"mesh": 0, "mesh ": None, "scale": [1, None, 1]}]}):
        with pytest.raises(SceneError, match="its JSON is not that of a glTF file"):
            clrt.load(write(tmp_path, document(**wrong)))
