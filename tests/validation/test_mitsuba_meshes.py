"""Files of meshes as Mitsuba's side reads them: the mesh that is meant, or a word that it cannot."""

from __future__ import annotations

import json
import warnings
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import clrt
from clrt.base.resources import validation_module
from clrt.scene.mesh import Mesh
from tests.mesh_samples import write_sample
from validation.oracle_mitsuba import Source, faces, meshfile, patches
from validation.oracle_mitsuba.reading import read

oracles = validation_module("oracles")
cases = validation_module("cases")
_SQUARE = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n"
_TWO = "mtllib a.mtl\nusemtl one\nf 1 2 3\nusemtl two\nf 1 3 4\n"
Row = tuple[float, ...]


def _rows(data: Any, uv: bool) -> np.ndarray:
    """The triangles that span something, with normals and uv, each from its least corner on, sorted."""
    faces = np.asarray(data.faces)
    columns = [data.vertices] + ([] if data.normals is None else [data.normals]) + ([data.uv] if uv else [])
    found = []
    for face, corners in zip(faces, data.vertices[faces], strict=True):
        if np.linalg.norm(np.cross(corners[1] - corners[0], corners[2] - corners[0])) < 1e-9:
            continue
        rows = [tuple(np.concatenate([column[k] for column in columns]).round(5) + 0.0) for k in face]
        start = rows.index(min(rows))
        found.append(rows[start:] + rows[:start])
    return np.array(sorted(found))


@pytest.mark.parametrize("suffix", [".obj", ".ply", ".stl", ".gltf", ".glb"])
def test_both_readers_give_the_same_triangles(suffix: str, tmp_path: Path) -> None:
    """Or this one says that it cannot; and that of few files."""
    judged = unread = 0
    for seed in range(25):
        file = tmp_path / f"{seed}{suffix}"
        write_sample(file, seed)
        for part, smooth in [(None, None), (None, True), (0, None), (1, None), (2, False), (9, None)]:
            table = {"type": "mesh", "file": file.name, "part": part, "smooth": smooth}
            said = {key: value for key, value in table.items() if value is not None}
            with warnings.catch_warnings():
                warnings.simplefilter("ignore", clrt.ClrtWarning)
                try:
                    (shape,) = clrt.load_dict({"shapes": [said]}, folder=tmp_path).shapes
                except clrt.ClrtError:
                    continue  # it has no such part, most often
            ours = shape.data()  # type: ignore[union-attr]
            try:
                theirs = meshfile.read(file, smooth, part)
            except patches.Unreadable as reason:
                assert str(reason).startswith(file.name)
                unread += 1
                continue
            assert (ours.normals is None) == (theirs.normals is None), (file, said)
            uv = ours.uv is not None and theirs.uv is not None
            one, other = _rows(ours, uv), _rows(theirs, uv)
            assert one.shape == other.shape and np.allclose(one, other, atol=1e-4), (file, said)
            judged += 1
    assert judged > 2 * unread


@pytest.mark.parametrize("keys", [{"smooth": True}, {"normals": True}, {"uv": True}])
def test_both_cut_a_face_with_a_dent_alike(keys: dict[str, Any]) -> None:
    """One whose corners stand in a scene; where normals are blended, the cut is in the picture."""
    pytest.importorskip("mapbox_earcut", reason="needs the optional dependency clrt[mesh]")
    draw = np.random.default_rng(5)
    for size in (4, 5, 7, 12):
        for tilt in np.vstack([np.eye(3), draw.normal(size=(4, 3))]):
            angles = np.linspace(0, 2 * np.pi, size, endpoint=False) + draw.uniform(-0.1, 0.1, size)
            lengths = np.where(np.arange(size) % 3 == 1, -0.2 if size == 4 else 0.2, 1)
            across = np.linalg.svd(tilt[None])[2][1:]
            points = 3 + (lengths * np.array([np.cos(angles), np.sin(angles)])).T @ across
            arrays = {"normals": draw.normal(size=(size, 3)), "uv": points[:, :2]}
            given = {key: arrays.get(key, value) for key, value in keys.items()}
            table = {"type": "mesh", "vertices": points, "faces": [[*range(size)]], **given}
            (ours,) = clrt.load_dict({"shapes": [table]}).shapes
            (theirs,) = read(Source({"shapes": [table]})).shapes
            assert isinstance(ours, Mesh)
            one, other = _rows(ours.data(), "uv" in keys), _rows(theirs.data(), "uv" in keys)
            assert len(one) == size - 2 and np.allclose(one, other, atol=1e-5)
            assert len(faces.triangles(theirs)[0].faces) == size - 2


def _corners(path: Path, part: int | None = None) -> list[Any]:
    data = meshfile.read(path, None, part)
    return data.vertices[data.faces].tolist()  # type: ignore[no-any-return]


