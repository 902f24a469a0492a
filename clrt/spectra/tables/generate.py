"""Write the tables in this folder anew: `python -m clrt.spectra.tables.generate` (needs colour-science).

Sources stand in the first lines of each file. Nothing here is imported when clrt runs.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import colour
import numpy as np

FOLDER = Path(__file__).parent
NM = np.arange(360, 831)
COARSE = np.arange(360, 831, 5)
CHART = np.arange(380, 731, 5)
WHITE = "D65"
# colour-science's names of the lights
LIGHTS = {"D65": "D65", "A": "A", "E": "E"} | {f"F{i}": f"FL{i}" for i in range(1, 13)}


def main() -> None:
    """Write all files."""
    observer = colour.MSDS_CMFS["CIE 1931 2 Degree Standard Observer"]
    matching = {axis: observer.to_sds()[i][NM] for i, axis in enumerate("xyz")}
    text = "CIE 1931 2-degree standard observer (CIE 018:2019, table 6), 1 nm"
    _write("observer.csv", text, NM, matching, 9)
    lights = {name: _light(colour.SDS_ILLUMINANTS[source]) for name, source in LIGHTS.items()}
    lights["sun"] = _light(colour.plotting.SD_ASTMG173_DIRECT_CIRCUMSOLAR)
    text = (
        "D65, A, E, F1 to F12: CIE 15:2004; sun: direct and circumsolar light, ASTM G173-03 (AM1.5), averaged"
        " over 5 nm; 5 nm, linear between, end values kept beyond 380 to 780 nm (F)"
    )
    _write("lights.csv", text, COARSE, lights, 6)
    text = "smoothest curves of red, green, blue that add up to 1 and give back linear Rec.709 under D65"
    _write("upsampling.csv", text, COARSE, _upsampling(matching, lights[WHITE]), 9)
    chart = colour.SDS_COLOURCHECKERS["BabelColor Average"]
    shape = colour.SpectralShape(CHART[0], CHART[-1], 5)
    patches = {f"patch-{i}": sd.copy().align(shape).values for i, sd in enumerate(chart.values(), 1)}
    text = (
        "the 24 patches of the ColorChecker chart (BabelColor's average of 30 charts), row by row;"
        " measured every 10 nm, between by Sprague's interpolation (CIE 167:2005)"
    )
    _write("colorchecker.csv", text, CHART, patches, 4)


def _light(spectrum: colour.SpectralDistribution) -> np.ndarray:
    """(95,) values at COARSE; finer tables are averaged over the 5 nm about each point."""
    nm, values = spectrum.wavelengths, spectrum.values
    if np.diff(nm).min() >= 5:
        return np.interp(COARSE, nm, values)
    fine = np.arange(357.55, 832.5, 0.1)
    return np.interp(fine, nm, values).reshape(len(COARSE), 50).mean(axis=1)


def _upsampling(matching: Mapping[str, np.ndarray], white: np.ndarray) -> dict[str, np.ndarray]:
    """Curves r, g, b at COARSE with r + g + b = 1 and 0 <= each <= 1, the least sum of squared second
    differences, and the colours of the Rec.709 primaries under `white`.

    After Mallett and Yuksel 2019, "Spectral primary decomposition for rendering with sRGB reflectance".
    """
    n = len(COARSE)
    hat = np.stack([np.interp(NM, COARSE, row) for row in np.eye(n)])  # linear between the points
    light = np.interp(NM, COARSE, white)
    functions = np.stack([matching[axis] for axis in "xyz"])
    to_xyz = (hat * light) @ functions.T / (light @ functions[1])  # (n, 3)
    primaries = colour.RGB_COLOURSPACES["ITU-R BT.709"]
    target = colour.normalised_primary_matrix(primaries.primaries, [0.3127, 0.3290])  # (xyz, rgb)
    # the table's own white differs by 2e-4 from (.3127, .3290), and curves that add up to 1 have the former
    target = target * (to_xyz.sum(axis=0) / target.sum(axis=1))[:, None]
    bend = np.kron(np.eye(3), np.diff(np.eye(n), 2, axis=0))
    sums = np.kron(np.ones(3), np.eye(n))
    colours = np.kron(np.eye(3), to_xyz.T)[:6]  # blue's follows from red's, green's and the sum
    found = _least(bend, np.vstack([sums, colours]), np.concatenate([np.ones(n), target.T.ravel()[:6]]))
    return dict(zip(("red", "green", "blue"), found.reshape(3, n), strict=True))


def _least(rows: np.ndarray, equal: np.ndarray, right: np.ndarray) -> np.ndarray:
    """The x >= 0 with equal x = right and the least |rows x|^2, by a primal-dual active set method."""
    n, m = rows.shape[1], len(equal)
    at_zero = np.zeros(n, bool)
    for _ in range(100):
        fixed = np.eye(n)[at_zero]
        conditions = np.vstack([equal, fixed])
        system = np.block(
            [[rows.T @ rows, conditions.T], [conditions, np.zeros((len(conditions), len(conditions)))]]
        )
        solved = np.linalg.solve(system, np.concatenate([np.zeros(n), right, np.zeros(len(fixed))]))
        x, push = solved[:n], np.zeros(n)
        push[at_zero] = solved[n + m :]
        wanted = np.where(at_zero, push < 0, x < 0)
        if (wanted == at_zero).all():
            return np.maximum(x, 0.0)
        at_zero = wanted
    raise SystemExit("the upsampling curves were not found")


def _write(file: str, text: str, nm: np.ndarray, columns: Mapping[str, np.ndarray], digits: int) -> None:
    """A comment, a line of names, then a line a wavelength."""
    lines = [f"# {text}. Written by clrt/spectra/tables/generate.py.", ",".join(("nm", *columns))]
    for i, at in enumerate(nm):
        lines.append(",".join([str(at), *(f"{column[i]:.{digits}g}" for column in columns.values())]))
    (FOLDER / file).write_text("\n".join(lines) + "\n", "utf-8")


if __name__ == "__main__":
    main()
