"""Spectra from colour-science: its observer, lights and chart, and what this model makes of them (nm,
float64).

Integrals over an interval are sums over its cells of 0.01 nm or less, or of a hundredth of it.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from importlib import import_module
from importlib.util import module_from_spec, spec_from_file_location
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from . import published
from .records import LIGHTS, Spectrum

Array = np.ndarray
Curve = Callable[[Array], Array]
NM = np.arange(360.0, 831.0)
KNOTS = np.arange(360.0, 831.0, 5.0)  # of lights and of what red, green and blue stand for


@cache
def colour() -> Any:
    return import_module("colour")


@cache
def observer() -> Array:
    """The CIE 1931 functions at NM (3, 471)."""
    functions = colour().MSDS_CMFS["CIE 1931 2 Degree Standard Observer"]
    at = functions.domain
    return np.stack([np.interp(NM, at, functions.values[:, axis]) for axis in range(3)])


def seen(nm: Array) -> Array:
    """The CIE 1931 functions (3, n)."""
    return np.stack([np.interp(nm, NM, row) for row in observer()])


def _through(nm: Array, values: Array) -> Curve:
    return lambda at: np.interp(at, nm, values)


@cache
def named(name: str) -> Curve:
    """A light, a metal's reflectance straight on, or a patch of the chart."""
    if name == "sun":
        table = _sun()
        fine = np.arange(357.505, 832.5, 0.01)
        power = np.interp(fine, table.wavelengths, table.values)
        return _through(KNOTS, power.reshape(len(KNOTS), -1).mean(axis=1))
    if name in LIGHTS:
        table = colour().SDS_ILLUMINANTS[name.replace("F", "FL")]
        return _through(KNOTS, np.interp(KNOTS, table.wavelengths, table.values))
    if name.startswith("patch-"):
        chart = list(colour().SDS_COLOURCHECKERS["BabelColor Average"].values())
        patch = chart[int(name.removeprefix("patch-")) - 1]
        at = np.arange(380.0, 731.0, 5.0)
        return _through(at, colour().SpragueInterpolator(patch.wavelengths, patch.values)(at))
    eta, k = published.metal(name, NM)
    return _through(NM, straight(eta, k))


def _sun() -> Any:
    """ASTM G173-03, direct and circumsolar. (Its package would import matplotlib.)"""
    file = Path(colour().__file__).parent / "plotting" / "datasets" / "astm_g_173.py"
    spec = spec_from_file_location("astm_g_173", file)
    assert spec is not None and spec.loader is not None
    module = module_from_spec(spec)
    spec.loader.exec_module(module)
    return module.SD_ASTMG173_DIRECT_CIRCUMSOLAR


def straight(eta: Array, k: Array) -> Array:
    """What a metal reflects of light that falls on it straight from air."""
    return np.asarray(1 - 4 * eta / ((eta + 1) ** 2 + k**2))


def curve(value: Spectrum) -> Curve:
    """A spectrum over the wavelength, before lights of no natural unit are scaled."""
    shape = _shape(value)
    return lambda nm: value.scale * shape(nm)


def _shape(value: Spectrum) -> Curve:
    said: Any = value.value
    if value.kind == "name":
        return named(said)
    if value.kind == "blackbody":
        return _through(NM, colour().colorimetry.planck_law(NM * 1e-9, said, c2=1.438777e-2) * 1e-12)
    if value.kind == "samples":
        points = np.array(said, float)
        return _through(points[:, 0], points[:, 1])
    if value.kind == "gaussian":
        middle, deviation = said
        return lambda nm: np.exp(-0.5 * ((nm - middle) / deviation) ** 2) * (abs(nm - middle) < 6 * deviation)
    low, high = said if value.kind == "band" else (said - 0.5, said + 0.5)
    height = 1.0 if value.kind == "band" else 370.0
    return lambda nm: height * ((nm >= low) & (nm < high))


def means(value: Spectrum, edges: Array) -> Array:
    """Means over the intervals between ascending wavelengths, each in 2000 steps and at steps of the
    curve."""
    said: Any = value.value
    jumps = {"band": said, "samples": [nm for nm, _ in said] if value.kind == "samples" else ()}
    jumps["line"] = (said - 0.5, said + 0.5) if value.kind == "line" else ()
    shape, found = curve(value), []
    for low, high in pairwise(edges):
        steps = [nm for nm in jumps.get(value.kind, ()) if low < nm < high]
        cuts = np.unique([*np.linspace(low, high, 2001), *steps])
        found.append(shape((cuts[1:] + cuts[:-1]) / 2) @ np.diff(cuts) / (high - low))
    return np.array(found)


