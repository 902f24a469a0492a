"""Spectra from the published tables, in lines of their own: dense samples in place of most integrals."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np

from clrt.spectra.spectrum import LAMPS, METALS, Spectrum
from clrt.spectra.tables import FOLDER

from .vectors import Array

NM = np.arange(360.0, 831.0)
_INSIDE = (np.arange(2000) + 0.5) / 2000 - 0.5  # places in an interval about its middle
_REC709 = np.array([[0.64, 0.33, 0.03], [0.30, 0.60, 0.10], [0.15, 0.06, 0.79]]).T  # x, y, z by columns
_D65 = np.array([0.3127, 0.3290, 0.3583]) / 0.3290
TO_RGB = np.linalg.inv(_REC709 * np.linalg.solve(_REC709, _D65))

Curve = Callable[[Array], Array]  # wavelengths in nm to values


@cache
def table(name: str) -> dict[str, Array]:
    """Columns of a table by their names."""
    lines = [line for line in (FOLDER / f"{name}.csv").read_text().splitlines() if not line.startswith("#")]
    rows = np.array([line.split(",")[1 if name == "glasses" else 0 :] for line in lines[1:]], float)
    heads = lines[0].split(",")[1 if name == "glasses" else 0 :]
    return dict(zip(heads, rows.T, strict=True))


def tabled(name: str, column: str) -> Curve:
    """A column over wavelengths: linear between its rows, constant beyond."""
    rows = table(name)
    return lambda nm: np.interp(nm, rows["nm"], rows[column])


def means(curve: Curve, middle: Array, width: float) -> Array:
    """Means of a curve over intervals."""
    return np.asarray(curve(middle[:, None] + width * _INSIDE).mean(axis=1))


def means_of(value: Any, middle: Array, width: float) -> Array:
    """Means over intervals of a name or a record of the scene's; of boxes without sampling."""
    box = None if isinstance(value, str) else value.band
    height = 1.0
    if not isinstance(value, str) and value.line is not None:
        box, height = (value.line - 0.5, value.line + 0.5), 370.0
    if box is None:
        knots = None if isinstance(value, str) else value.samples
        curve = curve_of(value)
        return means(curve, middle, width) if knots is None else _pieced(curve, knots, middle, width)
    inside = np.minimum(middle + width / 2, box[1]) - np.maximum(middle - width / 2, box[0])
    return np.asarray(np.maximum(inside, 0.0) / width * height * value.scale)


def matching(nm: Array) -> Array:
    """The CIE 1931 functions (3, n)."""
    return np.stack([tabled("observer", axis)(nm) for axis in "xyz"])


def basis(nm: Array) -> Array:
    """What linear red, green and blue stand for (3, n)."""
    return np.stack([tabled("upsampling", color)(nm) for color in ("red", "green", "blue")])


def _pieced(curve: Curve, knots: Any, middle: Array, width: float) -> Array:
    """Means of a curve that is linear between knots: each piece has its own middle's value."""
    found = []
    for low, high in zip(middle - width / 2, middle + width / 2, strict=True):
        cuts = np.array([low, *(nm for nm, _ in knots if low < nm < high), high])
        found.append(np.diff(cuts) @ curve((cuts[1:] + cuts[:-1]) / 2) / width)
    return np.array(found)


@cache
def xyz(value: Any) -> Array:
    """XYZ of a name or a record of the scene's; that of the spectrum 1 has Y = 1."""
    observer = matching(NM)
    return np.asarray(observer @ means_of(value, NM, 1.0) / observer[1].sum())


def curve_of(value: Any) -> Curve:
    """A name or a record of the scene's as a curve, before any scaling to Y = 1."""
    if isinstance(value, str):
        return _named(value)
    shape = _shape(value)
    return lambda nm: value.scale * shape(nm)


def _named(name: str) -> Curve:
    if name in LAMPS:
        return tabled("lights", name)
    if name not in METALS:
        return tabled("colorchecker", name)
    n, k = tabled(name, "eta"), tabled(name, "k")

    def reflectance(nm: Array) -> Array:
        index = n(NM) + 1j * k(NM)
        return np.interp(nm, NM, np.abs((index - 1) / (index + 1)) ** 2)

    return reflectance


def _shape(value: Spectrum) -> Curve:
    if value.name is not None:
        return _named(value.name)
    if value.blackbody is not None:
        kelvin = value.blackbody
        planck = (560 / NM) ** 5 / (np.exp(1.438777e7 / (NM * kelvin)) - 1)
        return lambda nm: np.asarray(np.interp(nm, NM, planck))
    if value.gaussian is not None:
        middle, deviation = value.gaussian
        bell = _bell(middle, deviation)
        return lambda nm: np.where(np.abs(nm - middle) <= 6 * deviation, bell(nm), 0.0)
    if value.band is not None:
        low, high = value.band
        return lambda nm: ((nm >= low) & (nm < high)).astype(float)
    if value.line is not None:
        at = value.line
        return lambda nm: np.where(np.abs(nm - at) <= 0.5, 370.0, 0.0)
    nm_given, values = np.array(value.samples, float).T
    return lambda nm: np.interp(nm, nm_given, values)


def _bell(middle: float, deviation: float) -> Curve:
    return lambda nm: np.exp(-(((nm - middle) / deviation) ** 2) / 2)


def index(value: Any, nm: Array) -> Array:
    """Index of refraction of what a scene calls `ior`, if that is a curve."""
    if isinstance(value, tuple):
        return np.interp(nm, *np.array(value, float).T)
    square = (nm / 1000) ** 2
    if isinstance(value, str):
        lines = (FOLDER / "glasses.csv").read_text().splitlines()
        words = next(line for line in lines if line.startswith(f"{value},")).split(",")[1:]
        return _sellmeier(np.array(words[:4], float), np.array(words[4:], float), square)
    if value.sellmeier is not None:
        return _sellmeier(np.array(value.sellmeier.B), np.array(value.sellmeier.C), square)
    return np.asarray(sum(c / square**power for power, c in enumerate(value.cauchy)))


def _sellmeier(b: Array, c: Array, square: Array) -> Array:
    return np.asarray(np.sqrt(1 + (b[:, None] * square / (square - c[:, None])).sum(axis=0)))


def bradford(white: Array) -> Array:
    """XYZ under a white to XYZ that look alike under D65 (3, 3)."""
    cones = np.array([[0.8951, 0.2664, -0.1614], [-0.7502, 1.7135, 0.0367], [0.0389, -0.0685, 1.0296]])
    return np.asarray(np.linalg.inv(cones) @ np.diag(cones @ _D65 / (cones @ white)) @ cones)
