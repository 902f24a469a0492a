"""A spectral scene, wavelength by wavelength: the scenes in RGB that stand for its bands."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import clrt
from clrt.spectra.bands import Bands, light, reflectance
from validation.oracle64 import render64
from validation.wavelengths import at_bands, not_by_wavelength, triples

pytestmark = pytest.mark.filterwarnings("ignore::clrt.base.errors.ClrtWarning")
CAMERA = {"origin": [0, 0.4, 5], "target": [0, 0, 0], "fov": 40, "width": 24, "height": 18}
BALL = {"type": "sphere", "center": [0, 0, 0], "radius": 1.2}
FLOOR = {"type": "plane", "point": [0, -1.2, 0], "normal": [0, 1, 0], "material": {"color": "patch-12"}}
LAMP = {"type": "point", "position": [3, 4, 5], "intensity": {"name": "F2", "scale": 0.8}}


def lit(material: dict, **spectrum: object) -> clrt.Scene:
    return clrt.load_dict({
        "spectrum": {"bands": 5, **spectrum}, "background": {"name": "A", "scale": 0.3}, "ambient": 0.1,
        "camera": CAMERA, "lights": [LAMP], "shapes": [FLOOR, {**BALL, "material": material}],
    })  # fmt: skip


MATERIALS = {
    "tints": {"color": "gold", "diffuse": 0.5, "reflection": 0.4, "reflection_color": [0.9, 0.7, 0.2]},
    "absorbing glass": {"diffuse": 0.0, "fresnel": True, "absorption": {"samples": [[400, 0.2], [700, 0.9]]}},
    "metal": {"color": 0.2, "diffuse": 0.1, "conductor": "copper"},
    "dispersion": {"diffuse": 0.0, "fresnel": True, "ior": "SF10"},
}


@pytest.mark.parametrize("name", MATERIALS)
def test_each_band_is_a_picture_of_its_own(name: str) -> None:
    scene = lit(MATERIALS[name])
    together = render64(scene).bands
    assert together.shape == (18, 24, 5)
    for bands in triples(scene):
        alone = render64(at_bands(scene, bands)).pixels
        np.testing.assert_allclose(together[..., list(bands)], alone, rtol=0, atol=1e-9)


def test_a_background_image_is_seen_in_its_bands(tmp_path: Path) -> None:
    sky = np.random.default_rng(2).random((8, 16, 3), np.float32)
    clrt.Image(sky).save(tmp_path / "sky.exr")
    keys = {"spectrum": {"bands": 5}, "background": "sky.exr", "camera": CAMERA, "shapes": [BALL]}
    scene = clrt.load_dict(keys, folder=tmp_path)
    together = render64(scene).bands
    for bands in triples(scene):
        alone = render64(at_bands(scene, bands)).pixels
        np.testing.assert_allclose(together[..., list(bands)], alone, rtol=0, atol=1e-9)
    assert np.ptp(together) > 0.1


def test_groups_share_the_index_of_their_middle() -> None:
    scene = lit(MATERIALS["dispersion"], group=2)
    first, second, last = (at_bands(scene, (b, b, b)).shapes[1].material for b in (0, 1, 4))
    assert first.ior == second.ior != last.ior
    alone = render64(at_bands(scene, (1, 1, 1))).pixels
    np.testing.assert_allclose(render64(scene).bands[..., 1], alone[..., 1], rtol=0, atol=1e-9)


def test_the_numbers_are_those_of_the_renderer() -> None:
    scene = at_bands(lit(MATERIALS["tints"]), (4, 0, 2))
    bands = Bands(5)
    assert scene.lights[0].intensity == pytest.approx(0.8 * light("F2", bands)[[4, 0, 2]], abs=1e-5)
    assert scene.material_of(scene.shapes[1]).color == pytest.approx(reflectance("gold", bands)[[4, 0, 2]])
    assert scene.ambient == pytest.approx(light(0.1, bands)[[4, 0, 2]], abs=1e-5)


def test_what_has_no_bands_or_no_numbers_is_refused() -> None:
    with pytest.raises(ValueError, match="in RGB"):
        at_bands(clrt.load_dict({"shapes": []}), (0, 1, 2))
    with pytest.raises(ValueError, match="a metal is not the same"):
        at_bands(lit(MATERIALS["metal"]), (0, 1, 2))
    with pytest.raises(ValueError, match="an index of refraction is not the same"):
        at_bands(lit(MATERIALS["dispersion"]), (0, 1, 2))
    assert not_by_wavelength(lit(MATERIALS["tints"], response="thesis-2011"))
