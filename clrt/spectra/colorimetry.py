"""From band radiances to colours: XYZ, linear Rec.709, white balance, and the thesis program's own way.

XYZ are relative to the spectrum 1, which has Y = 1 (it is not white: D65 is). Sources: CIE 15:2004, Rec.
ITU-R BT.709, IEC 61966-2-1; Bradford: Lam 1985, as in CIE 160:2004.
"""

from __future__ import annotations

from functools import cache
from typing import TYPE_CHECKING, Final

import numpy as np

from clrt import layout
from clrt.spectra.curves import VISIBLE, Curve, curve_of
from clrt.spectra.tables import columns

if TYPE_CHECKING:
    from clrt.spectra.bands import Bands
    from clrt.spectra.spectrum import Spectral

PRIMARIES: Final = ((0.64, 0.33), (0.30, 0.60), (0.15, 0.06))
"""Chromaticities of Rec.709's red, green, blue."""
WHITE: Final = (0.3127, 0.3290)
"""Chromaticity of Rec.709's white, D65."""
BRADFORD: Final = np.array([[0.8951, 0.2664, -0.1614], [-0.7502, 1.7135, 0.0367], [0.0389, -0.0685, 1.0296]])
"""XYZ to cone responses."""
_PART = 1 << 13  # pixels finished at a time: larger arrays come from the system, cleared, each time
THESIS_CURVES: Final = ((610.0, 25.0), (540.0, 30.0), (445.0, 25.0))
"""Centre and standard deviation in nm of the thesis program's curves for red, green, blue."""
_CELLS: Final = np.append(VISIBLE - 0.5, VISIBLE[-1] + 0.5)


def matching(nm: np.ndarray) -> np.ndarray:
    """(3, n): the CIE 1931 matching functions x, y, z at n wavelengths in nm."""
    table = columns("observer")
    return np.stack([np.interp(nm, table["nm"], table[axis]) for axis in "xyz"])


@cache
def observer() -> np.ndarray:
    """(3, 471): the matching functions at VISIBLE; not to be written to."""
    return matching(VISIBLE)


def cells(curve: Curve) -> np.ndarray:
    """(471,) means of a curve over the nanometre about each wavelength of VISIBLE."""
    return curve.averages(_CELLS)


def xyz_of(values: np.ndarray) -> np.ndarray:
    """(3,) XYZ of a spectrum given at VISIBLE."""
    functions = observer()
    return functions @ values / functions[1].sum()


def from_chromaticity(x: float, y: float) -> np.ndarray:
    """(3,) XYZ of Y = 1."""
    return np.array([x / y, 1.0, (1 - x - y) / y])


def _xyz_of_rgb() -> np.ndarray:
    primaries = np.stack([from_chromaticity(*xy) for xy in PRIMARIES], axis=1)
    return primaries * np.linalg.solve(primaries, from_chromaticity(*WHITE))


XYZ_OF_RGB: Final = _xyz_of_rgb()
"""(3, 3) float64: linear Rec.709 to XYZ; white has Y = 1."""
RGB_OF_XYZ: Final = np.linalg.inv(XYZ_OF_RGB)
"""(3, 3) float64: XYZ to linear Rec.709; T 3.4 is this to four digits."""


def adaptation(white: np.ndarray, to: np.ndarray) -> np.ndarray:
    """(3, 3): XYZ seen under `white` to XYZ that look alike under the white `to` (Bradford)."""
    gains = (BRADFORD @ to) / (BRADFORD @ white)
    return np.linalg.inv(BRADFORD) @ (gains[:, None] * BRADFORD)


def lamp_xyz(name: str) -> np.ndarray:
    """(3,) XYZ of a named light, Y = 1."""
    xyz = xyz_of(cells(curve_of(name)))
    return xyz / xyz[1]


def xyz_matrix(bands: Bands) -> np.ndarray:
    """(3, n) float64: band radiances to XYZ; the spectrum 1 has Y = 1."""
    functions = matching(bands.midpoints)
    return functions / functions[1].sum()


def rgb_matrix(bands: Bands, spectral: Spectral | None = None) -> np.ndarray:
    """(3, n) float64: band radiances to linear Rec.709, white-balanced where `spectral` says so."""
    matrix = RGB_OF_XYZ
    if spectral is not None and spectral.white_balance:
        matrix = matrix @ adaptation(lamp_xyz(spectral.white), from_chromaticity(*WHITE))
    return matrix @ xyz_matrix(bands)


def thesis_matrix(bands: Bands) -> np.ndarray:
    """(4, n) float64: band radiances to the thesis program's x, y, z and its spectrum's integral over nm."""
    curves = []
    for center, deviation in THESIS_CURVES:
        curve = np.exp(-(((bands.midpoints - center) / deviation) ** 2) / 2)
        curves.append(curve / (deviation * np.sqrt(2 * np.pi)))
    return np.stack([*curves, np.ones(bands.n)]) * bands.width


def thesis_finish(values: np.ndarray) -> np.ndarray:
    """(..., 3) linear colours of (..., 4) values of `thesis_matrix`.

    The program shows (x, y, z) / max(x, y, z) * integral as it is, without a gamma. So that an 8-bit picture
    shows these numbers, too, they are taken for sRGB-encoded and decoded; beyond 1 the curve goes on. Where
    none of the three is positive, as a filter's negative lobes may leave them, they are black.
    """
    linear = np.empty((*values.shape[:-1], 3))
    flat, found = values.reshape(-1, 4), linear.reshape(-1, 3)
    for start in range(0, len(flat), _PART):
        part = slice(start, start + _PART)
        rows = np.array(flat[part].T, np.float64, order="C")  # numpy is slow along axes of three
        top = np.maximum(np.maximum(rows[0], rows[1]), rows[2])
        shown = rows[:3]
        shown /= np.where(top <= 0, np.inf, top)  # NaN stays NaN
        shown *= rows[3]
        curve = np.maximum(shown, 0.04045)  # what is less is on the straight part
        curve += 0.055
        curve /= 1.055
        np.power(curve, 2.4, out=curve)
        found[part] = np.where(shown <= 0.04045, shown / 12.92, curve).T
    return linear


def finished(values: np.ndarray) -> np.ndarray:
    """Linear colours (..., 3) float32 of what a response gives, which is RGB or the thesis program's own."""
    if values.shape[-1] == 3:
        return values
    linear = thesis_finish(values)
    return np.minimum(linear, layout.BRIGHTEST, out=linear).astype(np.float32)
