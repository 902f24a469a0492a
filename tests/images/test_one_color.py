"""A picture of one colour shows it: in bands within five roundings (the bits in RGB: tests/engine)."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image

import clrt
from clrt.spectra.bands import Bands, reflectance

_BANDS = 8
_ROUNDINGS = 5 * 2.0**-24  # docs/model.md, "Images"


def test_a_picture_of_one_colour_in_bands(tmp_path: Path) -> None:
    Image.new("RGB", (3, 2), (51, 102, 204)).save(tmp_path / "one.png")
    camera = {"type": "orthographic", "origin": [0, 0, 5], "target": [0, 0, 0], "size": 1, "width": 8,
              "height": 8}  # fmt: skip
    table = {"camera": camera, "ambient": 1.0, "background": 0.0, "spectrum": {"bands": _BANDS}}

    def pixels(color: Any) -> np.ndarray:
        ball = {"type": "sphere", "center": [0, 0, 0], "radius": 2, "material": {"color": color}}
        scene = clrt.load_dict({**table, "shapes": [ball]}, folder=tmp_path)
        return np.asarray(clrt.render(scene).pixels)

    encoded = {"type": "image", "file": "one.png", "encoding": "linear"}
    shown, meant = pixels(encoded), pixels([51 / 255, 102 / 255, 204 / 255])
    assert meant.max() > 0.1
    # eight bands are added up, of either sign
    assert np.abs(shown - meant).max() <= 2.5 * (_ROUNDINGS + _BANDS * 2.0**-24)


def test_the_sum_in_float32_is_within_five_roundings() -> None:
    bands = Bands(360, 830, 24)
    primaries = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)
    curves = [reflectance(one, bands).astype(np.float32) for one in primaries]
    for texel in np.random.default_rng(5).random((2000, 3)).astype(np.float32):
        said = float(texel[0]), float(texel[1]), float(texel[2])
        meant = reflectance(said, bands).astype(np.float32).astype(np.float64)
        shown = texel[0] * curves[0] + texel[1] * curves[1] + texel[2] * curves[2]
        assert np.all(np.abs(shown - meant) <= _ROUNDINGS * (1 + 1e-6) * meant)
