"""Spectra in bands and their colours, against colour-science at 1 nm and against numbers that are known."""

from __future__ import annotations

import warnings
from functools import cache

import numpy as np
import pytest

with warnings.catch_warnings():
    warnings.simplefilter("ignore")  # of optional parts that are not installed
    import colour as science

import clrt
from clrt.formats.thesis import SPECTRA
from clrt.images.file import encode
from clrt.spectra.bands import Bands, conductor, curve, light, reflectance
from clrt.spectra.colorimetry import (
    RGB_OF_XYZ,
    WHITE,
    adaptation,
    cells,
    from_chromaticity,
    lamp_xyz,
    rgb_matrix,
    thesis_finish,
    thesis_matrix,
    xyz_matrix,
    xyz_of,
)
from clrt.spectra.curves import Curve, curve_of, filter_of, ior_at, normal_reflectance
from clrt.spectra.indices import GLASSES, Dispersion, Sellmeier
from clrt.spectra.spectrum import LAMPS, METALS, PATCHES, Spectral, Spectrum

NANOMETRES = science.SpectralShape(360, 830, 1)
EVERY = [3, 4, 5, 6, 7, 8, 12, 16, 24, 31, 64]


# ------------------------------------------------------------------------- against colour-science, 1 nm
def illuminant(name: str) -> science.SpectralDistribution:
    source = name.replace("F", "FL") if name[0] == "F" else name
    return science.SDS_ILLUMINANTS[source].copy().align(NANOMETRES)


@cache
def observer() -> science.MultiSpectralDistributions:
    return science.MSDS_CMFS["CIE 1931 2 Degree Standard Observer"].copy().align(NANOMETRES)


def patches_xyz(lamp: str) -> np.ndarray:
    """(24, 3) XYZ of the chart by colour-science; a perfect white has Y = 1."""
    chart = science.SDS_COLOURCHECKERS["BabelColor Average"].values()
    found = [
        science.sd_to_XYZ(sd.copy().align(NANOMETRES), observer(), illuminant(lamp), method="Integration")
        for sd in chart
    ]
    return np.array(found) / 100


def worst_patch(lamp: str, n: int) -> float:
    """The largest CIE dE2000 of the chart's patches in n bands, both seen under that lamp's own white."""
    bands = Bands(n)
    lit = light(lamp, bands)
    ours = np.array([xyz_matrix(bands) @ (lit * reflectance(name, bands)) for name in PATCHES])
    white = science.XYZ_to_xy(lamp_xyz(lamp))
    lab = [science.XYZ_to_Lab(xyz, white) for xyz in (ours, patches_xyz(lamp))]
    return float(np.max(science.delta_E(*lab, method="CIE 2000")))


@pytest.mark.parametrize(
    ("lamp", "n", "most"), [("D65", 24, 0.1), ("A", 24, 0.1), ("F11", 24, 0.6), ("F11", 64, 0.1)]
)
def test_colorchecker_patches_have_their_colours(lamp: str, n: int, most: float) -> None:
    assert worst_patch(lamp, n) <= most


def test_few_bands_are_not_enough_for_lines() -> None:
    """The measure notices what it should: F11 has lines that 8 bands do not tell apart."""
    assert worst_patch("F11", 8) > 1


@pytest.mark.parametrize("lamp", [name for name in LAMPS if name != "sun"])
def test_lamps_have_their_published_whites(lamp: str) -> None:
    theirs = science.sd_to_XYZ(illuminant(lamp), observer(), method="Integration")
    assert lamp_xyz(lamp) == pytest.approx(theirs / theirs[1], abs=2e-4)


def test_black_bodies_are_plancks() -> None:
    theirs = science.sd_to_XYZ(science.sd_blackbody(3200, NANOMETRES), observer(), method="Integration")
    bands = Bands(24)
    xyz = xyz_matrix(bands) @ light(Spectrum(blackbody=3200, scale=2.0), bands)
    assert xyz == pytest.approx(2 * theirs / theirs[1], rel=1e-4)


