"""What a case's comparison with an oracle must reach; and where float32 itself allows less, how much.

Cases have the limits of docs/validation.md. Scenes that ship, are drawn by chance or are somebody's own may
lie where float32 is coarse: where one of them fails, its own noise is measured (`noise`), and a figure may be
as far off as that explains (`widened`). No limit is chosen by what was measured of our own pictures.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

from .compare.oracle import Limits, exact, limits
from .types import Case

# fields of Limits that float32 has a say in -> the figure, and whether the smaller is the worse
FIGURES: Final = {
    "fine": ("within 1e-4", True), "coarse": ("within 1e-3", True), "masked": ("edges far off", False),
    "mean": ("mean radiance", False), "distance": ("distance", False), "ssim": ("SSIM", True),
    "psnr": ("PSNR", True), "flip": ("FLIP", False), "rays": ("rays", True), "layers": ("layers", True),
}  # fmt: skip
# times that a program in float32 rounds what light depends on: as the scene is read, and as a hit is computed
_ROUNDED: Final = 2
_MORE_ROUNDED: Final = {"shipped rainbow": 4}
_SIGMAS: Final = 3.0  # that a number of pixels may be above the one that is expected
# the share of edges is the reference's alone, in which float32 has no say
_EDGES: Final = {"shipped sphereflake": 0.4, "shipped sphereflake at 16 samples": 0.55}
_NOTES: Final = {
    "shipped thesis_3_07_acne": (
        "3000 units from the origin float32 coordinates are 2.4e-4 apart. Half of that turns the normal of a "
        "body of radius 0.6 by 2e-4, and so much of its light; at a distance of 8, on a surface seen at 10 "
        "degrees, it moves the hit by 1e-4 of the distance. Feelers start 1.4e-3 above the ground, which "
        "moves shadows there by up to 3.4e-3: 0.04 pixel, 13 times what is left out at 16 samples."
    ),
    "shipped rainbow": (
        "The drop's two images of the lamp join in a caustic, where a ray's direction no longer changes with "
        "its place: rounding a hit by 1e-7 moves the image there by more than is left out as an edge. Light "
        "is rounded four times: when the scene is read, and at each of its three hits on the drop."
    ),
    "shipped sphereflake": (
        "A generation has 9 times the spheres at a third of the radius, and so 3 times the outlines, until "
        "they are smaller than a pixel: 44, 37 and 35 % of the pixels are edges at a width of 80, 160 and "
        "240, 51 % of 80 x 80 at 16 samples."
    ),
}  # fmt: skip


@dataclass(frozen=True)
class Noise:
    """What float32 moves a picture by.

    figures: by field of Limits; shares of pixels as they are to be expected, others as the worst of a few
    pictures. pixels: of how many pixels a field is a share.
    """

    figures: Mapping[str, float]
    pixels: Mapping[str, int]


def note_of(name: str) -> str:
    """Why a scene that ships has limits of its own; "" where it needs none."""
    return _NOTES.get(name.removesuffix(" at 16 samples"), "")


def limits_of(case: Case, oracle: str) -> Limits:
    """The limits of a case's comparison: strict for what was made as a test and for the oracle in float64."""
    base = limits(case.spp, many_edges=not case.is_test)
    if oracle == "oracle64":
        # one pixel of an edge can spoil a window; where a checkered floor ends, three can move the whole
        strict = dataclasses.replace(exact(base), window=base.window)
        base = strict if case.is_test else dataclasses.replace(strict, ssim=max(base.ssim or 0, 0.999))
    return dataclasses.replace(base, mask=_EDGES.get(case.name, base.mask))


def times_of(case: Case, oracle: str) -> int:
    """How often float32 rounds what two pictures of a case are made from: ours, and that of an oracle."""
    programs = 1 if oracle == "oracle64" else 2
    return programs * _MORE_ROUNDED.get(case.name, _ROUNDED)


def widened(limit: Limits, noise: Noise, times: int) -> Limits:
    """The limits, or where float32 moves the picture by more, that; `times` it is rounded."""
    fields: dict[str, float] = {}
    for field, (_, low) in FIGURES.items():
        before: float | None = getattr(limit, field)
        if before is not None and field in noise.figures:
            most = allowed(field, noise, times)
            fields[field] = min(before, most) if low else max(before, most)
    return dataclasses.replace(limit, **fields)


def allowed(field: str, noise: Noise, times: int) -> float:
    """What a figure may be where float32 moves the picture so many times, each time by that noise.

    Differences and shares of pixels add up; a mean of squares (PSNR) does so as energy. How many pixels it is
    that differ is chance: three standard deviations of a count (Poisson) more.
    """
    value = noise.figures[field]
    if field == "psnr":
        return value - 10 * math.log10(times * times)
    off = times * (1 - value if FIGURES[field][1] else value)
    if field in noise.pixels:
        off += _SIGMAS * math.sqrt(off / noise.pixels[field])
    return 1 - off if FIGURES[field][1] else off
