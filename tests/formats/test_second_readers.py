"""NFF and the thesis' format against readers of their own: what each file says arrives in the scene."""

from __future__ import annotations

import math
import warnings
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import clrt
from clrt.scene.scene import Cone, Cylinder, Ellipsoid, Mesh, Plane, Polygon, Quadric, Scene, Sphere
from clrt.spectra.bands import Bands, light, reflectance
from tests.second_readers import nff, thesis

BANDS = Bands(20, 380, 740)
NFF_TEXT = """# everything once
b 0.1 0.2 0.3
v
from 2 1 1
at 0 0.5 0
up 0 0 1
angle 40
hither 1
resolution 400 300
l 1 2 3
l 4 5 6 0.5 0.6 0.7
s 9 9 9 0.5
f 1 0.5 0.25 0.7 0.2 30 0.1 1.4
s 1 2 3 4
c 0 0 0 1  0 1 2 1
c 0 0 0 1.5  0 2 2 0.5
f 0.2 0.5 0.9 0.6 0.3 12 0 0
p 4
0 0 0
1 0 0
1 1 0
0 1 0
p 3
0 0 1
2 0 1
0 2 1
p 4
0 2 3
1 1 3
2 2 3
1 -1 3
f 0.3 0.3 0.3 1 0 1 0 0
pp 3
0 0 0 0 0 1
1 0 0 0 0.6 0.8
0 1 0 0.6 0 0.8
"""
THESIS_TEXT = """Width 480 Height 320 Ambient .4 Focal -10 15 -90
Light Point 1000 900 -1000 Spectrum 380 750 Intensity .6
Light Point -200 1000 -1000 Spectrum Magenta Intensity 1
Ellipsoid Center 20 0 -10 Radii 15 2 14 Surface Spectrum 380 560 Constants 1 0.1 0.2 1.5 10
Sphere Point 45 0 30. Radius 20 Surface Spectrum 600 750 Constants .1 .9 0 0 100
Plane Point 0 -20 1 Vector 0.5 2 0 Surface Spectrum Red Constants .8 .2 0 0 1
Polygon Point 0 2 0 Point 1 1 0 Point 2 2 0 Point 1 -1 0 Surface None
Quadric Constants 1 2 3 .1 .2 .3 4 5 6 -7 Surface Spectrum 500 600 Constants .5 .5 .1 1.2 3
Mesh Polygon Point 0 0 0 Point 1 0 0 Point 0 1 0 Surface None
 Polygon Point 0 0 1 Point 2 0 1 Point 0 2 1 Surface None Surface Spectrum 495 570 Constants 1 0 0 0 1
"""


def loaded(folder: Path, name: str, text: str, **options: Any) -> Scene:
    (folder / name).write_text(text)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", clrt.ClrtWarning)
        return clrt.load(folder / name, **options)


def same(ours: Any, theirs: Any) -> None:
    np.testing.assert_allclose(np.array(ours, float), np.array(theirs, float), rtol=1e-12, atol=0)


def corners(shape: Any) -> list[np.ndarray]:
    """The outlines of polygons, one after the other, with normals where there are some."""
    if isinstance(shape, Polygon):
        return [np.array(shape.points)]
    data = shape.data()
    rows = data.vertices if data.normals is None else np.c_[data.vertices, data.normals]
    return [rows[face] for face in data.faces]


def check_nff(scene: Scene, text: str) -> None:
    said = nff(text)
    (view,) = said["view"]
    camera = scene.camera
    assert camera is not None and camera.fov_axis == "vertical"
    same([camera.origin, camera.target, camera.up], [view["from"], view["at"], view["up"]])
    same([camera.width, camera.height], view["resolution"])
    rows = 2 * math.tan(math.radians(camera.fov) / 2) / camera.height  # spacing of rows a unit away
    same(rows, 2 * math.tan(math.radians(view["angle"][0]) / 2) / (camera.height - 1))
    same(np.broadcast_to(scene.background, 3), said["b"][-1] if said["b"] else (0, 0, 0))
    level = math.sqrt(len(said["l"])) / (2 * len(said["l"]))
    for ours, (position, color) in zip(scene.lights, said["l"], strict=True):
        same(ours.position, position)
        same(np.broadcast_to(ours.intensity, 3), (level,) * 3 if color is None else color)
    same(np.broadcast_to(scene.ambient, 3), (level,) * 3)

    def check_fill(shape: Any, fill: int) -> None:
        if fill < 0:
            assert shape.material is None
            return
        *color, kd, ks, shine, transmission, ior = said["f"][fill]
        m = scene.material_of(shape)
        same([*m.color, m.diffuse, m.ka, m.specular, m.kr, m.shininess, m.kt, m.ior_d],
             [*color, kd, kd, ks, ks, shine, transmission, ior or 1])  # fmt: skip
        assert not m.fresnel and not m.thin and m.conductor is None

    spheres = [shape for shape in scene.shapes if isinstance(shape, Sphere)]
    for shape, (fill, numbers) in zip(spheres, said["s"], strict=True):
        same([*shape.center, shape.radius], numbers)
        check_fill(shape, fill)
    cones = [shape for shape in scene.shapes if isinstance(shape, (Cone, Cylinder))]
    for cone, (fill, numbers) in zip(cones, said["c"], strict=True):
        ends = (cone.r0, cone.r1) if isinstance(cone, Cone) else (cone.radius, cone.radius)
        same([*cone.p0, ends[0], *cone.p1, ends[1]], numbers)
        assert not cone.caps
        check_fill(cone, fill)
    flat = [(s, c) for s in scene.shapes if isinstance(s, (Polygon, Mesh)) for c in corners(s)]
    for key in ("p", "pp"):
        ours = [(shape, outline) for shape, outline in flat if (outline.shape[1] == 6) == (key == "pp")]
        for (shape, outline), (fill, points) in zip(ours, said[key], strict=True):
            expected = np.array(points)
            if key == "p":
                a, b, c = expected[:3]
                newell = np.cross(expected, np.roll(expected, -1, axis=0)).sum(axis=0)
                if np.cross(b - a, c - b) @ newell < 0:  # the format's outer side is told by the first corner
                    expected = expected[::-1]
                start = np.flatnonzero((outline == expected[0]).all(axis=1))[0]
                outline = np.roll(outline, -start, axis=0)
            same(outline, expected)
            check_fill(shape, fill)


