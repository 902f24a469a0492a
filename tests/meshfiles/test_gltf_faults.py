"""glTF files that contradict themselves, or declare more than they hold."""

from __future__ import annotations

import json
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
from tests.meshfiles.test_gltf import (
    INDICES,
    POSITIONS,
    SHOWN,
    TRIANGLE,
    data_uri,
    document,
    read,
    write,
)

SPARSE = {"indices": {"bufferView": 0, "componentType": 5125}, "values": {"bufferView": 0}, "count": 1}


HUGE = {"componentType": 5126, "count": 300_000_000, "type": "VEC3", "sparse": SPARSE}


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
        ({"buffers": [{"uri": "data:;base64,A"}]}, r"buffers\[0\] is not in base64: it has 1 letters, not 4"),
        ({"accessors": [{**POSITIONS, "type": "VEC2"}]}, r"accessors\[0\] is of type VEC2; VEC3 is needed"),
        ({"accessors": [{**POSITIONS, "componentType": 5124}]}, "Invalid enum value 5124"),
        ({"accessors": [{"componentType": 5126, "count": 3, "type": "VEC3"}]}, "has no bufferView"),
        ({"accessors": [{**POSITIONS, "sparse": {**SPARSE, "indices": {"bufferView": 0, "byteOffset": 12,
          "componentType": 5125}}}]}, "replaces numbers that it does not have"),
        ({"accessors": [{**POSITIONS, "sparse": {**SPARSE, "count": 2, "indices": {"bufferView": 0,
          "componentType": 5121}}}]}, r"accessors\[0\]\.sparse\.indices has 0 after 0; each must be larger"),
        ({"accessors": [{**POSITIONS, "sparse": {**SPARSE, "indices": {"bufferView": 0,
          "componentType": 5126}}}]}, r"indices\.componentType is 5126; it must be one of 5121, 5123, 5125"),
        ({"meshes": []}, r"there is no meshes\[0\]"),
        ({"nodes": [{"children": [0], "mesh": 0}]}, r"nodes\[0\] is below two nodes, or below itself"),
        ({"scene": 1}, r"there is no scenes\[1\]"),
        ({"scene": 0, "scenes": []}, r"there is no scenes\[0\], which it speaks of"),
        ({"scenes": []}, "it has no scene that would say which of its nodes are shown; save it with one"),
        ({"nodes": []}, r"there is no nodes\[0\]"),
        ({"nodes": [{"mesh": 0, "matrix": [1]}]}, "Expected `array`"),
        ({"meshes": [{"primitives": [{**SHOWN, "indices": 1}]}], "accessors": [POSITIONS, POSITIONS]},
         r"accessors\[1\] is of type VEC3; SCALAR"),
        ({"meshes": [{"primitives": [{**SHOWN, "indices": 1}]}],
          "accessors": [POSITIONS, {**INDICES, "componentType": 5126}]}, "must hold whole numbers"),
        ({"meshes": [{"primitives": [{**SHOWN, "indices": 1}]}],
          "accessors": [POSITIONS, {**INDICES, "byteOffset": 12}]}, "names vertex 16256 of a part"),
        ({"meshes": [{"primitives": [{**SHOWN, "indices": 1}]}], "accessors": [{**POSITIONS, "count": 300},
          {**INDICES, "bufferView": 1, "componentType": 5121}],
          "buffers": [{"uri": data_uri(bytes(3600) + b"\0\1\xff")}], "bufferViews": [
          {"buffer": 0, "byteLength": 3600}, {"buffer": 0, "byteOffset": 3600, "byteLength": 3}]},
         r"accessors\[1\] has the index 255; of its componentType 254 is the largest"),
        ({"nodes": [{"mesh": 0}, {"children": [0], "scale": [2, 2, 2]}]},
         r"nodes\[0\] is in the scene, but stands below nodes\[1\], which is not"),
        ({"nodes": [{"children": [2]}, {"children": [2]}, {"mesh": 0}]}, r"nodes\[2\] is in the scene, but"),
        ({"nodes": [{"mesh": 0, "matrix": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 5, 0, 0, 1],
          "translation": [1, 1, 1]}]}, r"nodes\[0\] has a matrix and translation; one or the other places"),
        ({"nodes": [{"children": [1]}, {"mesh": 0, "matrix": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1],
          "rotation": [0, 0, 0, 1], "scale": [1, 1, 1]}]}, r"nodes\[1\] has a matrix and rotation and scale"),
        ({"buffers": [{"uri": data_uri(bytes(36)), "byteLength": 37}]},
         r"buffers\[0\]\.byteLength is 37, and it has 36 bytes; it may be cut short"),
        ({"buffers": [{"uri": data_uri(bytes(48)), "byteLength": 24}]}, "beyond the 24 bytes of its buffer"),
        ({"meshes": [{"primitives": [{"attributes": {"POSITION": 0, "NORMAL": 1}}]}],
          "accessors": [POSITIONS, {**POSITIONS, "count": 2}]}, "not one normal for each of 3 vertices"),
        ({"meshes": [{"primitives": [{**SHOWN, "extensions": {"KHR_draco_mesh_compression": {}}}]}]},
         "is compressed"),
        ({"asset": {"version": "1.0"}}, "only glTF of version 2"),
        ({"asset": {"version": "2.0", "minVersion": "2.9"}}, r"it needs glTF of version 2\.9"),
        ({"nodes": [{"mesh": 0, "matrix": [1, 0, 0, 2e-5, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]}]}, "last row"),
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


@pytest.mark.parametrize(
    ("change", "key"),
    [
        (('"nodes":', '"nodes": [], "nodes":'), "nodes"),
        (('"POSITION":', '"POSITION": 0, "POSITION":'), "POSITION"),
        (('"asset":', '"extras": [{"a": {"x": 1e9999, "\\u0078": -7}}], "asset":'), "x"),
        (('"asset":', '"extras": {"data:a": "data:a\\\\" , "data:a": "data:b"}, "asset":'), "data:a"),
    ],
)
def test_a_key_that_stands_twice_is_refused(tmp_path: Path, change: tuple[str, str], key: str) -> None:
    """One of the two would hold, without a word."""
    text = json.dumps(document()).replace(*change, 1)
    (tmp_path / "a.gltf").write_text(text)
    with pytest.raises(SceneError, match=f"its JSON is not .*: the key '{key}' stands twice in one table"):
        clrt.load(tmp_path / "a.gltf")


def test_keys_of_several_tables_and_odd_values_stand_for_themselves(tmp_path: Path) -> None:
    odd = {"data:a": "data:,", "data:b": "data:,", "c": [{"a": 1}, {"a": 10**400}, "\\\"data:x", ["data:y" ]]}
    (tmp_path / "a.gltf").write_text(json.dumps(document(extras=odd)))
    assert len(clrt.load(tmp_path / "a.gltf").shapes) == 1
