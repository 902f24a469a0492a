"""Causes in how a picture was stored or shown: compression as a JPEG, a tone curve of its own."""

from __future__ import annotations

import io
import itertools
from collections.abc import Callable, Iterator

import numpy as np

from clrt.images.file import decode, encode

from .causes import VANISHED, Cause, disagreement, error_of, remaining, told
from .metrics import Array, beyond, decoded, encoded

_QUALITIES = (95, 90, 80, 70, 60, 50, 40, 30, 20, 10)
_SUBSAMPLINGS = (2, 0)  # of colour, as Pillow counts: halved both ways (what most programs do), not at all
_SEARCHED = 256  # pixels a side that qualities are tried on, in whole blocks of 16
_BINS = 256
_ONE_BIN = 0.8  # of what a curve moves: more of it in one bin, and it is none
_SAMPLES = 4000  # pixels that kinds of grey are tried on
_NO_COLOUR = 0.03  # of the colour: what is left of it in a grey picture
_ALL_COLOUR = 0.02  # of it: what is nearer to all of it is no cause
_WEIGHTS = ((0.2126, 0.7152, 0.0722), (0.299, 0.587, 0.114), (1 / 3, 1 / 3, 1 / 3))  # of channels in a grey
_SHOWN = (0.25, 0.5, 0.75)  # encoded values whose place on a curve is told
_Curve = Callable[[Array], Array]


def clipped(picture: Array, reference: Array, tolerance: float) -> Iterator[Cause]:
    """The reference as a file of integers, or a screen, holds it."""
    if picture.shape != reference.shape or beyond(picture).any() or not beyond(reference).any():
        return
    left = remaining(picture, np.clip(reference, 0, 1), error_of(picture, reference, tolerance), tolerance)
    yield Cause("clipped", "what is brighter than white, or below black, is cut off", left)


def compressed(picture: Array, reference: Array, tolerance: float) -> Iterator[Cause]:
    """The reference as a JPEG of the quality that comes nearest to the picture."""
    if picture.shape != reference.shape or min(picture.shape[:2]) < 16 or (picture == picture[0, 0]).all():
        return  # a picture of one colour tells nothing
    before = error_of(picture, reference, tolerance)
    bytes_, where = encode(reference), _middle(reference)
    errors: dict[tuple[int, int], float] = {}

    def try_(quality: int, subsampling: int) -> None:
        if (quality, subsampling) not in errors:
            stored = _as_jpeg(bytes_[where], quality, subsampling)
            errors[quality, subsampling] = disagreement(picture[where], stored, tolerance)

    for subsampling in _SUBSAMPLINGS:
        for quality in _QUALITIES:
            try_(quality, subsampling)
    for step in (4, 2, 1):
        best, subsampling = min(errors, key=lambda entry: errors[entry])
        for quality in (best - step, best + step):
            if 1 <= quality <= 100:
                try_(quality, subsampling)
    quality, subsampling = min(errors, key=lambda entry: errors[entry])
    left = disagreement(picture, _as_jpeg(bytes_, quality, subsampling), tolerance) / (before or 1.0)
    text = f"the picture was stored as a JPEG of quality {quality} or so; PNG and EXR lose nothing"
    yield Cause("JPEG compression", text, left)


