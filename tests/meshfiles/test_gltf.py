"""glTF files: what is read of them, and that what they declare is summed before it is made."""

from __future__ import annotations

import base64
import json
import struct
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import clrt
from clrt.base.errors import LimitError, SceneError
from clrt.base.files import read_bytes
from clrt.base.limits import Limits
from clrt.base.places import At
from clrt.meshfiles.file import read_mesh_file
from tests.cost import bounded

TRIANGLE = ((0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0))
POSITIONS = {"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"}
SPARSE = {"indices": {"bufferView": 0, "componentType": 5125}, "values": {"bufferView": 0}, "count": 1}
HUGE = {"componentType": 5126, "count": 300_000_000, "type": "VEC3", "sparse": SPARSE}
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


@pytest.mark.parametrize(
    ("name", "table", "says"),
    [
        ("vertices", document(accessors=[HUGE]), "primitives: 100 000 000 is above the limit"),
        ("indices", document(
            accessors=[POSITIONS, {**HUGE, "componentType": 5125, "type": "SCALAR"}],
            meshes=[{"primitives": [{**SHOWN, "indices": 1}]}],
        ), "primitives: 100 000 000 is above the limit"),
        ("a strip of nothing", document(accessors=[HUGE], meshes=[{"primitives": [{**SHOWN, "mode": 5}]}]),
         "primitives: 299 999 998"),
        ("vertices of few faces", document(
            accessors=[HUGE, {**INDICES, "componentType": 5125}],
            meshes=[{"primitives": [{**SHOWN, "indices": 1}]}],
        ), "vertices: 300 000 000 is above the limit"),
        ("many nodes", document(
            accessors=[{**HUGE, "count": 300_000}], nodes=[{"mesh": 0}] * 2000,
            scenes=[{"nodes": list(range(2000))}],
        ), "primitives: 200 000 000"),
        ("many nodes of many primitives", document(
            nodes=[{"mesh": 0}] * 20_000, scenes=[{"nodes": list(range(20_000))}],
            meshes=[{"primitives": [SHOWN] * 20_000}],
        ), "primitives: 400 000 000"),
        ("many primitives", document(meshes=[{"primitives": [SHOWN] * 100_000}]), ""),
        ("many meshes", document(
            meshes=[{"primitives": [SHOWN]}] * 50_000, nodes=[{"mesh": n} for n in range(50_000)],
            scenes=[{"nodes": list(range(50_000))}],
        ), ""),
        ("many accessors", document(
            accessors=[POSITIONS] * 20_000,
            meshes=[{"primitives": [{"attributes": {"POSITION": n}} for n in range(20_000)]}],
        ), ""),
        ("a chain of nodes", document(
            nodes=[
                *({"children": [n + 1], "scale": [1, 1, 1], "mesh": 0} for n in range(20_000)),
                {"mesh": 0},
            ],
        ), ""),
        ("empty tables", document(nodes=[{}] * 500_000), "no faces"),
        ("a node twice", document(nodes=[{"children": [1] * 500_000}, {}]), r"nodes[1] is below two nodes"),
        ("a bowl of nodes", document(nodes=[*({"children": [n + 1] * 2} for n in range(99)), {"mesh": 0}]),
         "below two nodes, or below itself"),
        ("a circle", document(nodes=[{"children": [1]}, {"children": [0]}]), "nodes[0] is below two nodes"),
        ("brackets", "[" * 1_000_000, "Expected `object`"),
        ("nested brackets", '{"extras":' + "[" * 1_000_000, "nested too deeply"),
    ],
)  # fmt: skip
def test_what_a_file_declares_costs_no_more_than_its_bytes(
    tmp_path: Path, name: str, table: dict[str, Any] | str, says: str
) -> None:
    found = bounded("load", write(tmp_path, table))
    assert says in found.error and bool(says) == bool(found.error), found.error


def test_a_file_that_several_buffers_name_is_read_once(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "a b.bin").write_bytes(np.array(TRIANGLE, "<f4").tobytes())
    names = ["a%20b.bin", "./a%20b.bin", "x/../a%20b.bin"]
    table = document(
        buffers=[{"uri": name} for name in names],
        bufferViews=[{"buffer": n, "byteLength": 36} for n in range(3)],
        accessors=[{**POSITIONS, "bufferView": n} for n in range(3)],
        meshes=[{"primitives": [{"attributes": {"POSITION": n}} for n in range(3)]}],
    )
    calls: list[Path] = []
    monkeypatch.setattr(
        "clrt.meshfiles.file.read_bytes", lambda path, limits: calls.append(path) or read_bytes(path, limits)
    )
    assert len(read(write(tmp_path, table))[0]) == 9
    assert [path.name for path in calls] == ["a.gltf", "a b.bin"]


