"""Mitsuba's spectra as colours of a scene file: numbers, three of them, or curves of [nm, value] pairs."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from clrt.base.errors import fault

if TYPE_CHECKING:
    from clrt.formats.mitsuba.values import Plugin

VISIBLE: Final = (360.0, 830.0)  # nm
_STEP: Final = 10.0  # nm, of a curve that a formula gives
_PLANCK, _LIGHT, _BOLTZMANN = 6.62607015e-34, 299792458.0, 1.380649e-23  # J s, m/s, J/K


def flat(value: float) -> list[list[float]]:
    """As much of each wavelength."""
    return [[nm, value] for nm in VISIBLE]


def closed(pairs: list[list[float]]) -> list[list[float]]:
    """Pairs that step to 0 at both ends within what is seen: there it is 0 beyond them, and here constant."""
    low, high = pairs[0], pairs[-1]
    if low[0] >= high[0]:  # no curve, which is said later
        return pairs
    before = [[low[0], 0.0]] if low[1] and low[0] > VISIBLE[0] else []
    return [*before, *pairs, *([[high[0], 0.0]] if high[1] and high[0] < VISIBLE[1] else [])]


def times(value: Any, factor: float) -> Any:
    """A colour so many times as bright."""
    if isinstance(value, float):
        return plain(value * factor)
    if isinstance(value[0], list):
        return [[nm, plain(part * factor)] for nm, part in value]
    return [plain(part * factor) for part in value]


def plain(value: float) -> float:
    """The number of 15 digits that is meant: what was multiplied by pi and divided again lost its last."""
    return float(f"{value:.15g}")


def _uniform(plugin: Plugin, of_light: bool) -> Any:
    value = plugin.number("value", 1.0)
    return flat(value) if of_light else value


def _d65(plugin: Plugin, of_light: bool) -> Any:
    """Daylight is what a plain number is here."""
    return times(plugin.color("color", 1.0), plugin.number("scale", 1.0))


def _constant(plugin: Plugin, of_light: bool) -> Any:
    return plugin.color("color" if plugin.type == "srgb" else "value", 1.0)


def _regular(plugin: Plugin, of_light: bool) -> Any:
    values = plugin.numbers("values")
    low, high = plugin.number("wavelength_min", VISIBLE[0]), plugin.number("wavelength_max", VISIBLE[1])
    steps = max(len(values) - 1, 1)
    return closed([[low + (high - low) * k / steps, value] for k, value in enumerate(values)])


def _irregular(plugin: Plugin, of_light: bool) -> Any:
    lengths, values = plugin.numbers("wavelengths"), plugin.numbers("values")
    if len(lengths) != len(values):
        raise plugin.element.says(f"{len(lengths)} wavelengths have {len(values)} values; give each one")
    return closed([[nm, value] for nm, value in zip(lengths, values, strict=True)])


def _blackbody(plugin: Plugin, of_light: bool) -> Any:
    """Planck's law, in W/(m^2 sr nm); 0 where the plugin says that it ends within what is seen."""
    kelvin, scale = plugin.number("temperature", 5000.0), plugin.number("scale", 1.0)
    if not kelvin > 0:
        raise plugin.element.says(fault("", "temperature", kelvin, "it must be a number of kelvins > 0"))
    low = max(plugin.number("wavelength_min", VISIBLE[0]), VISIBLE[0])
    high = min(plugin.number("wavelength_max", VISIBLE[1]), VISIBLE[1])
    if not low < high:
        return 0.0
    lengths = np.linspace(low, high, math.ceil((high - low) / _STEP) + 1)
    return closed(np.stack([lengths, scale * _planck(lengths, kelvin)], axis=1).tolist())


def _planck(nm: np.ndarray, kelvin: float) -> np.ndarray:
    metres = nm * 1e-9
    with np.errstate(over="ignore"):  # of what is too cold to be seen
        seen: np.ndarray = 2e-9 * _PLANCK * _LIGHT**2 / metres**5
        return seen / np.expm1(_PLANCK * _LIGHT / (metres * _BOLTZMANN * kelvin))


Make = Callable[["Plugin", bool], Any]
SPECTRA: Final[dict[str, tuple[Make, Sequence[str]]]] = {
    "uniform": (_uniform, ("value",)),
    "d65": (_d65, ("color", "scale")),
    "srgb": (_constant, ("color", "unbounded")),
    "rawconstant": (_constant, ("value",)),
    "regular": (_regular, ("values", "wavelength_min", "wavelength_max")),
    "irregular": (_irregular, ("values", "wavelengths")),
    "blackbody": (_blackbody, ("temperature", "scale", "wavelength_min", "wavelength_max")),
}
"""What makes a colour of each, and its values. The former is told whether it is that of a light."""
