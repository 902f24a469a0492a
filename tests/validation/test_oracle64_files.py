"""Pictures on surfaces as files store them: with alpha, turned, in part. The oracle by what was stored."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import OpenImageIO as oiio
import pytest

import clrt
from clrt.base.resources import validation_module
from validation.oracle64 import render64

RNG = np.random.default_rng(9)
STORED = RNG.integers(0, 256, (4, 9, 4)).astype(np.uint8)
WINDOW = RNG.random((4, 9, 3)).astype(np.float32)
# of an upright picture: what is stored of it, by EXIF's numbers
TURNED = {
    1: lambda p: p, 2: lambda p: p[:, ::-1], 3: lambda p: p[::-1, ::-1], 4: lambda p: p[::-1],
    5: lambda p: p.swapaxes(0, 1), 6: lambda p: p.swapaxes(0, 1)[::-1],
    7: lambda p: p.swapaxes(0, 1)[::-1, ::-1], 8: lambda p: p.swapaxes(0, 1)[:, ::-1],
}  # fmt: skip


def linear(samples: np.ndarray) -> np.ndarray:
    x = samples / 255.0
    return np.where(x <= 0.04045, x / 12.92, ((x + 0.055) / 1.055) ** 2.4)


def write(file: Path, stored: np.ndarray, **attributes: Any) -> None:
    height, width, channels = stored.shape
    spec = oiio.ImageSpec(width, height, channels, stored.dtype.name.removesuffix("32"))
    spec.alpha_channel = spec.nchannels - 1 if spec.nchannels in (2, 4) else -1
    spec.attribute("oiio:UnassociatedAlpha", 1)
    for name, value in attributes.items():
        if name == "window":
            spec.x, spec.y, spec.full_width, spec.full_height = value
            spec.full_x = spec.full_y = 0
        else:
            spec.attribute(name, value)
    out = oiio.ImageOutput.create(str(file))
    assert out.open(str(file), spec) and out.write_image(np.ascontiguousarray(stored))
    out.close()


def shown(folder: Path, name: str, height: int, width: int) -> clrt.Scene:
    """The picture alone, a pixel for each texel."""
    corners = [[0, -height, 0], [width, -height, 0], [width, 0, 0], [0, 0, 0]]
    middle = [width / 2, -height / 2]
    glows = {"diffuse": 0, "emission": {"type": "image", "file": name, "filter": "nearest"}}
    return clrt.load_dict(
        {"camera": {"type": "orthographic", "size": width, "origin": [*middle, 5], "target": [*middle, 0],
                    "width": width, "height": height},
         "shapes": [{"type": "polygon", "points": corners, "material": glows}]},
        folder=folder,
    )  # fmt: skip


def agree(scene: clrt.Scene, right: np.ndarray) -> None:
    rounded = 2.4 * 2.0**-24  # samples are float32 before they are decoded
    assert np.abs(render64(scene).pixels - right).max() < rounded
    assert np.abs(clrt.render(scene).pixels - right).max() < 1e-6


@pytest.mark.parametrize("suffix", ["png", "tif"])
@pytest.mark.parametrize("channels", [1, 2, 3, 4])
def test_alpha_changes_no_colour(tmp_path: Path, suffix: str, channels: int) -> None:
    write(tmp_path / f"a.{suffix}", STORED[..., :channels])
    colors = STORED[..., :3] if channels > 2 else STORED[..., [0, 0, 0]]
    agree(shown(tmp_path, f"a.{suffix}", 4, 9), linear(colors))


@pytest.mark.parametrize("way", TURNED)
def test_pictures_are_turned_as_their_file_says(tmp_path: Path, way: int) -> None:
    upright = STORED[..., :3]
    write(tmp_path / "a.tif", TURNED[way](upright), Orientation=way)
    scene = shown(tmp_path, "a.tif", 4, 9)
    agree(scene, linear(upright))
    assert unable(tmp_path, scene) == (way != 1)


@pytest.mark.parametrize("window", [(2, 1, 12, 8), (-3, -1, 5, 2), (0, 0, 9, 4)])
def test_a_picture_is_all_of_its_window(tmp_path: Path, window: tuple[int, int, int, int]) -> None:
    left, top, width, height = window
    write(tmp_path / "a.exr", WINDOW, window=window)
    right = np.zeros((height, width, 3), np.float32)
    for y in range(height):
        for x in range(width):
            if 0 <= y - top < 4 and 0 <= x - left < 9:
                right[y, x] = WINDOW[y - top, x - left]
    scene = shown(tmp_path, "a.exr", height, width)
    agree(scene, right)
    assert unable(tmp_path, scene) == (window != (0, 0, 9, 4))


def unable(folder: Path, scene: clrt.Scene) -> bool:
    """Whether Mitsuba's side, which takes samples as they are stored, cannot express a scene, and says so."""
    scene.save(folder / "scene.toml")
    cases = validation_module("cases")
    case = cases.case_named(cases.own_case(str(folder / "scene.toml")))
    why = validation_module("oracles").why_not("mitsuba-table", case)
    assert why is None or "pictures " in why
    return why is not None
