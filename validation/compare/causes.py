"""What is said of why two pictures differ, and how it is tested.

Nothing is guessed from the look of a picture. A cause is something that can be undone in the picture, or
done to the scene, and then the error must vanish: `compare_undo` (turns, channels, curves, factors),
`compare_curves` (JPEG, tone curves), `compare_moves` (shifts, sizes), `compare_scene` (lights, shadows,
depth, materials, objects).
"""

from __future__ import annotations

import math
import time
from dataclasses import dataclass, field

import numpy as np

from .metrics import Array, encoded, extended, parts

VANISHED = 0.1  # a cause is proven when undoing it leaves no more of the error
LIKELY = 0.5  # ... and likely when it leaves no more than this
NOTHING = 0.01  # what leaves no more than this explains all: rounding and edges leave as much
EXACT = 0.002  # ... and no other does better
BYTE = 1.5 / 255  # tolerance for pictures of 8 bits, in encoded values; rounding, and curves that magnify it
FLOAT = 1e-4  # tolerance for pictures of floats
WORD = FLOAT + 1.5 / 65535  # tolerance for pictures of 16 bits; as those of 8 they end at white
STEP = 1 / 255


@dataclass(frozen=True)
class Cause:
    """A mistake that would explain a picture."""

    name: str  # "vertical flip"; combinations joined by " and "
    text: str  # what was done wrong, for the picture's author
    left: float  # share of the error that is left when it is undone: 0 explains all
    undone: Array | None = field(default=None, compare=False)  # the picture with the mistake undone
    certain: bool = True  # False: what was tested must hold for this cause, but could hold for others
    hinted: bool = False  # likely for another reason than `left`
    blurs: bool = False  # undoing it takes means of pixels, which hides what it does not explain
    shades: bool = False  # it only makes lighter, darker or of another hue, as faults of a scene do
    numbers: int = 1  # that were chosen or fitted: the more, the more other mistakes it can feign

    @property
    def proven(self) -> bool:
        return self.certain and self.left <= VANISHED

    @property
    def likely(self) -> bool:
        return self.left <= LIKELY or self.hinted


@dataclass
class Budget:
    """Seconds of processor time that a search for causes may take; whoever asks `over` stops when it is."""

    seconds: float
    start: float = field(default_factory=time.process_time)
    stopped: bool = False

    def over(self) -> bool:
        """Whether the time is spent."""
        self.stopped = self.stopped or time.process_time() - self.start >= self.seconds
        return self.stopped


def tolerance_of(a: Array, b: Array, bits: tuple[int, int] = (32, 32)) -> float:
    """BYTE or WORD where one is known to be stored in 8 or 16 bits, so that both are to end at white.

    Values alone tell of 8 bits only where clipping loses less than a step: radiance of 1 is no file's white.
    """
    fewest = min(bits)
    ends = fewest < 32 or not any(off_screen(image) for image in (a, b))
    if fewest == 8 or (ends and (_rounded(a) or _rounded(b))):
        return BYTE
    return WORD if fewest == 16 else FLOAT


def off_screen(picture: Array) -> int:
    """How many pixels have a value above white, or below black, by more than a step of 8 bits."""
    return sum(
        int(np.count_nonzero((np.abs(extended(part) - encoded(part)) > STEP).any(axis=-1)))
        for part in parts(picture)
    )


def _rounded(picture: Array) -> bool:
    """Whether all values are steps of 8 bits; black and white alone tell nothing."""
    grey = False
    for part in parts(picture):
        values = encoded(part) / STEP
        steps = np.round(values)
        if np.abs(values - steps).max(initial=0.0) >= 1e-3:
            return False
        grey = grey or bool(((steps > 0) & (steps < 255)).any())
    return grey


def disagreement(picture: Array, reference: Array, tolerance: float) -> float:
    """Mean difference of encoded values beyond the tolerance: 0 for pictures that agree."""
    shown = extended if tolerance == FLOAT else encoded  # files of integers end at white
    total = sum(
        float(np.maximum(np.abs(shown(a) - shown(b)) - tolerance, 0.0).sum())
        for a, b in zip(parts(picture), parts(reference), strict=True)
    )
    return total / max(reference.size, 1)


def ranked(causes: list[Cause]) -> list[Cause]:
    """Each name once, proven ones first, of these those that only move pixels, then by what they explain.

    What takes more numbers has to leave less: a curve of many explains a part of everything.
    """
    causes = sorted(causes, key=_rank)
    best: dict[str, Cause] = {}
    for cause in causes:
        best.setdefault(cause.name, cause)
    return list(best.values())


def _rank(cause: Cause) -> tuple[bool, bool, float, float]:
    price = max(cause.left, EXACT) * math.log2(1 + cause.numbers)
    return not cause.proven, cause.proven and cause.blurs, price, cause.left


def told(factor: float) -> str:
    """A factor in two digits, or in as many as show how far from 1 it is."""
    digits = 2
    while abs(float(f"{factor:.{digits}g}") - factor) > abs(factor - 1) / 4:
        digits += 1
    return f"{factor:.{digits}g}"


def remaining(undone: Array, reference: Array, before: float, tolerance: float) -> float:
    """Share of the error `before` that is left."""
    return disagreement(undone, reference, tolerance) / before if before else 1.0


def error_of(picture: Array, reference: Array, tolerance: float) -> float:
    """The error that a cause has to explain; of pictures that do not fit, that of a mean grey."""
    fits = picture.shape == reference.shape
    return disagreement(picture if fits else np.full_like(reference, reference.mean()), reference, tolerance)
