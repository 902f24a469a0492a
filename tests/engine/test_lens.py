"""A lens: where its rays go, how large it makes what is out of focus, and that without it nothing changes."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import clrt
from validation.oracle64 import hashing
from validation.oracle64.camera import camera_rays
from validation.twin.math import disk

VIEW: dict[str, Any] = {"origin": [0, 0, 0], "target": [0, 0, -1], "fov": 45, "width": 512, "height": 512}
LENS: dict[str, Any] = {**VIEW, "aperture": 0.1, "focus": 2.0}
ONE_THIRD = np.array([0.3]), np.array([0.7])


def spot(depth: float) -> dict[str, Any]:
    """A ball that shines, so small that it is seen as one pixel is, straight ahead."""
    shine = {"diffuse": 0.0, "emission": 1.0}
    return {"type": "sphere", "center": [0, 0, -depth], "radius": 0.0008 * depth, "material": shine}


@pytest.fixture(scope="module")
def tracer() -> clrt.Tracer:
    return clrt.Tracer({"shapes": [spot(4.0), {**spot(1.0), "center": [0.25, 0, -1.0]}]})


def test_numbers_30_and_38() -> None:
    """A point of the disk, the ray from there, and the point that sample 3 of pixel 12345 has."""
    point = hashing.concentric(*ONE_THIRD)
    assert np.concatenate(point) == pytest.approx([-0.2828427, 0.2828427], abs=5e-8)
    ours = disk(*(u.astype(np.float32) for u in ONE_THIRD))
    assert np.concatenate(ours) == pytest.approx([-0.2828427, 0.2828427], abs=2e-7)
    at = np.array([100.5]), np.array([300.5])
    _, direction = camera_rays(clrt.Camera(**LENS), 512, 512, *at, point)
    assert direction[0] == pytest.approx([-0.2302286, -0.0835207, -0.9695458], abs=5e-8)
    x, y = hashing.concentric(np.array([0.0178163648]), np.array([0.7903636694]))
    assert np.array(hashing.lens(0, np.array([12345]), 3)).ravel() == pytest.approx([x[0], y[0]], abs=1e-9)


def test_kernels_send_the_rays_of_the_lens(tracer: clrt.Tracer) -> None:
    """To float32's precision, from the very points of the lens."""
    origins, directions = tracer.camera_rays(LENS)
    pixel = np.array([100 + 512 * 300, 12345])
    lens = hashing.lens(0, pixel, 0)
    at = pixel % 512 + 0.5, pixel // 512 + 0.5
    origin, direction = camera_rays(clrt.Camera(**LENS), 512, 512, *at, lens)
    assert origins.reshape(-1, 3)[pixel] == pytest.approx(origin, abs=1e-7)  # of 0.1
    assert directions.reshape(-1, 3)[pixel] == pytest.approx(direction, abs=4e-7)


@pytest.mark.parametrize(("depth", "x", "radius"), [(4.0, 0.0, 15.4509668), (1.0, 0.25, 30.9019336)])
def test_number_31_the_circle_of_confusion(
    tracer: clrt.Tracer, depth: float, x: float, radius: float
) -> None:
    """A point before or behind what is in focus covers a disk of that radius, evenly."""
    center = 256 + x / depth * 256 / np.tan(np.radians(22.5)), 256.0
    side = int(radius) + 6
    corner = int(center[0]) - side, int(center[1]) - side
    crop = (*corner, 2 * side, 2 * side)
    seen = tracer.render(camera=LENS, spp=36, crop=crop).pixels[:, :, 0].astype(float)
    rows, columns = np.nonzero(seen)
    away = np.hypot(columns + 0.5 + corner[0] - center[0], rows + 0.5 + corner[1] - center[1])
    own = 0.0008 * 256 / np.tan(np.radians(22.5))  # the ball's own radius in pixels, 0.5
    reach = own + np.sqrt(0.5)  # from the middle of a pixel to its corner
    assert radius - 1.5 < away.max() < radius + reach
    light = seen[rows, columns]
    inner = light[away < radius / 2].sum() / light.sum()
    # each of some 36 pi own^2 samples a pixel of the disk's area is there by chance, one in four of them
    samples = 36 * np.pi * own**2
    assert inner == pytest.approx(0.25, abs=4.5 * np.sqrt(0.25 * 0.75 / samples) + 1.5 / radius)
    # and what it brings is what the ball has without a lens
    sharp = tracer.render(camera=VIEW, spp=36, crop=crop).pixels[:, :, 0].astype(float).sum()
    assert light.sum() == pytest.approx(sharp, rel=4.5 / np.sqrt(samples) + 0.02)


