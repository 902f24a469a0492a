"""A spectral render's pixels are what the bands' numbers say: colours, XYZ and bands, to the file."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import OpenImageIO as oiio
import pytest

import clrt
from clrt.spectra.bands import Bands, light, reflectance
from clrt.spectra.colorimetry import rgb_matrix, xyz_matrix

BANDS = Bands(20, 380, 740)  # which other tests have compiled, too
PATCHES = [1, 7, 13, 15, 18, 19]


def wall(lamp: str, **spectrum: object) -> clrt.Scene:
    """Six patches of the ColorChecker side by side under ambient light alone, a pixel each."""
    strips = [
        {
            "type": "polygon",
            "points": [[x, -1, 0], [x + 1, -1, 0], [x + 1, 1, 0], [x, 1, 0]],
            "material": {"color": f"patch-{patch}"},
        }
        for x, patch in enumerate(PATCHES)
    ]
    camera = {"type": "orthographic", "origin": [3, 0, 5], "target": [3, 0, 0], "size": 6, "width": 6,
              "height": 1}  # fmt: skip
    table = {"bands": BANDS.n, "range": [BANDS.low, BANDS.high], **spectrum}
    return clrt.load_dict({"spectrum": table, "ambient": lamp, "camera": camera, "shapes": strips})


@pytest.mark.parametrize("lamp", ["D65", "F11"])
def test_patches_have_their_bands_xyz_and_colours(lamp: str, tmp_path: Path) -> None:
    image = clrt.render(wall(lamp), layers=("bands", "xyz"))
    expected = np.array([light(lamp, BANDS) * reflectance(f"patch-{patch}", BANDS) for patch in PATCHES])
    assert image.layers["bands"][0] == pytest.approx(expected, rel=1e-6)
    assert image.layers["xyz"][0] == pytest.approx(expected @ xyz_matrix(BANDS).T, rel=1e-5)
    assert image.pixels[0] == pytest.approx(expected @ rgb_matrix(BANDS).T, abs=1e-6)
    assert image.wavelengths == tuple(BANDS.midpoints)
    image.save(tmp_path / "a.exr")
    names = oiio.ImageBuf(str(tmp_path / "a.exr")).spec().channelnames
    banded = [name for name in names if name.startswith("S0.")]
    assert banded == [f"S0.{nm},000000nm" for nm in range(389, 740, 18)]


def test_white_balance_shows_patches_under_a_lamp_as_under_daylight() -> None:
    white = PATCHES.index(19)
    pictures = wall("A", white="A", white_balance=True), wall("A"), wall("D65")
    balanced, plain, daylight = (clrt.render(scene).pixels[0, white] for scene in pictures)
    assert balanced == pytest.approx(daylight, abs=0.02)
    assert np.abs(plain - daylight).max() > 0.5