@cache
def by_nm(value: Spectrum) -> Array:
    """Means about each of NM (471,)."""
    return means(value, np.append(NM - 0.5, NM[-1] + 0.5))


def xyz(value: Spectrum) -> Array:
    """XYZ, those of the spectrum 1 with Y = 1."""
    return np.asarray(observer() @ by_nm(value) / observer()[1].sum())


def to_rgb() -> Array:
    """XYZ to linear Rec.709, from its primaries and white as printed (the standard's own matrix is
    rounded)."""
    primaries = colour().RGB_COLOURSPACES["ITU-R BT.709"].primaries
    return np.linalg.inv(colour().normalised_primary_matrix(primaries, (0.3127, 0.3290)))


def white_balance(white: str) -> Array:
    """XYZ under a light to XYZ that look alike under Rec.709's white (3, 3)."""
    seen_under = xyz(Spectrum("name", white))
    d65 = colour().xy_to_XYZ((0.3127, 0.3290))
    adapt = colour().adaptation.matrix_chromatic_adaptation_VonKries
    return np.asarray(adapt(seen_under / seen_under[1], d65, transform="Bradford"))


def primaries(nm: Array) -> Array:
    """What red, green and blue of 1 stand for (3, n)."""
    return np.stack([np.interp(nm, KNOTS, row) for row in _smoothest()])


@cache
def _smoothest() -> Array:
    """The curves (3, 95) at KNOTS, none negative, of the least sum of squared second differences that add up
    to 1 and have under D65 the colours of Rec.709's primaries: by a quadratic programme's interior points.

    Blue is what red and green leave. Mallett and Yuksel 2019, "Spectral primary decomposition".
    """
    count = len(KNOTS)
    hats = np.stack([np.interp(NM, KNOTS, row) for row in np.eye(count)])
    light = named("D65")(NM)
    to_xyz = (hats * light) @ observer().T / (observer()[1] @ light)  # (95, 3)
    white = to_xyz.sum(axis=0)
    target = np.linalg.inv(to_rgb())
    target = target / target.sum(axis=1, keepdims=True) * white[:, None]  # curves that add up to 1 have D65's
    bend = np.diff(np.eye(count), 2, axis=0)
    bend = bend.T @ bend
    quadratic = np.block([[2 * bend, bend], [bend, 2 * bend]])  # of (red, green), blue = 1 - red - green
    equal = np.kron(np.eye(2), to_xyz.T)
    wanted = np.concatenate([target[:, 0], target[:, 1]])
    inside = np.vstack([np.eye(2 * count), -np.hstack([np.eye(count), np.eye(count)])])  # >= least
    least = np.concatenate([np.zeros(2 * count), -np.ones(count)])
    x = np.full(2 * count, 1 / 3)
    slack, push, held = inside @ x - least, np.ones(3 * count), np.zeros(6)
    for _ in range(60):
        gap = slack @ push / len(slack)
        dual = quadratic @ x - equal.T @ held - inside.T @ push
        short, off = equal @ x - wanted, inside @ x - slack - least
        ratio = push / slack
        system = np.block([[quadratic + inside.T * ratio @ inside, -equal.T], [equal, np.zeros((6, 6))]])
        right = -dual + inside.T @ (0.1 * gap / slack - push - ratio * off)
        step = np.linalg.solve(system, np.concatenate([right, -short]))
        d_x, d_held = step[: 2 * count], step[2 * count :]
        d_slack = inside @ d_x + off
        d_push = (0.1 * gap - push * d_slack) / slack - push
        size = 1.0
        for value, change in ((slack, d_slack), (push, d_push)):
            falling = change < 0
            size = min(size, 0.99 * float(np.min(-value[falling] / change[falling], initial=np.inf)))
        x, held, slack, push = (
            x + size * d_x,
            held + size * d_held,
            slack + size * d_slack,
            push + size * d_push,
        )
        if gap < 1e-15:
            break
    red, green = x.reshape(2, count)
    return np.stack([red, green, 1 - red - green])