def test_matrix_is_rec_709() -> None:
    theirs = science.RGB_COLOURSPACES["ITU-R BT.709"]
    derived = science.normalised_primary_matrix(theirs.primaries, WHITE)
    assert pytest.approx(np.linalg.inv(derived), abs=1e-12) == RGB_OF_XYZ
    printed = [[3.2410, -1.5374, -0.4986], [-0.9692, 1.8760, 0.0416], [0.0556, -0.2040, 1.0570]]  # T 3.4
    assert pytest.approx(np.array(printed), abs=5e-5) == RGB_OF_XYZ


def test_bradford() -> None:
    """The model's number 18."""
    found = adaptation(from_chromaticity(0.44757, 0.40745), from_chromaticity(*WHITE)) @ [0.5, 0.4, 0.1]
    assert found == pytest.approx([0.4146625771, 0.3862482731, 0.3052931192], abs=5e-11)


# ------------------------------------------------------------------------------------------ whites
@pytest.mark.parametrize("n", [n for n in EVERY if n >= 8])
def test_d65_is_white(n: int) -> None:
    bands = Bands(n)
    assert rgb_matrix(bands) @ light("D65", bands) == pytest.approx(np.ones(3), abs=1e-3)
    assert rgb_matrix(bands) @ light(1.0, bands) == pytest.approx(np.ones(3), abs=1e-3)


@pytest.mark.parametrize("lamp", LAMPS)
@pytest.mark.parametrize("n", EVERY)
def test_every_lamp_has_y_1_and_no_dark_band(lamp: str, n: int) -> None:
    bands = Bands(n)
    found = light(lamp, bands)
    assert (found > 0).all() and found.shape == (n,)
    assert (xyz_matrix(bands) @ found)[1] == pytest.approx(1, abs=1e-9)
    if n >= 12:
        assert xyz_matrix(bands) @ found == pytest.approx(lamp_xyz(lamp), abs=1e-9)


def test_the_spectrum_1_is_not_white() -> None:
    bands = Bands(64)
    flat = light(Spectrum(samples=((360, 1), (830, 1))), bands)
    assert flat == pytest.approx(np.ones(64), abs=1e-12)
    assert rgb_matrix(bands) @ flat == pytest.approx([1.205, 0.948, 0.909], abs=2e-3)
    assert (xyz_matrix(bands) @ flat)[1] == pytest.approx(1, abs=1e-12)


@pytest.mark.parametrize("lamp", ["A", "F11", "D65"])
def test_white_balance_makes_the_lamp_white(lamp: str) -> None:
    bands = Bands(24)
    balanced = rgb_matrix(bands, Spectral(white=lamp, white_balance=True)) @ light(lamp, bands)
    assert balanced == pytest.approx(np.ones(3), abs=1e-3)
    assert rgb_matrix(bands, Spectral(white=lamp)) == pytest.approx(rgb_matrix(bands), abs=0)


# ------------------------------------------------------------------------------------------ RGB and bands
@pytest.mark.parametrize(("n", "most"), [(24, 2e-3), (64, 5e-4)])
def test_rgb_colours_come_back_under_d65(n: int, most: float) -> None:
    bands, rng = Bands(n), np.random.default_rng(1)
    for rgb in [*np.eye(3), *rng.random((20, 3))]:
        color = tuple(map(float, rgb))
        lit = rgb_matrix(bands) @ light(color, bands)
        seen = rgb_matrix(bands) @ (light("D65", bands) * reflectance(color, bands))
        assert lit == pytest.approx(rgb, abs=most) and seen == pytest.approx(rgb, abs=most)


@pytest.mark.parametrize("n", EVERY)
def test_upsampled_reflectances_stay_reflectances(n: int) -> None:
    rng = np.random.default_rng(2)
    for rgb in rng.random((50, 3)):
        found = reflectance(tuple(rgb), Bands(n))
        assert found.min() >= rgb.min() - 1e-9 and found.max() <= rgb.max() + 1e-9
    assert reflectance(0.3, Bands(n)) == pytest.approx(np.full(n, 0.3), abs=1e-9)
    assert reflectance((0.3, 0.3, 0.3), Bands(n)) == pytest.approx(np.full(n, 0.3), abs=1e-8)


