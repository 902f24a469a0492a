"""Light in bands, metals and dispersion: as a picture of each wavelength shows them."""

from __future__ import annotations

import re
from typing import Any

import numpy as np
import pytest

import clrt
from clrt import layout
from clrt.device.device import Device
from clrt.flatten.flatten import flatten
from clrt.spectra.bands import Bands
from clrt.spectra.curves import ior_at
from validation.twin.scenes import scenes
from validation.twin.variants import in_bands

GLASS: dict[str, Any] = {"type": "sphere", "center": [0, 0.3, 0], "radius": 0.8}
METAL = {"type": "sphere", "center": [1.5, 0, -0.5], "radius": 0.6,
         "material": {"diffuse": 0, "conductor": "copper"}}  # fmt: skip
FLOOR = {"type": "plane", "point": [0, -0.6, 0], "normal": [0, 1, 0],
         "material": {"color": {"type": "checker", "size": 0.4, "colors": ["patch-14", 0.2]}}}  # fmt: skip


def scene(ior: Any, **more: Any) -> clrt.Scene:
    table = {
        "spectrum": {"bands": 6}, "max_depth": 5, "ambient": 0.2, "background": [0.1, 0.2, 0.4],
        "camera": {"origin": [0, 1, 4], "target": [0, 0.2, 0], "width": 48, "height": 36},
        "lights": [{"type": "point", "position": [3, 5, 4]}],
        "shapes": [FLOOR, {**GLASS, "material": {"diffuse": 0, "fresnel": True, "ior": ior}}, METAL],
    }  # fmt: skip
    return clrt.load_dict({**table, **more})


def bands_of(scene: clrt.Scene) -> np.ndarray:
    return clrt.render(scene, layers=["bands"]).layers["bands"]


@pytest.mark.parametrize("group", [1, 4])
def test_each_band_is_bent_by_the_index_of_its_group(group: int) -> None:
    """Up to the order of sums: rays of one pixel and generation are added up queue by queue."""
    spectrum = {"bands": 6, "group": group}
    split = bands_of(scene("SF11", spectrum=spectrum))
    edges = Bands(6).edges
    for first in range(0, 6, group):
        last = min(first + group, 6)
        bent = ior_at("SF11", np.array((edges[first] + edges[last]) / 2))
        alone = bands_of(scene(float(bent)))[..., first:last]
        np.testing.assert_allclose(split[..., first:last], alone, atol=1e-5 * alone.max(), rtol=0)
    # that would be no news if all wavelengths were bent alike
    assert np.abs(split - bands_of(scene(float(ior_at("SF11", np.array(540.0)))))).max() > 0.01 * split.max()


def test_without_dispersion_no_ray_is_narrow() -> None:
    flat = flatten(scene(1.7))
    assert flat.ray_format == layout.RayFormat(bands=6)
    assert flatten(scene("BK7")).ray_format == layout.RayFormat(bands=6, group=1)
    assert flatten(scene("BK7", spectrum=None)).ray_format == layout.RayFormat()


def test_each_group_of_a_split_ray_counts_as_a_ray() -> None:
    """One camera ray, six groups: six rays enter the glass, one is reflected, and none is lost."""
    ray = np.array([[0.0, 0.3, 4.0]]), np.array([[0.1, 0.05, -1.0]])
    _, stats = clrt.Tracer(scene("BK7")).radiance(*ray, max_depth=1)
    assert stats["generations"][1]["transmission"] == 6 and stats["generations"][1]["reflection"] == 1
    _, whole = clrt.Tracer(scene(1.5)).radiance(*ray, max_depth=1)
    assert whole["generations"][1]["transmission"] == 1


def test_the_picture_is_the_same_for_tiles_of_any_size() -> None:
    expected = clrt.render(scene("diamond-dispersive"))
    for tile in (1 << 16, 500, 31):
        settings = clrt.Settings(tile=tile, local_size=16)
        assert clrt.render(scene("diamond-dispersive"), settings=settings).hash == expected.hash


def test_a_tile_of_which_dispersion_makes_many_rays_is_split(monkeypatch: pytest.MonkeyPatch) -> None:
    tracer = clrt.Tracer(scene("BK7"))

    def render() -> tuple[clrt.Image, int]:
        tiles: list[int] = []
        return tracer.render(spp=4, progress=lambda done, *_: tiles.append(done)), len(tiles)

    whole, few = render()
    monkeypatch.setattr("clrt.engine.wavefront._NARROW_RAYS", 12)  # fewer than a pixel's four samples give
    split, many = render()
    assert many > 10 * few, "as far as there are pixels to part"
    assert split.hash == whole.hash and split.stats["rays"] == whole.stats["rays"]


def test_the_work_of_narrow_rays_is_foreseen() -> None:
    work = 48 * 36 * 2 * (1 << 5)  # rays of a branching family, one light
    settings = clrt.Settings(limits=clrt.Limits(work=work))
    clrt.render(scene(1.5), settings=settings)
    with pytest.raises(clrt.LimitError, match="work"):
        clrt.render(scene("BK7"), settings=settings)


def test_layers_of_a_spectral_picture() -> None:
    layers = ["bands", "xyz", "reflection", "transmission", "direct"]
    image = clrt.render(scene("BK7"), layers=layers)
    assert image.layers["bands"].shape == (36, 48, 6) and image.layers["xyz"].shape == (36, 48, 3)
    flat = flatten(scene("BK7"))
    assert flat.response is not None and flat.xyz is not None
    for matrix, values in ((flat.response, image.pixels), (flat.xyz, image.layers["xyz"])):
        np.testing.assert_allclose(image.layers["bands"] @ matrix.T, values, atol=2e-6 * values.max())
    parts = sum(image.layers[name] for name in ("reflection", "transmission", "direct"))
    np.testing.assert_allclose(parts, image.pixels, atol=2e-6 * image.pixels.max())


@pytest.mark.parametrize("layer", ["bands", "xyz"])
def test_rgb_pictures_have_no_bands(layer: str) -> None:
    text = f"layers: {layer!r} is for scenes with a spectrum; this one is in RGB"
    with pytest.raises(clrt.ClrtError, match=re.escape(text)):
        clrt.render(scene(1.5, spectrum=None), layers=[layer])


def test_a_conductor_has_the_reflectance_of_its_complex_index() -> None:
    """eta = .2, k = 3 at 0, 45 and 80 degrees (docs/model.md, number 5), in every band."""
    mirror = {"diffuse": 0, "conductor": {"eta": 0.2, "k": 3.0}}
    plane = {"type": "plane", "point": [0, 0, 0], "normal": [0, 1, 0], "material": mirror}
    sky = {"samples": [[380, 1], [750, 1]]}
    table = {"spectrum": {"bands": 3}, "background": sky, "shapes": [plane]}
    for degrees, expected in ((0, 0.923371648), (45, 0.921319621), (80, 0.938558370)):
        angle = np.radians(degrees)
        camera = {"origin": [0, 1, 0], "target": [np.tan(angle), 0, 0], "up": [0, 0, 1], "fov": 1e-3}
        reflected = bands_of(clrt.load_dict({**table, "camera": {**camera, "width": 1, "height": 1}}))
        np.testing.assert_allclose(reflected, expected, rtol=2e-6)


def test_the_kernels_must_be_those_for_the_scenes_rays() -> None:
    from clrt.engine.world import World

    flat = in_bands(scenes()["nothing"][1], 5)
    with pytest.raises(ValueError, match="bands=3"):
        World(Device(), flat)
    World(Device().variant(flat.ray_format), flat)