def test_files_beside_it_count_together(tmp_path: Path) -> None:
    for name in "ab":
        (tmp_path / f"{name}.bin").write_bytes(np.array(TRIANGLE, "<f4").tobytes().ljust(900))
    table = document(
        buffers=[{"uri": "a.bin"}, {"uri": "b.bin"}],
        bufferViews=[{"buffer": n, "byteLength": 36} for n in range(2)],
        accessors=[{**POSITIONS, "bufferView": n} for n in range(2)],
        meshes=[{"primitives": [{"attributes": {"POSITION": n}} for n in range(2)]}],
    )
    with pytest.raises(LimitError, match="file_bytes: 1 800 is above the limit of 1 000"):
        read_mesh_file(write(tmp_path, table), At(), Limits(file_bytes=1000), None)


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
    vertices, faces, normals = read(write(tmp_path, document(data, bufferViews=views, accessors=[position])))
    assert vertices.tolist() == [[0, 0, 0], [7, 8, 9], [0, 1, 0]] and faces.tolist() == [[0, 1, 2]]
    assert normals is None
    zeros = {**POSITIONS, "sparse": sparse}
    del zeros["bufferView"]
    vertices, _, _ = read(write(tmp_path, document(data, bufferViews=views, accessors=[zeros])))
    assert vertices.tolist() == [[0, 0, 0], [7, 8, 9], [0, 0, 0]]
    none = {**POSITIONS, "byteOffset": 4, "sparse": {**sparse, "count": 0}}
    vertices, _, _ = read(write(tmp_path, document(data, bufferViews=views, accessors=[none])))
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
            {"mesh": 0, "matrix": [-1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, *[1] * 4], "rotation": [0] * 4},
        ],
    )
    vertices, faces, turned = read(write(tmp_path, table))
    mirrored = [[1, 1, 6], [0, 1, 6], [1, 2, 6]]
    np.testing.assert_allclose(vertices, [*mirrored, [0, 0, 5], [0, 2, 5], [-2, 0, 5]], atol=1e-15)
    assert faces.tolist() == [[2, 1, 0], [3, 4, 5]]
    np.testing.assert_allclose(turned, [[0, 0, 1]] * 6, atol=1e-15)


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
    for shapes, place in (([shape] * 3, "file"), ([shape, shape, other], "vertices")):
        with pytest.raises(LimitError, match=rf"shapes\[2\]\.{place}: vertices: 9 is above the limit of 8"):
            clrt.load_dict({"shapes": shapes}, folder=tmp_path, limits=Limits(vertices=8))
    smooth = [shape, {**shape, "smooth": False}, {**shape, "smooth": True}]
    with pytest.raises(LimitError, match=r"shapes\[2\]\.file: primitives: 3 is above the limit of 2"):
        clrt.load_dict({"shapes": smooth}, folder=tmp_path, limits=Limits(primitives=2))
    with pytest.raises(LimitError, match=r"shapes: primitives: 3 is above the limit of 2"):
        clrt.load_dict({"shapes": [shape] * 3}, folder=tmp_path, limits=Limits(primitives=2))


CHUNK = (b"BIN\0", np.array(TRIANGLE, "<f4").tobytes())


