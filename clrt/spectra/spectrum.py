"""Spectra as a scene states them: records, names, checks. What they are in numbers: `clrt.spectra.curves`."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Annotated, Any, Literal

from msgspec import Meta

from clrt.base.hints import Numbers
from clrt.base.places import At, listed
from clrt.base.records import Record, table_of
from clrt.base.suggest import did_you_mean

LAMPS = ("D65", "A", "E", *(f"F{i}" for i in range(1, 13)), "sun")
"""Light sources by name: CIE standard illuminants, and the sun at air mass 1.5."""
METALS = ("gold", "silver", "copper", "aluminium", "iron")
PATCHES = tuple(f"patch-{i}" for i in range(1, 25))
"""The patches of the ColorChecker chart, row by row from the dark skin."""
REFLECTANCES = (*METALS, *PATCHES)
VISIBLE = (360.0, 830.0)
"""Range in nm of the observer's table."""
MEASURED = (100.0, 10000.0)
"""Range in nm of any curve's points."""

Points = tuple[tuple[float, float], ...]
_POINTS = "samples must be 2 or more [nm, value] pairs"
if TYPE_CHECKING:
    Samples = Points | Any
    Interval = Numbers
    Range = Numbers
else:
    Samples = Points
    Interval = tuple[float, float]
    Range = Annotated[
        tuple[float, float], Meta(description="range must be [low, high] in nm, within 360 to 830")
    ]


class Spectrum(Record, frozen=True, kw_only=True, tag="spectrum", tag_field="type"):
    """One of `name`, `blackbody`, `gaussian`, `band`, `line` and `samples`, times `scale`.

    name: a published one. blackbody: temperature in K. gaussian: centre and standard deviation in nm, peak 1.
    band: 1 between two wavelengths in nm, 0 elsewhere. line: a wavelength in nm. samples: (nm, value) pairs,
    linear between, constant beyond both ends; where a wavelength stands twice the curve steps.
    """

    name: str | None = None
    blackbody: Annotated[
        float | None, Meta(description="blackbody must be a temperature from 500 to 100000 (K)")
    ] = None
    gaussian: Annotated[
        Interval | None, Meta(description="gaussian must be [centre, standard deviation] in nm")
    ] = None
    band: Annotated[Interval | None, Meta(description="band must be [low, high] in nm")] = None
    line: Annotated[float | None, Meta(description="line must be a wavelength in nm")] = None
    samples: Annotated[Samples | None, Meta(description=_POINTS)] = None
    scale: Annotated[float, Meta(ge=0, description="must be a number >= 0")] = 1.0

    def check(self, at: At) -> None:
        """Raise where not exactly one kind is given, or its wavelengths are outside, unordered or too few."""
        kinds = [kind for kind in _KINDS if getattr(self, kind) is not None]
        if len(kinds) != 1:
            given = listed(kinds) if kinds else "none of them"
            raise at.says(f"a spectrum has one of {listed(_KINDS)}; {given} is given")
        if self.blackbody is not None and not 500 <= self.blackbody <= 1e5:
            raise at.key("blackbody").error(self.blackbody, "it must be a temperature from 500 to 100000 (K)")
        if self.gaussian is not None:
            check_nm(self.gaussian[0], at.key("gaussian"), VISIBLE)
            if not self.gaussian[1] >= 0.01:
                raise at.key("gaussian").error(self.gaussian[1], "a standard deviation must be >= 0.01 nm")
        if self.line is not None:
            check_nm(self.line, at.key("line"), VISIBLE)
        if self.band is not None:
            for nm in self.band:
                check_nm(nm, at.key("band"), MEASURED)
            if not self.band[0] < self.band[1]:
                raise at.key("band").error(self.band, "the first wavelength must be below the second")
        if self.samples is not None:
            check_points(self.samples, at.key("samples"), least=0.0)


    def short(self) -> Any:
        """A name or pairs where nothing else is said, else the table without its type."""
        table = {key: value for key, value in table_of(self).items() if key != "type"}
        if table.keys() == {"name"} or table.keys() == {"samples"}:
            return next(iter(table.values()))
        return table


_KINDS = ("name", "blackbody", "gaussian", "band", "line", "samples")


def check_points(points: Points, at: At, least: float, most: float = math.inf) -> None:
    """Raise where pairs are fewer than 2, their wavelengths not within MEASURED and ascending, or a value
    not from `least` to `most`. Equal wavelengths, twice at most, are a step."""
    if len(points) < 2:
        raise at.error(points, "a curve has 2 or more [nm, value] pairs")
    for i, (nm, value) in enumerate(points):
        check_nm(nm, at.item(i), MEASURED)
        if i and nm < points[i - 1][0]:
            raise at.item(i).error(nm, f"wavelengths must ascend, and {points[i - 1][0]:g} stands before it")
        if i > 1 and nm == points[i - 2][0]:
            raise at.item(i).error(nm, "a wavelength can stand twice (a step), not three times")
        if not least <= value <= most:
            bound = f"from {least:g} to {most:g}" if most < math.inf else f">= {least:g}"
            raise at.item(i).error(value, f"values must be {bound}")
    if points[0][0] == points[-1][0]:
        raise at.error(points, "a curve needs 2 different wavelengths")


def check_nm(nm: float, at: At, span: tuple[float, float]) -> None:
    if not span[0] <= nm <= span[1]:
        raise at.error(nm, f"wavelengths are in nm, from {span[0]:g} to {span[1]:g}")


class Spectral(Record, frozen=True, kw_only=True):
    """How a scene's light is computed: in `bands` equal intervals of `range` (nm) instead of in RGB.

    white, white_balance: with true, the picture's colours are adapted (Bradford) from this light to D65.
    response: CIE 1931, or the thesis program's own. group: bands that dispersion bends together. faults: for
    validation, which then copies the thesis program's faults.
    """

    bands: Annotated[int, Meta(ge=3, description="must be a whole number from 3 to 64")] = 24
    range: Range = (380.0, 750.0)
    white: str = "D65"
    white_balance: bool = False
    response: Annotated[
        Literal["cie", "thesis-2011"], Meta(description="response must be 'cie' or 'thesis-2011'")
    ] = "cie"
    group: Annotated[int, Meta(ge=1, description="must be a whole number from 1 to bands")] = 1
    faults: bool = False

    def check(self, at: At) -> None:
        low, high = self.range
        for nm in self.range:
            check_nm(nm, at.key("range"), VISIBLE)
        if not high - low >= 10:
            raise at.key("range").error(self.range, "the range must be at least 10 nm wide, low before high")
        if self.white not in LAMPS:
            known = f"a white is one of {listed(LAMPS)}{did_you_mean(self.white, LAMPS)}"
            raise at.key("white").error(self.white, known)
        if self.group > self.bands:
            raise at.key("group").error(self.group, f"a group has 1 to {self.bands} bands, all there are")
        if self.faults and self.response != "thesis-2011":
            raise at.key("faults").says("faults are those of response = 'thesis-2011'")