def test_the_samples_of_a_pixel_fill_the_lens() -> None:
    """Each quarter of the disk gets its share of 64 samples, but for a few."""
    for pixel in (0, 77, 12345):
        x, y = hashing.lens(5, np.full(64, pixel), np.arange(64))
        for quarter in ((x > 0) & (y > 0), (x < 0) & (y > 0), (x > 0) & (y < 0), (x < 0) & (y < 0)):
            assert abs(np.count_nonzero(quarter) - 16) <= 4  # measured: 3; by chance 4.5 sigma are 16
        assert abs(np.count_nonzero(np.hypot(x, y) < np.sqrt(0.5)) - 32) <= 5


PLAIN: list[dict[str, Any]] = [{"type": "sphere", "center": [0, 0, -1], "radius": 1}]
GLASS = {"diffuse": 0.0, "reflection": 1.0, "transmission": 1.0, "ior": 1.5, "fresnel": True}
FILLED: list[dict[str, Any]] = [  # glass with a mirror and a bubble in it
    {"type": "sphere", "center": [0, 0, -1], "radius": 1.2, "material": {**GLASS, "absorption": 0.2}},
    {"type": "sphere", "center": [0.4, 0, -1], "radius": 0.5, "material": {"reflection": 0.8}},
    {"type": "sphere", "center": [-0.6, 0.2, -1], "radius": 0.3,
     "material": {**GLASS, "ior": 1.0, "priority": 1}},
    {"type": "plane", "point": [0, -1.5, 0], "normal": [0, 1, 0]},
]


@pytest.mark.parametrize(("shapes", "camera"), [
    (PLAIN, {"near": 0.4}), (PLAIN, {"type": "orthographic", "size": 3.0}), (FILLED, {}),
    (FILLED, {"type": "orthographic", "size": 3.0}),
    (FILLED, {"origin": [0.0, 0.7, -0.6], "target": [0, 0, -1]}),
], ids=["plain", "plain orthographic", "glass", "glass orthographic", "within the glass"])  # fmt: skip
def test_aperture_0_has_the_bits_of_the_pinhole(shapes: list[Any], camera: dict[str, Any]) -> None:
    view = {**VIEW, "width": 40, "height": 30, "origin": [0, 1, 2], "jitter": 3, "spp": 4, **camera}
    scene = {"background": [0.1, 0.2, 0.3], "lights": [{"type": "point", "position": [1, 3, 2]}],
             "shapes": shapes, "max_depth": 5}  # fmt: skip
    sharp, closed, open_ = (
        clrt.render({**scene, "camera": {**view, **lens}}).hash
        for lens in ({}, {"aperture": 0.0, "focus": 0.7}, {"aperture": 0.1, "focus": 0.7})
    )
    assert sharp == closed != open_


def test_parts_have_the_bits_of_the_whole(tracer: clrt.Tracer) -> None:
    camera = {**LENS, "width": 64, "height": 48, "aperture": 0.4}
    whole = tracer.render(camera=camera, spp=9)
    part = tracer.render(camera=camera, spp=9, crop=(20, 13, 31, 30))
    assert np.array_equal(part.pixels, whole.pixels[13:43, 20:51]) and part.pixels.max() > 0
    small = clrt.Tracer(tracer.scene, settings=clrt.Settings(tile=100, lanes=8))
    assert small.render(camera=camera, spp=9).hash == whole.hash


def test_what_is_not_given_is_in_focus_at_the_target() -> None:
    camera = clrt.Camera(origin=(1, 2, 3), target=(4, 2, 7), aperture=0.1)
    assert camera.in_focus == 5 and clrt.Camera(origin=(1, 2, 3), target=(4, 2, 7), focus=2.5).in_focus == 2.5


def test_a_lens_within_glass_and_out_of_it() -> None:
    """Each ray starts in the media that its own origin lies in: half of the lens is in the block."""
    glass = {"diffuse": 0.0, "transmission": 1.0, "ior": 1.0, "absorption": 2.0}
    block = {"type": "box", "min": [0, -9, -0.5], "max": [9, 9, 0.5], "material": glass}
    camera = {"type": "orthographic", "origin": [0, 0, 0], "target": [0, 0, -1], "size": 1e-6,
              "aperture": 0.1, "focus": 1e5, "width": 2, "height": 2, "spp": 64}  # fmt: skip
    pixels = clrt.render({"background": 1.0, "camera": camera, "shapes": [block]}).pixels[:, :, 0]
    inside = [hashing.lens(0, np.full(64, pixel), np.arange(64))[0] > 0 for pixel in range(4)]
    expected = [np.where(within, np.exp(-1.0), 1.0).mean() for within in inside]
    assert pixels.ravel() == pytest.approx(expected, rel=1e-5) and 0.6 < pixels.mean() < 0.75
