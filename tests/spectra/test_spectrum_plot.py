"""`clrt plot-spectrum`: every name is drawn, and what is drawn are the spectrum's own values and colours."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from clrt.cli import main
from clrt.cli.plot_spectrum import GROUPS
from clrt.images.file import read_image
from clrt.spectra.bands import Bands, light
from clrt.spectra.curves import curve_of
from clrt.spectra.plot import SHOWN, draw, wavelength_colors
from clrt.spectra.spectrum import Spectrum


@pytest.mark.parametrize("name", [*GROUPS, "F11", "gold", "SF10", "[[400, 0.2], [700, 0.4]]"])
def test_names_and_stated_spectra_are_drawn(tmp_path: Path, name: str, capsys: pytest.CaptureFixture) -> None:
    assert main(["plot-spectrum", name, "-o", str(tmp_path / "a.png"), "--bands", "12"]) == 0
    assert capsys.readouterr().out.strip() == str(tmp_path / "a.png")
    assert read_image(tmp_path / "a.png").std() > 0.05


def test_the_file_is_named_after_the_spectrum(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(["plot-spectrum", "{blackbody = 3200}"]) == 0
    assert [file.name for file in tmp_path.iterdir()] == ["blackbody_3200.png"]


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("D66", "'D66' is not allowed; it is one of matching, rgb, metals"),
        ("{line = 5}", "NAME: line: 5.0 is not allowed; wavelengths are in nm"),
        ("{line = }", "NAME: {line = }: Invalid value"),
        ("{nme = 'D65'}", "unknown key 'nme'; did you mean 'name'"),
        ("[" * 100_000, "nesting: 100 001 is above the limit of 16"),
        ("{blackbody = " + "9" * 5000 + "}", "is a number of 5 000 characters"),
    ],
)
def test_faults_are_one_line(name: str, text: str, capsys: pytest.CaptureFixture) -> None:
    assert main(["plot-spectrum", name, "-o", "a.png"]) == 2
    error = capsys.readouterr().err
    assert text in error and error.count("\n") == 1


@pytest.mark.parametrize("bands", ["0", "-1", "65", "2147483647"])
def test_bands_beyond_what_a_ray_carries_are_refused(bands: str, capsys: pytest.CaptureFixture) -> None:
    """Drawn, they took all of the machine's memory."""
    assert main(["plot-spectrum", "D65", "-o", "a.png", "--bands", bands]) == 2
    assert f"--bands: {bands} is not allowed; it must be a whole number" in capsys.readouterr().err


def test_the_curve_is_the_lights_own_with_y_1() -> None:
    axes = draw("F11", 64).axes[0]
    x, y = axes.lines[0].get_data()
    assert np.array_equal(x, SHOWN)
    table = curve_of("F11").at(SHOWN)
    assert np.allclose(y / table, y[0] / table[0])
    assert y.mean() == pytest.approx(light("F11", Bands(64)).mean(), rel=5e-3)
    twice = draw(Spectrum(name="F11", scale=2.0)).axes[0].lines[0].get_data()[1]
    assert np.allclose(twice, 2 * y)


def test_wavelengths_have_their_colours() -> None:
    blue, green, red, infrared = wavelength_colors(np.array([460.0, 530.0, 650.0, 780.0]))
    assert blue.argmax() == 2 and green.argmax() == 1 and red.argmax() == 0
    assert red[1:].max() < 0.1 and infrared.max() < 0.1
