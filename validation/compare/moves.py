"""Causes that move pixels: a shift by whole or half pixels, another size, a part of the picture."""

from __future__ import annotations

import itertools
from collections.abc import Iterator

import numpy as np

from .causes import Cause, disagreement, error_of, remaining
from .metrics import Array, encoded

_SEARCHED = 1 << 18  # pixels: of larger pictures means are compared; a template takes 900 bytes a pixel
_FEWER = 32  # times the pixels a side that a picture is shrunk from: a filter's window grows as they do
_TRIED = 128  # pixels a side that tell by how many pixels those means are off


def moved(picture: Array, reference: Array, tolerance: float) -> Iterator[Cause]:
    """A shift by whole or half pixels, found by phase correlation."""
    if picture.shape != reference.shape or min(picture.shape[:2]) < 8:
        return
    from skimage.registration import phase_cross_correlation

    grey = [encoded(image).mean(axis=-1) for image in (reference, picture)]
    if any(np.ptp(image) == 0 for image in grey):  # nothing in it that could be moved
        return
    estimate = phase_cross_correlation(*grey, upsample_factor=10)[0]
    near = {tuple(np.round(2 * estimate) / 2)} | {tuple(np.round(estimate))}
    steps = (-0.5, 0.0, 0.5)
    candidates = {(y, x) for y in steps for x in steps} | {(float(-y), float(-x)) for y, x in near}
    largest = max(picture.shape[:2]) / 4
    errors: dict[tuple[float, float], tuple[float, float]] = {}
    for shift in candidates - {(0.0, 0.0)}:
        if max(map(abs, shift)) <= largest:
            errors[shift] = _shift_errors(picture, reference, shift, tolerance)
    shares = {shift: after / before for shift, (before, after) in sorted(errors.items()) if before}
    if shares:
        y, x = min(shares, key=lambda shift: shares[shift])
        left = shares[y, x]
        words = [
            f"{abs(v):g} pixel{'s' if abs(v) > 1 else ''} {way[v > 0]}"
            for v, way in ((x, ("left", "right")), (y, ("up", "down")))
            if v
        ]
        whole = all(v == int(v) for v in (x, y))
        far = max(abs(x), abs(y)) > 1
        text = "the picture is moved" if whole or far else "samples are not at the pixels' centres"
        # hard edges let no half pixel vanish; but only a shift is better one way and worse the other
        hinted = left < 1 and (-y, -x) in errors and errors[y, x][1] < 0.6 * errors[-y, -x][1]
        yield Cause(f"shift by {' and '.join(words)}", text, left, hinted=hinted, blurs=not whole)


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


def resized(picture: Array, reference: Array, tolerance: float) -> Iterator[Cause]:
    """Another size: the same view in other pixels, or a part of the reference (or the reverse).

    Large pictures are looked at in means over squares of pixels.
    """
    if picture.shape == reference.shape:
        return
    from skimage.transform import resize

    # the second is of pictures thinner than that square: they are means along their length alone
    pixels, longest = max(picture.size, reference.size) / 3, max(*picture.shape, *reference.shape)
    side = int(np.ceil(max(np.sqrt(pixels / _SEARCHED), longest / _SEARCHED)))
    a, b = _means(picture, side, side), _means(reference, side, side)
    before = error_of(a, b, tolerance)
    sizes = f"{picture.shape[1]} x {picture.shape[0]} in place of {reference.shape[1]} x {reference.shape[0]}"
    rows, columns = (have // (_FEWER * want) for have, want in zip(a.shape[:2], b.shape[:2], strict=True))
    scaled = resize(_means(a, rows, columns), b.shape, order=1, anti_aliasing=True)
    left = remaining(scaled, b, before, tolerance)
    yield Cause("another size", f"the same view in {sizes} pixels", left)
    small, large = sorted((picture, reference), key=lambda image: image.shape[0])
    fits = small.shape[0] <= large.shape[0] and small.shape[1] <= large.shape[1]
    if fits and min(small.shape[:2]) >= 8 * side:
        y, x = _place(small, large, side, tolerance)
        part = large[y : y + small.shape[0], x : x + small.shape[1]]
        left = disagreement(small, part, tolerance) / before if before else 1.0
        name = "cropped" if small is picture else "larger view"
        part_of = ("the picture", "the reference") if small is picture else ("the reference", "the picture")
        yield Cause(name, f"{part_of[0]} is a part of {part_of[1]}, from pixel ({x}, {y}) on: {sizes}", left)


def _means(picture: Array, rows: int, columns: int) -> Array:
    """Means over so many pixels, or all there are; what is left over right and below is left out."""
    wanted = zip((rows, columns), picture.shape[:2], strict=True)
    rows, columns = (min(max(count, 1), length) for count, length in wanted)
    if rows == columns == 1:
        return picture
    height, width = picture.shape[0] // rows, picture.shape[1] // columns
    whole = picture[: height * rows, : width * columns]
    return whole.reshape(height, rows, width, columns, 3).mean(axis=(1, 3))


def _place(small: Array, large: Array, side: int, tolerance: float) -> tuple[int, int]:
    """Row and column from which `small` is most like a part of `large`: among means, then pixel by pixel."""
    from skimage.feature import match_template

    grey = [encoded(_means(image, side, side)).mean(axis=-1) for image in (large, small)]
    score = match_template(*grey)
    near = [side * int(v) for v in np.unravel_index(np.argmax(score), score.shape)]
    if side == 1:
        return near[0], near[1]
    height, width = (min(length, _TRIED) for length in small.shape[:2])
    top, left = (small.shape[0] - height) // 2, (small.shape[1] - width) // 2
    tried = small[top : top + height, left : left + width]
    rows, columns = (
        [at for at in range(place - side, place + side + 1) if 0 <= at <= big - little]
        for place, big, little in zip(near, large.shape, small.shape, strict=False)
    )

    def off(place: tuple[int, int]) -> float:
        y, x = place[0] + top, place[1] + left
        return disagreement(tried, large[y : y + height, x : x + width], tolerance)

    return min(itertools.product(rows, columns), key=off)
