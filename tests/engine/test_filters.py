"""Reconstruction filters: their numbers, pixels that stand alone, and what the box leaves as it was."""

from __future__ import annotations

import warnings
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import clrt
from clrt import layout
from clrt.layout import FILTERS
from validation.oracle64 import filters
from validation.oracle64.render import render64
from validation.twin.compare import compare_picture
from validation.twin.picture import render32
from validation.twin.queues import _filter

CAMERA: dict[str, Any] = {"origin": [0, 0.3, 4], "target": [0, 0, 0], "width": 18, "height": 14, "spp": 9}
SCENE: dict[str, Any] = {
    "background": [0.1, 0.2, 0.3], "max_depth": 2,
    "lights": [{"type": "point", "position": [3, 4, 5]}],
    "shapes": [
        {"type": "sphere", "center": [0, 0, 0], "radius": 1, "material": {"diffuse": 0.5, "reflection": 0.4}},
        {"type": "plane", "point": [0, -1, 0], "normal": [0, 1, 0]},
    ],
}  # fmt: skip


def seen(**camera: Any) -> clrt.Scene:
    return clrt.load_dict({**SCENE, "camera": {**CAMERA, **camera}})


@pytest.mark.parametrize(("name", "x", "value"), [
    ("mitchell", 0.5, 0.534722222), ("mitchell", 1.5, -0.0347222222), ("gaussian", 1.0, 0.134999821),
    ("tent", 0.25, 0.75), ("mitchell", 2.0, 0.0), ("gaussian", 2.0, 0.0), ("tent", 1.0, 0.0),
])  # fmt: skip
def test_number_36_values_of_filters(name: str, x: float, value: float) -> None:
    assert filters.weight(name, np.array([x, -x])) == pytest.approx([value] * 2, abs=5e-10)
    ours = _filter(FILTERS[name.upper()], np.float32([x, -x]))
    assert ours == pytest.approx([value] * 2, abs=4e-7)  # sums of numbers up to 40 in float32, over 6


def test_number_37_shares_of_a_tent() -> None:
    """A wall that is lit in one of four columns of samples at a time, by how far it reaches in."""
    camera = clrt.Camera(origin=(0, 0, 0), target=(0, 0, -1), filter="tent")
    share = filters.shares(camera, 4, 1).reshape(4, 4).sum(axis=0)
    assert share == pytest.approx(np.array([0.125, 0.375, 0.375, 0.125]), abs=1e-15)
    view = {"type": "orthographic", "origin": [0, 0, 1], "target": [0, 0, 0], "size": 1}
    view |= {"width": 1, "height": 1}
    glow = {"diffuse": 0.0, "emission": 1.0}
    edges = []
    for x in (-0.5, 0.0, 0.5, 1.0):  # of the samples' columns
        points = [[-9, -9, 0], [x, -9, 0], [x, 9, 0], [-9, 9, 0]]
        box = {"type": "polygon", "points": points, "material": glow}
        tent = {**view, "spp": 16, "filter": "tent"}
        edges.append(clrt.render({"camera": tent, "shapes": [box]}).pixels[0, 0, 0])
    assert np.diff(edges, prepend=0) == pytest.approx([0.125, 0.375, 0.375, 0.125], abs=1e-6)


@pytest.mark.parametrize("camera", [
    {"filter": "tent"}, {"filter": "gaussian", "jitter": 4}, {"filter": "mitchell", "spp": 16},
    {"filter": "mitchell", "jitter": 4, "spp": 4},  # most of whose weights cancel in some pixels
], ids=str)  # fmt: skip
def test_kernels_twin_oracle_and_every_part_agree(camera: dict[str, Any]) -> None:
    scene = seen(**camera)
    tracer = clrt.Tracer(scene)
    layers = ("direct", "reflection", "generation_1", "highlight", "depth", "shape")
    whole, twin, oracle = tracer.render(layers=layers), render32(scene, layers=layers), render64(scene)
    assert np.array_equal(whole.pixels, twin.pixels)
    assert all(np.array_equal(whole.layers[name], twin.layers[name]) for name in layers)
    assert compare_picture(tracer.device, scene).difference is None
    # weights are off by 4e-7 (above), and may sum to a quarter of themselves
    assert np.abs(whole.pixels - oracle.pixels).max() < 2e-5  # measured: 1.3e-5, without jitter 9e-7
    small = clrt.Tracer(scene, settings=clrt.Settings(tile=40, lanes=8, check=True))
    part = small.render(crop=(3, 4, 7, 5))
    assert np.array_equal(part.pixels, whole.pixels[4:9, 3:10])
    assert whole.layers["direct"] + whole.layers["reflection"] == pytest.approx(whole.pixels, abs=1e-6)
    tree = tracer.explain(9, 6)
    assert np.array_equal(tree.total, whole.pixels[6, 9]) and len(tree.weights) == len(tree.roots)


