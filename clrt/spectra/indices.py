"""Indices of refraction as a scene states them: numbers, names, curves and formulas; metals' complex ones."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Annotated, Any

from msgspec import Meta

from clrt.base.places import At, listed
from clrt.base.records import Record
from clrt.base.suggest import did_you_mean
from clrt.spectra.spectrum import METALS, VISIBLE, Points, check_points

IOR = {"air": 1.0, "water": 1.333, "ice": 1.31, "glass": 1.5, "diamond": 2.419}
"""Indices of refraction by name (at the sodium line)."""
GLASSES = ("BK7", "SF10", "SF11", "silica", "water-dispersive", "diamond-dispersive")
"""Glasses whose index depends on the wavelength."""
LEAST, MOST = 1e-3, 1e6
"""The bounds of an index of refraction: the fourth power of two indices' ratio still is a float32."""
_SEEN = tuple((nm / 1000) ** 2 for nm in VISIBLE)  # um^2
INDEX = f"a number from {LEAST:g} to {MOST:g}"
"""What an index is, in a message."""


class Sellmeier(Record, frozen=True, kw_only=True):
    """n^2 = 1 + sum B_i l^2 / (l^2 - C_i), l in um, C in um^2."""

    B: Annotated[tuple[float, ...], Meta(description="B must be 1 to 6 numbers")]
    C: Annotated[tuple[float, ...], Meta(description="C must be as many numbers (um^2) as B has")]

    def check(self, at: At) -> None:
        if not 1 <= len(self.B) <= 6:
            raise at.key("B").error(self.B, "B must be 1 to 6 numbers")
        if len(self.C) != len(self.B):
            raise at.key("C").error(self.C, "C must be as many numbers (um^2) as B has")
        for number, square in enumerate(self.C):
            if _SEEN[0] <= square <= _SEEN[1]:
                text = f"the index has no end at {1000 * math.sqrt(square):.6g} nm, which is visible"
                right = f"C must be below {_SEEN[0]:g} or above {_SEEN[1]:g} (um^2)"
                raise at.key("C").item(number).error(square, f"{text}; {right}")


class Dispersion(Record, frozen=True, kw_only=True):
    """An index of refraction over the wavelength, by Sellmeier's or Cauchy's formula."""

    sellmeier: Annotated[Sellmeier, Meta(description="must be a table {B = [...], C = [...]}")] | None = None
    cauchy: Annotated[
        tuple[float, ...] | None, Meta(description="cauchy must be 1 to 6 numbers A, B (um^2), C (um^4) ...")
    ] = None

    def check(self, at: At) -> None:
        if (self.sellmeier is None) == (self.cauchy is None):
            raise at.says("an index's formula has one of sellmeier, cauchy")
        if self.sellmeier is not None:
            self.sellmeier.check(at.key("sellmeier"))
        if self.cauchy is not None and not 1 <= len(self.cauchy) <= 6:
            raise at.key("cauchy").error(self.cauchy, "cauchy must be 1 to 6 numbers")


class Conductor(Record, frozen=True, kw_only=True):
    """Complex index eta + i k of a metal, each a number or (nm, value) pairs."""

    eta: Annotated[float | Points, Meta(description="eta must be a number or [nm, value] pairs")]
    k: Annotated[float | Points, Meta(description="k must be a number or [nm, value] pairs")]

    def check(self, at: At) -> None:
        for name, least in (("eta", LEAST), ("k", 0.0)):
            value = getattr(self, name)
            if isinstance(value, tuple):
                check_points(value, at.key(name), least, MOST)
            elif not least <= value <= MOST:
                raise at.key(name).error(value, f"{name} must be a number from {least:g} to {MOST:g}")


if TYPE_CHECKING:
    Ior = float | str | Points | Dispersion | Any
    Metal = str | Conductor | Any
else:
    Ior = Annotated[
        float | str | Points | Dispersion,
        Meta(description=f"ior must be {INDEX}, a name, [nm, index] pairs, or a formula's table"),
    ]
    Metal = Annotated[
        str | Conductor, Meta(description="conductor must be a metal's name or {eta = ..., k = ...}")
    ]


def check_conductor(conductor: Metal, at: At) -> None:
    """Raise for an unknown name or a complex index that is none."""
    if isinstance(conductor, Conductor):
        conductor.check(at)
    elif conductor not in METALS:
        raise at.error(conductor, f"a metal is one of {listed(METALS)}{did_you_mean(conductor, METALS)}")
