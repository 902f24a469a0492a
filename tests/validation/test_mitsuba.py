"""Mitsuba's recursion against closed forms, the renderer and the float64 oracle."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import clrt
from tests.mitsuba_rooms import (
    BALL,
    CAMERA,
    FLOOR,
    GLASS,
    GREY,
    MATERIALS,
    MATTE,
    MIRROR,
    OTHERS,
    RED,
    SCENES,
    as_read,
    off,
    ours,
    room,
)
from validation.oracle64 import render64
from validation.oracle_mitsuba import MODES
from validation.oracle_mitsuba.parts import CROWD
from validation.oracles import handed_on


@pytest.mark.parametrize("name", SCENES)
def test_table_agrees_with_the_renderer(mitsuba: Any, name: str) -> None:
    scene = room(**SCENES[name])
    theirs, mine = mitsuba.render(scene), ours(scene)
    assert off(theirs.pixels, mine.pixels) <= 2e-3  # edges included; measured: 0 to 1.2e-3
    assert np.mean(theirs.shape != mine.layers["shape"]) <= 3e-4
    both = np.isfinite(theirs.t) & np.isfinite(mine.layers["depth"])
    assert np.quantile(np.abs(theirs.t / mine.layers["depth"] - 1)[both], 0.99) <= 1e-5


def test_generations_and_terms_add_up(mitsuba: Any) -> None:
    scene = room(MATERIALS)
    theirs = mitsuba.render(scene)
    layers = tuple(f"generation_{g}" for g in range(4))
    mine = ours(scene, layers=(*layers, "highlight", "diffuse"))
    for generation, layer in enumerate(layers):
        kinds = [name for name in theirs.by_ray if name.startswith(f"generation {generation} ")]
        total = sum(theirs.by_ray[name] for name in kinds if len(name.split()) == 3)
        assert off(total, mine.layers[layer]) <= 2e-3
    for term in ("highlight", "diffuse"):
        assert off(theirs.by_ray[f"generation 0 camera {term}"], mine.layers[term]) <= 2e-3


def test_samples_and_jitter(mitsuba: Any) -> None:
    scene = replace(room(MATERIALS, camera={**CAMERA, "jitter": 7}), spp=4)
    assert off(mitsuba.render(scene).pixels, ours(scene).pixels) <= 4e-3


def test_same_bits_twice(mitsuba: Any) -> None:
    scene = room(MATERIALS)
    first, second = (mitsuba.render(scene).pixels for _ in range(2))
    assert np.array_equal(first, second)


BSDF_MATERIALS: dict[str, dict[str, Any]] = {
    "boundaries": {
        "a": GLASS,
        "b": {**GLASS, "ior": 1.3},
        "c": {**GLASS, "thin": True},
        "d": {**GLASS, "ior": 0.7},
    },
    "constant shares": {
        "a": {"diffuse": 0.1, "reflection": 0.2, "transmission": 0.7, "ior": 1.4},
        "b": {
            "diffuse": 0.1,
            "transmission": 0.9,
            "ior": 0.7,
        },  # lights itself up: total reflection from outside
        "c": {"diffuse": 0.1, "reflection": 0.3, "transmission": 0.6, "thin": True},
        "d": MIRROR,
    },
}


@pytest.mark.parametrize("name", BSDF_MATERIALS)
def test_mitsubas_own_lobes_agree(mitsuba: Any, name: str) -> None:
    scene = room({"floor": GREY, **BSDF_MATERIALS[name]}, background="sky.exr")
    lobes = mitsuba.render(scene, "bsdf")
    assert off(lobes.pixels, mitsuba.render(scene, "table").pixels, 1e-5) <= 2e-3
    assert off(lobes.pixels, ours(scene).pixels) <= 2e-3


def test_mitsubas_lobes_on_smooth_meshes(mitsuba: Any) -> None:
    scene = room({"floor": GREY, "a": GLASS, "b": MATTE, "c": MATTE, "d": MIRROR}, OTHERS)
    lobes, table = (mitsuba.render(scene, mode).pixels for mode in ("bsdf", "table"))
    assert off(lobes, table, 1e-5) <= 2e-3


def test_closed_forms(mitsuba: Any) -> None:
    """The numbers of docs/model.md: a glass sphere's transmittance (7) and light on a sphere (14)."""
    ball = {
        "type": "sphere",
        "center": [0, 0, 0],
        "radius": 1.0,
        "material": {"diffuse": 0.0, "fresnel": True},
    }
    black = {"type": "plane", "point": [0, 0, -6], "normal": [0, 0, 1], "material": {"color": 0.0}}
    screened = room({}, [ball, black], background=1.0, ambient=0.0, lights=[], max_depth=2)
    for mode in MODES[:2]:
        # straight through: the reflected ray meets black, so two crossings of 1 - Fr remain
        seen = mitsuba.radiance(screened, [[0, 0.5, -5]], [[0, 0, 1]], mode)
        assert seen[0, 0] == pytest.approx(0.918678877, abs=2e-6)
    lit = {"m": {"color": 0.5, "ambient": 0.7, "diffuse": 0.7, "specular": 0.3, "shininess": 10.0}}
    for falloff, value in (("none", 0.4112744370), ("inverse-square", 0.0618767455)):
        light = {"type": "point", "position": [2, 1, -4], "intensity": 1.2, "falloff": falloff}
        sphere = {"type": "sphere", "center": [0, 0, 0], "radius": 1.0, "material": "m"}
        scene = room(lit, [sphere], lights=[light], ambient=0.1)
        seen = mitsuba.radiance(scene, [[0, 0, -3]], [[0, 0, 1]])
        assert seen[0] == pytest.approx([value] * 3, rel=2e-6)