@pytest.mark.parametrize(
    ("name", "text", "corners"),
    [
        ("a.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nf -3 -2 -1\nv 0 1 0\nf 1 3 -1\n",
         [[[0, 0, 0], [1, 0, 0], [1, 1, 0]], [[0, 0, 0], [1, 1, 0], [0, 1, 0]]]),
        ("a.obj", f"\ufeff{_SQUARE}f\t1\t2 \\\n 3 # three\n".replace(" 1 0 0", "\t1 0  0"),
         [[[0, 0, 0], [1, 0, 0], [1, 1, 0]]]),
        ("a.stl", "solid facet vertex 1 2 3\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\n"
         "vertex 1 1 0\nendloop\nendfacet\nendsolid facet vertex 1 2 3\n",
         [[[0, 0, 0], [1, 0, 0], [1, 1, 0]]]),
    ],
)  # fmt: skip
def test_they_are_read(name: str, text: str, corners: list[Any], tmp_path: Path) -> None:
    (tmp_path / name).write_text(text, "utf-8")
    assert _corners(tmp_path / name) == corners


def test_a_part_is_one(tmp_path: Path) -> None:
    """And no other than clrt's of that number."""
    (tmp_path / "a.obj").write_text(_SQUARE + _TWO)
    assert _corners(tmp_path / "a.obj", 0) == [[[0, 0, 0], [1, 0, 0], [1, 1, 0]]]
    assert _corners(tmp_path / "a.obj", 1) == [[[0, 0, 0], [1, 1, 0], [0, 1, 0]]]
    assert len(_corners(tmp_path / "a.obj")) == 2
    halves = [{"type": "mesh", "file": "a.obj", "part": part} for part in (0, 1)]
    one, two = (shape.data() for shape in read(Source({"shapes": halves}, str(tmp_path))).shapes)
    assert (one.vertices.tolist(), two.vertices.tolist()) == (
        [[0, 0, 0], [1, 0, 0], [1, 1, 0]],
        [[0, 0, 0], [1, 1, 0], [0, 1, 0]],
    )


def _triangle(**more: Any) -> dict[str, Any]:
    uri = "data:;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA"
    table: dict[str, Any] = {
        "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}], "buffers": [{"uri": uri, "byteLength": 36}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
        "bufferViews": [{"buffer": 0, "byteLength": 36}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "type": "VEC3", "count": 3}],
    }  # fmt: skip
    return table | more


_UNREAD: dict[str, tuple[str, str, int | None]] = {
    "a dent": ("a.obj", "v 0 0 0\nv 3 0 0\nv 1 1 0\nv 0 3 0\nf 2 3 4 1\n", None),
    "a dent of a PLY": ("a.ply", "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\n"
        "property float y\nproperty float z\nelement face 1\nproperty list uchar int vertex_index\n"
        "end_header\n3 0 0\n1 1 0\n0 3 0\n0 0 0\n4 0 1 2 3\n", None),
    "surfaces": ("a.obj", f"{_SQUARE}cstype bezier\nf 1 2 3\n", None),
    "weights": ("a.obj", "v 0 0 0 1\nv 1 0 0 2\nv 0 1 0 1\nf 1 2 3\n", None),
    "numbers of Python's": ("a.obj", "v 0 0 0\nv 1_0 0 0\nv 0 1 0\nf 1 2 3\n", None),
    "a corner of a kind": ("a.obj", f"{_SQUARE}f 1 2/ 3.0\n", None),
    "a corner without a vertex": ("a.obj", f"{_SQUARE}f 1 2 /3\n", None),
    "too far back": ("a.obj", f"{_SQUARE}f 1 2 -5\n", None),
    "too far on": ("a.obj", f"{_SQUARE}f 1 2 5\n", None),
    "corners unlike": ("a.obj", f"{_SQUARE}vt 0 0\nf 1/1 2 3\n", None),
    "too few numbers": ("a.obj", f"{_SQUARE}v 1 2\nf 1 2 3\n", None),
    "what is not finite": ("a.obj", "v nan 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", None),
    "a part without a library": ("a.obj", _SQUARE + _TWO.replace("mtllib a.mtl\n", ""), 1),
    "parts in pieces": ("a.obj", f"{_SQUARE}vt 0 0\n{_TWO}f 1/1 2/1 3/1\n", 1),
    "many parts": ("a.obj", _SQUARE + _TWO + "".join(f"usemtl {n}\nf 1 2 3\n" for n in range(70)), 1),
    "no such part": ("a.obj", _SQUARE + _TWO, 2),
    "normals of some": ("a.obj", f"{_SQUARE}vn 0 0 1\nf 1 2 3\nf 1//1 3//1 4//1\n", None),
    "normals of no length": ("a.obj", f"{_SQUARE}vn 0 0 0\nf 1//1 3//1 4//1\n", None),
    "a solid that does not end": ("a.stl", "solid a\nfacet normal 0 0 1\n", None),
    "other words": ("a.stl", "solid a\nfacet\nouter loop\nvertex 0 0 1\nvertex 1 0 0\nstop\n", None),
    "too few of a corner": ("a.stl", "solid a\nfacet\nouter loop\nvertex 0 0\n", None),
    "several solids": ("a.stl", "solid a\nendsolid\nsolid b\nendsolid\n", 0),
    "another kind": ("a.off", "", None),
    "what is not there": ("b.obj", "", None),
    "no header": ("a.ply", "ply\nformat ascii 1.0\nelement vertex 1\n", None),
}  # fmt: skip
_UNREAD_GLTF: dict[str, dict[str, Any]] = {
    "sparse": {"accessors": [{"componentType": 5126, "type": "VEC3", "count": 3, "sparse": {"count": 1}}]},
    "a skin": {"nodes": [{"mesh": 0, "skin": 0}]},
    "morph targets": {"nodes": [{"mesh": 0, "weights": [0, 1]}]},
    "instances": {"nodes": [{"mesh": 0, "extensions": {"EXT_mesh_gpu_instancing": {}}}]},
    "what is asked for": {"extensionsRequired": ["KHR_draco_mesh_compression"]},
    "a node twice": {"nodes": [{"mesh": 0, "children": [0]}]},
    "a matrix and more": {"nodes": [{"mesh": 0, "matrix": [1.0] * 16, "scale": [1, 1, 1]}]},
    "a rotation that is none": {"nodes": [{"mesh": 0, "rotation": [1, 1, 1, 1]}]},
    "what is no mesh": {"meshes": []},
    "whole numbers": {"accessors": [{"bufferView": 0, "componentType": 5123, "type": "VEC3", "count": 3}]},
}