def test_binary_files(tmp_path: Path) -> None:
    path = tmp_path / "a.glb"
    path.write_bytes(glb(document(buffers=[{}]), (b"MORE", b"xyz"), CHUNK, CHUNK))
    assert read(path)[0].tolist() == [list(corner) for corner in TRIANGLE]
    for data, says in (
        (glb(document(buffers=[{}])), r"buffers\[0\] has no data"),
        (glb(document(buffers=[{}]), CHUNK)[:-1], "ends before its last chunk"),
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


@pytest.mark.parametrize(
    ("changes", "says"),
    [
        ({"accessors": [{**POSITIONS, "count": 4}]}, "has 4 corners, which make no triangles"),
        ({"accessors": [{**POSITIONS, "count": 6}]}, r"accessors\[0\] reaches beyond the 36 bytes"),
        ({"accessors": [{**POSITIONS, "byteOffset": 1}]}, r"accessors\[0\] reaches beyond"),
        ({"bufferViews": [{"buffer": 0, "byteLength": 37}]}, "reaches beyond"),
        ({"bufferViews": [{"buffer": 0, "byteLength": 36, "byteStride": 1}]}, "byteStride is 1; .* takes 12"),
        ({"bufferViews": [{"buffer": 0, "byteLength": -1}]}, "Expected `int` >= 0"),
        ({"bufferViews": []}, r"there is no bufferViews\[0\]"),
        ({"buffers": []}, r"there is no buffers\[0\]"),
        ({"buffers": [{}]}, r"buffers\[0\] has no data"),
        ({"buffers": [{"uri": "data:;base64,A"}]}, r"buffers\[0\] is not in base64"),
        ({"accessors": [{**POSITIONS, "type": "VEC2"}]}, r"accessors\[0\] is of type VEC2; VEC3 is needed"),
        ({"accessors": [{**POSITIONS, "componentType": 5124}]}, "Invalid enum value 5124"),
        ({"accessors": [{"componentType": 5126, "count": 3, "type": "VEC3"}]}, "has no bufferView"),
        ({"accessors": [{**POSITIONS, "sparse": {**SPARSE, "indices": {"bufferView": 0, "byteOffset": 12,
          "componentType": 5125}}}]}, "replaces numbers that it does not have"),
        ({"meshes": []}, r"there is no meshes\[0\]"),
        ({"nodes": [{"children": [0], "mesh": 0}]}, r"nodes\[0\] is below two nodes, or below itself"),
        ({"scene": 1}, r"there is no scenes\[1\]"),
        ({"nodes": []}, r"there is no nodes\[0\]"),
        ({"nodes": [{"mesh": 0, "matrix": [1]}]}, "Expected `array`"),
        ({"meshes": [{"primitives": [{**SHOWN, "indices": 1}]}], "accessors": [POSITIONS, POSITIONS]},
         r"accessors\[1\] is of type VEC3; SCALAR"),
        ({"meshes": [{"primitives": [{**SHOWN, "indices": 1}]}],
          "accessors": [POSITIONS, {**INDICES, "componentType": 5126}]}, "must hold whole numbers"),
        ({"meshes": [{"primitives": [{**SHOWN, "indices": 1}]}],
          "accessors": [POSITIONS, {**INDICES, "byteOffset": 12}]}, "names vertex 16256 of a part"),
        ({"meshes": [{"primitives": [{"attributes": {"POSITION": 0, "NORMAL": 1}}]}],
          "accessors": [POSITIONS, {**POSITIONS, "count": 2}]}, "not one normal for each of 3 vertices"),
        ({"meshes": [{"primitives": [{**SHOWN, "extensions": {"KHR_draco_mesh_compression": {}}}]}]},
         "is compressed"),
        ({"asset": {"version": "1.0"}}, "only glTF of version 2"),
        ({"asset": {"version": "2.0", "minVersion": "2.9"}}, r"it needs glTF of version 2\.9"),
        ({"nodes": [{"mesh": 0, "matrix": [1, 0, 0, 0.5, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]}]}, "last row"),
        ({"extensionsRequired": ["FOO_bar"]}, "it needs the extension FOO_bar, which is not read"),
        ({"extensionsRequired": ["KHR_materials_ior", "EXT_mesh_gpu_instancing"]}, "EXT_mesh_gpu_instancing"),
        ({"extensionsRequired": ["EXT_meshopt_compression"]}, "EXT_meshopt_compression"),
        ({"extensionsRequired": ["x\x1b" * 9999]}, "it needs the extension"),
        ({"meshes": [{"primitives": [{"attributes": {}}]}]}, "no faces"),
        ({"meshes": [{"primitives": [{**SHOWN, "mode": 5}]}], "accessors": [{**POSITIONS, "count": 2}]},
         "no faces"),
    ],
)  # fmt: skip
def test_files_that_contradict_themselves(tmp_path: Path, changes: dict[str, Any], says: str) -> None:
    with pytest.raises(SceneError, match=rf"a\.gltf .*{says}") as caught:
        read(write(tmp_path, document(**changes)))
    assert len(str(caught.value)) < 400


@pytest.mark.parametrize("begin", ["data:application/octet-stream,", "DATA:,", "Data:;x=y,"])
def test_data_in_percent_signs(tmp_path: Path, begin: str) -> None:
    data = np.array(TRIANGLE, "<f4").tobytes()
    text = begin + "".join(f"%{byte:02x}" for byte in data)
    found = read(write(tmp_path, document(buffers=[{"uri": text, "byteLength": 36}])))
    assert found[0].tolist() == [list(corner) for corner in TRIANGLE]
    upper = data_uri(data).replace("data:", "DATA:")
    assert len(read(write(tmp_path, document(buffers=[{"uri": upper, "byteLength": 36}])))[1]) == 1
