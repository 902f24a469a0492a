"""Foreign formats: NFF, the thesis' scenes and mesh files become the scene that they describe."""

from __future__ import annotations

import json
import math
import struct
import warnings
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import clrt
from clrt.bands import Bands, light, reflectance
from clrt.formats.thesis import SPECTRA, interval, steps
from clrt.places import At
from clrt.records import read as read_record
from clrt.scene import (
    Checker,
    Cone,
    Cylinder,
    Mesh,
    PointLight,
    Polygon,
    Quadric,
    Scene,
    Spectral,
    Spectrum,
    Sphere,
)

VIEW = "v\nfrom 2 1 1\nat 0 0 0\nup 0 0 1\nangle 40\nhither 1\nresolution 400 300\n"


def read(tmp_path: Path, name: str, text: str, **options: Any) -> Scene:
    (tmp_path / name).write_text(text)
    return clrt.load(tmp_path / name, **options)


def spacing(scene: Scene) -> float:
    """Distance of neighbouring pixel rows on the plane at distance 1."""
    assert scene.camera is not None and scene.camera.fov_axis == "vertical"
    return 2 * math.tan(math.radians(scene.camera.fov / 2)) / scene.camera.height


# ---------------------------------------------------------------- NFF


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
    assert (material.kt, material.eta) == (0.1, 1.0)
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
        ("c 0 0 0 -1 0 0 0 -1\n", ["a.nff: line 1: shapes[0]"]),
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


# ---------------------------------------------------------------- the thesis' scenes

SURFACE = "Surface Spectrum 380 750 Constants .6 .3 .1 1.4 100\n"


def read_thesis(tmp_path: Path, text: str) -> tuple[Scene, list[str]]:
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        scene = read(tmp_path, "a.txt", text)
    assert all(issubclass(warning.category, clrt.ClrtWarning) for warning in caught)
    return scene, [str(warning.message) for warning in caught]


def test_thesis_defaults(tmp_path: Path) -> None:
    scene, messages = read_thesis(tmp_path, "")
    assert (
        scene.max_depth == 3 and scene.medium_ior == 1.0003 and scene.background == 0 and not messages
    )
    assert scene.spectrum == Spectral(bands=20, range=(380, 740), response="thesis-2011")
    np.testing.assert_allclose(light(scene.ambient, PROGRAM), np.full(20, 1 / 360))
    camera = scene.camera
    assert camera is not None and (camera.width, camera.height, camera.origin) == (800, 600, (0, 20, -30))
    assert math.isclose(math.tan(math.radians(camera.fov / 2)), 400 * 0.0015 * 500 / 800)


def ray(scene: Scene, x: int, y: int) -> np.ndarray:
    """The point of pixel (x, y) one unit in front of the camera, by the camera model's formulas."""
    camera = scene.camera
    assert camera is not None and camera.up is not None
    d = np.subtract(camera.target, camera.origin) / np.linalg.norm(np.subtract(camera.target, camera.origin))
    right = np.cross(d, camera.up) / np.linalg.norm(np.cross(d, camera.up))
    v = np.cross(right, d)
    right = -right if camera.mirror else right
    tangent = math.tan(math.radians(camera.fov / 2))
    across = 2 * (x + 0.5 + camera.shift[0]) / camera.width - 1
    down = 1 - 2 * (y + 0.5 + camera.shift[1]) / camera.height
    return d + across * tangent * right + down * tangent * camera.height / camera.width * v


