"""NFF files become the scenes that they describe, with the published scenes' conventions."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import clrt
from clrt.scene.scene import Cone, Cylinder, Mesh, PointLight, Polygon, Quadric, Scene, Sphere

VIEW = "v\nfrom 2 1 1\nat 0 0 0\nup 0 0 1\nangle 40\nhither 1\nresolution 400 300\n"


def read(tmp_path: Path, name: str, text: str, **options: Any) -> Scene:
    (tmp_path / name).write_text(text)
    return clrt.load(tmp_path / name, **options)


def spacing(scene: Scene) -> float:
    """Distance of neighbouring pixel rows on the plane at distance 1."""
    assert scene.camera is not None and scene.camera.fov_axis == "vertical"
    return 2 * math.tan(math.radians(scene.camera.fov / 2)) / scene.camera.height


def test_nff_mapping(tmp_path: Path) -> None:
    text = f"""b 0.1 0.2 0.3  # a comment
{VIEW}l 1 2 3
l 4 5 6 0.5 0.6 0.7
f 1 0.5 0.25 0.7 0.2 30 0.1 0
s 1 2 3 4
"""
    scene = read(tmp_path, "a.nff", text)
    level = math.sqrt(2) / 4
    assert scene.max_depth == 4 and scene.background == (0.1, 0.2, 0.3) and scene.ambient == level
    assert scene.one_sided == "none" and scene.conformance == "none"
    assert scene.lights == (
        PointLight(position=(1, 2, 3), intensity=level),
        PointLight(position=(4, 5, 6), intensity=(0.5, 0.6, 0.7)),
    )
    (ball,) = scene.shapes
    assert isinstance(ball, Sphere) and (ball.center, ball.radius) == ((1, 2, 3), 4)
    material = scene.material_of(ball)
    assert (material.color, material.diffuse, material.ka) == ((1, 0.5, 0.25), 0.7, 0.7)
    assert (material.specular, material.kr, material.shininess) == (0.2, 0.2, 30)
    assert (material.kt, material.ior_d) == (0.1, 1.0)
    camera = scene.camera
    assert camera is not None
    assert (camera.origin, camera.target, camera.up) == ((2, 1, 1), (0, 0, 0), (0, 0, 1))
    assert (camera.width, camera.height, camera.near, camera.mirror) == (400, 300, 0, False)
    assert math.isclose(spacing(scene), 2 * math.tan(math.radians(20)) / 299)


def test_nff_conformance_shoots_the_corner_rays(tmp_path: Path) -> None:
    scene = read(tmp_path, "a.nff", VIEW.replace("400 300", "512 512"), conformance="spd")
    assert scene.camera is not None and (scene.camera.width, scene.camera.height) == (513, 513)
    assert math.isclose(spacing(scene), 2 * math.tan(math.radians(20)) / 511)
    assert scene.one_sided == "opaque" and scene.conformance == "spd"
    patch = "pp 3\n0 0 0 0 0 1\n1 0 0 0 0 1\n0 1 0 0 0 1\n"
    assert read(tmp_path, "a.nff", patch, conformance="spd").one_sided == "none"


def test_nff_line_breaks_end_a_light_only(tmp_path: Path) -> None:
    scene = read(tmp_path, "a.nff", "l\n1\n2\n3\nl 1 2 3\ns\n0 0\n0 1 s 0 0 0 2")
    assert [light.position for light in scene.lights] == [(1, 2, 3), (1, 2, 3)]
    assert [shape.radius for shape in scene.shapes] == [1, 2]


def test_nff_cones(tmp_path: Path) -> None:
    scene = read(tmp_path, "a.nff", "c 0 0 0 1  0 0 2 1\nc 0 0 0 1  0 0 2 0\n")
    assert scene.shapes == (
        Cylinder(p0=(0, 0, 0), p1=(0, 0, 2), radius=1),
        Cone(p0=(0, 0, 0), r0=1, p1=(0, 0, 2), r1=0),
    )


def form(quadric: Quadric, point: np.ndarray) -> tuple[float, bool]:
    """The quadric's value at a point of world space, and whether its clip box holds the point."""
    x, y, z, _ = np.linalg.solve(quadric.matrix, [*point, 1.0])
    a, b, c, d, e, f, g, h, i, j = quadric.coefficients
    value = (
        a * x * x
        + b * y * y
        + c * z * z
        + 2 * (d * x * y + e * y * z + f * x * z + g * x + h * y + i * z)
        + j
    )
    if quadric.clip is None:
        return value, True
    low, high = np.array(quadric.clip)
    return value, bool(((low - 1e-12 <= (x, y, z)) & ((x, y, z) <= high + 1e-12)).all())


