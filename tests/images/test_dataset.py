"""An image as labelled arrays."""

from __future__ import annotations

import sys

import numpy as np
import pytest

import clrt


def test_an_image_becomes_a_dataset() -> None:
    pytest.importorskip("xarray", reason="needs the optional dependency clrt[xarray]")
    image = clrt.render("spectrum", width=16, layers=["depth", "normal", "bands", "xyz", "direct", "shape"])
    made = image.to_xarray()
    assert made.pixels.dims == ("y", "x", "channel") and made.sizes["x"] == 16
    assert np.shares_memory(made.pixels.values, image.pixels)
    assert made.bands.dims == ("y", "x", "wavelength") and made.wavelength.attrs["units"] == "nm"
    assert made.wavelength.values.tolist() == list(image.wavelengths)
    assert made.normal.dims[2] == "axis" and made.xyz.dims[2] == "cie" and made.depth.dims == ("y", "x")
    assert made["direct"].dims == made.pixels.dims and made["shape"].dtype == np.int32
    assert made.attrs == dict(image.metadata)
    assert float(made.pixels.sel(y=1, x=2, channel="G")) == image.pixels[1, 2, 1]


def test_a_layer_of_a_user_s_own_has_a_name_of_its_own() -> None:
    pytest.importorskip("xarray", reason="needs the optional dependency clrt[xarray]")
    pixels = np.zeros((2, 3, 3), np.float32)
    made = clrt.Image(pixels, {"mine": np.zeros((2, 3, 3))}).to_xarray()
    assert made.mine.dims == ("y", "x", "channel")


@pytest.mark.parametrize("name", ["depth", "samples", "alpha", "crypto_shape", "uv", "shape"])
def test_a_layer_of_three_numbers_where_ours_has_others(name: str) -> None:
    """An image takes any layer of 1 or 3 numbers a pixel."""
    pytest.importorskip("xarray", reason="needs the optional dependency clrt[xarray]")
    pixels = np.zeros((2, 3, 3), np.float32)
    made = clrt.Image(pixels, {name: np.ones((2, 3, 3), np.float32), "z": pixels[..., 0]}).to_xarray()
    assert made[name].dims == ("y", "x", f"{name} part") and float(made[name].sum()) == 18


@pytest.mark.parametrize("name", ["pixels", "x", "y", "channel"])
def test_a_layer_that_is_called_as_an_axis_is_refused(name: str) -> None:
    pytest.importorskip("xarray", reason="needs the optional dependency clrt[xarray]")
    pixels = np.zeros((2, 3, 3), np.float32)
    with pytest.raises(clrt.ClrtError, match=rf"layers\['{name}'\]: .* give the layer another name"):
        clrt.Image(pixels, {name: pixels[..., 0]}).to_xarray()


def test_without_xarray_it_is_said(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "xarray", None)
    with pytest.raises(clrt.ClrtError, match="to_xarray: needs xarray; install it with"):
        clrt.Image(np.zeros((2, 3, 3), np.float32)).to_xarray()