def test_rgb_mode_gives_the_colours_that_bands_give() -> None:
    bands = Bands(64)
    for name in (*METALS, *PATCHES):
        seen = rgb_matrix(bands) @ (light("D65", bands) * reflectance(name, bands))
        assert reflectance(name, None) == pytest.approx(np.clip(seen, 0, 1), abs=2e-3)
    for lamp in LAMPS:
        shown = rgb_matrix(bands) @ light(lamp, bands)
        assert light(lamp, None) == pytest.approx(np.maximum(shown, 0), abs=2e-3)


def test_rgb_mode_keeps_numbers_and_clips_what_is_out_of_gamut() -> None:
    assert reflectance((0.1, 0.2, 0.3), None).tolist() == [0.1, 0.2, 0.3]
    assert light(0.5, None).tolist() == curve(0.5, None).tolist() == [0.5] * 3
    green = light(Spectrum(line=520), None)
    assert green[0] == 0 and green[1] > 1


# ------------------------------------------------------------------------------------------ curves
def test_averages_are_exact_and_know_steps() -> None:
    made = Curve(np.array([400.0, 500.0, 500.0, 600.0]), np.array([0.0, 1.0, 3.0, 3.0]))
    edges = np.array([300.0, 400.0, 450.0, 490.0, 510.0, 600.0, 700.0])
    assert made.averages(edges) == pytest.approx([0, 0.25, 0.7, (0.95 * 10 + 3 * 10) / 20, 3, 3], abs=1e-12)


@pytest.mark.parametrize("name", ["F11", "gold", "patch-3", "sun"])
def test_averages_of_all_bands_make_the_whole(name: str) -> None:
    found = curve_of(name)
    fine, coarse = found.averages(np.linspace(380, 750, 65)), found.averages(np.array([380.0, 750.0]))
    assert fine.mean() == pytest.approx(coarse[0], rel=1e-12)


@pytest.mark.parametrize("n", EVERY)
def test_a_line_keeps_its_power(n: int) -> None:
    bands = Bands(n)
    lit = light(Spectrum(line=589.3), bands)
    assert lit.sum() * bands.width == pytest.approx(370, rel=1e-9)
    assert np.count_nonzero(lit) <= 2
    assert reflectance(Spectrum(line=589.3), bands).sum() == 1
    holds = bands.edges[np.argmax(reflectance(Spectrum(line=589.3), bands))]
    assert holds <= 589.3 <= holds + bands.width


def test_lights_are_averages_and_reflectances_midpoints() -> None:
    bands, half = Bands(4, 400, 700), Spectrum(band=(400, 500))
    assert light(half, bands) == pytest.approx([1, 1 / 3, 0, 0], abs=1e-12)
    assert reflectance(half, bands).tolist() == [1, 0, 0, 0]  # the second midpoint is 512.5 nm
    peak = Spectrum(gaussian=(550, 20), scale=3.0)
    assert reflectance(peak, Bands(3, 400, 700))[1] == pytest.approx(3, rel=1e-6)


# ------------------------------------------------------------------------------------------ indices
def test_bk7() -> None:
    """The model's number 10: indices at the d, F and C lines, and a prism's deviations."""
    n = ior_at("BK7", np.array([587.5618, 486.1327, 656.2725]))
    assert n == pytest.approx([1.516800035, 1.522376290, 1.514322347], abs=5e-10)
    into = np.arcsin(n[0] * np.sin(np.pi / 6))  # at d's least deviation the ray goes through symmetrically
    inside = np.arcsin(np.sin(into) / n)
    out = np.arcsin(n * np.sin(np.pi / 3 - inside))
    deviation = np.degrees(into + out - np.pi / 3)
    assert deviation == pytest.approx([38.64669851, 39.13904981, 38.42931640], abs=5e-8)


def test_glasses_have_their_published_indices() -> None:
    published = {"BK7": 1.51680, "SF10": 1.72828, "SF11": 1.78472, "silica": 1.45846,
                 "water-dispersive": 1.33340, "diamond-dispersive": 2.4175}  # fmt: skip
    assert set(published) == set(GLASSES)
    for name, nd in published.items():
        assert float(ior_at(name, np.array(587.5618))) == pytest.approx(nd, abs=6e-5)


