"""Plots of spectra: below a curve the colours of its wavelengths, beside it a patch of the whole's colour."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Final

import numpy as np

from clrt.images.file import encode
from clrt.images.plotting import drawing, subplots
from clrt.spectra.bands import Bands, light, reflectance, upsampling
from clrt.spectra.colorimetry import RGB_OF_XYZ, cells, matching, xyz_of
from clrt.spectra.curves import curve_of, ior_at, is_lamp
from clrt.spectra.indices import GLASSES
from clrt.spectra.spectrum import METALS, REFLECTANCES, Spectrum

SHOWN: Final = np.arange(380.0, 751.0)
"""Wavelengths in nm that plots show."""
_METAL_COLORS: Final = {
    "silver": "#8a8f98", "gold": "#c9972b", "copper": "#b0592f", "aluminium": "#4c78a8", "iron": "#444444",
}  # fmt: skip


@drawing()
def draw(value: str | Spectrum, bands: int | None = None) -> Any:
    """A figure of a name (of `clrt plot-spectrum`) or a spectrum; with `bands`, what a render makes of it."""
    figure, axes = subplots(figsize=(7, 3.6))
    if value == "matching":
        _several(axes, dict(zip("xyz", matching(SHOWN), strict=True)), ("#c0392b", "#27ae60", "#2c5fb3"))
        _finish(axes, "CIE 1931 matching functions (2 degrees)", "matching function")
    elif value == "rgb":
        curves = dict(zip(("red", "green", "blue"), upsampling(SHOWN), strict=True))
        _several(axes, curves, ("#c0392b", "#27ae60", "#2c5fb3"))
        _finish(axes, "What an RGB colour's parts stand for", "reflectance")
    elif value == "metals":
        curves = {name: curve_of(name).at(SHOWN) for name in METALS}
        _several(axes, curves, [_METAL_COLORS[name] for name in METALS])
        axes.set_ylim(0, 1)
        _finish(axes, "Reflectance of metals, seen straight on", "reflectance")
    elif value in (*GLASSES, "glasses"):
        names = GLASSES if value == "glasses" else (str(value),)
        _several(axes, {name: ior_at(name, SHOWN) for name in names}, None, "center right")
        _finish(axes, "Index of refraction", "index of refraction")
    else:
        _spectrum(axes, value, bands)
    return figure


def _spectrum(axes: Any, value: str | Spectrum, bands: int | None) -> None:
    """One curve over its colours, the patch, and the steps that a render has."""
    reflects = (value if isinstance(value, str) else value.name) in REFLECTANCES
    shown = curve_of(value).at(SHOWN)
    of = reflectance if reflects else light
    if not reflects and is_lamp(value):  # whose unit is Y = 1, not what its table has
        shown = shown / xyz_of(cells(curve_of(value)))[1] * (1 if isinstance(value, str) else value.scale)
    axes.bar(SHOWN, shown, width=1.1, color=wavelength_colors(SHOWN), linewidth=0)
    axes.plot(SHOWN, shown, color="#222222", linewidth=1.2)
    if bands is not None:
        made = Bands(bands)
        axes.stairs(of(value, made), made.edges, color="#222222", linestyle=":", label=f"{bands} bands")
        axes.legend(frameon=False)
    color = of(value, None)
    patch = axes.inset_axes([1.03, 0.0, 0.06, 1.0])
    patch.set_facecolor(displayed(color / max(color.max(), 1.0)))
    patch.set(xticks=[], yticks=[])
    patch.spines[:].set_visible(True)
    label = "reflectance" if reflects else "radiance (all 1: Y = 1)"
    short = value if isinstance(value, str) else value.short()
    text = ", ".join(f"{k} {v}" for k, v in short.items()) if isinstance(short, dict) else short
    text = text if isinstance(text, str) else f"{len(text)} points"
    rgb = ", ".join(f"{part:.3f}" for part in color)
    _finish(axes, f"{text}: linear RGB {rgb}", label)


def _several(
    axes: Any, curves: Mapping[str, np.ndarray], colors: Sequence[str] | None, legend: str = "best"
) -> None:
    for i, (name, values) in enumerate(curves.items()):
        axes.plot(SHOWN, values, label=name, color=None if colors is None else colors[i], linewidth=1.8)
    axes.legend(frameon=False, loc=legend)


def _finish(axes: Any, title: str, label: str) -> None:
    axes.set(title=title, xlabel="wavelength in nm", ylabel=label, xlim=(SHOWN[0], SHOWN[-1]))
    if axes.get_ylim()[0] < 1 and not label.startswith("index"):
        axes.set_ylim(bottom=0)


def wavelength_colors(nm: np.ndarray) -> np.ndarray:
    """(n, 3) sRGB in [0, 1] of single wavelengths, clipped to the gamut, as bright as they can be."""
    rgb = np.maximum((RGB_OF_XYZ @ matching(nm)).T, 0)
    strength = matching(nm).sum(axis=0)[:, None]
    fade = np.minimum(strength / 0.3, 1.0)  # the eye's limits stay dark
    return displayed(rgb / np.maximum(rgb.max(axis=1, keepdims=True), 1e-9) * fade)


def displayed(linear: np.ndarray) -> np.ndarray:
    """sRGB in [0, 1] of linear colours (..., 3)."""
    flat = np.asarray(linear, np.float32).reshape(1, -1, 3)
    return (encode(flat) / 255.0).reshape(np.shape(linear))