ENDLESS = {
    "cylinder": [9, 0, 9, 0, 0, 0, 0, 0, 0, -1], "one sheet": [9, -0.5, 9, 0, 0, 0, 0, 0, 0, -1],
    "two sheets": [9, -1.5, 9, 0, 0, 0, 0, 0, 0, 0.1], "double cone": [1, -0.5, 1, 0, 0, 0, 0, 0, 0, 0],
    "paraboloid": [1, 0, 1, 0, 0, 0, 0, -0.3, 0, 0.2], "saddle": [1, 0, -1, 0, 0, 0, 0, -0.5, 0, 0],
    "parabolic cylinder": [1, 0, 0, 0, 0, 0, 0, 0.3, 0, 0],
    "hyperbolic cylinder": [1, 0, -1, 0, 0, 0, 0, 0, 0, 0.2],
    "two planes": [1, 0, 0, 0, 0, 0, 0, 0, 0, -0.3], "crossed planes": [1, -1, 0, 0, 0, 0, 0, 0, 0, 0],
    "plane": [0, 0, 0, 0, 0, 0, 0.3, 0.5, 0.1, -0.2], "oblique": [1, 0, -2, 0.3, 0.2, 0.1, 0, -0.5, 0, 0.3],
}  # fmt: skip


@pytest.mark.parametrize("name", ENDLESS)
def test_quadrics_without_an_end(mitsuba: Any, name: str) -> None:
    """Against the float64 oracle, for float32 is coarse where such a surface is far away."""
    shape = {"type": "quadric", "coefficients": ENDLESS[name], "material": "a",
             "transform": [{"rotate": ["z", 20.0]}, {"translate": [0.5, 1.2, 0.4]}]}  # fmt: skip
    scene = replace(room({"a": MATTE, "floor": GREY}, [FLOOR, shape], max_depth=0), width=64, height=48)
    theirs, exact = mitsuba.render(scene), render64(as_read(scene), layers=("shape",))
    assert off(theirs.pixels, exact.pixels) <= 3e-3
    assert np.mean(theirs.shape != exact.layers["shape"]) <= 1e-3
    assert (theirs.shape == 1).mean() > 0.02


def test_many_spheres_are_one_mesh(mitsuba: Any) -> None:
    spots = np.random.default_rng(3).uniform([-2, 0.1, -2], [2, 1.5, 2], (CROWD, 3))
    balls = [{"type": "sphere", "center": spot.tolist(), "radius": 0.12, "material": "a"} for spot in spots]
    scene = room({"floor": GREY, "a": RED}, [FLOOR, *balls], max_depth=1)
    theirs, mine = mitsuba.render(scene), ours(scene)
    assert np.mean(theirs.shape != mine.layers["shape"]) <= 1e-3
    assert off(theirs.pixels, mine.pixels, 1e-3) <= 0.02  # mirrors at the edges of mirrors


def test_a_scene_that_exists_only_as_read_is_handed_on(mitsuba: Any, tmp_path: Path) -> None:
    """Say from an NFF file: its tables are what the renderer read, the defaults are Mitsuba's side's own."""
    text = """b 0.1 0.2 0.3
v from 3 2 6 at 0 0 0 up 0 1 0 angle 40 hither 1 resolution 80 60
l 5 6 7
l -4 5 6
f 0.8 0.5 0.3 0.7 0.3 20 0 0
s 0 0 0 1
c 1.5 -1 0 0.5 1.5 1 0 0.2
f 0.5 0.6 0.7 0.9 0 1 0 0
p 4 -5 -1 5 5 -1 5 5 -1 -5 -5 -1 -5
"""
    (tmp_path / "a.nff").write_text(text)
    scene = clrt.load(tmp_path / "a.nff")
    theirs, mine = mitsuba.render(handed_on(scene)), clrt.render(scene)
    assert off(theirs.pixels, mine.pixels) <= 2e-3 and np.ptp(mine.pixels) > 0.5


@pytest.mark.parametrize(("mode", "spectrum"), [("table", {}), ("spectral", {"spectrum": {"bands": 3}})])
def test_a_lamp_scaled_by_0_is_dark(mitsuba: Any, mode: str, spectrum: dict[str, Any]) -> None:
    def seen(dark: Any) -> np.ndarray:
        ball = {**BALL, "material": {"color": 0.8, "emission": dark}}
        lights = [{"type": "point", "position": [0, 5, 3], "intensity": each} for each in (dark, 0.7)]
        return np.asarray(mitsuba.render(room({}, [ball], lights=lights, **spectrum), mode).pixels)

    assert np.array_equal(seen({"name": "D65", "scale": 0}), seen(0.0)) and seen(0.0).max() > 0.1
