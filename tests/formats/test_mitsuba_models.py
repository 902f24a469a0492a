"""Models as Mitsuba's XML: its plugins alone hold the meshes that clrt renders, part by part."""

from __future__ import annotations

import os
import sys
import warnings
from pathlib import Path

import numpy as np
import pytest

import clrt
from clrt.cli import main
from clrt.scene.scene import Mesh
from tests.formats.test_mitsuba_return import without_itself, written
from tests.mesh_samples import write_sample

_SQUARE = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n"


def _triangles(shape: object) -> np.ndarray:
    """The corners (m, 3, 3) of a mesh's triangles that span something, in order."""
    assert isinstance(shape, Mesh)
    data = shape.data()
    corners = data.vertices[np.asarray(data.faces)]
    across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    return corners[np.linalg.norm(across, axis=1) > 1e-7]


def _by_its_plugins(scene: clrt.Scene, path: Path) -> clrt.Scene:
    written(scene, path)
    without_itself(path)
    return clrt.load(path)


@pytest.mark.parametrize("suffix", [".obj", ".ply", ".stl", ".gltf", ".glb"])
def test_each_part_is_its_own_mesh(suffix: str, tmp_path: Path) -> None:
    parts = 0
    for seed in range(10):
        file = tmp_path / f"{seed}{suffix}"
        write_sample(file, seed)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", clrt.ClrtWarning)
            try:
                scene = clrt.load(file)
            except clrt.ClrtError:
                continue  # some have no triangles
            if any(scene.material_of(shape).pictures for shape in scene.shapes):
                continue  # colours of vertices are not written
            again = _by_its_plugins(scene, tmp_path / f"{seed}.xml")
        ours, theirs = (
            [found for shape in which.shapes if len(found := _triangles(shape))] for which in (scene, again)
        )
        assert len(ours) == len(theirs), file
        for one, other in zip(ours, theirs, strict=True):
            assert one.shape == other.shape and np.allclose(one, other, atol=1e-5), file
        parts += len(ours)
    assert parts > 4


@pytest.mark.parametrize(
    "text",
    [
        "v 0 0 0\nv 1 0 0\nv 1 1 0\nf -3 -2 -1\nv 0 1 0\nf 1 3 -1\n",
        f"{_SQUARE}f 1 2 3 # one\nf 1 3 4 # two\n",
        f"{_SQUARE}f\t1\t2\t3\nf\t1\t3\t4\n",
    ],
)
def test_an_obj_that_is_written_otherwise_is_the_same(text: str, tmp_path: Path) -> None:
    (tmp_path / "a.obj").write_text(text)
    (shape,) = _by_its_plugins(clrt.load(tmp_path / "a.obj"), tmp_path / "a.xml").shapes
    assert _triangles(shape).tolist() == [
        [[0, 0, 0], [1, 0, 0], [1, 1, 0]],
        [[0, 0, 0], [1, 1, 0], [0, 1, 0]],
    ]


def test_a_dent_is_not_covered(tmp_path: Path) -> None:
    (tmp_path / "a.obj").write_text("v 0 0 0\nv 3 0 0\nv 1 1 0\nv 0 3 0\nf 2 3 4 1\n")
    (shape,) = _by_its_plugins(clrt.load(tmp_path / "a.obj"), tmp_path / "a.xml").shapes
    corners = _triangles(shape)
    assert np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])[:, 2].tolist() == [3, 3]


@pytest.mark.skipif(sys.platform != "linux", reason="names of files are text there")
@pytest.mark.parametrize("name", [b"caf\xe9", b"\x01c", b"$x"])
def test_names_of_any_bytes(name: bytes, tmp_path: Path) -> None:
    """Of the model as of the XML, whose folder then has a name that XML can hold."""
    model, out = (tmp_path / os.fsdecode(name + suffix) for suffix in (b".obj", b".xml"))
    model.write_text(f"{_SQUARE}f 1 2 3\n")
    assert main(["convert", str(model), str(out)]) == 0
    with warnings.catch_warnings():
        warnings.simplefilter("error")  # it is the scene itself that is read
        (whole,) = clrt.load(out).shapes
    without_itself(out)
    (shape,) = clrt.load(out).shapes
    assert _triangles(shape).tolist() == _triangles(whole).tolist() == [[[0, 0, 0], [1, 0, 0], [1, 1, 0]]]
