"""Bands of wavelengths, and what a scene's spectra, colours and indices are in them.

A value is a number, three numbers (linear Rec.709), a name or a `Spectrum`. Without bands (`None`: RGB mode)
a spectrum becomes the linear Rec.709 colour that it has; where that lies outside the gamut, its negative
parts become 0.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache, lru_cache, wraps
from typing import Any, Final, TypeVar

import numpy as np
from msgspec import structs

from clrt.spectra.colorimetry import RGB_OF_XYZ, cells, matching, observer, xyz_matrix, xyz_of
from clrt.spectra.curves import (
    VISIBLE,
    Curve,
    curve_of,
    filter_of,
    is_lamp,
    metal,
    normal_reflectance,
    samples,
)
from clrt.spectra.indices import Metal
from clrt.spectra.spectrum import Points, Spectrum
from clrt.spectra.tables import columns

Color = float | tuple[float, float, float] | str | Spectrum
Value = TypeVar("Value")
Result = TypeVar("Result")
_KEPT: Final = 256  # values whose colours are remembered
_SHORT: Final = 16  # points of the longest of them: longer ones take memory, and their files time anyway


def _remembered(color: Callable[[Value], Result]) -> Callable[[Value], Result]:
    """What `color` gives, computed once where many materials say the same; it is not to be written to."""
    known = lru_cache(_KEPT)(color)

    @wraps(color)
    def of(value: Value) -> Result:
        parts = (value, *(getattr(value, name, None) for name in ("samples", "eta", "k")))
        short = all(len(part) <= _SHORT for part in parts if isinstance(part, tuple))
        return known(value) if short else color(value)

    return of


@dataclass(frozen=True)
class Bands:
    """`n` equal intervals of the wavelengths from `low` to `high` in nm."""

    n: int = 24
    low: float = 380.0
    high: float = 750.0

    @property
    def edges(self) -> np.ndarray:
        """(n + 1,) wavelengths in nm."""
        return np.linspace(self.low, self.high, self.n + 1)

    @property
    def midpoints(self) -> np.ndarray:
        """(n,) wavelengths in nm, where reflectances, indices and matching functions are taken."""
        return (self.edges[:-1] + self.edges[1:]) / 2

    @property
    def width(self) -> float:
        """Width of a band in nm."""
        return (self.high - self.low) / self.n

    def holding(self, nm: float) -> np.ndarray:
        """(n,) 1 for the band that holds a wavelength (the upper one at an edge), 0 for the others."""
        out = np.zeros(self.n)
        if self.low <= nm <= self.high:
            out[min(int((nm - self.low) / self.width), self.n - 1)] = 1.0
        return out


def reflectance(value: Color, bands: Bands | None) -> np.ndarray:
    """(n,) float64 reflectances or tints, at midpoints; (3,) the colour under D65 without bands."""
    if isinstance(value, (int, float, tuple)):
        return _upsampled(value, bands)
    return _rgb_reflectance(value) if bands is None else _at_midpoints(value, curve_of(value), bands)


@_remembered
def _rgb_reflectance(value: str | Spectrum) -> np.ndarray:
    return _seen_under_d65(filter_of(value))


def _seen_under_d65(curve: Curve) -> np.ndarray:
    white = _d65()
    rgb = _rgb(xyz_of(white * cells(curve)) / xyz_of(white)[1])
    return np.minimum(rgb, max(1.0, curve.values.max()))  # no channel may give more light than any band


def light(value: Color, bands: Bands | None) -> np.ndarray:
    """(n,) float64 of a light, ambient, background or emission: band averages; (3,) its colour without bands.

    Names and black bodies have Y = 1 times their scale, and the XYZ of their full table under the band sums.
    Other spectra are taken as they are (the spectrum 1 has Y = 1). Numbers and RGB are upsampled times D65.
    """
    if isinstance(value, (int, float, tuple)):
        return _upsampled(value, bands) * (1.0 if bands is None else _lamp("D65", bands))
    if bands is None:
        return _rgb_light(value)
    if isinstance(value, str):
        return _lamp(value, bands)
    if is_lamp(value):
        return value.scale * _lamp(structs.replace(value, scale=1.0), bands)
    return curve_of(value).averages(bands.edges)


@_remembered
def _rgb_light(value: str | Spectrum) -> np.ndarray:
    xyz = xyz_of(cells(curve_of(value)))
    return _rgb(xyz / xyz[1] * _scale(value) if is_lamp(value) and xyz[1] > 0 else xyz)


def curve(value: float | tuple[Any, ...] | Spectrum, bands: Bands | None) -> np.ndarray:
    """(n,) float64 of a plain curve (absorption, eta, k) at the midpoints.

    Without bands (3,): means weighted by the upsampling curves of red, green and blue under D65. `value` is a
    number, linear RGB, (nm, value) pairs or a `Spectrum`.
    """
    if isinstance(value, (int, float)):
        return np.full(3 if bands is None else bands.n, float(value))
    if isinstance(value, tuple) and not isinstance(value[0], tuple):
        return _upsampled(value, bands)
    found = filter_of(value) if isinstance(value, Spectrum) else samples(value)
    return _means(found) if bands is None else _at_midpoints(value, found, bands)


def _means(curve: Curve) -> np.ndarray:
    weights = _weights()
    return weights @ cells(curve) / weights.sum(axis=1)


@cache
def _d65() -> np.ndarray:
    return cells(curve_of("D65"))


@cache
def _weights() -> np.ndarray:
    """(3, 471): how much each wavelength of VISIBLE counts for red, green and blue."""
    return upsampling(VISIBLE) * _d65() * observer().sum(axis=0)


def conductor(value: Metal, bands: Bands | None) -> tuple[np.ndarray, np.ndarray]:
    """(n,) eta and (n,) k of a metal at the midpoints.

    Without bands (3,): numbers as they are; of curves eta as `curve`, and the k that gives the metal's own
    colour (its reflectance straight on, seen under D65), as the spectral picture shows it.
    """
    if bands is None:
        return _rgb_conductor(value)
    eta, k = _curves(value)
    return eta.at(bands.midpoints), k.at(bands.midpoints)


def _curves(value: Metal) -> tuple[Curve, Curve]:
    return metal(value) if isinstance(value, str) else (_as_curve(value.eta), _as_curve(value.k))


@_remembered
def _rgb_conductor(value: Metal) -> tuple[np.ndarray, np.ndarray]:
    eta, k = _curves(value)
    if len(eta.values) == len(k.values) == 2 and np.ptp(eta.values) == np.ptp(k.values) == 0:
        return np.full(3, eta.values[0]), np.full(3, k.values[0])  # one index for all colours
    seen = eta.at(VISIBLE)
    straight = normal_reflectance(seen, k.at(VISIBLE))
    n, r = _means(Curve(VISIBLE, seen)), np.minimum(_seen_under_d65(Curve(VISIBLE, straight)), 0.995)
    return n, np.sqrt(np.maximum(r * (n + 1) ** 2 - (n - 1) ** 2, 0.0) / (1 - r))


def _as_curve(value: float | Points) -> Curve:
    return samples(value if isinstance(value, tuple) else ((VISIBLE[0], value), (VISIBLE[-1], value)))


def _scale(value: str | Spectrum) -> float:
    return 1.0 if isinstance(value, str) else value.scale


def _rgb(xyz: np.ndarray) -> np.ndarray:
    return np.maximum(RGB_OF_XYZ @ xyz, 0.0)


def _at_midpoints(value: Any, found: Curve, bands: Bands) -> np.ndarray:
    if isinstance(value, Spectrum) and value.line is not None:  # which no midpoint would meet
        return bands.holding(value.line) * value.scale
    return found.at(bands.midpoints)


def upsampling(nm: np.ndarray) -> np.ndarray:
    """(3, n): the curves that red, green and blue stand for; they add up to 1."""
    table = columns("upsampling")
    return np.stack([np.interp(nm, table["nm"], table[name]) for name in ("red", "green", "blue")])


def _upsampled(color: float | tuple[float, ...], bands: Bands | None) -> np.ndarray:
    if isinstance(color, tuple):
        rgb = np.array(color, np.float64)
        return rgb if bands is None else rgb @ upsampling(bands.midpoints)
    return np.full(3 if bands is None else bands.n, float(color))


@lru_cache(_KEPT)
def _lamp(value: str | Spectrum, bands: Bands) -> np.ndarray:
    """(n,) band averages of a light with Y = 1, and with the XYZ of its full table under the band sums.

    The correction is the factor 1 + a x + b y + c z of the matching functions. It needs bands that tell the
    three apart; where it would leave a band dark or more than double it, the light is only scaled to Y = 1.
    """
    full = xyz_of(cells(curve_of(value)))
    found = curve_of(value).averages(bands.edges) / full[1]
    to_xyz = xyz_matrix(bands)
    have = to_xyz @ found
    functions = matching(bands.midpoints)
    if np.linalg.cond(system := (to_xyz * found) @ functions.T) < 1e8:
        factor = 1 + np.linalg.solve(system, full / full[1] - have) @ functions
        if (factor > 0).all() and (factor < 2).all():
            return found * factor
    return found / have[1]