@pytest.mark.parametrize(("r0", "r1"), [(-2.0, -1.0), (-1.0, -1.0), (-1.0, 0.0), (0.0, -3.0)])
def test_nff_negative_radii_turn_the_visible_side_inside(tmp_path: Path, r0: float, r1: float) -> None:
    p0, p1 = np.array([1.0, 2.0, 3.0]), np.array([2.0, 4.0, 5.0])
    words = " ".join(map(str, ["c", *p0, r0, *p1, r1, "s 1 2 3 -2"]))
    cone, ball = read(tmp_path, "a.nff", words).shapes
    assert isinstance(cone, Quadric) and isinstance(ball, Quadric)
    axis = (p1 - p0) / 3
    across = np.cross(axis, [1, 0, 0]) / np.linalg.norm(np.cross(axis, [1, 0, 0]))
    for part in (0.01, 0.5, 0.99):
        radius = abs(r0 + part * (r1 - r0))
        value, kept = form(cone, p0 + part * (p1 - p0) + radius * across)
        assert abs(value) < 1e-12 and kept
        assert form(cone, p0 + part * (p1 - p0))[0] > 0  # the axis is outside: the form is positive there
    for part in (-0.01, 1.01):
        assert not form(cone, p0 + part * (p1 - p0))[1]
    assert form(ball, p0)[0] > 0 and form(ball, p0 + 2 * across)[0] == pytest.approx(0, abs=1e-12)


def normals(vertices: np.ndarray, faces: Any) -> np.ndarray:
    """Newell's normals, by the textbook's sums."""
    sums = []
    for face in faces:
        p = vertices[np.asarray(face)]
        q = np.roll(p, -1, axis=0)
        sums.append([((p - q)[:, (k + 1) % 3] * (p + q)[:, (k + 2) % 3]).sum() for k in range(3)])
    return np.array(sums)


def test_nff_polygons_keep_the_side_that_the_first_corner_names(tmp_path: Path) -> None:
    # The first corner of the second outline is the reflex one: NFF's normal points to -z though it runs
    # counter-clockwise around +z.
    convex = "p 4\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n"
    reflex = "p 4\n0 1 0\n1 1 0\n4 0 0\n1 4 0\n"
    scene = read(tmp_path, "a.nff", convex + reflex)
    (mesh,) = scene.shapes
    assert isinstance(mesh, Mesh) and mesh.primitives == 2
    up, down = normals(mesh.data().vertices, mesh.data().faces)
    assert up[2] > 0 and down[2] < 0
    alone = read(tmp_path, "a.nff", reflex).shapes[0]
    assert isinstance(alone, Polygon) and normals(np.array(alone.points), [range(4)])[0][2] < 0


def test_nff_runs_of_polygons_become_one_mesh_a_material(tmp_path: Path) -> None:
    triangle, quad = "p 3 0 0 0 1 0 0 0 1 0\n", "p 4 0 0 0 1 0 0 1 1 0 0 1 0\n"
    patch = "pp 4 0 0 0 0 0 1  1 0 0 0 0 1  1 1 0 0 0 1  0 1 0 0 1 1\n"
    fills = ["f 1 0 0 1 0 1 0 0\n", "f 0 1 0 1 0 1 0 0\n"]
    text = fills[0] + triangle + quad + fills[1] + triangle + triangle + patch + patch + fills[0] + triangle
    scene = read(tmp_path, "a.nff", text)
    assert [shape.type for shape in scene.shapes] == ["mesh", "mesh", "mesh", "polygon"]
    assert [shape.primitives for shape in scene.shapes] == [2, 2, 4, 1]
    assert [shape.material for shape in scene.shapes] == ["fill_1", "fill_2", "fill_2", "fill_1"]
    data = scene.shapes[2].data()
    assert data.normals.shape == (8, 3) and data.normals[3].tolist() == [0, 1, 1]
    assert [face.tolist() for face in data.faces] == [[0, 1, 2, 3], [4, 5, 6, 7]]


def test_a_patch_with_a_dent_is_hit_where_the_polygon_is(tmp_path: Path) -> None:
    corners = ["0.8 -0.8 0", "0.8 0 0", "0 0 0", "0 0.8 0", "-0.8 0.8 0", "-0.8 -0.8 0"]
    rays = np.c_[np.random.default_rng(2).uniform(-1, 1, (1000, 2)), np.full(1000, 3.0)], [0.0, 0.0, -1.0]
    met = []
    for kind, normal in (("p", ""), ("pp", " 0 0 1")):
        text = f"f 1 0 0 1 0 1 0 0\n{kind} 6\n" + "".join(f"{corner}{normal}\n" for corner in corners)
        with clrt.Tracer(read(tmp_path, f"{kind}.nff", text)) as tracer:
            met.append(np.isfinite(tracer.intersect(*rays).t))
    assert np.array_equal(*met) and 300 < met[0].sum() < 700


