"""Spectra as curves over the wavelength: piecewise linear, from tables and formulas."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cache
from typing import Final

import numpy as np

from clrt.spectra.indices import IOR, Ior
from clrt.spectra.spectrum import LAMPS, METALS, Spectrum
from clrt.spectra.tables import columns, rows

VISIBLE: Final = np.arange(360.0, 831.0)
"""Wavelengths in nm of the observer's table."""
D_LINE: Final = 587.5618
"""Wavelength in nm of helium's d line, at which RGB pictures take an index."""
LINE_POWER: Final = 370.0
"""Power of a spectral line: what the spectrum 1 has between 380 and 750 nm."""


@dataclass(frozen=True, eq=False)
class Curve:
    """Values over ascending wavelengths in nm, linear between, constant beyond both ends.

    A wavelength may stand twice: there the curve steps.
    """

    nm: np.ndarray
    values: np.ndarray

    def at(self, nm: np.ndarray) -> np.ndarray:
        """Values at wavelengths, shape of `nm`."""
        return np.interp(nm, self.nm, self.values)

    def averages(self, edges: np.ndarray) -> np.ndarray:
        """(n,) exact means over the n intervals between n + 1 ascending wavelengths."""
        low, high = min(self.nm[0], edges[0]) - 1, max(self.nm[-1], edges[-1]) + 1
        knots = np.concatenate([[low], self.nm, [high]])
        values = np.concatenate([self.values[:1], self.values, self.values[-1:]])
        widths = np.diff(knots)
        sums = np.concatenate([[0.0], np.cumsum(widths * (values[:-1] + values[1:]) / 2)])
        slopes = np.diff(values) / np.where(widths > 0, widths, 1.0)
        # the integral from `low` to each edge: whole segments, and a part of one (never of a step)
        i = np.searchsorted(knots, edges, "right") - 1
        part = edges - knots[i]
        return np.diff(sums[i] + part * (values[i] + slopes[i] * part / 2)) / np.diff(edges)

    def __mul__(self, factor: float) -> Curve:
        return Curve(self.nm, self.values * factor)


def curve_of(spectrum: Spectrum | str) -> Curve:
    """The curve of a spectrum as the scene states it, its `scale` included, before any scaling to Y = 1."""
    if isinstance(spectrum, str):
        return _named(spectrum)
    return _unscaled(spectrum) * spectrum.scale


def filter_of(spectrum: Spectrum | str) -> Curve:
    """The same of what reflects, tints or absorbs: there a line is 1 over the nm that it stands for."""
    found = curve_of(spectrum)
    is_line = isinstance(spectrum, Spectrum) and spectrum.line is not None
    return found * (1 / LINE_POWER) if is_line else found


def is_lamp(spectrum: Spectrum | str) -> bool:
    """Whether this is a light of no natural unit, which is scaled to Y = 1: a name or a black body."""
    return isinstance(spectrum, str) or spectrum.name is not None or spectrum.blackbody is not None


def samples(points: Iterable[tuple[float, float]]) -> Curve:
    """The curve through (nm, value) pairs."""
    nm, values = np.array(list(points), np.float64).T
    return Curve(nm, values)


def ior_at(ior: Ior, nm: np.ndarray) -> np.ndarray:
    """Index of refraction at wavelengths in nm, shape of `nm`. Formulas: NaN where n^2 is below 0."""
    if isinstance(ior, str) and ior in IOR:
        ior = IOR[ior]
    if isinstance(ior, (int, float)):
        return np.full(np.shape(nm), float(ior))
    if isinstance(ior, tuple):
        return samples(ior).at(nm)
    micro = np.asarray(nm, np.float64) / 1000
    if isinstance(ior, str):
        row = rows("glasses")[ior]
        return _sellmeier([row[f"B{i}"] for i in range(1, 5)], [row[f"C{i}"] for i in range(1, 5)], micro)
    if ior.sellmeier is not None:
        return _sellmeier(ior.sellmeier.B, ior.sellmeier.C, micro)
    return np.sum([c / micro ** (2 * i) for i, c in enumerate(ior.cauchy or ())], axis=0)


def metal(name: str) -> tuple[Curve, Curve]:
    """Index and extinction coefficient of one of METALS."""
    data = columns(name)
    return Curve(data["nm"], data["eta"]), Curve(data["nm"], data["k"])


def normal_reflectance(eta: np.ndarray, k: np.ndarray) -> np.ndarray:
    """Reflectance of a conductor of index eta + i k, seen straight on from air."""
    return ((eta - 1) ** 2 + k**2) / ((eta + 1) ** 2 + k**2)


def _sellmeier(b: Sequence[float], c: Sequence[float], micro: np.ndarray) -> np.ndarray:
    """n^2 = 1 + sum B l^2 / (l^2 - C), l in um; NaN where n^2 is below 0."""
    square = micro**2
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.sqrt(1 + sum(b * square / (square - c) for b, c in zip(b, c, strict=True)))


def _unscaled(spectrum: Spectrum) -> Curve:
    if spectrum.name is not None:
        return _named(spectrum.name)
    if spectrum.samples is not None:
        return samples(spectrum.samples)
    if spectrum.blackbody is not None:
        return Curve(VISIBLE, _planck(VISIBLE, spectrum.blackbody))
    if spectrum.gaussian is not None:
        center, deviation = spectrum.gaussian
        z = np.linspace(-6, 6, 2401)
        bell = np.exp(-(z**2) / 2)
        bell[[0, -1]] = 0.0  # a curve goes on as it ends
        return Curve(center + deviation * z, bell)
    if spectrum.line is not None:
        return _box(spectrum.line - 0.5, spectrum.line + 0.5) * LINE_POWER
    assert spectrum.band is not None
    return _box(*spectrum.band)


def _box(low: float, high: float) -> Curve:
    return Curve(np.array([low, low, high, high]), np.array([0.0, 1.0, 1.0, 0.0]))


def _planck(nm: np.ndarray, temperature: float) -> np.ndarray:
    """Relative radiance of a black body over the wavelength (c2 = 1.438777e7 nm K, CODATA 2018)."""
    return (560.0 / nm) ** 5 / np.expm1(1.438777e7 / (nm * temperature))


@cache
def _named(name: str) -> Curve:
    if name in METALS:
        eta, k = metal(name)
        return Curve(VISIBLE, normal_reflectance(eta.at(VISIBLE), k.at(VISIBLE)))
    data = columns("lights" if name in LAMPS else "colorchecker")
    return Curve(data["nm"], data[name])
