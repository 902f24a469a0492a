"""Mitsuba's stock plugins against the renderer: shading that nobody here wrote."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from tests.mitsuba_rooms import (
    BALL,
    CHECKER,
    GLASS,
    GREY,
    MATERIALS,
    MATTE,
    MIRROR,
    NEAR,
    POINT,
    SCENES,
    SUN,
    off,
    ours,
    room,
    stock_room,
)
from validation.oracle_mitsuba import MODES, Mitsuba

STOCK: dict[str, tuple[dict[str, Any], dict[str, Any]]] = {
    "S1": ({"a": MATTE, "b": MATTE, "c": GREY, "d": MATTE}, {"lights": [NEAR, SUN]}),
    "S2": ({"a": MIRROR, "b": MATTE, "c": MIRROR, "d": MIRROR}, {"lights": [NEAR, SUN]}),
    "S2, metals in water": (
        {"a": {**MIRROR, "conductor": {"eta": 0.6, "k": 1.9}}, "b": MATTE, "c": MIRROR,
         "d": {**MIRROR, "conductor": "copper"}},
        {"lights": [NEAR, SUN], "medium_ior": 1.333},
    ),
    "S4": (
        {"a": {"diffuse": 0.0, "specular": 0.7, "shininess": 40.0, "highlight_color": [1.0, 0.9, 0.5]}},
        {"lights": [SUN, {**SUN, "direction": [-1, -1, -1]}],
         "shapes": [{**BALL, "center": [0, 0.7, 0], "radius": 2}]},
    ),
    "S5": ({"a": MATTE, "b": MATTE, "c": GREY, "d": MATTE}, {"lights": [NEAR, SUN, POINT]}),
}  # fmt: skip


@pytest.mark.parametrize("name", STOCK)
def test_stock_plugins_agree(mitsuba: Any, name: str) -> None:
    scene = stock_room(*STOCK[name])
    theirs, mine = mitsuba.render(scene, f"stock-{name[:2]}"), ours(scene)
    assert off(theirs.pixels, mine.pixels) <= 2e-3  # measured: 0 (S4) to 1e-3 (S2)
    assert np.mean(theirs.shape != mine.layers["shape"]) <= 3e-4
    # where nothing is near an edge
    assert np.quantile(np.abs(theirs.pixels - mine.pixels).max(axis=2), 0.95) <= 5e-5


def test_stock_checkers_agree(mitsuba: Any) -> None:
    """Mitsuba's own checkerboard texture, on every shape that takes one."""
    for divisions in (10, 7):
        checker = {"color": {**CHECKER["color"], "divisions": divisions}}
        scene = stock_room({"a": checker, "b": checker, "d": checker, "floor": checker},
                           {"shapes": SCENES["checkers"]["shapes"]})  # fmt: skip
        assert off(mitsuba.render(scene, "stock-S5").pixels, ours(scene).pixels) <= 2e-3


RANDOM: dict[str, tuple[dict[str, Any], dict[str, Any]]] = {
    "S3": (
        {"floor": {"diffuse": 0.0, "emission": [0.5, 0.3, 0.2]},
         "a": MIRROR, "b": GLASS, "c": GLASS, "d": GLASS},
        {"lights": []},
    ),
    "S6": (
        {"a": {"diffuse": 0.0, "reflection": 0.3, "transmission": 0.7, "ior": 1.0},
         "b": MIRROR, "c": MATTE, "d": MATTE},
        {"lights": [NEAR, SUN]},
    ),
    "S8": ({"a": GLASS, "b": MATTE, "c": MIRROR, "d": GLASS}, {"lights": [NEAR, SUN]}),
}  # fmt: skip


@pytest.mark.parametrize("name", RANDOM)
def test_random_paths_agree(mitsuba: Any, name: str) -> None:
    scene = stock_room(*RANDOM[name])
    theirs = mitsuba.render(scene, f"stock-{name}", paths=64)
    mine = ours(scene)
    difference = theirs.pixels - mine.pixels
    assert 10 * np.log10(1 / np.mean(difference**2)) >= 42  # measured: 45 to 48 dB
    spread = np.sqrt(np.sum(theirs.error**2)) / theirs.error.size
    assert abs(difference.mean()) <= 5 * spread + 1e-5  # the mean of all pixels, by its own standard error
    steady = theirs.error.max(axis=2) < 1e-6  # nothing random there, or so rare that no path took it
    assert np.mean(steady) > 0.5
    assert np.mean(np.abs(difference[steady]).max(axis=1) > 1e-3) <= 0.02


