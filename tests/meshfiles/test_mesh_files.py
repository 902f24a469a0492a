"""Mesh files: alone they are scenes, in scenes they are shapes."""

from __future__ import annotations

import json
import math
import struct
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import clrt
from tests.cost import bounded


@pytest.fixture
def trimesh() -> Any:
    return pytest.importorskip("trimesh", reason="needs the optional dependency clrt[mesh]")


def load_mesh(path: Path, **keys: Any) -> Any:
    scene = clrt.load_dict({"shapes": [{"type": "mesh", "file": path.name, **keys}]}, folder=path.parent)
    return scene.shapes[0].data()


def test_a_mesh_file_alone_is_a_scene_with_all_of_it_in_view(trimesh: Any, tmp_path: Path) -> None:
    for scale, offset in ((1.0, 0.0), (1e-3, 5.0), (1e4, -3e4)):
        box = trimesh.creation.box(extents=[2 * scale, scale, 3 * scale])
        box.apply_translation([offset, 0, 2 * offset])
        box.export(tmp_path / "box.stl")
        scene = clrt.load(tmp_path / "box.stl")
        camera = scene.camera
        assert camera is not None and len(scene.lights) == 1 and scene.shapes[0].file == "box.stl"
        origin, d = np.array(camera.origin), np.subtract(camera.target, camera.origin)
        d /= np.linalg.norm(d)
        right = np.cross(d, camera.up)
        right /= np.linalg.norm(right)
        seen = scene.shapes[0].data().vertices - origin
        tangent = math.tan(math.radians(camera.fov / 2))
        depth = seen @ d
        assert (depth > 0).all()
        across = np.abs(seen @ right / depth).max() / tangent
        above = np.abs(seen @ np.cross(right, d) / depth).max() / tangent / 0.75
        assert 0.3 < max(across, above) <= 1
    assert clrt.load_dict(scene.to_dict(), folder=tmp_path) == scene


def test_nodes_are_joined_in_world_space(trimesh: Any, tmp_path: Path) -> None:
    ball = trimesh.creation.icosphere(subdivisions=1)
    group = trimesh.Scene()
    group.add_geometry(
        ball, geom_name="ball", transform=trimesh.transformations.translation_matrix([5, 0, 0])
    )
    mirrored = np.diag([-1.0, 2.0, 1.0, 1.0])
    group.graph.update(frame_to="again", geometry="ball", matrix=mirrored)
    group.export(tmp_path / "two.glb")
    data = load_mesh(tmp_path / "two.glb")
    assert len(data.faces) == 2 * len(ball.faces) and len(data.vertices) == 2 * len(ball.vertices)
    a, b, c = (data.vertices[data.faces[:, k]] for k in range(3))
    outward = np.einsum(
        "ij,ij->i", np.cross(b - a, c - a), (a + b + c) / 3 - np.where(a[:, :1] > 2, [5, 0, 0], 0)
    )
    assert (outward > 0).all()  # the mirrored copy's winding is turned round
    assert data.vertices[:, 0].max() == pytest.approx(6) and data.vertices[:, 1].max() > 1.5


QUAD = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n"


def test_the_files_own_normals_make_it_smooth(trimesh: Any, tmp_path: Path) -> None:
    path = tmp_path / "a.obj"
    path.write_text(QUAD + "vn 0 0 2\nvn 1 0 1\nf 1//1 2//2 3//1 4//1\n")
    given = load_mesh(path).normals
    np.testing.assert_allclose(given[1], [0.5**0.5, 0, 0.5**0.5], atol=1e-6)
    np.testing.assert_allclose(load_mesh(path, smooth=True).normals, given)
    assert load_mesh(path, smooth=False).normals is None
    path.write_text(QUAD + "f 1 2 3 4\n")
    assert load_mesh(path).normals is None
    np.testing.assert_allclose(load_mesh(path, smooth=True).normals, [[0, 0, 1]] * 4)


def test_smooth_joins_vertices_that_the_file_splits(trimesh: Any, tmp_path: Path) -> None:
    box = trimesh.creation.box()
    box.export(tmp_path / "box.stl")  # STL has corners of its own for every triangle
    data = load_mesh(tmp_path / "box.stl", smooth=True)
    assert len(data.vertices) == 36
    for vertex in box.vertices:
        same = data.normals[(data.vertices == vertex).all(axis=1)]
        assert len(same) > 3 and np.ptp(same, axis=0).max() < 1e-12
        assert (np.sign(same[0]) == np.sign(vertex)).all()