@pytest.mark.parametrize(
    ("text", "parts"),
    [
        ("b 0 0 0\nq 1\n", ["a.nff: line 2: 'q'", "b or v or l"]),
        ("s 0 0 0 x\n", ["a.nff: line 1: 'x'", "must be a number"]),
        ("s 0 0 0 nan\n", ["a.nff: line 1: 'nan'", "must be a number"]),
        ("s 0 0 0 1_0\n", ["a.nff: line 1: '1_0'", "must be a number"]),
        ("\n\ns 0 0 0", ["a.nff: line 3: the file ends", "a sphere"]),
        ("b 0 0 0\ns 0 0 0 0\n", ["a.nff: line 2: shapes[0].radius: 0", "> 0"]),
        ("f 1 1 1 1 0 1 0 0\nf 1 1 1 -1 0 1 0 0\ns 0 0 0 1", ["line 2: materials.fill_2.diffuse: -1"]),
        ("p 2\n0 0 0\n1 0 0\n", ["a.nff: line 1: 2 points"]),
        ("p 2.5\n", ["a.nff: line 1: 2.5", "whole number"]),
        ("p 3\n0 0 0\n1 1 1\n2 2 2\n", ["a.nff: line 1: shapes[0].points", "on a line"]),
        ("c 0 0 0 1 0 0 0 1\n", ["a.nff: line 1: shapes[0].p1"]),
        ("\nc 0 0 0 -1 0 0 1 -1e200\n", ["a.nff: line 2: -1e+200 is not allowed; a radius"]),
        ("c 0 0 0 -1 0 0 0 -1\n", ["a.nff: line 1: shapes[0]"]),
        ("\nc 1e308 1e308 0 -1 -1e308 0 0 -2\n", ["a.nff: line 2: its ends are too far apart"]),
        ("c 0 0 0 -1 0 0 1 1\n", ["a.nff: line 1: shapes[0].r0", "-1"]),
        (VIEW.replace("angle 40", "angle 180"), ["a.nff: line", "angle 180"]),
        (VIEW.replace("400 300", "400 0"), ["a.nff: line 7: 0", "resolution must be from 1 to 65536"]),
        (VIEW.replace("at 0 0 0", "to 0 0 0"), ["a.nff: line 3: 'to'", "at"]),
        (VIEW.replace("up 0 0 1", "up 2 1 1"), ["a.nff: line 1: camera.up", "parallel"]),
    ],
)
def test_nff_faults_name_the_line(tmp_path: Path, text: str, parts: list[str]) -> None:
    with pytest.raises(clrt.SceneError) as caught:
        read(tmp_path, "a.nff", text)
    for part in parts:
        assert part in str(caught.value)


# (name, shapes by type, primitives, lights): counted in the files by `cut -d' ' -f1 | sort | uniq -c`
SPD = [
    ("balls_c_s3", {"sphere": 820}, 821, 3),
    ("balls_c_s4", {"sphere": 7381}, 7382, 3),
    ("mount_c_s6", {"sphere": 4}, 8196, 1),
    ("teapot_c_s12", {}, 144 + 9120, 2),
    ("tetra_c_s6", {}, 4096, 1),
    ("tree_c_s11", {"sphere": 4095}, 8191, 7),
]


@pytest.mark.shared
@pytest.mark.filterwarnings("ignore::clrt.ClrtWarning")
@pytest.mark.parametrize(("name", "counts", "primitives", "lights"), SPD)
def test_published_nff_scenes(
    shared_folder: Path, name: str, counts: dict[str, int], primitives: int, lights: int
) -> None:
    scene = clrt.load(shared_folder / "data" / "spd" / f"{name}.nff", conformance="spd")
    for kind, count in counts.items():
        assert sum(shape.type == kind for shape in scene.shapes) == count
    assert sum(shape.primitives for shape in scene.shapes) == primitives
    assert len(scene.lights) == lights and scene.camera is not None
    assert scene.one_sided == ("none" if name.startswith("teapot") else "opaque")
    assert clrt.load_dict(scene.to_dict()) == scene


def test_an_option_of_another_kind_is_named(tmp_path: Path):
    (tmp_path / "a.nff").write_text("v\n")
    with pytest.raises(clrt.SceneError, match="conformance: 3 is not allowed; it must be a text"):
        clrt.load(tmp_path / "a.nff", conformance=3)


def test_a_mark_before_the_first_word_is_passed_over(tmp_path: Path) -> None:
    (tmp_path / "a.nff").write_bytes(b"\xef\xbb\xbf" + f"b 0.5 0 0\n{VIEW}l 1 2 3\ns 1 2 3 4\n".encode())
    assert clrt.load(tmp_path / "a.nff").background == (0.5, 0.0, 0.0)
    (tmp_path / "b.nff").write_bytes(b"\xef\xbb\xbfx")
    with pytest.raises(clrt.ClrtError, match=r"b\.nff: line 1: 'x' is not allowed"):
        clrt.load(tmp_path / "b.nff")


def test_nff_shapes_seen_from_within_are_a_run(tmp_path: Path) -> None:
    """Balls and cones by turns, each where its line says."""
    text = "s 0 0 0 -1\ns 5 0 0 -2\nc 0 0 9 -1 0 2 9 -1\nc 0 0 12 -1 0 2 12 -1\ns 9 0 0 -3\n"
    shapes = read(tmp_path, "a.nff", text).shapes
    assert len(shapes) == 5 and all(isinstance(shape, Quadric) for shape in shapes)
