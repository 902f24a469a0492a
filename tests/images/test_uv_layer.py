"""The layer of where surfaces lie in their pictures: against gradients, the oracle and the float32 twin."""

from __future__ import annotations

import warnings
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import clrt
from tests.pictured import image, put
from validation.oracle64 import render64
from validation.twin.picture import render32

GEOMETRY = ["uv", "albedo", "shading_normal", "shape", "material", "z", "distance"]


@pytest.fixture
def scene(tmp_path: Path) -> clrt.Scene:
    """Shapes that show a picture of u in red and v in green, one that bends normals, and a plain one."""
    y, x = (np.mgrid[0:64, 0:64] + 0.5) / 64
    put(tmp_path / "gradient.exr", np.dstack([x, y, np.full(x.shape, 0.25)]))
    leaning = [0.5 + 0.2 * np.sin(9 * x), 0.5 + 0.2 * np.cos(7 * y), np.full(x.shape, 0.9)]
    put(tmp_path / "bumps.exr", np.dstack(leaning))
    shown = {"color": image("gradient.exr", wrap="clamp"), "diffuse": 0.5}
    bent = {**shown, "normal_map": {"file": "bumps.exr"}}
    shapes: list[dict[str, Any]] = [
        {"type": "sphere", "center": [-2.2, 0, 0], "radius": 1, "material": shown},
        {"type": "box", "min": [-0.7, -0.9, -0.7], "max": [0.7, 0.9, 0.7], "material": shown,
         "transform": [{"rotate": ["y", 30]}]},
        {"type": "cylinder", "p0": [2.2, -1, 0], "p1": [2.2, 1, 0], "radius": 0.9, "material": bent},
        {"type": "disk", "center": [0, 1.9, 0], "normal": [0, 0.2, 1], "radius": 0.7, "material": shown},
        {"type": "sphere", "center": [0, -2, 0], "radius": 0.7, "material": {"diffuse": 0.8}},
    ]  # fmt: skip
    return clrt.load_dict({
        "camera": {"origin": [0.5, 1, 9], "target": [0, 0, 0], "fov": 40, "width": 64, "height": 48},
        "lights": [{"type": "point", "position": [3, 5, 4]}], "shapes": shapes,
    }, folder=tmp_path)  # fmt: skip


def test_a_gradient_is_the_layer(scene: clrt.Scene, tmp_path: Path) -> None:
    """The picture holds u in red, v in green: albedo is half of that, between the middles of edge texels."""
    picture = clrt.render(scene, layers=GEOMETRY)
    layers = picture.layers
    shows = (layers["shape"] >= 0) & (layers["shape"] < 4)
    assert layers["uv"].shape == (48, 64, 2) and not layers["uv"][~shows].any()
    edge = 0.5 / 64
    expected = 0.5 * np.clip(layers["uv"], edge, 1 - edge)
    assert np.abs(layers["albedo"][..., :2] - expected)[shows].max() <= 1e-6
    assert np.abs(layers["albedo"][..., 2] - 0.125)[shows].max() <= 1e-6
    for number in range(4):
        u, v = layers["uv"][layers["shape"] == number].T
        assert min(u.min(), v.min()) >= 0 and max(u.max(), v.max()) <= 1 + 1e-6
        assert np.ptp(u) > 0.3 and np.ptp(v) > 0.3
    back = clrt.read_image(picture.save(tmp_path / "a.exr"), layers=["uv"])
    assert np.array_equal(back.layers["uv"], layers["uv"])
    shown = picture.layer("uv")
    shown.save(tmp_path / "uv.png", bits=16)
    values = clrt.read_image(tmp_path / "uv.png")
    assert values.shape == (48, 64, 3) and not values[..., 2].any()


def test_the_layers_are_the_oracles(scene: clrt.Scene) -> None:
    """Bit for bit the float32 twin's; the float64 oracle's but at edges, and where u goes round to 0."""
    mine = clrt.render(scene, layers=GEOMETRY).layers
    twin = render32(scene, layers=GEOMETRY).layers
    for name in GEOMETRY:
        assert mine[name].tobytes() == twin[name].tobytes(), name
    exact = render64(scene, layers=GEOMETRY).layers
    same = mine["shape"] == exact["shape"]
    assert same.mean() > 0.995
    for name in ("uv", "albedo", "shading_normal"):
        off = np.abs(mine[name] - exact[name]).max(axis=2)[same]
        assert np.mean(off > 1e-4) <= 5e-3, name
    straight = clrt.render(scene, layers=["normal"]).layers["normal"]
    bent = np.abs(exact["shading_normal"] - straight).max(axis=2)
    assert (bent[exact["shape"] == 2] > 0.05).mean() > 0.3


def test_a_scene_without_pictures_has_none(scene: clrt.Scene) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", clrt.ClrtWarning)
        plain = {"shapes": [{"type": "sphere", "center": [0, 0, 0], "radius": 1}],
                 "camera": {"origin": [0, 0, 5], "target": [0, 0, 0], "width": 4, "height": 3}}  # fmt: skip
        assert "uv" not in clrt.render(plain, layers="all").layers
        with pytest.raises(clrt.ClrtError, match="'uv' is for scenes with pictures on surfaces"):
            clrt.render(plain, layers=["uv"])
    assert "uv" in clrt.render(scene, layers="all", width=8).layers
