"""Smooth meshes of Mitsuba's files without normals: as its own, over faces that share a vertex's number."""

from __future__ import annotations

import itertools
import json
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import clrt
from clrt.scene.scene import Mesh

CORNERS = [*itertools.product((0, 1), (0, 1), (0, 1))]
SIDES = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
SHAPE = '<scene version="3.0.0"><shape type="{}"><string name="filename" value="a.{}"/></shape></scene>'
# Each face's corners, (place, normal)
ASKED = """
import json, sys
import mitsuba as mi
mi.set_variant("scalar_rgb")
shape = mi.load_dict({"type": sys.argv[1][-3:], "filename": sys.argv[1]})
found = mi.traverse(shape)
rows = [[float(x) for x in found[name]] for name in ("vertex_positions", "vertex_normals")]
print(json.dumps([*rows, [int(x) for x in found["faces"]]]))
"""


def obj(split: bool, uv: bool = False, materials: bool = False, normals: bool = False) -> str:
    """A cube, of which each side has vertices of its own, or uv, or a material that the next has not."""
    points = [CORNERS[k] for side in SIDES for k in side] if split else CORNERS
    lines = [f"v {x} {y} {z}" for x, y, z in points]
    lines += ["vt 0 0", "vt 1 0", "vt 1 1", "vt 0 1"] if uv else []
    lines += ["vn 0.6 0 0.8"] if normals else []
    for number, side in enumerate(SIDES):
        lines += [f"usemtl m{number % 2}"] if materials else []
        corners = range(4 * number, 4 * number + 4) if split else side
        more = [f"/{at}" if uv else "//1" if normals else "" for at in range(1, 5)]
        words = [f"{k + 1}{word}" for k, word in zip(corners, more, strict=True)]
        lines += [f"f {' '.join(words[:3])}", f"f {words[0]} {words[2]} {words[3]}"]
    return "\n".join([*lines, ""])


def ply(split: bool) -> str:
    points = [CORNERS[k] for side in SIDES for k in side] if split else CORNERS
    corners = [range(4 * n, 4 * n + 4) if split else side for n, side in enumerate(SIDES)]
    faces = [f"3 {a} {b} {c}\n3 {a} {c} {d}" for a, b, c, d in corners]
    head = [f"element vertex {len(points)}", *(f"property float {axis}" for axis in "xyz"), "element face 12"]
    head += ["property list uchar int vertex_indices", "end_header"]
    return "\n".join(["ply", "format ascii 1.0", *head, *(f"{x} {y} {z}" for x, y, z in points), *faces, ""])


def mesh(folder: Path, kind: str, text: str) -> Mesh:
    (folder / f"a.{kind}").write_text(text)
    (folder / "a.xml").write_text(SHAPE.format(kind, kind))
    (found,) = clrt.load(folder / "a.xml").shapes
    assert isinstance(found, Mesh)
    return found


def corners_of(vertices: Any, normals: Any, faces: Any) -> dict[Any, Any]:
    """By face and place: the normal there."""
    faces = np.reshape(faces, (-1, 3))
    points, normals = np.round(np.reshape(vertices, (-1, 3)), 3), np.reshape(normals, (-1, 3))
    keys = [tuple(map(tuple, points[face].tolist())) for face in faces]
    return {(key, k): normals[face[k]] for key, face in zip(keys, faces, strict=True) for k in range(3)}


@pytest.mark.parametrize(
    ("kind", "text"),
    [("ply", ply(True)), ("obj", obj(True)), ("obj", obj(False, uv=True)), ("obj", obj(True, materials=True)),
     ("obj", obj(False, uv=True, materials=True))],
)  # fmt: skip
@pytest.mark.filterwarnings("ignore::clrt.ClrtWarning")
def test_normals_are_mitsubas(tmp_path: Path, kind: str, text: str) -> None:
    """Sides whose corners have numbers of their own stay flat: the cube was a ball."""
    found = mesh(tmp_path, kind, text)
    done = subprocess.run(
        [sys.executable, "-c", ASKED, str(tmp_path / f"a.{kind}")],
        capture_output=True, text=True, check=True, timeout=300,
    )  # fmt: skip
    data, theirs = found.data(), corners_of(*json.loads(done.stdout))
    ours = corners_of(data.vertices, data.normals, data.faces)
    assert len(ours) == 36 and ours.keys() == theirs.keys()
    for key, normal in ours.items():
        np.testing.assert_allclose(normal, theirs[key], atol=1e-5)
    scene = clrt.load(tmp_path / "a.xml")
    scene.save(tmp_path / "b.json")
    assert clrt.load(tmp_path / "b.json").shapes == scene.shapes


@pytest.mark.parametrize(
    ("kind", "text"),
    [("ply", ply(False)), ("obj", obj(False)), ("obj", obj(False, materials=True)),
     ("obj", obj(True, normals=True))],
)  # fmt: skip
@pytest.mark.filterwarnings("ignore::clrt.ClrtWarning")
def test_files_stay_files_where_it_makes_no_difference(tmp_path: Path, kind: str, text: str) -> None:
    found = mesh(tmp_path, kind, text)
    assert found.file == f"a.{kind}" and found.smooth and found.data().normals is not None
