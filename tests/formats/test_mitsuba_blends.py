"""blendbsdf: any two materials, of which the one that is kept is kept whole."""

from __future__ import annotations

import itertools
import warnings
from pathlib import Path
from typing import Any

import pytest

import clrt
from tests.mitsuba_samples import BALL, lost, material, read

TINT = '<rgb name="specular_reflectance" value="0.9 0.6 0.4"/>'
PLAIN = {
    "diffuse": '<bsdf type="diffuse"/>',
    "mirror": '<bsdf type="conductor"><string name="material" value="none"/></bsdf>',
    "tinted": f'<bsdf type="conductor"><string name="material" value="none"/>{TINT}</bsdf>',
    "gold": '<bsdf type="conductor"><string name="material" value="Au"/></bsdf>',
    "rough gold": '<bsdf type="roughconductor"><string name="material" value="Au"/></bsdf>',
    "glass": '<bsdf type="dielectric"/>',
    "pane": '<bsdf type="thindielectric"/>',
    "rough glass": '<bsdf type="roughdielectric"/>',
    "plastic": '<bsdf type="plastic"/>',
    "rough plastic": '<bsdf type="roughplastic"/>',
    "principled": '<bsdf type="principled"/>',
    "metallic": '<bsdf type="principled"><float name="metallic" value="0.6"/></bsdf>',
    "clear": '<bsdf type="principled"><float name="spec_trans" value="0.5"/></bsdf>',
}
KINDS = PLAIN | {"blend": f'<bsdf type="blendbsdf">{PLAIN["glass"]}{PLAIN["diffuse"]}</bsdf>'}
RAYS = ("reflection_color", "roughness", "conductor", "transmission_color", "ior", "thin", "fresnel")


def blend(weight: float, first: str, second: str) -> str:
    parts = f'<float name="weight" value="{weight}"/>{KINDS[first]}{KINDS[second]}'
    return f'<bsdf type="blendbsdf">{parts}</bsdf>'


def _of(tmp_path: Path, bsdf: str) -> dict[str, Any]:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", clrt.ClrtWarning)
        return material(tmp_path, bsdf)


@pytest.mark.parametrize("first", KINDS)
def test_any_two_are_one_material(tmp_path: Path, first: str) -> None:
    """A metal with the glass of the other, or with its Schlick reflection, is no material."""
    alone = {name: _of(tmp_path, bsdf) for name, bsdf in KINDS.items()}
    for second, weight in itertools.product(KINDS, (0.0, 0.3, 0.8, 1.0)):
        found = _of(tmp_path, blend(weight, first, second))
        one, other = alone[first], alone[second]
        if weight in (0, 1):
            assert found == (other if weight else one)
            continue
        shares = ((1 - weight, one), (weight, other))
        assert found.get("diffuse", 1.0) == pytest.approx(sum(s * p.get("diffuse", 1.0) for s, p in shares))
        rays = {key: found[key] for key in RAYS if key in found}
        if max(found.get("reflection", 0.0), found.get("transmission", 0.0)) > 0:
            kept = [part for _, part in shares if rays == {key: part[key] for key in RAYS if key in part}]
            assert kept, (second, weight, found)


@pytest.mark.parametrize(
    ("weight", "first", "second", "reflection", "named"),
    [
        (0.2, "mirror", "glass", 0.8, "the weaker glass"), (0.2, "mirror", "pane", 0.8, "the weaker glass"),
        (0.4, "mirror", "glass", 0.6, "the weaker glass"),  # which sends on 0.4, mirrored and through it
        (0.4, "plastic", "mirror", 0.4, "the weaker reflection"),
        (0.6, "mirror", "plastic", 0.4, "the weaker reflection"),
        (0.4, "glass", "mirror", 0.6, "the weaker reflection"),
        (0.3, "gold", "tinted", 0.7, "the weaker reflection"),
        (0.7, "gold", "tinted", 0.7, "the weaker reflection"),
    ],
)  # fmt: skip
def test_what_sends_more_light_on_is_kept(
    tmp_path: Path, weight: float, first: str, second: str, reflection: float, named: str
) -> None:
    """As `bsdf.sample` of Mitsuba 3.9 has it straight on: a plastic mirrors 0.04, glass lets 0.96 pass."""
    assert named in lost(tmp_path, BALL.format(blend(weight, first, second)))
    found = _of(tmp_path, blend(weight, first, second))
    assert found["reflection"] == pytest.approx(reflection)


def test_a_mirror_beside_glass_shows_what_is_around_it(tmp_path: Path) -> None:
    sky = '<emitter type="constant"><rgb name="radiance" value="1"/></emitter>'
    view = {"origin": [0, 0, 9], "target": [0, 0, 0], "fov": 5.0, "width": 3, "height": 3}
    with pytest.warns(clrt.ClrtWarning, match="the weaker glass of a blendbsdf"):
        scene = read(tmp_path, sky + BALL.format(blend(0.2, "mirror", "glass")))
    assert clrt.render(scene.replace({"camera": view})).pixels[1, 1] == pytest.approx([0.8] * 3)
