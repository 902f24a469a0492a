"""Files of Mitsuba's first version (0.5, 0.6): what its exporters write, and what Mitsuba 3 has no more."""

from __future__ import annotations

import shutil
import warnings
from pathlib import Path

import pytest

import clrt
from clrt.scene.textures import ImageTexture
from tests.mitsuba_samples import BALL, SCENES, read

FIRST = "0.5.0"
LOOK = '<transform name="toWorld"><lookAt origin="0,0,5" target="0,0,0" up="0,1,0"/></transform>'
SAMPLER = '<integer name="sampleCount" value="9"/><integer name="scramble" value="1"/>'
FILM = '<integer name="width" value="64"/><string name="tonemapMethod" value="gamma"/>'
CAMERA = f"""<sensor type="perspective"><float name="fov" value="35"/>{LOOK}
<sampler type="{{sampler}}">{SAMPLER}</sampler>
<film type="{{film}}">{FILM}<rfilter type="{{rfilter}}"/></film></sensor>"""
NAMES = {"sampler": "sobol", "film": "ldrfilm", "rfilter": "tent"}
DIFFUSE = '<bsdf type="diffuse">{}</bsdf>'
GAMMA = '<float name="gamma" value="1.8"/>'
BITMAP = '<texture type="bitmap" {}><string name="filename" value="a.png"/>{}</texture>'


def color(folder: Path, bsdf: str) -> object:
    """The colour of a ball that has this BSDF."""
    scene = read(folder, BALL.format(bsdf), FIRST)
    return scene.material_of(scene.shapes[0]).color


@pytest.mark.parametrize("what", NAMES)
def test_views_are_read_whatever_they_are_of(tmp_path: Path, what: str) -> None:
    integrator = '<integrator type="path"><boolean name="strictNormals" value="true"/></integrator>'
    text = integrator + CAMERA.format(**{**NAMES, what: "another"})
    with pytest.warns(clrt.ClrtWarning, match=f"the {what} 'another'") as said:
        camera = read(tmp_path, text, FIRST).camera
    assert "tonemap_method" in str(said[0].message) and "strict" not in str(said[0].message)
    assert camera is not None and (camera.width, camera.fov, camera.spp, camera.up) == (64, 35, 9, (0, 1, 0))
    assert camera.filter == ("gaussian" if what == "rfilter" else "tent")
    with pytest.raises(clrt.ClrtError, match=r"there is no .*'(another|tonemap_method)'"):
        read(tmp_path, text, "3.0.0")


@pytest.mark.parametrize("kind", ["bsdf", "shape", "emitter", "integrator", "sensor"])
def test_what_mitsuba_3_has_no_more_is_named(tmp_path: Path, kind: str) -> None:
    element = f'<{kind} type="another"><float name="some" value="1"/></{kind}>'
    with pytest.warns(clrt.ClrtWarning, match=f"left out, .*: the {kind} 'another'$"):
        read(tmp_path, element, FIRST)
    with pytest.raises(clrt.ClrtError, match=f"there is no {kind} 'another'"):
        read(tmp_path, element, "2.1.0")


def test_the_colour_of_an_unknown_surface_is_kept(tmp_path: Path) -> None:
    phong = '<bsdf type="phong"><srgb name="diffuseReflectance" value="#ff8000"/></bsdf>'
    with pytest.warns(clrt.ClrtWarning, match="the bsdf 'phong'$"):
        assert color(tmp_path, phong) == pytest.approx((1, ((128 / 255 + 0.055) / 1.055) ** 2.4, 0))
    inner = DIFFUSE.format('<rgb name="reflectance" value="0.1,0.2,0.3"/>')
    with pytest.warns(clrt.ClrtWarning, match="the bsdf 'coating'$"):
        assert color(tmp_path, f'<bsdf type="coating">{inner}</bsdf>') == (0.1, 0.2, 0.3)


@pytest.mark.parametrize(("stated", "linear"), [
    ('<rgb name="reflectance" value="#ff8000"/>', (1, 128 / 255, 0)),
    ('<srgb name="reflectance" value="0.5, 0, 1"/>', (((0.5 + 0.055) / 1.055) ** 2.4, 0, 1)),
    ('<srgb name="reflectance" value="0.02"/>', (0.02 / 12.92,) * 3),
])  # fmt: skip
def test_colours_as_they_are_encoded(tmp_path: Path, stated: str, linear: tuple[float, ...]) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert color(tmp_path, DIFFUSE.format(stated)) == pytest.approx(linear, rel=1e-6)


def test_colours_that_are_none(tmp_path: Path) -> None:
    for stated, says in {
        '<srgb name="reflectance" value="2"/>': "each part must be from 0 to 1",
        '<rgb name="reflectance" value="#ff80"/>': "must be a number",
        '<blackbody name="reflectance" temperature="5000"/>': "a blackbody of the first version is not read",
    }.items():
        with pytest.raises(clrt.ClrtError, match=says):
            color(tmp_path, DIFFUSE.format(stated))


@pytest.mark.parametrize(("kind", "gamma", "filtered", "encoding"), [
    ("trilinear", 1, "linear", "linear"), ("ewa", 2.2, "linear", None), ("nearest", -1, "nearest", None),
])  # fmt: skip
def test_pictures(tmp_path: Path, kind: str, gamma: float, filtered: str, encoding: str | None) -> None:
    shutil.copy(SCENES / "tiles.png", tmp_path / "a.png")
    values = f'<string name="filterType" value="{kind}"/><float name="gamma" value="{gamma}"/>'
    found = color(tmp_path, DIFFUSE.format(BITMAP.format('name="reflectance"', values)))
    assert isinstance(found, ImageTexture)
    assert (found.filter, found.encoding, found.file) == (filtered, encoding, "a.png")
    with pytest.warns(clrt.ClrtWarning, match="the gamma of a bitmap$"):
        color(tmp_path, DIFFUSE.format(BITMAP.format('name="reflectance"', GAMMA)))


def test_a_texture_within_one_that_is_left_out(tmp_path: Path) -> None:
    shutil.copy(SCENES / "tiles.png", tmp_path / "a.png")
    scaled = f'<texture type="scale" name="reflectance">{BITMAP.format("", "")}</texture>'
    with pytest.warns(clrt.ClrtWarning, match="the texture 'scale'$"):
        found = color(tmp_path, DIFFUSE.format(scaled))
    assert isinstance(found, ImageTexture) and found.file == "a.png"