@pytest.mark.parametrize("name", _UNREAD)
def test_what_is_not_read_is_named(name: str, tmp_path: Path) -> None:
    """With the file and a reason, never another mesh, nor an error of another kind."""
    file, text, part = _UNREAD[name]
    if file != "b.obj":
        (tmp_path / file).write_text(text)
    with pytest.raises(patches.Unreadable, match=rf"^{file} (has what|is not)"):
        meshfile.read(tmp_path / file, None, part)


@pytest.mark.parametrize("name", _UNREAD_GLTF)
def test_what_of_gltf_is_not_read_is_named(name: str, tmp_path: Path) -> None:
    (tmp_path / "a.gltf").write_text(json.dumps(_triangle(**_UNREAD_GLTF[name])))
    with pytest.raises(patches.Unreadable, match=r"^a.gltf (has what|is not)"):
        meshfile.read(tmp_path / "a.gltf", None)


def test_a_triangle_of_gltf_is_read(tmp_path: Path) -> None:
    """So that the files above are not read for what they have beside it."""
    (tmp_path / "a.gltf").write_text(json.dumps(_triangle()))
    assert _corners(tmp_path / "a.gltf", 0) == [[[0, 0, 0], [1, 0, 0], [0, 1, 0]]]


def _scene(folder: Path, file: str, **more: Any) -> Path:
    path = folder / "a.json"
    table = {"type": "mesh", "file": file, **more}
    path.write_text(json.dumps({"camera": {"origin": [0, 0, 5], "target": [0, 0, 0]}, "shapes": [table]}))
    return path


def test_a_case_that_is_not_read_is_not_judged_and_named(tmp_path: Path) -> None:
    (tmp_path / "a.obj").write_text("v 0 0 0\nv 3 0 0\nv 1 1 0\nv 0 3 0\nf 2 3 4 1\n")
    case = cases.case_named(cases.own_case(str(_scene(tmp_path, "a.obj"))))
    why = oracles.why_not("mitsuba-table", case)
    what = "face 0 (from 0) of 4 corners is dented, or crosses itself"
    assert why == f"shapes[0]: a.obj has what is not read: {what}"
    (tmp_path / "a.obj").write_text(_SQUARE + _TWO)
    case = cases.case_named(cases.own_case(str(_scene(tmp_path, "a.obj", part=1))))
    assert oracles.why_not("mitsuba-table", case) is None


def test_of_a_model_that_is_not_read_clrts_own_mesh_is_judged(tmp_path: Path) -> None:
    """Where it is, Mitsuba's side reads it by itself."""
    (tmp_path / "a.obj").write_text("v 0 0 0\nv 3 0 0\nv 1 1 0\nv 0 3 0\nf 2 3 4 1\n")
    dented = oracles.handed_on(clrt.load(tmp_path / "a.obj")).tables["shapes"]
    assert "file" not in dented[0] and len(dented[0]["faces"]) == 2
    (tmp_path / "a.mtl").write_text("newmtl one\nKd 1 0 0\nnewmtl two\nKd 0 1 0\n")
    (tmp_path / "a.obj").write_text(_SQUARE + _TWO)
    halves = oracles.handed_on(clrt.load(tmp_path / "a.obj")).tables["shapes"]
    assert [(table["file"], table["part"]) for table in halves] == [("a.obj", 0), ("a.obj", 1)]
