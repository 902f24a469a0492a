"""Normals that have no direction, as programs write that made none: triangles' own take their place."""

from __future__ import annotations

import json
import struct
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh

import clrt
from clrt.scene.mesh import Mesh

BALL = trimesh.creation.icosphere(2)
OUT = BALL.vertices / np.linalg.norm(BALL.vertices, axis=1)[:, None]
LOST = {"zero": 0.0, "nan": np.nan, "infinite": np.inf}


def as_obj(normals: np.ndarray) -> bytes:
    lines = [f"v {x} {y} {z}" for x, y, z in BALL.vertices]
    lines += [f"vn {x} {y} {z}" for x, y, z in normals]
    lines += ["f " + " ".join(f"{k + 1}//{k + 1}" for k in face) for face in BALL.faces]
    return "\n".join([*lines, ""]).encode()


def as_ply(normals: np.ndarray) -> bytes:
    head = ["ply", "format ascii 1.0", f"element vertex {len(normals)}"]
    head += [f"property float {name}" for name in ("x", "y", "z", "nx", "ny", "nz")]
    head += [f"element face {len(BALL.faces)}", "property list uchar int vertex_indices", "end_header"]
    rows = [" ".join(map(str, row)) for row in np.hstack([BALL.vertices, normals])]
    rows += ["3 " + " ".join(map(str, face)) for face in BALL.faces]
    return "\n".join([*head, *rows, ""]).encode()


def as_glb(normals: np.ndarray) -> bytes:
    arrays = [BALL.vertices.astype("<f4"), normals.astype("<f4"), BALL.faces.astype("<u4").reshape(-1)]
    kinds = [("VEC3", 5126), ("VEC3", 5126), ("SCALAR", 5125)]
    ends = np.cumsum([array.nbytes for array in arrays]).tolist()
    table: dict[str, Any] = {
        "asset": {"version": "2.0"}, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "NORMAL": 1}, "indices": 2}]}],
        "buffers": [{"byteLength": ends[-1]}],
        "bufferViews": [{"buffer": 0, "byteOffset": end - array.nbytes, "byteLength": array.nbytes}
                        for end, array in zip(ends, arrays, strict=True)],
        "accessors": [{"bufferView": k, "componentType": code, "type": kind, "count": len(array)}
                      for k, (array, (kind, code)) in enumerate(zip(arrays, kinds, strict=True))],
    }  # fmt: skip
    text = json.dumps(table).encode()
    text += b" " * (-len(text) % 4)
    data = b"".join(array.tobytes() for array in arrays)
    chunks = struct.pack("<I4s", len(text), b"JSON") + text + struct.pack("<I4s", len(data), b"BIN\0") + data
    return struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks


@pytest.mark.parametrize("every", [1, 3])
@pytest.mark.parametrize("lost", LOST)
@pytest.mark.parametrize(("suffix", "made"), [("obj", as_obj), ("ply", as_ply), ("glb", as_glb)])
def test_normals_without_a_direction(tmp_path: Path, suffix: str, made: Any, lost: str, every: int) -> None:
    """On a fine ball the mean of the triangles at a vertex is its normal to a hundredth."""
    normals = OUT.copy()
    normals[::every] = LOST[lost]
    path = tmp_path / f"a.{suffix}"
    path.write_bytes(made(normals))
    count = len(normals[::every])
    with pytest.warns(clrt.ClrtWarning, match=rf"{count} of its normals have no direction; those"):
        (shape,) = clrt.load(path).shapes
    assert isinstance(shape, Mesh)
    data = shape.data()
    found = data.normals
    out = data.vertices / np.linalg.norm(data.vertices, axis=1)[:, None]
    assert found is not None and (np.sum(found * out, axis=1) > 0.999).all()
    if every > 1:
        kept = np.sum(found * out, axis=1) > 1 - 1e-9
        assert kept.sum() >= len(normals) - count, "the others are the file's own"


def test_those_of_no_face_do_not_count(tmp_path: Path, recwarn: Any) -> None:
    """Vertices that no face has have none in many files."""
    text = as_ply(OUT).replace(b"element vertex %d" % len(OUT), b"element vertex %d" % (len(OUT) + 1))
    begins = text.index(b"end_header\n") + len(b"end_header\n")
    rows = text[begins:].split(b"\n")
    rows.insert(len(OUT), b"9 9 9 0 0 0")
    (tmp_path / "a.ply").write_bytes(text[:begins] + b"\n".join(rows))
    (shape,) = clrt.load(tmp_path / "a.ply").shapes
    assert isinstance(shape, Mesh) and shape.primitives == len(BALL.faces)
    assert not [one for one in recwarn if "direction" in str(one.message)]
