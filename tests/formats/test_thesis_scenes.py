"""The thesis program's scene files become the scenes that they describe."""

from __future__ import annotations

import math
import warnings
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import clrt
from clrt.base.places import At
from clrt.base.records import read as read_record
from clrt.formats.thesis import SPECTRA, interval, steps
from clrt.scene.scene import Checker, Mesh, Scene, Spectral, Spectrum
from clrt.spectra.bands import Bands, light, reflectance


def read(tmp_path: Path, name: str, text: str, **options: Any) -> Scene:
    (tmp_path / name).write_text(text)
    return clrt.load(tmp_path / name, **options)


def spacing(scene: Scene) -> float:
    """Distance of neighbouring pixel rows on the plane at distance 1."""
    assert scene.camera is not None and scene.camera.fov_axis == "vertical"
    return 2 * math.tan(math.radians(scene.camera.fov / 2)) / scene.camera.height


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
    assert (material.specular, material.kr, material.kt, material.ior_d, material.shininess) == (
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
    assert scene.material_of(mesh).ior_d == 1.0  # an index of 0 stands for none


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