@pytest.mark.parametrize("suffix", [".obj", ".ply", ".glb", ".stl"])
def test_every_format_gives_the_same_solid(trimesh: Any, tmp_path: Path, suffix: str) -> None:
    trimesh.creation.box(extents=[1, 2, 3]).export(tmp_path / f"box{suffix}")
    data = load_mesh(tmp_path / f"box{suffix}", smooth=False)
    a, b, c = (data.vertices[data.faces[:, k]] for k in range(3))
    assert len(data.faces) == 12 and np.einsum("ij,ij->", np.cross(a, b), c) / 6 == pytest.approx(6)


def test_foreign_materials_are_ignored_with_a_warning(trimesh: Any, tmp_path: Path) -> None:
    (tmp_path / "a.obj").write_text("mtllib a.mtl\n" + QUAD + "usemtl red\nf 1 2 3 4\n")
    (tmp_path / "a.mtl").write_text("newmtl red\nKd 1 0 0\nmap_Kd missing.png\n")
    with pytest.warns(
        clrt.ClrtWarning, match=r"shapes\[0\].file: a.obj: its materials and colours are ignored"
    ):
        data = load_mesh(tmp_path / "a.obj")
    assert len(data.faces) == 2


def gltf(uri: str) -> bytes:
    """A triangle whose numbers are in a file of their own."""
    document = {
        "asset": {"version": "2.0"},
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"}],
        "bufferViews": [{"buffer": 0, "byteLength": 36}],
        "buffers": [{"uri": uri, "byteLength": 36}],
    }
    return json.dumps(document).encode()


def test_a_gltf_reads_files_of_its_own_folder_only(trimesh: Any, tmp_path: Path) -> None:
    (tmp_path / "in").mkdir()
    numbers = struct.pack("<9f", 0, 0, 0, 1, 0, 0, 0, 1, 0)
    (tmp_path / "in" / "a.bin").write_bytes(numbers)
    (tmp_path / "out.bin").write_bytes(numbers)
    (tmp_path / "in" / "good.gltf").write_bytes(gltf("a.bin"))
    (tmp_path / "in" / "bad.gltf").write_bytes(gltf("../out.bin"))
    assert load_mesh(tmp_path / "in" / "good.gltf").vertices.tolist() == [[0, 0, 0], [1, 0, 0], [0, 1, 0]]
    with pytest.raises(
        clrt.SceneError, match=r"'\.\./out\.bin' is not allowed; a file must lie in the scene's folder"
    ):
        load_mesh(tmp_path / "in" / "bad.gltf")


SOLID = "solid a\nvertex {0} 0 0\nvertex {0} 1 0\nvertex {0} 0 1\nendsolid a\n"
OBJ = "v 0 0 0\n" * 20_000 + "v 1 0 0\nv 0 1 0\n"


@pytest.mark.parametrize(
    ("name", "text", "faces"),
    [
        ("a.obj", OBJ + "".join(f"usemtl {n}\nf {n + 1} 20001 20002\n" for n in range(5000)), 5000),
        ("a.stl", "".join(SOLID.format(n) for n in range(8000)), 8000),
        ("a.stl", "solid " + "endsolid " * 60_000, None),
        ("a.ply", f"ply\nformat ascii 1.0\nelement vertex {1 << 40}\nproperty float x\nend_header\n", None),
    ],
)
def test_many_materials_solids_and_vertices_take_no_longer_than_their_bytes(
    trimesh: Any, tmp_path: Path, name: str, text: str, faces: int | None
) -> None:
    (tmp_path / name).write_text(text)
    found = bounded("load", tmp_path / name)
    assert bool(found.error) == (faces is None), found.error
    if faces:
        assert len(load_mesh(tmp_path / name).faces) == faces


@pytest.mark.parametrize("groups", [3, 99])
def test_groups_keep_their_faces_in_the_files_order(trimesh: Any, tmp_path: Path, groups: int) -> None:
    (tmp_path / "a.stl").write_text("".join(SOLID.format(n) for n in range(groups)).upper())
    data = load_mesh(tmp_path / "a.stl")
    assert data.vertices[data.faces[:, 0], 0].tolist() == list(range(groups))
    binary = trimesh.creation.box().export(file_type="stl")
    (tmp_path / "a.stl").write_bytes(b"endsolid ".ljust(9) * 8 + binary[72:])
    assert len(load_mesh(tmp_path / "a.stl").faces) == 12
