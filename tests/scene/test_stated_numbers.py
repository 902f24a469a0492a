"""What all oracles but Mitsuba's side read as the renderer reads it, against numbers stated elsewhere."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import clrt
from clrt.engine.tracer import Tracer
from clrt.images.file import encode
from clrt.scene.adaptive import Adaptive
from clrt.scene.materials import Checker, Material
from clrt.scene.scene import Mesh, Scene
from clrt.scene.textures import ImageTexture
from clrt.spectra import bands, colorimetry, curves
from clrt.spectra.spectrum import LAMPS, METALS, PATCHES, Spectral
from tests import published_numbers as stated
from validation.oracle_mitsuba import published, spectra

pytestmark = pytest.mark.filterwarnings("ignore::clrt.base.errors.ClrtWarning")
BALL: dict[str, Any] = {"type": "sphere", "center": [0, 0, 0], "radius": 1}
CAMERA: dict[str, Any] = {"origin": [0.3, 0.4, 6], "target": [0, 0, 0], "width": 40, "height": 30}


@pytest.mark.parametrize("name", stated.TRANSFORMS)
def test_transforms_are_the_matrices_they_stand_for(name: str) -> None:
    steps, matrix = stated.TRANSFORMS[name]
    shape = clrt.load_dict({"shapes": [{**BALL, "transform": steps}]}).shapes[0]
    np.testing.assert_allclose(shape.matrix, matrix, rtol=0, atol=1e-15)


@pytest.mark.parametrize("name", stated.TRANSFORMS)
def test_and_so_are_their_pictures(name: str) -> None:
    """A box under the steps, and one under the matrix as it is written out: the same bits on the device."""
    steps, matrix = stated.TRANSFORMS[name]
    box = {"type": "box", "min": [-0.5, -0.3, -0.4], "max": [0.4, 0.2, 0.6]}

    def seen(transform: Any) -> np.ndarray:
        scene = {"camera": CAMERA, "lights": [{"type": "point", "position": [3, 4, 5]}], "ambient": 0.2,
                 "shapes": [{**box, "transform": transform}]}  # fmt: skip
        return Tracer(clrt.load_dict(scene)).render(layers=["position"]).layers["position"]

    np.testing.assert_allclose(seen(steps), seen(matrix), rtol=0, atol=2e-6)


def test_computed_normals_are_weighted_by_area() -> None:
    mesh = Mesh(vertices=stated.CORNER["vertices"], faces=stated.CORNER["faces"], smooth=True)
    np.testing.assert_allclose(mesh.data().normals, stated.CORNER["normals"], rtol=0, atol=1e-15)


def test_defaults_are_those_that_the_documents_state() -> None:
    scene = clrt.load_dict({
        "camera": {"origin": [0, 0, 5], "target": [0, 0, 0]}, "shapes": [BALL],
        "lights": [{"type": "point", "position": [0, 5, 0]},
                   {"type": "directional", "direction": [0, -1, 0]},
                   {"type": "spot", "position": [0, 5, 0], "target": [0, 0, 0]},
                   {"type": "rectangle", "center": [0, 5, 0], "u": [1, 0, 0], "v": [0, 0, 1]},
                   {"type": "disk", "center": [0, 5, 0], "normal": [0, -1, 0], "radius": 1},
                   {"type": "sphere", "center": [0, 5, 0], "radius": 1}],
    })  # fmt: skip
    pairs: list[tuple[Any, dict[str, Any]]] = [
        (scene, stated.SCENE), (scene.camera, stated.CAMERA), (Material(), stated.MATERIAL),
        (scene.material_of(scene.shapes[0]), stated.MATERIAL), (Checker(), stated.CHECKER),
        (scene.lights[0], stated.POINT), (Spectral(), stated.SPECTRUM), (Adaptive(), stated.ADAPTIVE),
        (scene.lights[2], stated.SPOT), *((light, stated.AREA) for light in scene.lights[3:]),
        (ImageTexture(file="a.png"), stated.IMAGE),
    ]  # fmt: skip
    for found, expected in pairs:
        assert {name: getattr(found, name) for name in expected} == expected
    assert scene.lights[1].intensity == 1.0


@pytest.mark.parametrize("origin", [[0, 5, 0], [0, -3, 0]])
def test_a_camera_that_looks_along_y_has_z_up(origin: list[float]) -> None:
    camera = clrt.load_dict({"camera": {"origin": origin, "target": [0, 0, 0]}}).camera
    assert camera is not None and camera.up == (0.0, 0.0, 1.0)


@pytest.mark.parametrize(("keys", "coefficients"), stated.COEFFICIENTS)
def test_coefficients_that_are_not_given(keys: dict[str, Any], coefficients: tuple[float, ...]) -> None:
    material = Material(**keys)
    assert (material.ka, material.kr, material.kt) == coefficients


def test_named_indices() -> None:
    found = {name: Material(ior=name).ior_d for name in stated.NAMED_INDEX}
    assert found == stated.NAMED_INDEX


@pytest.mark.parametrize("name", stated.GLASSES)
def test_glasses_have_their_data_sheets_index_and_dispersion(name: str) -> None:
    index, abbe, off, abbe_off = stated.GLASSES[name]
    d, f, c = curves.ior_at(name, np.array([stated.LINES[line] for line in "dFC"]))
    assert d == pytest.approx(index, abs=off) and Material(ior=name).ior_d == d
    assert (d - 1) / (f - c) == pytest.approx(abbe, abs=abbe_off)


def test_other_dispersive_indices() -> None:
    for name, (index, off) in stated.SODIUM.items():
        assert curves.ior_at(name, np.array(stated.LINES["D"])) == pytest.approx(index, abs=off)
    nm = np.linspace(380.0, 750.0, 200)
    for name in published.SELLMEIER:
        np.testing.assert_allclose(curves.ior_at(name, nm), published.index(name, nm), rtol=1e-12)


@pytest.mark.parametrize("name", METALS)
def test_metals_are_as_published(name: str) -> None:
    eta, k = curves.metal(name)
    nm = np.linspace(380.0, 750.0, 200)
    np.testing.assert_allclose([eta.at(nm), k.at(nm)], published.metal(name, nm), rtol=1e-4)


def test_the_observer_is_the_cies() -> None:
    nm = np.array(list(stated.OBSERVER), float)
    seen = list(stated.OBSERVER.values())
    np.testing.assert_allclose(colorimetry.matching(nm).T, seen, rtol=1e-5, atol=2e-6)
    fine = np.arange(360.0, 830.5, 0.5)
    np.testing.assert_allclose(colorimetry.matching(fine), spectra.seen(fine), rtol=0, atol=1e-12)


@pytest.mark.parametrize("name", LAMPS)
def test_lights_are_the_cies(name: str) -> None:
    for nm, power in stated.ILLUMINANTS.get(name, {}).items():
        assert curves.curve_of(name).at(np.array(float(nm))) == pytest.approx(power, rel=1e-5)
    if name in stated.CHROMATICITY:
        xyz = colorimetry.lamp_xyz(name)
        assert xyz[:2] / xyz.sum() == pytest.approx(stated.CHROMATICITY[name], abs=3e-4)  # F: tails
    nm = np.linspace(360.0, 830.0, 500)
    np.testing.assert_allclose(curves.curve_of(name).at(nm), spectra.named(name)(nm), rtol=1e-5, atol=1e-5)


@pytest.mark.parametrize("number", range(1, 25))
def test_patches_have_the_charts_colours(number: int) -> None:
    """The maker's sRGB, of another chart and adapted from D50: within 14 of 255, where neighbours differ by
    60."""
    shown = encode(bands.reflectance(f"patch-{number}", None).reshape(1, 1, 3)).reshape(3)
    assert np.abs(shown.astype(int) - stated.CHART[number - 1]).max() <= 14
    nm = np.linspace(360.0, 830.0, 500)
    ours = curves.curve_of(PATCHES[number - 1]).at(nm)
    np.testing.assert_allclose(ours, spectra.named(PATCHES[number - 1])(nm), rtol=0, atol=5e-5)  # 4 digits


def test_red_green_and_blue_stand_for_the_smoothest_curves() -> None:
    """Found a second time by another method; colours come back, nothing is negative, white is 1."""
    nm = np.linspace(360.0, 830.0, 471)
    found = bands.upsampling(nm)
    np.testing.assert_allclose(found, spectra.primaries(nm), rtol=0, atol=1e-6)
    np.testing.assert_allclose(found.sum(axis=0), 1.0, rtol=0, atol=1e-8)
    assert found.min() >= 0


def test_colours_are_rec_709s() -> None:
    np.testing.assert_allclose(colorimetry.XYZ_OF_RGB, stated.XYZ_OF_RGB, rtol=0, atol=6e-5)


def test_overrides_change_the_picture_and_nothing_else() -> None:
    table = {"camera": {**CAMERA, "fov": 30, "spp": 4}, "shapes": [BALL], "max_depth": 2, "ambient": 0.3}
    scene = clrt.load_dict(table)
    other = scene.override(width=20, height=10, spp=9, max_depth=7)
    camera = {**table["camera"], "width": 20, "height": 10, "spp": 9}  # type: ignore[dict-item]
    assert other == clrt.load_dict({**table, "camera": camera, "max_depth": 7})
    assert scene == clrt.load_dict(table) and isinstance(other, Scene)


def test_a_whole_number_beyond_float32_is_refused_as_such() -> None:
    for huge in (10**40, -(10**40)):
        table = {"type": "sphere", "center": [0, huge, 0], "radius": 1}
        says = r"shapes\[0\]\.center\[1\]: .*numbers must be finite and at most"
        with pytest.raises(clrt.SceneError, match=says):
            clrt.load_dict({"shapes": [table]})
        light = {"type": "point", "position": [0, 0, huge]}
        with pytest.raises(clrt.SceneError, match=r"lights\[0\]\.position\[2\]: .*numbers must be finite"):
            clrt.load_dict({"lights": [light]})


def test_a_spot_stands_at_its_position() -> None:
    spot = {"type": "spot", "position": [1, 2, 3], "target": [0, 0, 0]}
    (light,) = clrt.load_dict({"lights": [spot]}).lights
    assert light.place == (1.0, 2.0, 3.0, 1.0)
