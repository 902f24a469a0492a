"""Causes that are undone pixel by pixel: turns, swapped channels, wrong curves, factors, and combinations."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np

from .causes import Cause, disagreement, error_of, told
from .metrics import Array, beyond, decoded, encoded

_SAMPLES = 4000  # pixels that combinations are tried on
_FACTOR = 0.005  # a factor nearer to 1 is none


@dataclass(frozen=True)
class _Part:
    """One thing to undo; the first of each family does nothing."""

    name: str
    text: str
    undo: Callable[[Array], Array]
    redo: Callable[[Array], Array] | None = None  # on the reference: undoing cannot bring back what clipped
    shades: bool = False  # pixels stay where they are, and channels what they are
    numbers: int = 1  # that were chosen or fitted
    scales: bool = False

    def error(self, picture: Array, reference: Array, tolerance: float) -> float:
        """The disagreement once this is undone, or the reference has it too."""
        if self.redo:
            return disagreement(picture, self.redo(reference), tolerance)
        return disagreement(self.undo(picture), reference, tolerance)


def _tone(name: str, text: str, curve: Callable[[Array], Array]) -> _Part:
    """A curve from black to white; what is beyond stays, or the curve would seem to explain it."""
    return _Part(name, text, lambda image: curve(image) + beyond(image), shades=True)


_NOTHING = _Part("", "", lambda image: image)
_TURNS = (
    _NOTHING,
    _Part("horizontal flip", "left and right are swapped", lambda image: image[:, ::-1]),
    _Part(
        "vertical flip",
        "top and bottom are swapped: y points the other way, or rows start at the bottom",
        lambda image: image[::-1],
    ),
    _Part("rotation by 180 degrees", "both axes point the other way", lambda image: image[::-1, ::-1]),
    _Part(
        "transpose",
        "rows and columns are swapped: pixels are indexed [x][y]",
        lambda image: image.swapaxes(0, 1),
    ),
    _Part("rotation by 90 degrees to the right", "it lies on its side", lambda image: np.rot90(image, 1)),
    _Part("rotation by 90 degrees to the left", "it lies on its side", lambda image: np.rot90(image, -1)),
    _Part(
        "transpose about the other diagonal",
        "rows and columns are swapped and turned",
        lambda image: image[::-1, ::-1].swapaxes(0, 1),
    ),
)
_SWAPS = (
    _NOTHING,
    _Part("red and blue swapped", "channels are in the order B, G, R", lambda image: image[..., [2, 1, 0]]),
    _Part("red and green swapped", "channels are in the order G, R, B", lambda image: image[..., [1, 0, 2]]),
    _Part("green and blue swapped", "channels are in the order R, B, G", lambda image: image[..., [0, 2, 1]]),
    _Part("channels rotated", "channels are in the order G, B, R", lambda image: image[..., [2, 0, 1]]),
    _Part("channels rotated", "channels are in the order B, R, G", lambda image: image[..., [1, 2, 0]]),
)
_TONES = (
    _NOTHING,
    _tone("sRGB applied twice", "the sRGB curve is applied two times: the picture is washed out", decoded),
    _tone("sRGB not applied", "linear values stand where sRGB ones belong: the picture is too dark", encoded),
    _tone(
        "gamma 2.2 in place of sRGB",
        "a power of 1/2.2 is used, not the sRGB curve",
        lambda image: encoded(image) ** 2.2,
    ),
    _tone("negative", "the picture is inverted", lambda image: decoded(1 - encoded(image))),
)


def undoable(picture: Array, reference: Array, tolerance: float) -> Iterator[Cause]:
    """The simplest of the best combinations of a turn, a swap of channels, a curve and a factor.

    Also the best one without a factor, which other faults could feign. No promise that either explains much.
    """
    turns = [turn for turn in _TURNS if turn.undo(picture).shape == reference.shape]
    if not turns:
        return
    height, width = reference.shape[:2]
    # of a picture thinner than a step the second: there is one row of samples, and it is as long
    step = max(1, int(np.sqrt(height * width / _SAMPLES)), max(height, width) // _SAMPLES)
    sampled = reference[::step, ::step].astype(np.float64)
    found: list[tuple[float, tuple[_Part, ...]]] = []
    for turn, swap, tone in itertools.product(turns, _SWAPS, _TONES):
        turned = turn.undo(picture)[::step, ::step].astype(np.float64)
        undone = tone.undo(swap.undo(turned))
        for factor in (_NOTHING, _factor(undone, sampled), _balance(undone, sampled)):
            parts = tuple(part for part in (turn, swap, tone, factor) if part.name)
            error = factor.error(undone, sampled, tolerance)
            if swap.name and factor.numbers > 1 and not _needed(tone.undo(turned), sampled, error, tolerance):
                continue
            found.append((error, parts))
    before = error_of(picture, reference, tolerance)
    factorless = [entry for entry in found if not any(part.scales for part in entry[1])]
    for parts in {_simplest(found, before): None, _simplest(factorless, before): None}:
        if parts:
            undone = picture
            for part in parts[:-1]:
                undone = part.undo(undone)
            left = parts[-1].error(undone, reference, tolerance) / (before or 1.0)
            names, texts = " and ".join(part.name for part in parts), "; ".join(part.text for part in parts)
            shades, numbers = all(part.shades for part in parts), _numbers(parts)
            yield Cause(names, texts, left, parts[-1].undo(undone), shades=shades, numbers=numbers)


def _needed(unswapped: Array, reference: Array, error: float, tolerance: float) -> bool:
    """Whether a swap of channels with a balance, which leave `error`, do more than a balance alone.

    In a scene of one hue channels are each other's multiples: to swap them and scale them back is no change.
    """
    return 2 * error < _balance(unswapped, reference, least=0.0).error(unswapped, reference, tolerance)


def _numbers(parts: tuple[_Part, ...]) -> int:
    return sum(part.numbers for part in parts)


def _simplest(found: list[tuple[float, tuple[_Part, ...]]], before: float) -> tuple[_Part, ...]:
    """Of the combinations that do about as well as the best, the one with the fewest numbers."""
    bound = max(2 * min(error for error, _ in found), 0.02 * before)
    good = [entry for entry in found if entry[0] <= bound]
    return min(good, key=lambda entry: (_numbers(entry[1]), entry[0]))[1]


def _factor(undone: Array, reference: Array) -> _Part:
    """The factor of exposure between two pictures, from what is neither black nor clipped."""
    usable = _usable(undone) & _usable(reference)
    if np.count_nonzero(usable) < 10:
        return _NOTHING
    factor = _ratio(undone[usable], reference[usable])
    if abs(factor - 1) < _FACTOR:
        return _NOTHING
    direction = "bright" if factor > 1 else "dark"
    times = factor if factor > 1 else 1 / factor
    text = f"all of it is {times:.3g} times too {direction} ({np.log2(factor):+.2f} stops)"
    return _scaling(f"exposure factor {told(factor)}", text, np.array(factor))


def _balance(undone: Array, reference: Array, least: float = 4 * _FACTOR) -> _Part:
    """A factor for each channel; none where they are less than `least` apart."""
    factors = []
    for channel in range(3):
        a, b = undone[..., channel], reference[..., channel]
        usable = _usable(a) & _usable(b)
        if np.count_nonzero(usable) < 10:
            return _NOTHING
        factors.append(_ratio(a[usable], b[usable]))
    if np.ptp(factors) < least:
        return _NOTHING  # the factor of exposure does it
    listed = ", ".join(f"{factor:.3g}" for factor in factors)
    text = f"red, green and blue are scaled by {listed}"
    return _scaling("colour balance", text, np.array(factors))


def _ratio(a: Array, b: Array) -> float:
    """a / b of most values: that of the sums over what is near the median ratio, which bytes round least."""
    ratios = a / b
    middle = np.median(ratios)
    near = np.abs(ratios / middle - 1) < 0.1
    return float(a[near].sum() / b[near].sum())


def _scaling(name: str, text: str, factor: Array) -> _Part:
    redo = (lambda image: image * factor) if factor.max() > 1 else None
    return _Part(
        name, text, lambda image: image / factor, redo, shades=True, numbers=factor.size, scales=True
    )


def _usable(values: Array) -> Array:
    """Neither black nor clipped: radiance that goes on above white is not clipped there."""
    return (values > 0.01) & ((values < 0.97) | bool(values.max(initial=0.0) > 1))