def test_metals_and_glass_are_not_expressed() -> None:
    """A metal may lie in glass, and Mitsuba's lie in one medium."""
    table = {"a": GLASS, "b": {**MIRROR, "conductor": "gold"}, "c": MIRROR, "d": MIRROR, "floor": MATTE}
    assert "a metal and glass" in Mitsuba().supports(stock_room(table, {"lights": [NEAR]}), "stock-S8")


@pytest.mark.parametrize("metal", [{}, {"conductor": {"eta": 0.6, "k": 1.9}}, {"conductor": "gold"}])
def test_rough_mirrors_agree_with_mitsubas_own(mitsuba: Any, metal: dict[str, Any]) -> None:
    """Both by chance, each ray of ours in one direction and each of its in four."""
    rough = {"diffuse": 0.0, "reflection": 0.9, "reflection_color": [1, 0.8, 0.5], **metal}
    glow = {"diffuse": 0.0, "emission": [0.5, 0.3, 0.2]}
    table = {"floor": glow, "a": {**rough, "roughness": 0.3}, "b": {**rough, "roughness": 0.6}, "c": MIRROR,
             "d": {**rough, "roughness": 0.9}}  # fmt: skip
    scene = stock_room(table, {"lights": []})
    size = {"width": 48, "height": 36, "spp": 256}
    scene = replace(scene, tables={**scene.tables, "camera": {**scene.tables["camera"], **size}})
    theirs, mine = mitsuba.render(scene, "stock-S9", paths=4), ours(scene)
    difference, error = theirs.pixels - mine.pixels, np.sqrt(1 + 4) * theirs.error
    spread = np.sqrt(np.sum(error**2)) / error.size
    assert abs(difference.mean()) <= 4.5 * spread  # measured: 1.4
    hit = theirs.error.max(axis=2) > 1e-4
    chance = np.abs(difference[hit]) / (error[hit] + 1e-4)
    assert hit.mean() > 0.1 and np.quantile(chance, 0.99) <= 3  # measured: 1.9


AREAS = [
    {"type": "rectangle", "center": [2, 4, 2], "u": [0, 0.3, -0.8], "v": [1, 0.2, 0], "radiance": [5, 4, 3]},
    {"type": "disk", "center": [-2.5, 3.5, 1], "normal": [1, -1.2, -0.3], "radius": 0.7, "radiance": 4},
    {"type": "sphere", "center": [0.5, 4, -1], "radius": 0.6, "radiance": [2, 3, 4]},
]


def test_lights_with_extent_agree_with_mitsubas_own(mitsuba: Any) -> None:
    """Its `area` emitters by chance, ours by 400 points each, which are off by less."""
    many = [{**light, "samples": 400, "visible": False} for light in AREAS]
    scene = stock_room({"a": MATTE, "b": MATTE, "c": GREY, "d": MATTE}, {"lights": many})
    theirs, mine = mitsuba.render(scene, "stock-S7"), ours(scene)
    difference = theirs.pixels - mine.pixels
    assert mine.pixels.mean() > 0.05
    spread = np.sqrt(np.sum(theirs.error**2)) / theirs.error.size
    assert abs(difference.mean()) <= 5 * spread + 1e-5
    hit = theirs.error.max(axis=2) > 1e-4
    # and what 400 points are off by in penumbras
    chance = np.abs(difference[hit]) / (theirs.error[hit] + 1e-3)
    assert hit.mean() > 0.5 and np.quantile(chance, 0.99) <= 2.5  # measured: 1.55


def test_what_modes_cannot_express() -> None:
    mitsuba = Mitsuba()
    scene = room(MATERIALS)
    assert mitsuba.supports(scene, "table") is None
    assert "Phong" in mitsuba.supports(scene, "bsdf")
    for mode in MODES[2:]:
        assert "shapes[" in mitsuba.supports(scene, mode)
    assert "the modes are" in mitsuba.supports(scene, "raytrace")
    with pytest.raises(ValueError, match="Phong"):
        mitsuba.render(scene, "bsdf")
    saddle = {"type": "quadric", "coefficients": [1, 0, -1, 0, 0, 0, 0, -0.5, 0, 0], "material": "a"}
    endless = room({"a": MATTE}, [saddle], ambient=0.0)
    assert "without an end" in mitsuba.supports(endless, "stock-S5")
    plain = {"a": MATTE, "b": MATTE, "c": MATTE, "d": MATTE, "floor": GREY}
    assert "falloff" in mitsuba.supports(room(plain, ambient=0.0), "stock-S1")
    assert "ambient" in mitsuba.supports(room(plain), "stock-S5")
