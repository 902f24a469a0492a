"""The oracle's cameras, hashes and textures against what is known without it."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import OpenImageIO as oiio
import pytest

import clrt
from clrt.base.resources import scene_folder
from tests.engines import unit
from tests.solids import CAMERA, colourful, scene
from validation import oracles
from validation.oracle64 import edge_mask, hashing, radiance64, render64
from validation.oracles import edges64, picture64


def test_hashes_are_those_of_plain_integers() -> None:
    def mix(x: int) -> int:
        for shift, factor in ((16, 0x7FEB352D), (15, 0x846CA68B)):
            x = (x ^ x >> shift) * factor % 2**32
        return x ^ x >> 16

    words = [0, 1, 2, 12345, 2**31, 2**32 - 1]
    assert hashing.mix(hashing.word(words)).tolist() == [mix(x) for x in words]
    combined = hashing.combine(hashing.word(words), 7)
    assert combined.tolist() == [mix(x ^ mix((7 + 0x9E3779B9) % 2**32)) for x in words]
    h = 123456789
    assert [float(x) for x in hashing.jitter(hashing.word(h))] == [mix(h + i) // 256 / 2**24 for i in (1, 2)]
    u1, u2 = ((mix(h + 1) + 5 * 0xC13FA9A9) % 2**32 // 256, (mix(h + 2) + 5 * 0x91E10DA5) % 2**32 // 256)
    # about +z the frame is x, y: the direction's first two coordinates are the point of the disk
    point = hashing.concentric(np.array([u1 / 2**24]), np.array([u2 / 2**24]))
    direction = hashing.cosine_direction(hashing.word([h]), 5, np.array([[0, 0, 1.0]]))
    assert direction[0, :2] == pytest.approx(np.concatenate(point), abs=1e-12)


def test_camera_variants() -> None:
    base = colourful(max_depth=0)
    picture = render64(base).pixels

    def with_camera(**keys: Any) -> np.ndarray:
        return render64(colourful(max_depth=0, camera={**CAMERA, **keys})).pixels

    assert np.abs(with_camera(mirror=True)[:, ::-1] - picture).max() < 1e-12
    assert np.abs(with_camera(shift=[3, -2])[2:, :-3] - picture[:-2, 3:]).max() < 1e-12
    vertical = 2 * np.degrees(np.arctan(np.tan(np.radians(45 / 2)) * 30 / 40))
    assert np.abs(with_camera(fov=vertical, fov_axis="vertical") - picture).max() < 1e-9
    # a grid of samples: the mean of what four cameras shifted by a quarter of a pixel see
    quarters = [render64(base, shift=(dx, dy)).pixels for dx in (-0.25, 0.25) for dy in (-0.25, 0.25)]
    assert np.abs(render64(base, spp=4).pixels - np.mean(quarters, axis=0)).max() < 1e-12
    depth = render64(base, layers=["depth"]).layers["depth"]
    near = render64(colourful(camera={**CAMERA, "near": 1.0}), layers=["depth", "position"])
    ahead = unit(np.subtract(CAMERA["target"], CAMERA["origin"]))
    cosine = (unit(near.layers["position"] - CAMERA["origin"]) @ ahead)[20:]
    assert (depth[20:] - near.layers["depth"][20:]) * cosine == pytest.approx(1, abs=1e-9)


def test_orthographic_camera_and_default_up() -> None:
    camera = {
        "type": "orthographic",
        "origin": [0, 5, 0],
        "target": [0, 0, 0],
        "size": 4.0,
        "width": 8,
        "height": 4,
    }
    floor = {"type": "plane", "point": [0, 0, 0], "normal": [0, 1, 0]}
    layers = render64(scene(floor, camera=camera), layers=["position", "depth"]).layers
    # looking down, up is z: right = d x up = -y x z = -x
    assert layers["depth"] == pytest.approx(5)
    assert layers["position"][0, 0] == pytest.approx([1.75, 0, 0.75])
    assert layers["position"][3, 7] == pytest.approx([-1.75, 0, -0.75])


def test_background_image(tmp_path: Path) -> None:
    """Its middle lies towards -z, +y is up, u grows to the right; bilinear, wrapping in u."""
    pixels = np.random.default_rng(7).uniform(0, 1, (4, 8, 3)).astype(np.float32)
    spec = oiio.ImageSpec(8, 4, 3, oiio.FLOAT)
    out = oiio.ImageOutput.create(str(tmp_path / "sky.exr"))
    assert out.open(str(tmp_path / "sky.exr"), spec) and out.write_image(pixels)
    out.close()
    found = clrt.load_dict({"background": "sky.exr"}, folder=tmp_path)

    def towards(column: float, row: float) -> list[float]:
        longitude, colatitude = (column / 8 - 0.5) * 2 * np.pi, row / 4 * np.pi
        return [
            np.sin(colatitude) * np.sin(longitude),
            np.cos(colatitude),
            -np.sin(colatitude) * np.cos(longitude),
        ]

    places = [(2.5, 1.5), (4.0, 2.0), (0.0, 1.5), (7.5, 3.9)]
    light, _ = radiance64(found, np.zeros((4, 3)), [towards(*place) for place in places])
    expected = [
        pixels[1, 2],
        pixels[1:3, 3:5].mean(axis=(0, 1)),
        pixels[1, [0, 7]].mean(axis=0),
        pixels[3, 7],
    ]
    assert light == pytest.approx(np.array(expected), abs=1e-6)


def test_checkers() -> None:
    black_white = {"color": {"type": "checker", "colors": [0, 1], "size": 0.5}, "ambient": 1.0}
    floor = {"type": "plane", "point": [0.1, 0, 0], "normal": [0, 1, 0], "material": black_white}
    spots = np.array([[0.2, 0.2], [0.7, 0.2], [0.2, 0.7], [0.7, 0.7], [-0.1, 0.2], [-0.1, -0.1]])
    origin = np.stack([spots[:, 0], np.ones(6), spots[:, 1]], axis=1)
    light, _ = radiance64(scene(floor, ambient=1.0), origin, np.tile([0, -1, 0], (6, 1)))
    # u along x, the first of the axes in the plane; v = n x u = -z: cells of z in (0, .5) are number -1
    assert light[:, 0].tolist() == [1, 0, 0, 1, 0, 1]
    globe_color = {"type": "checker", "colors": [0, 1], "divisions": 8}
    globe = {
        "type": "sphere",
        "center": [0, 0, 0],
        "radius": 1,
        "material": {"color": globe_color, "ambient": 1.0},
    }
    # fields of 45 degrees, numbered from the back (+z) over -x, -z, +x and from the top down
    longitude = np.radians([10, 30, 50, 80, 100, 10, 10, 10])
    colatitude = np.radians([80, 80, 80, 80, 80, 100, 40, 10])
    outside = 3 * np.stack(
        [
            np.sin(colatitude) * np.sin(longitude),
            np.cos(colatitude),
            -np.sin(colatitude) * np.cos(longitude),
        ],
        axis=1,
    )
    light, _ = radiance64(scene(globe, ambient=1.0), outside, -outside)
    assert light[:, 0].tolist() == [1, 1, 0, 0, 1, 0, 0, 0]


@pytest.fixture
def ball() -> clrt.Scene:
    return ball_of(0.01)


def ball_of(step: float, spp: int = 1) -> clrt.Scene:
    """A ball whose edge is a step of radiance, at RADIUS pixels from the middle of 60 x 60."""
    camera = {"origin": [0, 0, 5], "target": [0, 0, 0], "width": 60, "height": 60, "spp": spp}
    material = {"diffuse": 0, "emission": step}
    shape = {"type": "sphere", "center": [0, 0, 0], "radius": 1.0, "material": material}
    return scene(shape, camera=camera, max_depth=0)


RADIUS = 30 / np.tan(np.radians(22.5)) * np.tan(np.arcsin(1 / 5))


def test_a_pixel_is_an_edge_where_one_of_its_samples_is(ball: clrt.Scene) -> None:
    """Also where the step is so low that the mean of 16 samples hardly moves: by 0.01 / 16 < 2e-3."""
    step = 0.01
    mask = edge_mask(ball, spp=16, step=step)
    y, x = (np.mgrid[:240, :240] + 0.5) / 4 - 30
    nearest = np.abs(np.hypot(x, y) - RADIUS).reshape(60, 4, 60, 4).min(axis=(1, 3))
    assert mask[nearest < 0.95 * step].all() and not mask[nearest > 1.415 * step].any()
    assert (nearest < 0.95 * step).sum() >= 4


@pytest.mark.parametrize(("spp", "step", "seen"), [
    (1, 0.0017, False), (1, 0.0021, True), (16, 0.0007, False), (16, 0.0009, True),
])  # fmt: skip
def test_what_moves_a_pixel_of_many_samples_is_an_edge(
    spp: int, step: float, seen: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Two samples that cross a step of 8e-4 move a pixel of 16 by 1e-4, which is as much as it may differ."""
    ball = ball_of(step, spp)
    assert edges64(ball, picture64(ball)).any(), "alone it is dim, and so looked at brighter"
    monkeypatch.setattr(oracles, "brightening", lambda _: 1.0)  # as beside what is not
    assert edges64(ball, picture64(ball)).any() == seen


def test_a_picture_is_no_edge_for_it_changes() -> None:
    """Its slope moves most pixels by more than an edge has to; float32 moves them by less than counts."""
    shown = {"diffuse": 0, "emission": {"type": "image", "file": "globe.png", "tint": [0.3, 0.3, 0.3]}}
    shape = {"type": "sphere", "center": [0, 0, 0], "radius": 1.0, "material": shown}
    camera = {"origin": [0, 0, 5], "target": [0, 0, 0], "fov": 24, "width": 40, "height": 40}
    lamp = {"type": "point", "position": [0, 9, 9]}
    tables = {"shapes": [shape], "lights": [lamp], "camera": camera, "max_depth": 0}
    globe = clrt.load_dict(tables, folder=scene_folder())
    assert edges64(globe, picture64(globe)).mean() < 0.1 < 0.3 < edge_mask(globe).mean()


def test_edge_mask_is_where_the_silhouette_is(ball: clrt.Scene) -> None:
    mask = edge_mask(ball)
    y, x = np.mgrid[:60, :60] + 0.5 - 30
    distance = np.abs(np.hypot(x, y) - RADIUS)
    assert mask[distance < 0.02].all() and not mask[distance > 0.0708].any()
    assert 0 < mask.mean() < 0.05
