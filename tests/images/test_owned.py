"""An image's numbers are its own: nobody else writes into them; files hold them, or say that they cannot."""

from __future__ import annotations

import copy
import pickle
from pathlib import Path

import numpy as np
import pytest

import clrt


def test_an_image_holds_the_numbers_that_it_was_given() -> None:
    """However the caller goes on with the array."""
    pixels, depth = np.zeros((2, 2, 3), np.float32), np.zeros((2, 2), np.float32)
    shown = pixels.view()
    shown.flags.writeable = False
    images = [clrt.Image(pixels, {"depth": depth}), clrt.Image(shown, {"depth": depth})]
    before = images[0].hash
    pixels[:], depth[:] = 1, 1
    for image in images:
        assert image.pixels.max() == 0 and image.layers["depth"].max() == 0
        assert clrt.Image(image.pixels).hash == before == image.hash


def test_what_is_an_image_s_own_is_not_copied_again() -> None:
    image = clrt.Image(np.zeros((2, 2, 3), np.float32))
    assert clrt.Image(image.pixels).pixels is image.pixels


def test_copies_stay_as_they_are_too() -> None:
    layers = {"depth": np.ones((2, 2), np.float32)}
    image = clrt.Image(np.zeros((2, 2, 3), np.float32), layers, {"n": 1}, {"a": "b"})
    for other in (pickle.loads(pickle.dumps(image)), copy.deepcopy(image), copy.copy(image)):
        assert other.hash == image.hash and other.stats == image.stats and other.metadata == image.metadata
        for array in (other.pixels, other.layers["depth"]):
            with pytest.raises(ValueError, match="read-only"):
                array[:] = 5


@pytest.mark.parametrize(
    ("layer", "says"),
    [
        (np.full((2, 2), 2**24 + 1, np.int32), r"whole numbers up to 2\^24"),
        (np.full((2, 2), 2**31, np.int64), None),  # exact in float32, but no number of a shape
        (np.full((2, 2), 1e300), "numbers up to 3.4e38"),
    ],
)
def test_an_exr_holds_a_layer_or_says_that_it_cannot(
    layer: np.ndarray, says: str | None, tmp_path: Path
) -> None:
    image = clrt.Image(np.zeros((2, 2, 3), np.float32), {"mine": layer})
    if says is None:
        image.save(tmp_path / "a.exr")
        assert (clrt.read_image(tmp_path / "a.exr", layers="all").layers["mine"] == layer).all()
        return
    with pytest.raises(clrt.ClrtError, match=rf"layers\['mine'\]: an .exr holds {says}"):
        image.save(tmp_path / "a.exr")
    assert not list(tmp_path.iterdir())


def test_infinity_and_nan_are_numbers_of_a_layer(tmp_path: Path) -> None:
    layer = np.array([[np.inf, -np.inf], [np.nan, 1.5]])
    clrt.Image(np.zeros((2, 2, 3), np.float32), {"mine": layer}).save(tmp_path / "a.exr")
    found = clrt.read_image(tmp_path / "a.exr", layers="all").layers["mine"]
    np.testing.assert_array_equal(found, layer.astype(np.float32))


def test_a_layer_has_a_name() -> None:
    with pytest.raises(clrt.ClrtError, match="a layer has a name"):
        clrt.Image(np.zeros((2, 2, 3), np.float32), {"": np.ones((2, 2), np.float32)})