@pytest.mark.parametrize(("width", "height"), [(480, 320), (481, 320), (480, 321), (5, 7)])
def test_thesis_camera_is_the_programs(tmp_path: Path, width: int, height: int) -> None:
    scene, _ = read_thesis(tmp_path, f"Width {width} Height {height} Pixel .01 Focal 0 0 0 Focal 1 2 -3")
    assert scene.camera is not None and scene.camera.near == 1 and scene.camera.origin == (1, 2, -3)
    for x, y in ((0, 0), (width - 1, 0), (width // 2, height // 2), (3, 2)):
        expected = [(x - width // 2) * 0.01, (height // 2 - y) * 0.01, 1]
        np.testing.assert_allclose(ray(scene, x, y), expected, atol=1e-12)


def test_thesis_width_sets_the_pixel_size(tmp_path: Path) -> None:
    scene, _ = read_thesis(tmp_path, "Pixel 7 Width 1000")
    assert scene.camera is not None and math.isclose(math.tan(math.radians(scene.camera.fov / 2)), 0.75)


def test_thesis_shapes(tmp_path: Path) -> None:
    text = f"""Sphere Point 1 2 3 Radius 4 {SURFACE}
Plane Point 0 -1 0 Vector 0 2 0 {SURFACE}
Polygon Point 0 0 0 Point 1 0 0 Point 0 1 0 Surface None
Ellipsoid Center 1 2 3 Radii 4 5 6 {SURFACE}
Quadric Constants 1 2 3 4 5 6 7 8 9 10 {SURFACE}
Mesh Polygon Point 0 0 0 Point 1 0 0 Point 0 1 0 Surface None
     Polygon Point 0 0 0 Point 1 0 0 Point 1 1 0 Point 0 1 0 {SURFACE}
Surface Spectrum 600 750 Constants 1 0 0 0 10
"""
    scene, _ = read_thesis(tmp_path, text)
    assert [shape.type for shape in scene.shapes] == [
        "sphere",
        "plane",
        "polygon",
        "ellipsoid",
        "quadric",
        "mesh",
    ]
    assert scene.shapes[4].coefficients == tuple(range(1, 11))
    material = scene.material_of(scene.shapes[0])
    assert bands_of(scene, 0).tolist() == [1.0] * 20 and (material.diffuse, material.ka) == (0.6, 0.6)
    assert (material.specular, material.kr, material.kt, material.eta, material.shininess) == (
        0.3,
        0.3,
        0.1,
        1.4,
        100,
    )
    assert scene.material_of(scene.shapes[2]).color == 0
    mesh = scene.shapes[5]
    assert isinstance(mesh, Mesh) and mesh.primitives == 2
    assert bands_of(scene, 5).tolist() == [0.0] * 13 + [1.0] * 7  # from 614 nm
    assert scene.material_of(mesh).eta == 1.0  # an index of 0 stands for none


PROGRAM = Bands(20, 380, 740)


def bands_of(scene: Scene, index: int) -> np.ndarray:
    color = scene.material_of(scene.shapes[index]).color
    assert not isinstance(color, Checker)
    return reflectance(color, PROGRAM)


@pytest.mark.parametrize("values", [*SPECTRA.values(), interval(500, 600), np.arange(20.0), np.zeros(20)])
def test_thesis_spectra_keep_the_value_of_every_band(values: np.ndarray) -> None:
    spectrum = read_record(Spectrum, {"type": "spectrum", "samples": steps(values)}, At())
    assert reflectance(spectrum, PROGRAM).tolist() == values.tolist()
    np.testing.assert_allclose(light(spectrum, PROGRAM), values, atol=1e-12)


def test_thesis_intervals_hold_the_bands_that_start_in_them() -> None:
    assert np.flatnonzero(interval(500, 600)).tolist() == list(range(7, 13))  # 506 to 596 nm
    assert interval(380, 750).all() and not interval(723, 750).any()


def test_thesis_lights_have_the_integral_that_is_asked_for(tmp_path: Path) -> None:
    white_light = "Light Point 1 2 3 Spectrum 380 750 Intensity .6 "
    red_light = "Light Point 0 0 0 Spectrum 600 750 Intensity 2"
    text = "Ambient .4 " + white_light + red_light
    scene, _ = read_thesis(tmp_path, text)
    found = [light(value, PROGRAM) for value in (scene.ambient, *(l.intensity for l in scene.lights))]
    np.testing.assert_allclose([18 * values.sum() for values in found], [0.4, 0.6, 2], rtol=1e-12)
    assert not found[2][:13].any()
    np.testing.assert_allclose(found[2][13:], found[2][13], rtol=1e-12)
    cie = clrt.load(tmp_path / "a.txt", response="cie")
    assert cie.spectrum is not None and cie.spectrum.response == "cie"
    np.testing.assert_allclose(light(cie.ambient, PROGRAM), np.full(20, 0.4), rtol=1e-12)
    with pytest.raises(clrt.SceneError, match=r"a\.txt: 'rgb' is not allowed; response must be"):
        clrt.load(tmp_path / "a.txt", response="rgb")


def test_thesis_magenta_is_scaled_to_1(tmp_path: Path) -> None:
    text = "Sphere Point 0 0 0 Radius 1 Surface Spectrum Magenta Constants 1 0 0 0 1"
    values = bands_of(read_thesis(tmp_path, text)[0], 0)
    assert values.tolist() == [0.5] * 7 + [0.1] * 6 + [1.0] * 7


def test_thesis_unknown_words_are_reported_with_their_line(tmp_path: Path) -> None:
    scene, messages = read_thesis(tmp_path, f"Width 100\nTorus 7\nSphere Point 0 0 0 Radius 1 {SURFACE}")
    assert len(scene.shapes) == 1
    assert messages[0].startswith("a.txt: line 2: the word 'Torus' is skipped")
    assert messages[1].startswith("a.txt: line 2: the word '7' is skipped")


@pytest.mark.parametrize(
    ("text", "parts"),
    [
        ("Width 0", ["line 1: 0 is", "Width must be from 1 to 65536"]),
        ("Width\nx", ["line 2: 'x'", "Width must be a number"]),
        ("Height 1e9", ["line 1: 1000000000 is", "Height must"]),
        ("Pixel 0", ["line 1: Pixel 0", "> 0"]),
        ("Ambient -1", ["line 1: Ambient -1", ">= 0"]),
        ("Focal 1 2", ["line 1: the file ends", "Focal"]),
        ("Light Point 0 0 0\nIntensity 1", ["line 2: 'Intensity'", "Spectrum should be here"]),
        ("Light Point 0 0 0 Spectrum 700 400 Intensity 1", ["line 1: the light's spectrum is empty"]),
        ("Light Point 0 0 0 Spectrum Magenta Intensity -1", ["line 1: lights[0].intensity"]),
        ("Sphere Point 0 0 0\nRadius -1\nSurface None", ["line 1: shapes[0].radius: -1"]),
        ("Sphere Point 0 0 0 Radius 1 Surface Blue", ["line 1: 'Blue'", "None or Spectrum"]),
        ("\nPolygon Point 0 0 0 Point 1 0 0 Surface None", ["line 2: 2 Points"]),
        ("Mesh Surface None", ["line 1: a Mesh has one or more"]),
        (
            "Sphere Point 0 0 0 Radius 1\nSurface Spectrum 0 1 Constants -1 0 0 0 1",
            ["line 2: materials.surface_1"],
        ),
    ],
)
def test_thesis_faults_name_the_line(tmp_path: Path, text: str, parts: list[str]) -> None:
    with pytest.raises(clrt.SceneError) as caught, warnings.catch_warnings():
        warnings.simplefilter("ignore")
        read(tmp_path, "a.txt", text)
    for part in ["a.txt: ", *parts]:
        assert part in str(caught.value)


@pytest.mark.shared
@pytest.mark.filterwarnings("ignore::clrt.ClrtWarning")
@pytest.mark.parametrize(
    ("name", "shapes", "lights", "size"),
    [
        ("brushed", 3, 2, (800, 800)),
        ("example", 8, 3, (480, 320)),
        ("mbs", 732, 2, (2000, 2500)),
        ("progress_final", 20, 2, (2000, 2000)),
    ],
)
def test_thesis_scenes(
    shared_folder: Path, name: str, shapes: int, lights: int, size: tuple[int, int]
) -> None:
    path = shared_folder / "data" / "thesis" / f"{name}.txt"
    scene = clrt.load(path)
    assert len(scene.shapes) == shapes and len(scene.lights) == lights
    assert path.read_text().count("Surface") == shapes
    assert scene.camera is not None and (scene.camera.width, scene.camera.height) == size
    assert clrt.load_dict(scene.to_dict()) == scene


# ---------------------------------------------------------------- mesh files


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
