"""Why two pictures differ: usual mistakes, each tried by undoing it and looking whether the error vanishes.

Nothing is guessed from the look of a picture. A cause is a change that can be undone (turn the picture back,
take a curve off, divide by a factor, move it by half a pixel); what is named is the simplest combination that
leaves next to nothing of the error. Causes that need the scene (a light, a shadow, an object) are in
`compare_scene`.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np

from .compare_metrics import Array, decoded, encoded

VANISHED = 0.1  # a cause is proven when undoing it leaves no more of the error
LIKELY = 0.5  # ... and likely when it leaves no more than this
BYTE = 1.5 / 255  # tolerance for pictures of 8 bits, in encoded values; rounding, and curves that magnify it
FLOAT = 1e-4  # tolerance for pictures of floats
_SAMPLES = 4000  # pixels that combinations are tried on
_FACTOR = 0.005  # a factor nearer to 1 is none


@dataclass(frozen=True)
class Cause:
    """A mistake that would explain a picture."""

    name: str  # "vertical flip"; combinations joined by " and "
    text: str  # what was done wrong, for the picture's author
    left: float  # share of the error that is left when it is undone: 0 explains all
    undone: Array | None = None  # the picture with the mistake undone
    certain: bool = True  # False: what was tested must hold for this cause, but could hold for others

    @property
    def proven(self) -> bool:
        return self.certain and self.left <= VANISHED

    @property
    def likely(self) -> bool:
        return self.left <= LIKELY


@dataclass(frozen=True)
class _Part:
    """One thing to undo; the first of each family does nothing."""

    name: str
    text: str
    undo: Callable[[Array], Array]
    redo: Callable[[Array], Array] | None = None  # on the reference: undoing cannot bring back what clipped

    def error(self, picture: Array, reference: Array, tolerance: float) -> float:
        """The disagreement once this is undone, or the reference has it too."""
        if self.redo:
            return disagreement(picture, self.redo(reference), tolerance)
        return disagreement(self.undo(picture), reference, tolerance)


_NOTHING = _Part("", "", lambda image: image)
_TURNS = (
    _NOTHING,
    _Part("horizontal flip", "left and right are swapped", lambda image: image[:, ::-1]),
    _Part("vertical flip", "top and bottom are swapped: y points the other way, or rows start at the bottom",
          lambda image: image[::-1]),
    _Part("rotation by 180 degrees", "both axes point the other way", lambda image: image[::-1, ::-1]),
    _Part("transpose", "rows and columns are swapped: pixels are indexed [x][y]",
          lambda image: image.swapaxes(0, 1)),
    _Part("rotation by 90 degrees to the right", "it lies on its side", lambda image: np.rot90(image, 1)),
    _Part("rotation by 90 degrees to the left", "it lies on its side", lambda image: np.rot90(image, -1)),
    _Part("transpose about the other diagonal", "rows and columns are swapped and turned",
          lambda image: image[::-1, ::-1].swapaxes(0, 1)),
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
    _Part("sRGB applied twice", "the sRGB curve is applied two times: the picture is washed out", decoded),
    _Part("sRGB not applied", "linear values stand where sRGB ones belong: the picture is too dark",
          encoded),
    _Part("gamma 2.2 in place of sRGB", "a power of 1/2.2 is used, not the sRGB curve",
          lambda image: encoded(image) ** 2.2),
    _Part("negative", "the picture is inverted", lambda image: decoded(1 - encoded(image))),
)


def tolerance_of(*pictures: Array) -> float:
    """BYTE where a picture looks as if it came from a file of 8 bits, else FLOAT."""
    for picture in pictures:
        steps = encoded(picture) * 255
        if np.abs(steps - np.round(steps)).max(initial=0.0) < 1e-3 and picture.max(initial=0.0) <= 1:
            return BYTE
    return FLOAT


def disagreement(picture: Array, reference: Array, tolerance: float) -> float:
    """Mean difference of encoded values beyond the tolerance: 0 for pictures that agree."""
    return float(np.mean(np.maximum(np.abs(encoded(picture) - encoded(reference)) - tolerance, 0.0)))


def explain(picture: Array, reference: Array, tolerance: float) -> list[Cause]:
    """Causes for the difference of two linear pictures (h, w, 3) of any sizes, the best first.

    [] where they agree within the tolerance or nothing helps.
    """
    if picture.shape == reference.shape and disagreement(picture, reference, tolerance) == 0:
        return []
    causes = [*_combined(picture, reference, tolerance), *_moved(picture, reference, tolerance),
              *_resized(picture, reference, tolerance)]
    return ranked([cause for cause in causes if cause.likely or picture.shape != reference.shape])


def ranked(causes: list[Cause]) -> list[Cause]:
    """Each name once, proven ones first, then by how much they explain."""
    causes = sorted(causes, key=lambda cause: (not cause.proven, cause.left))
    return list({cause.name: cause for cause in reversed(causes)}.values())[::-1]


def remaining(undone: Array, reference: Array, before: float, tolerance: float) -> float:
    """Share of the error `before` that is left."""
    return disagreement(undone, reference, tolerance) / before if before else 1.0


def _combined(picture: Array, reference: Array, tolerance: float) -> Iterator[Cause]:
    """The simplest of the best combinations of a turn, a swap of channels, a curve and a factor."""
    turns = [turn for turn in _TURNS if turn.undo(picture).shape == reference.shape]
    if not turns:
        return
    step = max(1, int(np.sqrt(reference.shape[0] * reference.shape[1] / _SAMPLES)))
    sampled = reference[::step, ::step]
    found: list[tuple[float, tuple[_Part, ...]]] = []
    for turn, swap, tone in itertools.product(turns, _SWAPS, _TONES):
        undone = tone.undo(swap.undo(turn.undo(picture)[::step, ::step]))
        for factor in (_NOTHING, _factor(undone, sampled), _balance(undone, sampled)):
            parts = tuple(part for part in (turn, swap, tone, factor) if part.name)
            found.append((factor.error(undone, sampled, tolerance), parts))
    before = _reference_error(picture, reference, tolerance)
    least = min(error for error, _ in found)
    # of those that do about as well, the one with the fewest parts
    bound = max(2 * least, 0.02 * before)
    good = [entry for entry in found if entry[0] <= bound]
    parts = min(good, key=lambda entry: (len(entry[1]), entry[0]))[1]
    if parts:
        undone = picture
        for part in parts[:-1]:
            undone = part.undo(undone)
        left = parts[-1].error(undone, reference, tolerance) / (before or 1.0)
        names, texts = " and ".join(part.name for part in parts), "; ".join(part.text for part in parts)
        yield Cause(names, texts, left, parts[-1].undo(undone))


def _reference_error(picture: Array, reference: Array, tolerance: float) -> float:
    """The error that a cause has to explain; of pictures that do not fit, that of a mean grey."""
    fits = picture.shape == reference.shape
    return disagreement(picture if fits else np.full_like(reference, reference.mean()), reference, tolerance)


def _factor(undone: Array, reference: Array) -> _Part:
    """The factor of exposure between two pictures: the median over what is neither black nor clipped."""
    usable = _usable(undone) & _usable(reference)
    if np.count_nonzero(usable) < 10:
        return _NOTHING
    factor = float(np.median(undone[usable] / reference[usable]))
    if abs(factor - 1) < _FACTOR:
        return _NOTHING
    direction = "bright" if factor > 1 else "dark"
    times = factor if factor > 1 else 1 / factor
    text = f"all of it is {times:.3g} times too {direction} ({np.log2(factor):+.2f} stops)"
    return _scaling(f"exposure factor {factor:.3g}", text, np.array(factor))


def _balance(undone: Array, reference: Array) -> _Part:
    """A factor for each channel."""
    factors = []
    for channel in range(3):
        a, b = undone[..., channel], reference[..., channel]
        usable = _usable(a) & _usable(b)
        if np.count_nonzero(usable) < 10:
            return _NOTHING
        factors.append(float(np.median(a[usable] / b[usable])))
    if np.ptp(factors) < 4 * _FACTOR:
        return _NOTHING  # the factor of exposure does it
    listed = ", ".join(f"{factor:.3g}" for factor in factors)
    return _scaling("colour balance", f"red, green and blue are scaled by {listed}", np.array(factors))


def _scaling(name: str, text: str, factor: Array) -> _Part:
    return _Part(name, text, lambda image: image / factor,
                 (lambda image: image * factor) if factor.max() > 1 else None)


def _usable(values: Array) -> Array:
    return (values > 0.01) & (values < 0.97)


def _moved(picture: Array, reference: Array, tolerance: float) -> Iterator[Cause]:
    """A shift by whole or half pixels, found by phase correlation."""
    if picture.shape != reference.shape or min(picture.shape[:2]) < 8:
        return
    from skimage.registration import phase_cross_correlation

    grey = [encoded(image).mean(axis=-1) for image in (reference, picture)]
    estimate = phase_cross_correlation(*grey, upsample_factor=10)[0]
    near = {tuple(np.round(2 * estimate) / 2)} | {tuple(np.round(estimate))}
    steps = (-0.5, 0.0, 0.5)
    candidates = {(y, x) for y in steps for x in steps} | {(float(-y), float(-x)) for y, x in near}
    largest = max(picture.shape[:2]) / 4
    best: tuple[float, tuple[float, float]] | None = None
    for shift in sorted(candidates):
        if shift == (0.0, 0.0) or max(map(abs, shift)) > largest:
            continue
        before, after = _shift_errors(picture, reference, shift, tolerance)
        if before and (best is None or after / before < best[0]):
            best = after / before, shift
    if best:
        left, (y, x) = best
        words = [f"{abs(v):g} pixel{'s' if abs(v) > 1 else ''} {way[v > 0]}"
                 for v, way in ((x, ("left", "right")), (y, ("up", "down"))) if v]
        whole = all(v == int(v) for v in (x, y))
        text = "the picture is moved" if whole else "samples are not at the pixels' centres"
        yield Cause(f"shift by {' and '.join(words)}", text, left)


def _shift_errors(
    picture: Array, reference: Array, shift: tuple[float, float], tolerance: float
) -> tuple[float, float]:
    """Errors before and after `picture`, moved by `shift` = (y, x), is moved back, where both have pixels.

    Half a pixel is a mean of two; the other picture is blurred the same way, and for "before" both are.
    """
    a, b = np.asarray(picture, np.float64), np.asarray(reference, np.float64)
    still_a, still_b = a, b
    for axis, distance in enumerate(shift):
        whole, half = int(np.floor(abs(distance))), abs(distance) % 1 > 0
        if half:  # a[i] is b between i and i - 1: means of a's and b's neighbours meet a quarter off each
            a, still_a = _quarter(a, axis, distance > 0), _quarter(still_a, axis, distance > 0)
            b, still_b = _quarter(b, axis, distance < 0), _quarter(still_b, axis, distance > 0)
        if whole:
            ahead, behind = _cut(a, axis, whole, None), _cut(b, axis, 0, -whole)
            if distance < 0:
                ahead, behind = _cut(a, axis, 0, -whole), _cut(b, axis, whole, None)
            a, b = ahead, behind
    return disagreement(still_a, still_b, tolerance), disagreement(a, b, tolerance)


def _quarter(image: Array, axis: int, forwards: bool) -> Array:
    """The image sampled a quarter pixel further (or less far) along an axis; a pixel shorter at each end."""
    middle, ahead, behind = _cut(image, axis, 1, -1), _cut(image, axis, 2, None), _cut(image, axis, 0, -2)
    return 0.75 * middle + 0.25 * (ahead if forwards else behind)


def _cut(image: Array, axis: int, start: int, stop: int | None) -> Array:
    where = [slice(None)] * image.ndim
    where[axis] = slice(start, stop)
    return image[tuple(where)]


def _resized(picture: Array, reference: Array, tolerance: float) -> Iterator[Cause]:
    """Another size: the same view in other pixels, or a part of the reference (or the reverse)."""
    if picture.shape == reference.shape:
        return
    from skimage.transform import resize

    before = _reference_error(picture, reference, tolerance)
    sizes = f"{picture.shape[1]} x {picture.shape[0]} in place of {reference.shape[1]} x {reference.shape[0]}"
    scaled = resize(picture, reference.shape, order=1, anti_aliasing=True)
    left = remaining(scaled, reference, before, tolerance)
    yield Cause("another size", f"the same view in {sizes} pixels", left, scaled)
    small, large = sorted((picture, reference), key=lambda image: image.shape[0])
    if small.shape[0] <= large.shape[0] and small.shape[1] <= large.shape[1] and min(small.shape[:2]) >= 8:
        from skimage.feature import match_template

        score = match_template(encoded(large).mean(axis=-1), encoded(small).mean(axis=-1))
        y, x = (int(v) for v in np.unravel_index(np.argmax(score), score.shape))
        part = large[y : y + small.shape[0], x : x + small.shape[1]]
        left = disagreement(small, part, tolerance) / before if before else 1.0
        name = "cropped" if small is picture else "larger view"
        part_of = ("the picture", "the reference") if small is picture else ("the reference", "the picture")
        yield Cause(name, f"{part_of[0]} is a part of {part_of[1]}, from pixel ({x}, {y}) on: {sizes}", left)