def test_nff_is_read_as_a_second_reader_does(tmp_path: Path) -> None:
    check_nff(loaded(tmp_path, "a.nff", NFF_TEXT), NFF_TEXT)


@pytest.mark.shared
@pytest.mark.parametrize("name", ["balls_c_s3", "mount_c_s6", "tetra_c_s6", "tree_c_s11", "teapot_c_s12"])
def test_published_nff_files(shared_folder: Path, tmp_path: Path, name: str) -> None:
    text = (shared_folder / "data" / "spd" / f"{name}.nff").read_text()
    check_nff(loaded(tmp_path, "a.nff", text), text)


def powers(spectrum: Any) -> np.ndarray:
    """(20,) bands of the thesis' program: 1 where 380 + 18 i lies in an interval; its two names."""
    nm = 380 + 18 * np.arange(20)

    def within(low: float, high: float) -> np.ndarray:
        return ((nm >= low) & (nm <= high)).astype(float)

    if isinstance(spectrum, tuple):
        return within(*spectrum)
    red, green, blue = within(600, 750), within(500, 600), within(380, 500)
    found = {"Red": red + 0.1 * blue + 0.1 * green, "Magenta": red + 0.5 * blue + 0.1 * green}[spectrum]
    return found / found.max()


def check_thesis(scene: Scene, text: str) -> None:
    said = thesis(text)
    settings = {word: values[0] for word, values in said if word in ("Width", "Height", "Ambient", "Focal")}
    (width,), (height,) = settings.get("Width", (800,)), settings.get("Height", (600,))
    camera = scene.camera
    assert camera is not None and camera.mirror and camera.near == 1 and camera.fov_axis == "horizontal"
    same([camera.width, camera.height, *camera.origin], [width, height, *settings.get("Focal", (0, 20, -30))])
    pixel = [values[0][0] if word == "Pixel" else 1.5 / values[0][0] for word, values in said
             if word in ("Pixel", "Width")]  # fmt: skip
    tangent = math.tan(math.radians(camera.fov) / 2)
    same(2 * tangent / width, pixel[-1] if pixel else 0.0015 * 500 / 800)
    same(light(scene.ambient, BANDS), np.full(20, settings.get("Ambient", (1.0,))[0] / 360))
    lights = [values for word, values in said if word == "Light"]
    for ours, (position, spectrum, (intensity,)) in zip(scene.lights, lights, strict=True):
        same(ours.position, position)
        power = powers(spectrum)
        np.testing.assert_allclose(light(ours.intensity, BANDS), power * intensity / (18 * power.sum()),
        rtol=1e-9)
    shapes = [(word, values) for word, values in said if word not in (*settings, "Pixel", "Light")]
    for shape, (word, (*numbers, surface)) in zip(scene.shapes, shapes, strict=True):
        if isinstance(shape, Sphere):
            same([*shape.center, shape.radius], [*numbers[0], *numbers[1]])
        elif isinstance(shape, Plane):
            same([shape.point, shape.normal], numbers)
        elif isinstance(shape, Ellipsoid):
            same([shape.center, shape.radii], numbers)
        elif isinstance(shape, Quadric):
            same(shape.coefficients, numbers[0])
        else:
            outlines = numbers[0] if word == "Mesh" else [numbers[0]]
            for ours, theirs in zip(corners(shape), outlines, strict=True):
                assert sorted(map(tuple, ours.tolist())) == sorted(theirs)
                normal = np.cross(ours, np.roll(ours, -1, axis=0)).sum(axis=0)
                a, b, c = np.array(theirs[:3])
                assert normal @ np.cross(b - a, c - b) > 0
        assert shape.type == word.lower()
        m = scene.material_of(shape)
        if surface is None:
            same(np.broadcast_to(m.color, 3), (0, 0, 0))
            continue
        spectrum, (diffuse, specular, through, index, smooth) = surface
        assert reflectance(m.color, BANDS).tolist() == powers(spectrum).tolist()
        same([m.diffuse, m.ka, m.specular, m.kr, m.kt, m.ior_d, m.shininess],
             [diffuse, diffuse, specular, specular, through, index or 1, smooth])  # fmt: skip


def test_the_thesis_format_is_read_as_a_second_reader_does(tmp_path: Path) -> None:
    check_thesis(loaded(tmp_path, "a.txt", THESIS_TEXT), THESIS_TEXT)


@pytest.mark.shared
@pytest.mark.parametrize("name", ["example", "brushed", "progress_final", "mbs"])
def test_the_thesis_own_files(shared_folder: Path, tmp_path: Path, name: str) -> None:
    text = (shared_folder / "data" / "thesis" / f"{name}.txt").read_text()
    check_thesis(loaded(tmp_path, "a.txt", text), text)
