"""Mesh files against other programs' loaders: Mitsuba's for OBJ and PLY, trimesh asked directly for the
others."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh

import clrt
from clrt.base.resources import scene_folder
from clrt.scene.scene import Mesh

pytestmark = pytest.mark.filterwarnings("ignore::clrt.base.errors.ClrtWarning")
OBJ = """# quadrangles, normals of their own, two groups
v 0 0 0
v 1 0 0
v 1 1 0.25
v 0 1 0.25
vn 0 -0.6 0.8
vn 0 0 2
g first
f 1//1 2//1 3//2 4//2
v 0 0 1
v 2 0 1
v 0 2 1
g second
f {0}//1 {1}//2 {2}//1
"""
# what Mitsuba reads, without a JIT compiler: corners (m, 3, 3), and normals there where the file has some
ASK = """
import json, sys
import numpy as np
import mitsuba as mi
mi.set_variant("scalar_rgb")
kind, file, faceted = sys.argv[1:]
mesh = mi.load_dict({"type": kind, "filename": file, "face_normals": faceted == "flat"})
found = mi.traverse(mesh)
faces = np.array(found["faces"]).reshape(-1, 3)
rows = {name: np.array(found[f"vertex_{name}"], float).reshape(-1, 3)[faces].tolist()
        for name in ("positions", "normals") if len(np.array(found[f"vertex_{name}"]))}
print(json.dumps(rows))
"""


def mitsubas(file: Path, smooth: bool) -> dict[str, np.ndarray]:
    arguments = [file.suffix[1:], str(file), "smooth" if smooth else "flat"]
    done = subprocess.run([sys.executable, "-c", ASK, *arguments], capture_output=True, text=True, check=True)
    return {name: np.array(rows) for name, rows in json.loads(done.stdout.splitlines()[-1]).items()}


def ours(file: Path, smooth: bool | None) -> dict[str, np.ndarray]:
    table = {"type": "mesh", "file": file.name, "smooth": smooth}
    (shape,) = clrt.load_dict({"shapes": [table], "ambient": 1}, folder=file.parent).shapes
    assert isinstance(shape, Mesh)
    data = shape.data()
    faces = np.asarray(data.faces)
    return {"positions": data.vertices[faces]} | ({} if data.normals is None else {"normals":
    data.normals[faces]})


def in_order(rows: dict[str, np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
    """Triangles from their lowest corner on, sorted; the order of faces and vertices is each loader's own."""
    placed = []
    for number, corners in enumerate(np.round(rows["positions"], 5) + 0.0):
        first = min(range(3), key=lambda k, corners=corners: tuple(corners[k]))
        turned = [(first + k) % 3 for k in range(3)]
        placed.append((corners[turned].ravel().tolist(), number, turned))
    placed.sort()
    order, turns = [number for _, number, _ in placed], np.array([turned for _, _, turned in placed])
    picked = [rows[name][order][np.arange(len(order))[:, None], turns] for name in ("positions", "normals")
              if name in rows]  # fmt: skip
    return picked[0], picked[1] if len(picked) > 1 else np.zeros(0)


def agree(mine: dict[str, np.ndarray], theirs: dict[str, np.ndarray], normals: bool) -> None:
    (points, directions), (their_points, their_directions) = in_order(mine), in_order(theirs)
    np.testing.assert_allclose(points, their_points, rtol=0, atol=2e-6)  # theirs are float32
    if normals:
        lengths = np.linalg.norm(directions, axis=2, keepdims=True)
        np.testing.assert_allclose(directions / lengths, their_directions, rtol=0, atol=2e-6)


@pytest.fixture
def obj(tmp_path: Path) -> Path:
    file = tmp_path / "some.obj"
    file.write_text(OBJ.format(5, 6, 7))
    return file


def test_an_obj_is_what_mitsuba_reads(obj: Path) -> None:
    theirs = mitsubas(obj, smooth=True)
    lengths = np.linalg.norm(theirs["normals"], axis=2, keepdims=True)
    theirs["normals"] /= lengths
    agree(ours(obj, None), theirs, normals=True)
    agree(ours(obj, False), mitsubas(obj, smooth=False), normals=False)
    obj.write_text(OBJ.format(-3, -2, -1))  # numbers that count back, which Mitsuba does not know
    agree(ours(obj, None), theirs, normals=True)


def test_the_brilliant_is_what_mitsuba_reads() -> None:
    agree(ours(scene_folder() / "gem.obj", False), mitsubas(scene_folder() / "gem.obj", smooth=False), False)


@pytest.mark.parametrize("encoding", ["ascii", "binary"])
def test_a_ply_is_what_mitsuba_reads(tmp_path: Path, encoding: str) -> None:
    ball = trimesh.creation.icosphere(subdivisions=1)
    ball.apply_transform(np.diag([1.0, 0.6, 0.8, 1.0]))
    file = tmp_path / "ball.ply"
    file.write_bytes(ball.export(file_type="ply", encoding=encoding, vertex_normal=True))
    agree(ours(file, None), mitsubas(file, smooth=True), normals=True)


def test_computed_normals_are_like_mitsubas(tmp_path: Path) -> None:
    """Mitsuba weighs by angles, the renderer by areas: on an egg they differ by up to 3 degrees."""
    egg = trimesh.creation.icosphere(subdivisions=2)
    egg.apply_transform(np.diag([1.0, 0.6, 0.8, 1.0]))
    file = tmp_path / "egg.ply"
    file.write_bytes(egg.export(file_type="ply", vertex_normal=False))
    (points, directions), (their_points, their_directions) = map(
        in_order, (ours(file, True), mitsubas(file, smooth=True))
    )
    np.testing.assert_allclose(points, their_points, rtol=0, atol=2e-6)
    cosines = np.einsum("mki,mki->mk", directions, their_directions)
    assert np.cos(np.radians(3)) < cosines.min() < 1 - 1e-6


def test_the_knot_is_what_trimesh_says() -> None:
    """Mitsuba does not read its quadrangles."""
    knot = trimesh.load(scene_folder() / "knot.ply", process=False)
    agree(ours(scene_folder() / "knot.ply", False), {"positions": np.asarray(knot.triangles)}, normals=False)


@pytest.mark.parametrize("suffix", ["stl", "glb", "gltf", "obj", "ply"])
def test_other_files_are_what_trimesh_says(tmp_path: Path, suffix: str) -> None:
    """Two parts, each under a transform; one of them mirrors."""
    parts: Any = trimesh.Scene()
    turn = trimesh.transformations.rotation_matrix(0.7, [1, 2, 0.5], [0.3, 0, 0])
    parts.add_geometry(trimesh.creation.box([1, 2, 3]), transform=turn)
    parts.add_geometry(trimesh.creation.cone(0.5, 1.5), transform=np.diag([1.0, -1.0, 1.0, 1.0]))
    whole = parts.to_mesh() if suffix in ("stl", "obj", "ply") else parts
    file = tmp_path / f"parts.{suffix}"
    if suffix == "gltf":
        for name, data in whole.export(file_type="gltf").items():
            (tmp_path / (file.name if name == "model.gltf" else name)).write_bytes(data)
    else:
        whole.export(file)
    expected = parts.to_mesh().triangles
    agree(ours(file, False), {"positions": np.asarray(expected)}, normals=False)