def _middle(pixels: Array) -> tuple[slice, slice]:
    """The middle of a picture, beginning with a whole block."""
    sides = []
    for side in pixels.shape[:2]:
        start = max(0, (side - _SEARCHED) // 2 // 16 * 16)
        sides.append(slice(start, start + _SEARCHED if start else None))
    return sides[0], sides[1]


def _as_jpeg(bytes_: Array, quality: int, subsampling: int) -> Array:
    """8-bit pixels (h, w, 3) through a JPEG, as linear radiance."""
    from PIL import Image

    file = io.BytesIO()
    Image.fromarray(np.ascontiguousarray(bytes_)).save(file, "JPEG", quality=quality, subsampling=subsampling)
    return decode(np.asarray(Image.open(file))).astype(np.float64)


def recurved(picture: Array, reference: Array, tolerance: float) -> Iterator[Cause]:
    """One rising curve for all channels, fitted; told only where it explains nearly all.

    Whatever lacks light is darker, too, so that a curve explains a part of many other mistakes.
    """
    from scipy.optimize import isotonic_regression

    if picture.shape != reference.shape:
        return
    before = error_of(picture, reference, tolerance)
    shown, wanted = encoded(picture).ravel(), encoded(reference).ravel()
    bins = np.minimum((shown * _BINS).astype(int), _BINS - 1)
    counts = np.bincount(bins, minlength=_BINS)
    used = counts > 0
    at = np.bincount(bins, shown, _BINS)[used] / counts[used]
    means = np.bincount(bins, wanted, _BINS)[used] / counts[used]
    curve = isotonic_regression(means, weights=counts[used].astype(float)).x
    undone = decoded(np.interp(shown, at, curve)).reshape(picture.shape) + beyond(picture)
    left = disagreement(undone, reference, tolerance) / (before or 1.0)
    moved = counts[used] * np.abs(means - at)
    one_bin = moved.max() > _ONE_BIN * moved.sum()  # a hole, or shadows that are black
    one_value = np.ptp(curve) <= 1 / _BINS
    if left <= VANISHED and used.sum() > 2 and not one_bin and not one_value:
        found = np.interp(_SHOWN, curve, at)
        told = ", ".join(f"{value:g} is {place:.2f}" for value, place in zip(_SHOWN, found, strict=True))
        text = f"values pass through another curve (of encoded values from 0 to 1, {told})"
        yield Cause("another tone curve", text, left, undone, shades=True, numbers=_BINS)


def faded(picture: Array, reference: Array, tolerance: float) -> Iterator[tuple[Cause, Array]]:
    """The reference with less colour, or more, or none, and how it then looks.

    All greys that are in use are tried: of linear values and of stored ones, by the weights of Rec. 709, of
    Rec. 601, and their mean.
    """
    if picture.shape != reference.shape or _without_colour(reference, tolerance):
        return
    grey = _without_colour(picture, tolerance)
    step = max(1, int(np.sqrt(reference.shape[0] * reference.shape[1] / _SAMPLES)))
    sampled = picture[::step, ::step], reference[::step, ::step]
    least = error_of(*sampled, tolerance)
    found = []
    for curves, weights in itertools.product(((_linear, _linear), (encoded, decoded)), _WEIGHTS):
        amount = 0.0 if grey else _colour_left(*sampled, curves[0], weights)
        looks = _with_colour(sampled[1], amount, curves, weights)
        if grey:  # how bright it is tells nothing of the weights
            looks = looks * (sampled[0].mean() / max(looks.mean(), 1e-9))
        found.append((remaining(sampled[0], looks, least, tolerance), amount, curves, weights))
    left, amount, curves, weights = min(found, key=lambda entry: entry[0])
    if not grey and (left > VANISHED or abs(amount - 1) < _ALL_COLOUR):
        return
    looks = _with_colour(reference, amount, curves, weights)
    left = remaining(picture, looks, error_of(picture, reference, tolerance), tolerance)
    name, text = "in grey", "all channels are alike: there is no colour"
    if amount > 0.0:
        name = f"saturation times {told(amount)}"
        text = f"colours are {amount:.3g} times as far from grey as they should be"
    yield Cause(name, text, left, shades=True), looks


def _without_colour(picture: Array, tolerance: float) -> bool:
    return bool((np.ptp(encoded(picture), axis=-1) <= tolerance).all())


def _linear(values: Array) -> Array:
    return values


def _colour_left(picture: Array, reference: Array, curve: _Curve, weights: tuple[float, ...]) -> float:
    """How far the picture's colours are from the reference's greys, as a share of how far they should be."""
    grey = (curve(reference) @ np.array(weights))[..., None]
    colour = curve(reference) - grey
    square = float((colour**2).sum())
    amount = float((colour * (curve(picture) - grey)).sum()) / square if square else 1.0
    return 0.0 if amount < _NO_COLOUR else amount


def _with_colour(
    reference: Array, amount: float, curves: tuple[_Curve, _Curve], weights: tuple[float, ...]
) -> Array:
    shown = curves[0](reference)
    grey = (shown @ np.array(weights))[..., None]
    clipped_off = beyond(reference) if curves[0] is encoded else 0.0
    return curves[1](grey + amount * (shown - grey)) + clipped_off
