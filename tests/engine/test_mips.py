"""Mip levels of pictures on surfaces: which of them a footprint shows, what stands in them, what for."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import OpenImageIO as oiio
import pytest

import clrt
from clrt.flatten.flatten import flatten
from clrt.images.levels import halved, level_sizes
from tests.pictured import image, looked_at, put, sheet
from validation.oracle64 import render64

SIDE = 32  # texels of the sheet's picture, which is one unit wide


def fine_picture(folder: Path) -> np.ndarray:
    """`fine.exr`, of random texels."""
    texels = np.random.default_rng(11).random((SIDE, SIDE, 3)).astype(np.float32)
    put(folder / "fine.exr", texels)
    return texels


def from_above(texels: float) -> dict[str, Any]:
    """An orthographic camera over a `sheet`: so many texels a pixel."""
    return {"type": "orthographic", "origin": [0.37, 0.61, 3], "target": [0.37, 0.61, 0], "up": [0, 1, 0],
            "size": 8 * texels / SIDE, "width": 8, "height": 6}  # fmt: skip


def test_a_level_is_that_of_openimageio(tmp_path: Path) -> None:
    """Its maketx makes the levels and its TextureSystem looks them up; a pixel is just one texel of them.

    Texels differ by 1 at most, and weights by 16 * 2^-24 of what is looked up beyond the picture.
    """
    fine_picture(tmp_path)
    made = oiio.ImageSpec()
    made.set_format(oiio.FLOAT)
    made.attribute("maketx:resize", 0)
    assert oiio.ImageBufAlgo.make_texture(
        oiio.MakeTxTexture, str(tmp_path / "fine.exr"), str(tmp_path / "fine.tif"), made
    )
    system, how = oiio.TextureSystem(False), oiio.TextureOpt()
    how.swrap = how.twrap = oiio.Wrap.Periodic
    how.mipmode, how.interpmode = oiio.MipMode.OneLevel, oiio.InterpMode.Bilinear
    with clrt.Tracer(sheet(tmp_path, image("fine.exr", filter="mipmap"))) as tracer:
        for k in range(6):
            seen = tracer.render(camera=from_above(2.0**k), layers=["uv"])
            step = 2.0**k / SIDE
            expected = [
                system.texture(str(tmp_path / "fine.tif"), how, float(u), float(v), step, 0, 0, step, 3)
                for u, v in seen.layers["uv"].reshape(-1, 2)
            ]
            assert np.abs(seen.pixels.reshape(-1, 3) - expected).max() < 1e-5, k
            assert seen.pixels.std() > 0.01 or k == 5


def test_a_level_is_the_linear_lookup_of_the_picture_reduced(tmp_path: Path) -> None:
    texels = fine_picture(tmp_path)
    with clrt.Tracer(sheet(tmp_path, image("fine.exr", filter="mipmap"))) as tracer:
        for k in range(3):
            seen = tracer.render(camera=from_above(2.0**k), layers=["uv"])
            put(tmp_path / "small.exr", texels)
            u, v = seen.layers["uv"].reshape(-1, 2).T
            expected = looked_at(sheet(tmp_path, image("small.exr")), u, v).reshape(seen.pixels.shape)
            # the plane makes v of y, which is made of v here
            assert np.abs(seen.pixels - expected).max() < 2e-5
            texels = halved(texels)


def test_levels_are_the_published_ones(tmp_path: Path) -> None:
    """docs/model.md, "Numbers to test against", 39 and 40."""
    row = np.arange(1.0, 6)[None, :, None] * np.ones(3, np.float32)
    small = halved(row.astype(np.float32))
    assert small[0, :, 0].tolist() == [np.float32(1.8), np.float32(4.2)]
    assert halved(small)[0, 0, 0] == 3
    assert halved(row.astype(np.float32).swapaxes(0, 1))[:, 0, 0].tolist() == small[0, :, 0].tolist()
    assert level_sizes(5, 1) == [(2, 1), (1, 1)] and level_sizes(1, 1) == []
    levels = [np.random.default_rng(3).random((64, 64, 3)).astype(np.float32)]
    for _ in range(4):
        levels.append(halved(levels[-1]))
    put(tmp_path / "a.exr", levels[0])
    camera = {"origin": [0, 0, 1], "target": [3, 0, 0], "up": [0, 0, 1], "width": 1, "height": 1,
              "fov": float(np.degrees(2 * np.arctan(0.01)))}  # fmt: skip
    scene = sheet(tmp_path, image("a.exr", filter="mipmap", offset=[0.3, 0.2])).replace({"camera": camera})
    shown = []
    for k in (3, 4):
        put(tmp_path / "level.exr", levels[k])
        shown.append(looked_at(sheet(tmp_path, image("level.exr", offset=[0.3, 0.2])), 3, 1)[0])
    expected = 0.4 * shown[0] + 0.6 * shown[1]
    assert np.abs(shown[0] - shown[1]).max() > 0.02
    assert clrt.render(scene).pixels[0, 0] == pytest.approx(expected, abs=2e-6)
    assert render64(scene).pixels[0, 0] == pytest.approx(expected, abs=1e-6)


def test_a_large_level_is_that_of_its_parts() -> None:
    """Rows are done some at a time, of odd pictures too."""
    texels = np.random.default_rng(5).random((259, 7, 3)).astype(np.float32)
    weights = np.zeros((129, 259))
    for i in range(129):
        weights[i, 2 * i : 2 * i + 3] = np.array([129 - i, 129, i + 1]) / 259
    across = np.array([[3, 3, 1, 0, 0, 0, 0], [0, 0, 2, 3, 2, 0, 0], [0, 0, 0, 0, 1, 3, 3]]) / 7
    expected = np.einsum("ij,jkc,lk->ilc", weights, texels.astype(float), across)
    assert np.array_equal(halved(texels), expected.astype(np.float32))


def floor(folder: Path, **keys: Any) -> clrt.Scene:
    """A floor of 16 x 16 squares a picture, up to its horizon."""
    squares = np.add.outer(np.arange(256) // 16, np.arange(256) // 16) % 2 * 0.8 + 0.1
    put(folder / "squares.exr", np.repeat(squares[..., None], 3, axis=2))
    material = {"diffuse": 0, "ambient": 1, "color": image("squares.exr", scale=[0.25, 0.25], **keys)}
    plane = {"type": "plane", "point": [0, 0, 0], "normal": [0, 0, 1], "material": material}
    camera = {"origin": [0, 0, 1], "target": [0.2, 10, 0.4], "up": [0, 0, 1], "fov": 60, "width": 80,
              "height": 60, "jitter": 1}  # fmt: skip
    return clrt.load_dict({"camera": camera, "ambient": 1, "shapes": [plane]}, folder=folder)


def test_a_far_floor_is_nearer_to_that_of_1024_samples(tmp_path: Path) -> None:
    """RMSE of its 20 farthest rows: at 1 and 16 samples 0.352, 0.070 without levels, 0.114, 0.031 with."""
    with clrt.Tracer(floor(tmp_path)) as tracer:
        found = tracer.render(spp=1024, layers=["alpha"])
        first = int(np.flatnonzero(found.layers["alpha"].reshape(60, 80).min(axis=1) == 1)[0])
        truth = found.pixels[first : first + 20]
        plain = [tracer.render(spp=spp).pixels[first : first + 20] for spp in (1, 16)]
    with clrt.Tracer(floor(tmp_path, filter="mipmap")) as tracer:
        levels = [tracer.render(spp=spp).pixels[first : first + 20] for spp in (1, 16)]
    off = [float(np.sqrt(np.square(pixels - truth).mean())) for pixels in (*plain, *levels)]
    assert off[0] > 0.3 and off[1] > 0.06  # there is something to be averaged
    assert off[2] < 0.13 and off[3] < 0.035


def test_one_colour_has_its_bits_at_all_levels(tmp_path: Path) -> None:
    """Also of floats whose sums round, on a floor up to its horizon and in its mirror image."""
    color = np.array([0.1, 0.7, 1 / 3], np.float32)
    put(tmp_path / "one.exr", np.full((7, 13, 3), color))
    ball = {"type": "sphere", "center": [0.3, 4, 0.6], "radius": 0.6,
            "material": {"diffuse": 0.5, "reflection": 0.5}}  # fmt: skip
    mirror = clrt.load_dict({"shapes": [ball]}).shapes[0]
    scene = floor(tmp_path, filter="mipmap")
    scene = scene.replace({"shapes": [*scene.shapes, mirror]})
    key = "shapes[0].material.color"
    shown = clrt.render(scene.replace({f"{key}.file": "one.exr"})).pixels
    plain = clrt.render(scene.replace({key: color.tolist()})).pixels
    assert np.array_equal(shown, plain) and shown.std() > 0.1


def test_rays_of_callers_see_the_first_level(tmp_path: Path) -> None:
    random = np.random.default_rng(2)
    origins = np.concatenate([random.uniform(-9, 9, (500, 2)), random.uniform(0.1, 90, (500, 1))], axis=1)
    ways = np.concatenate([random.normal(size=(500, 2)), -random.uniform(0.01, 1, (500, 1))], axis=1)
    seen = []
    for name in ("linear", "mipmap"):
        with clrt.Tracer(floor(tmp_path, filter=name)) as tracer:
            seen.append(tracer.radiance(origins, ways)[0])
    assert np.array_equal(*seen) and seen[0].std() > 0.3


def test_a_tracer_follows_to_levels_and_back(tmp_path: Path) -> None:
    key = "shapes[0].material.color.filter"
    scene = floor(tmp_path)
    levels = clrt.render(scene.replace({key: "mipmap"})).hash
    with clrt.Tracer(scene) as tracer:
        first = tracer.render().hash
        tracer.update(scene.replace({key: "mipmap"}))
        assert tracer.render().hash == levels != first
        tracer.update(scene)
        assert tracer.render().hash == first


def test_how_it_is_traced_changes_no_bit(tmp_path: Path) -> None:
    scene = floor(tmp_path, filter="mipmap")
    whole = clrt.render(scene).pixels
    for settings in (clrt.Settings(tile=700), clrt.Settings(lanes=8)):
        assert np.array_equal(clrt.render(scene, settings=settings).pixels, whole)
    assert np.array_equal(clrt.render(scene, crop=(13, 31, 21, 11)).pixels, whole[31:42, 13:34])


def test_a_picture_that_two_show_has_its_texels_once(tmp_path: Path) -> None:
    """With and without levels, and of one texel, which has no others."""
    fine_picture(tmp_path)
    put(tmp_path / "dot.exr", np.full((1, 1, 3), 0.25))
    ball = {"type": "sphere", "center": [0, 0, 0], "radius": 1}
    files = {"color": "fine.exr", "emission": "dot.exr"}
    shapes = [
        {**ball, "material": {key: image(file, filter=name) for key, file in files.items()}}
        for name in ("linear", "mipmap")
    ]
    flat = flatten(clrt.load_dict({"shapes": shapes}, folder=tmp_path))
    assert flat.texels is not None and flat.textures is not None
    assert len(flat.texels) == 3 * (sum(4**k for k in range(6)) + 1) + 1
    assert flat.textures["levels"][:4].tolist() == [0, 0, 5, 0] and len(flat.textures) == 4 + 5
    last = flat.textures[-1]
    assert (last["width"], last["height"]) == (1, 1)
    start = 3 * last["first"]
    first = flat.textures[2]["first"] * 3
    mean = flat.texels[first : first + 3 * SIDE**2].reshape(-1, 3).mean(axis=0, dtype=float)
    assert flat.texels[start : start + 3] == pytest.approx(mean, abs=1e-6)
