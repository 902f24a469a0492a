"""8-bit pictures, in and out, against Pillow and the numbers of IEC 61966-2-1."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image as Pillow

import clrt
from clrt.scene.scene import Scene
from tests.published_numbers import SRGB
from validation.oracle64 import render64

LOSSLESS = ("png", "tif", "bmp")


def srgb_curve(linear: np.ndarray) -> np.ndarray:
    """IEC 61966-2-1, in its own two pieces."""
    upper = 1.055 * np.maximum(linear, 1e-9) ** (1 / 2.4) - 0.055
    return np.where(linear <= 0.0031308, 12.92 * linear, upper)


@pytest.mark.parametrize("suffix", LOSSLESS)
def test_bytes_that_are_written_are_the_models(tmp_path: Path, suffix: str) -> None:
    """docs/model.md: clip to [0, 1], sRGB curve, floor(255 v + 0.5); rows from the top, red first."""
    linear = np.random.default_rng(3).uniform(-0.2, 1.3, (37, 53, 3)).astype(np.float32)
    clrt.Image(linear).save(tmp_path / f"a.{suffix}")
    with Pillow.open(tmp_path / f"a.{suffix}") as picture:
        found = np.asarray(picture)
    assert found.shape == (37, 53, 3) and found.dtype == np.uint8
    exact = 255 * srgb_curve(np.clip(linear.astype(float), 0, 1)) + 0.5
    certain = np.abs(exact - np.round(exact)) > 1e-3  # float32 may round over a limit
    assert certain.mean() > 0.99
    np.testing.assert_array_equal(found[certain], np.floor(exact)[certain].astype(np.uint8))


def test_published_values_are_their_bytes(tmp_path: Path) -> None:
    pixels = np.array([[[value] * 3 for value in SRGB.values()]], np.float32)
    clrt.Image(pixels).save(tmp_path / "a.png")
    with Pillow.open(tmp_path / "a.png") as picture:
        assert np.asarray(picture)[0, :, 1].tolist() == list(SRGB)


@pytest.mark.parametrize("suffix", LOSSLESS)
def test_bytes_that_are_read_are_the_published_values(tmp_path: Path, suffix: str) -> None:
    rows = np.zeros((2, len(SRGB), 3), np.uint8)
    rows[0, :, 0], rows[1, :, 2] = list(SRGB), list(SRGB)
    Pillow.fromarray(rows).save(tmp_path / f"a.{suffix}")
    expected = np.zeros(rows.shape)
    expected[0, :, 0], expected[1, :, 2] = list(SRGB.values()), list(SRGB.values())
    np.testing.assert_allclose(clrt.read_image(tmp_path / f"a.{suffix}"), expected, rtol=2e-5, atol=1e-8)


def test_a_grey_jpeg_is_what_pillow_decodes(tmp_path: Path) -> None:
    """Decoders may round a byte apart."""
    smooth = np.linspace(10, 240, 64 * 48).reshape(48, 64).astype(np.uint8)
    Pillow.fromarray(np.stack([smooth] * 3, -1)).save(tmp_path / "a.jpg", quality=95)
    with Pillow.open(tmp_path / "a.jpg") as picture:
        theirs = np.asarray(picture.convert("RGB")).astype(float)
    ours = 255 * srgb_curve(clrt.read_image(tmp_path / "a.jpg").astype(float))
    assert np.abs(ours - theirs).max() <= 1.01


def sky(folder: Path, name: str) -> Scene:
    keys: dict[str, Any] = {
        "background": name,
        "camera": {"origin": [0, 0, 0], "target": [0.2, 0.1, -1], "fov": 120, "width": 64, "height": 48},
    }
    return clrt.load_dict(keys, folder=folder)


def test_an_8_bit_background_is_the_linear_picture_that_pillow_has(tmp_path: Path) -> None:
    """Twice: as bytes, and as what their published curve makes of them, in 32 bits. Both in the float64
    oracle too."""
    table = np.random.default_rng(4).integers(0, 256, (16, 32, 3), np.uint8)
    Pillow.fromarray(table).save(tmp_path / "sky.png")
    with Pillow.open(tmp_path / "sky.png") as picture:
        value = np.asarray(picture) / 255.0
    linear = np.where(value <= 0.04045, value / 12.92, ((value + 0.055) / 1.055) ** 2.4)
    clrt.Image(linear.astype(np.float32)).save(tmp_path / "sky.exr", bits=32)
    seen, expected = (clrt.render(sky(tmp_path, f"sky.{suffix}")).pixels for suffix in ("png", "exr"))
    np.testing.assert_allclose(seen, expected, rtol=0, atol=2e-7)
    exact = render64(sky(tmp_path, "sky.exr")).pixels
    np.testing.assert_allclose(seen, exact, rtol=0, atol=2e-5)
    assert np.ptp(seen) > 0.5
