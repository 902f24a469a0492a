"""Every layer against the float64 oracle, in a scene where each holds something, and against what it must
add up to."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import clrt
from clrt.base.layers import check_layers
from validation.oracle64 import edge_mask, render64
from validation.oracle_mitsuba import spectra

pytestmark = pytest.mark.filterwarnings("ignore::clrt.base.errors.ClrtWarning")
DEPTH = 3
MATTES = ("crypto_shape", "crypto_material")
TABLE: dict[str, Any] = {
    "max_depth": DEPTH, "background": [0.1, 0.2, 0.3], "ambient": [0.2, 0.1, 0.15], "depth_color": 0.1,
    "camera": {"origin": [0.4, 1.0, 6], "target": [0, 0, 0], "fov": 45, "width": 96, "height": 72},
    "lights": [{"type": "point", "position": [3, 5, 4], "intensity": 0.8},
               {"type": "directional", "direction": [1, -1, -1], "intensity": 0.3}],
    "shapes": [
        {"type": "sphere", "center": [-1.2, 0, 0], "radius": 1, "material": {
            "color": [0.7, 0.4, 0.3], "diffuse": 0.5, "specular": 0.4, "reflection": 0.4}},
        {"type": "sphere", "center": [1.2, 0, 0.5], "radius": 0.9, "material": {
            "diffuse": 0.1, "fresnel": True, "absorption": [0.2, 0.4, 0.1]}},
        {"type": "box", "min": [-0.4, -1, -2.5], "max": [0.6, 1, -2], "material": {
            "color": [0.2, 0.6, 0.8], "emission": [0.3, 0.1, 0.05]}, "transform": [{"rotate": ["y", 20]}]},
        {"type": "plane", "point": [0, -1, 0], "normal": [0, 1, 0], "material": {"color": 0.6}},
    ],
}  # fmt: skip
SCENES: dict[str, dict[str, Any]] = {
    "RGB": TABLE,
    "ambient rays": {**TABLE, "ambient_samples": 2},
    "bands": {**TABLE, "spectrum": {"bands": 5}},
}


@pytest.mark.parametrize("name", SCENES)
def test_every_layer_is_the_float64_oracles(name: str) -> None:
    scene = clrt.load_dict(SCENES[name])
    names = check_layers(["all"], DEPTH, spectral=scene.spectrum is not None)
    ours = clrt.render(scene, layers=names).layers
    found = render64(scene, layers=[each for each in names if each not in ("bands", "xyz", *MATTES)])
    theirs = found.layers | ({"bands": found.bands} if scene.spectrum is not None else {})
    away = ~edge_mask(scene)
    assert away.mean() > 0.8
    for layer in names:
        if layer in ("xyz", *MATTES):
            continue  # below: sums of the bands, of samples
        mine, exact = ours[layer].astype(float), np.asarray(theirs[layer], float)
        assert mine.shape == exact.shape
        with np.errstate(invalid="ignore"):
            off = np.where(mine == exact, 0.0, np.abs(mine - exact))  # both infinite where nothing is hit
        if layer in ("depth", "z", "distance", "position"):  # relative to the way: the ground is far
            off = off / np.maximum(theirs["depth"], 1.0).reshape(*away.shape, *[1] * (off.ndim - 2))
        off = off.reshape(*away.shape, -1).max(axis=2)[away]
        limit = 0.0 if layer in ("shape", "material", "alpha") else 3e-5
        assert np.mean(off > limit) <= 2e-3, layer
        assert np.isfinite(exact).any() and (layer == "shape" or np.abs(exact[np.isfinite(exact)]).max() >
        1e-3), layer


def test_xyz_is_what_the_observer_sees_of_the_bands() -> None:
    """By colour-science's observer at the middles of 5 bands of 74 nm from 380 nm on."""
    scene = clrt.load_dict(SCENES["bands"])
    layers = clrt.render(scene, layers=["bands", "xyz"]).layers
    observer = spectra.seen(np.array([417.0, 491.0, 565.0, 639.0, 713.0]))
    expected = layers["bands"].astype(float) @ (observer / observer[1].sum()).T
    np.testing.assert_allclose(layers["xyz"], expected, rtol=2e-6, atol=1e-7)
    assert expected.min() > 0 and np.ptp(expected) > 0.3