def test_weights_that_cancel_count_alike() -> None:
    """Jitter may put a pixel's few samples where Mitchell's filter is negative: nothing explodes."""
    camera = clrt.Camera(**{**CAMERA, "filter": "mitchell", "jitter": 4, "spp": 4})
    share = filters.shares(camera, 2, 18 * 14)
    alike = (share == 0.25).all(axis=0)
    assert 0 < alike.sum() < 18 * 14 / 2
    assert np.abs(share).sum(axis=0).max() <= 4


@pytest.mark.parametrize(("name", "spp", "wanted"), [
    ("tent", 1, 4), ("tent", 4, 0), ("gaussian", 9, 16), ("mitchell", 4, 16), ("mitchell", 16, 0),
    ("box", 1, 0),
])  # fmt: skip
def test_samples_too_few_for_a_filter_are_told(name: str, spp: int, wanted: int) -> None:
    """Of 4 samples for mitchell each lies a pixel from the middle in both directions, and counts alike."""
    with warnings.catch_warnings(record=True) as found:
        warnings.simplefilter("always")
        clrt.render(seen(spp=spp, filter=name, width=4, height=3))
    few = "1 sample" if spp == 1 else f"{spp} samples"
    text = f"camera.filter: {name!r} weighs {few} a pixel, too few to be weighed; spp = {wanted} or more"
    assert [str(one.message) for one in found] == [text] * (wanted > 0)


@pytest.mark.filterwarnings("ignore:.*too few to be weighed")
def test_one_sample_is_in_the_middle() -> None:
    plain = clrt.render(seen(spp=1), layers=("depth",))
    for name in ("tent", "gaussian", "mitchell"):
        for jitter in ({}, {"jitter": 3}):
            image = clrt.render(seen(spp=1, filter=name, **jitter), layers=("depth",))
            assert np.array_equal(image.layers["depth"], plain.layers["depth"])
            assert image.pixels == pytest.approx(plain.pixels, rel=2e-7)  # w l / w


def test_the_box_is_what_it_was() -> None:
    assert clrt.render(seen(filter="box")).hash == clrt.render(seen()).hash
    assert clrt.render(seen(filter="tent")).hash != clrt.render(seen()).hash


def test_a_wide_filter_keeps_the_mean_and_blurs() -> None:
    """Of a picture with nothing at its edges: what one pixel loses another gains."""
    ball = {"type": "sphere", "center": [0, 0, 0], "radius": 0.5, "material": {"diffuse": 0, "emission": 1.0}}
    names = ("box", "tent", "gaussian", "mitchell")
    views = [{**CAMERA, "spp": 64, "jitter": 1, "filter": name} for name in names]
    pictures = [clrt.render({"camera": view, "shapes": [ball]}).pixels[:, :, 0] for view in views]
    box, tent, gaussian, mitchell = pictures
    for wide in (tent, gaussian, mitchell):
        assert wide.sum() == pytest.approx(box.sum(), rel=0.02)  # measured: 1.3 %, by jitter
    grey = [np.count_nonzero((p > 0.01) & (p < 0.99)) for p in pictures]
    assert grey[0] < grey[1] < grey[2]
    assert mitchell.min() < -0.01 and box.min() == tent.min() == gaussian.min() == 0


def test_a_negative_pixel_stands_in_a_checkpoint(tmp_path: Path) -> None:
    scene = seen(filter="mitchell")
    tracer = clrt.Tracer(scene, settings=clrt.Settings(tile=500))
    path = tmp_path / "half.npz"

    class Stop(Exception):
        pass

    def stop(done: int, total: int, rays: int) -> None:
        if done > total / 2:
            raise Stop

    with pytest.raises(Stop):
        tracer.render(checkpoint=path, progress=stop)
    image = tracer.render(checkpoint=path)
    assert image.hash == clrt.render(scene).hash and image.pixels.min() < 0


def test_the_layout_knows_how_far_each_reaches() -> None:
    assert {name.upper() for name in layout.REACH} == {*FILTERS}
    assert {**layout.REACH, "box": 0.5} == filters.REACH
