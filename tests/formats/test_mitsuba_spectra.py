"""Spectra of Mitsuba 3 that are plugins, in both spellings: <spectrum type=...> and <texture type=...>."""

from __future__ import annotations

import math
import warnings
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import clrt
from tests.mitsuba_samples import material, read, table

RGB = '<rgb name="{}" value="0.1 0.2 0.3"/>'
NUMBER = '<float name="{}" value="{}"/>'
TEXT = '<string name="{}" value="{}"/>'
CURVE = TEXT.format("wavelengths", "400, 500 700") + TEXT.format("values", "1,2,5")


def light(folder: Path, kind: str, values: str, tag: str) -> Any:
    """pi times the intensity of a point that has this spectrum."""
    spectrum = f'<{tag} type="{kind}" name="intensity">{values}</{tag}>'
    found = table(folder, f'<emitter type="point">{spectrum}</emitter>')["lights"][0]["intensity"]
    return math.pi * np.array(found) if np.ndim(found) < 2 else [[nm, math.pi * value] for nm, value in found]


@pytest.mark.parametrize("tag", ["spectrum", "texture"])
@pytest.mark.parametrize(("kind", "values", "of_light", "of_surface"), [
    ("uniform", NUMBER.format("value", 0.3), [[360, 0.3], [830, 0.3]], 0.3),
    ("d65", NUMBER.format("scale", 0.3), 0.3, 0.3),
    ("d65", NUMBER.format("scale", 2) + RGB.format("color"), [0.2, 0.4, 0.6], [0.2, 0.4, 0.6]),
    ("srgb", RGB.format("color"), [0.1, 0.2, 0.3], [0.1, 0.2, 0.3]),
    ("rawconstant", RGB.format("value"), [0.1, 0.2, 0.3], [0.1, 0.2, 0.3]),
])  # fmt: skip
def test_plain_spectra(
    tmp_path: Path, kind: str, values: str, of_light: Any, of_surface: Any, tag: str
) -> None:
    np.testing.assert_allclose(light(tmp_path, kind, values, tag), of_light, rtol=1e-12)
    bsdf = f'<bsdf type="diffuse"><{tag} type="{kind}" name="reflectance">{values}</{tag}></bsdf>'
    np.testing.assert_allclose(material(tmp_path, bsdf)["color"], of_surface, rtol=1e-12)
    (area,) = table(
        tmp_path,
        f'<shape type="sphere"><emitter type="area"><{tag} type="{kind}" name="radiance">{values}</{tag}>'
        "</emitter></shape>",
    )["lights"]
    np.testing.assert_allclose(area["radiance"], of_light, rtol=1e-12)


@pytest.mark.parametrize("tag", ["spectrum", "texture"])
def test_curves(tmp_path: Path, tag: str) -> None:
    """0 beyond their points, as in Mitsuba 3.9; evenly spaced, or stated each."""
    ends = NUMBER.format("wavelength_min", 400) + NUMBER.format("wavelength_max", 700)
    even = ends + TEXT.format("values", "1,2,5")
    for kind, values, middle in ("irregular", CURVE, 500), ("regular", even, 550):
        found = np.array(light(tmp_path, kind, values, tag))
        expected = [[400, 0], [400, 1], [middle, 2], [700, 5], [700, 0]]
        np.testing.assert_allclose(found, expected, rtol=1e-12)


def test_a_black_body(tmp_path: Path) -> None:
    """`mi.load_dict({"type": "blackbody", "temperature": 5000}).eval` of Mitsuba 3.9.1 in scalar_spectral."""
    values = NUMBER.format("temperature", 5000) + NUMBER.format("scale", 2)
    found = dict(light(tmp_path, "blackbody", values, "spectrum"))
    assert min(found) == 360 and max(found) == 830
    for nm, mitsubas in {400: 8743.565, 550: 12712.999, 700: 11811.964}.items():
        assert found[nm] == pytest.approx(2 * mitsubas, rel=1e-5)
    ends = NUMBER.format("wavelength_min", 500) + NUMBER.format("wavelength_max", 604)
    cut = light(tmp_path, "blackbody", values + ends, "spectrum")
    assert [nm for nm, _ in cut] == pytest.approx([500, *np.linspace(500, 604, 12), 604])
    assert cut[0][1] == cut[-1][1] == 0 < cut[1][1] < cut[-2][1] < 2 * 13000
    outside = values + NUMBER.format("wavelength_min", 900)
    assert light(tmp_path, "blackbody", outside, "texture") == 0
    assert sum(dict(light(tmp_path, "blackbody", NUMBER.format("temperature", 20), "texture")).values()) == 0


@pytest.mark.parametrize(("kind", "values", "says"), [
    ("irregular", TEXT.format("wavelengths", "400,500") + TEXT.format("values", "1"), "2 wavelengths have 1"),
    ("irregular", TEXT.format("values", "1"), "the spectrum irregular needs its wavelengths"),
    ("regular", TEXT.format("values", "1,x"), "'1,x'|'x'"),
    ("regular", TEXT.format("values", ""), "it must be 1 numbers, not 0"),
    ("blackbody", NUMBER.format("temperature", 0), "a number of kelvins > 0"),
    ("uniform", NUMBER.format("scale", 2), "no value of spectrum 'uniform' called 'scale'"),
    ("acid", "", "there is no spectrum 'acid'"),
])  # fmt: skip
def test_what_is_no_spectrum(tmp_path: Path, kind: str, values: str, says: str) -> None:
    with pytest.raises(clrt.ClrtError, match=says):
        light(tmp_path, kind, values, "spectrum")


@pytest.mark.parametrize("tag", ["spectrum", "texture"])
def test_a_spectrum_that_many_refer_to(tmp_path: Path, tag: str) -> None:
    """An object of its own, with an id: as much at each wavelength of lights, a number of surfaces."""
    spectrum = f'<{tag} type="uniform" id="a">{NUMBER.format("value", 0.25)}</{tag}>'
    ball = '<shape type="sphere"><bsdf type="diffuse"><ref id="a" name="reflectance"/></bsdf></shape>'
    point = '<emitter type="point"><ref id="a" name="intensity"/></emitter>'
    area = '<shape type="disk"><emitter type="area"><ref name="radiance" id="a"/></emitter></shape>'
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        found = read(tmp_path, spectrum + 2 * ball + point + area)
    assert [found.material_of(shape).color for shape in found.shapes] == [0.25, 0.25]
    lit, shed = (light.get("intensity", light.get("radiance")) for light in found.to_dict()["lights"])
    assert shed == [[360, 0.25], [830, 0.25]] and lit == [[nm, pytest.approx(v / math.pi)] for nm, v in shed]


def test_an_emitter_that_a_shape_refers_to_is_not_left_out(tmp_path: Path) -> None:
    emitter = '<emitter type="area" id="e"><rgb name="radiance" value="2"/></emitter>'
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        (light,) = read(tmp_path, emitter + '<shape type="sphere"><ref id="e"/></shape>').lights
    assert light.radiance == 2
    with pytest.warns(clrt.ClrtWarning, match="the emitter area$"):
        read(tmp_path, emitter)
