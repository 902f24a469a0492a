"""Write the figures of colour.md anew: `python docs/make_colour.py` (needs colour-science, matplotlib).

The table between the page's two marks, and `colour.png`: a light, a surface and the observer in bands, and
how near the colours of the ColorChecker chart come to those at 1 nm.
"""

from __future__ import annotations

import sys
import warnings
from pathlib import Path
from typing import Any

import numpy as np

FOLDER = Path(__file__).parent
sys.path.insert(0, str(FOLDER.parent))

with warnings.catch_warnings():
    warnings.simplefilter("ignore")  # of colour-science's optional parts
    import colour as science

from clrt.images.plotting import drawing, save, subplots  # noqa: E402
from clrt.spectra.bands import Bands, light, reflectance  # noqa: E402
from clrt.spectra.colorimetry import XYZ_OF_RGB, lamp_xyz, matching, xyz_matrix  # noqa: E402
from clrt.spectra.curves import curve_of  # noqa: E402
from clrt.spectra.plot import SHOWN, wavelength_colors  # noqa: E402
from clrt.spectra.spectrum import PATCHES  # noqa: E402

LAMPS = {"D65": "D65", "A": "A", "F2": "FL2", "F7": "FL7", "F11": "FL11"}
COUNTS = (4, 6, 8, 12, 16, 24, 32, 48, 64)
NANOMETRES = science.SpectralShape(360, 830, 1)
MARKS = "<!-- made by make_colour.py -->", "<!-- end -->"


def exact(lamp: str) -> np.ndarray:
    """(24, 3) XYZ of the chart's patches by colour-science at 1 nm."""
    observer = science.MSDS_CMFS["CIE 1931 2 Degree Standard Observer"].copy().align(NANOMETRES)
    source = science.SDS_ILLUMINANTS[LAMPS[lamp]].copy().align(NANOMETRES)
    chart = (sd.copy().align(NANOMETRES) for sd in science.SDS_COLOURCHECKERS["BabelColor Average"].values())
    return np.array([science.sd_to_XYZ(sd, observer, source, method="Integration") for sd in chart]) / 100


def banded(lamp: str, n: int) -> np.ndarray:
    """(24, 3) XYZ of the patches in n bands; n = 0: in RGB mode."""
    if n == 0:
        lit = light(lamp, None)
        return np.array([XYZ_OF_RGB @ (lit * reflectance(patch, None)) for patch in PATCHES])
    bands = Bands(n)
    lit = light(lamp, bands)
    return np.array([xyz_matrix(bands) @ (lit * reflectance(patch, bands)) for patch in PATCHES])


def differences(lamp: str, n: int) -> np.ndarray:
    """(24,) CIE dE2000 of the patches, under the lamp's own white."""
    white = science.XYZ_to_xy(lamp_xyz(lamp))
    lab = [science.XYZ_to_Lab(xyz, white) for xyz in (banded(lamp, n), exact(lamp))]
    return np.asarray(science.delta_E(*lab, method="CIE 2000"))


def table(worst: dict[str, list[float]]) -> str:
    """The largest differences as a table in Markdown."""
    head = ["bands", *LAMPS]
    rows = [
        ["RGB mode" if n == 0 else str(n), *(f"{worst[lamp][i]:.2f}" for lamp in LAMPS)]
        for i, n in enumerate((0, *COUNTS))
    ]
    lines = [head, ["---"] * len(head), *rows]
    return "\n".join("| " + " | ".join(line) + " |" for line in lines)


@drawing()
def plot(worst: dict[str, list[float]]) -> Any:
    """Light, surface and observer, and the accuracy."""
    figure, ((lamp, surface), (observer, accuracy)) = subplots(2, 2, figsize=(10, 6.4))
    bands = Bands(24)
    fine = curve_of("F11").at(SHOWN)
    steps = light("F11", bands)
    _filled(lamp, fine * steps.mean() / fine.mean())
    lamp.stairs(steps, bands.edges, color="#222222", label="24 band averages")
    lamp.set_title("The light F11: averages over the bands")
    _filled(surface, curve_of("gold").at(SHOWN))
    surface.plot(bands.midpoints, reflectance("gold", bands), "k.", label="24 midpoints")
    surface.set_title("The surface gold: values at midpoints")
    for values, name, color in zip(matching(SHOWN), "xyz", ("#c0392b", "#27ae60", "#2c5fb3"), strict=True):
        observer.plot(SHOWN, values, color=color, label=name)
        observer.plot(bands.midpoints, matching(bands.midpoints)["xyz".index(name)], ".", color=color)
    observer.set_title("The observer CIE 1931: values at midpoints")
    for axes in (lamp, surface, observer):
        axes.set(xlim=(380, 750), xlabel="wavelength in nm", ylim=(0, None))
    for name, found in worst.items():
        accuracy.loglog(COUNTS, found[1:], marker="o", markersize=3.5, label=name)
    accuracy.axhline(1, color="#888888", linewidth=0.8, linestyle=":")
    accuracy.set(title="Worst patch of the ColorChecker", xlabel="bands", ylabel="CIE dE2000 (1: just seen)")
    accuracy.set_xticks(COUNTS, [str(n) for n in COUNTS], minor=False)
    accuracy.minorticks_off()
    for axes in (lamp, surface, observer, accuracy):
        axes.legend(frameon=False, fontsize=8)
    figure.tight_layout()
    return figure


def _filled(axes: Any, values: np.ndarray) -> None:
    axes.bar(SHOWN, values, width=1.1, color=wavelength_colors(SHOWN), linewidth=0)


def main() -> None:
    """Write the table and the plot."""
    worst = {lamp: [float(differences(lamp, n).max()) for n in (0, *COUNTS)] for lamp in LAMPS}
    page = FOLDER / "colour.md"
    text = page.read_text("utf-8")
    before, rest = text.split(MARKS[0])
    after = rest.split(MARKS[1])[1]
    page.write_text(f"{before}{MARKS[0]}\n{table(worst)}\n{MARKS[1]}{after}", "utf-8")
    save(plot(worst), FOLDER / "colour.png")


if __name__ == "__main__":
    main()