def test_formulas_and_pairs() -> None:
    nm = np.array([400.0, 550.0, 700.0])
    assert ior_at(Dispersion(cauchy=(1.5, 0.004)), nm) == pytest.approx(1.5 + 0.004 / (nm / 1000) ** 2)
    own = Sellmeier(B=(1.03961212, 0.231792344, 1.01046945), C=(0.00600069867, 0.0200179144, 103.560653))
    assert ior_at(Dispersion(sellmeier=own), nm) == pytest.approx(ior_at("BK7", nm), abs=1e-12)
    assert ior_at(((400, 1.6), (700, 1.5)), nm).tolist() == [1.6, 1.55, 1.5]
    assert ior_at("water", nm).tolist() == [1.333] * 3


@pytest.mark.parametrize("name", METALS)
def test_metals_in_rgb_have_the_colour_of_the_spectral_ones(name: str) -> None:
    eta, k = conductor(name, None)
    assert (eta > 0).all() and (k >= 0).all()
    assert normal_reflectance(eta, k) == pytest.approx(np.minimum(reflectance(name, None), 0.995), abs=1e-9)
    eta, k = conductor(name, Bands(24))
    assert normal_reflectance(eta, k) == pytest.approx(reflectance(name, Bands(24)), abs=0.01)


def test_plain_curves_in_rgb_are_weighted_means() -> None:
    falling = curve(((400, 1.0), (700, 0.0)), None)
    assert 0 < falling[0] < falling[1] < falling[2] < 1
    assert curve(((400, 0.5), (700, 0.5)), None) == pytest.approx([0.5] * 3, abs=1e-12)
    assert curve((1.0, 2.0, 3.0), Bands(24)).min() >= 1


# ------------------------------------------------------------------------------- the thesis program
@pytest.mark.parametrize(("name", "shown"), [("Red", (153, 32, 31)), ("Magenta", (151, 47, 153))])
def test_thesis_colours(name: str, shown: tuple[int, int, int]) -> None:
    """The model's number 17: 8 bits at an integral of .6, within 1 (the program truncates)."""
    bands = Bands(20, 380, 740)
    spectrum = SPECTRA[name]
    values = thesis_matrix(bands) @ (spectrum * 0.6 / (18 * spectrum.sum()))
    assert values[3] == pytest.approx(0.6)
    pixel = encode(thesis_finish(values)[None, None].astype(np.float32))[0, 0]
    assert np.abs(pixel.astype(int) - shown).max() <= 1


def test_thesis_black_is_black_and_colours_keep_their_ratio() -> None:
    one = np.array([0.02, 0.01, 0.0, 1.0])
    thesis_finish(one)
    assert one.tolist() == [0.02, 0.01, 0.0, 1.0], "what is given stays as it is"
    assert thesis_finish(np.zeros((2, 4))).tolist() == [[0, 0, 0]] * 2
    lobes = np.array([[-1.0, -2.0, -0.5, -3.0], [-1.0, 0.0, -2.0, 1.0], [0.2, -0.1, 0.0, 1.0]])
    found = thesis_finish(lobes)
    assert not found[:2].any(), "of no positive sum, as a filter's negative lobes leave it, they are black"
    assert found[2].tolist() == [1, -0.5 / 12.92, 0]
    assert encode(thesis_finish(np.array([[[0.02, 0.01, 0.0, 1.0]]])).astype(np.float32)).tolist() == [
        [[255, 128, 0]]
    ]


def test_a_line_is_a_narrow_filter() -> None:
    """Its power is that of lights: as a reflectance it was 370, in RGB and in a warning."""
    xyz = xyz_of(cells(curve_of("D65")) * cells(filter_of(Spectrum(line=589.3))))
    seen = np.maximum(RGB_OF_XYZ @ xyz / xyz_of(cells(curve_of("D65")))[1], 0)
    assert reflectance(Spectrum(line=589.3), None) == pytest.approx(seen) and seen.max() < 0.02
    assert reflectance(Spectrum(line=589.3, scale=0.5), None) == pytest.approx(seen / 2)
    assert curve(Spectrum(line=589.3), None).max() < 0.1
    ball = {"type": "sphere", "center": [0, 0, 0], "radius": 1, "material": {"color": {"line": 589.3}}}
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        clrt.load_dict({"shapes": [ball], "ambient": 1})
