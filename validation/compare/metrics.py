"""How far two pictures are apart: the figures of the field, each a function of two linear pictures.

Pictures are float (h, w, 3), linear Rec.709 radiance, finite. What looks at them as an eye does (SSIM, FLIP,
PSNR) works on `encoded` pictures: sRGB values in [0, 1] as floats, never rounded to bytes.
"""

from __future__ import annotations

import importlib.util
import itertools
import math
import os
import re
from collections.abc import Iterable, Iterator
from typing import Any

import numpy as np

from clrt.base.hush import hushed
from clrt.base.install import pip_install
from clrt.base.room import check_addresses

EDGE_CHANGE = 2e-3  # a pixel that moves by more under a shift of EDGE_STEP is on an edge; `relative` above 1
EDGE_STEP = 0.05  # pixel, for one sample in each
DIAGONAL = ((1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0))
_WINDOW = 11  # of SSIM: 2 * int(3.5 * 1.5 + 0.5) + 1 pixels
BORDER = _WINDOW // 2  # pixels of a picture's border about which SSIM's windows are not whole
_BLOCK = 1 << 20  # pixels that are looked at together: figures take ten arrays of float64 of as many
HALO = 16  # pixels about a block that its figures depend on: half of FLIP's widest filter; SSIM's is 5
PLAIN = 8 / 255  # of an encoded value: what an eye sees beside what it should be
THIN = 48  # pixels of such a thing, of those within a square of 2 HALO + 1 that has them
PLACE = 3  # pixels a side of what is off in pictures that show the same; 1 more is an object
_DIM = 2.0**-8  # 13 of 255, as a screen shows it
_LEAST_HALF = 2.0**-24  # the step of the smallest floats of 16 bits
_ADDRESSES = 640 << 20  # with fewer, the linear algebra that scipy brings waits for more, without end

Array = np.ndarray
Where = tuple[slice, slice]  # rows and columns


def blocks(shape: tuple[int, ...], halo: int = HALO) -> Iterator[tuple[Where, Where]]:
    """Rows and columns to look at together: of blocks, which fill the picture, and with `halo` more around.

    Whole rows, but of pictures that are wide beyond all use: else these alone would take all memory.
    """
    height, width = shape[:2]
    least = max(2 * halo, 1)  # rows and columns: of fewer most would be halo
    columns = max(min(width, _BLOCK // least), 1)
    wide = max(columns, _WINDOW) if halo else columns  # for SSIM what is smaller than a window is widened
    rows = max(least, _BLOCK // wide)
    for top, left in itertools.product(range(0, height, rows), range(0, width, columns)):
        here = slice(top, min(top + rows, height)), slice(left, min(left + columns, width))
        upper, across = (
            slice(max(0, part.start - halo), min(part.stop + halo, side))
            for part, side in zip(here, shape, strict=False)
        )
        yield here, (upper, across)


def parts(picture: Array) -> Iterator[Array]:
    """A picture (h, w, 3), or pixels (n, 3), part by part."""
    for where, _ in blocks(picture.shape, 0):
        yield picture[where]


def encoded(linear: Array) -> Array:
    """sRGB values in [0, 1], float64, of linear ones; what is beyond is clipped (IEC 61966-2-1)."""
    linear = np.clip(np.asarray(linear, np.float64), 0.0, 1.0)
    return np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)


def extended(linear: Array) -> Array:
    """`encoded` up to white, and above it as steep as it is there: a stop is the same step at any brightness.

    sRGB's curve ends at white; for pictures whose radiance goes on, float64. Below black it is odd: what is
    less than nothing is as far from it as the same amount of light.
    """
    linear = np.asarray(linear, np.float64)
    amount = np.abs(linear)
    return np.copysign(encoded(amount) + 1.055 / 2.4 * np.log(np.maximum(amount, 1.0)), linear)


def beyond(linear: Array) -> Array:
    """What `encoded` clips off: above white what is more, below black what is less."""
    return linear - np.clip(linear, 0.0, 1.0)


def to_white(linear: Array) -> Array:
    """`extended` as far as white: what a screen shows, and what is less than nothing."""
    return np.minimum(extended(linear), encoded(linear))


def decoded(values: Array) -> Array:
    """The inverse of `encoded`."""
    values = np.clip(np.asarray(values, np.float64), 0.0, 1.0)
    return np.where(values <= 0.04045, values / 12.92, ((values + 0.055) / 1.055) ** 2.4)


def ssim(ours: Array, reference: Array) -> tuple[float, Array]:
    """Mean structural similarity (Wang et al. 2004) of encoded pictures, and its map (h, w, 3).

    Gaussian windows of sigma 1.5. Pictures smaller than a window are reflected at their borders.
    """
    check_addresses(_ADDRESSES, "scikit-image")
    from skimage.metrics import structural_similarity

    height, width = reference.shape[:2]
    missing = [(0, max(0, _WINDOW - side)) for side in (height, width)]
    if any(after for _, after in missing):
        padding = (*missing, (0, 0))
        ours, reference = (np.pad(image, padding, mode="symmetric") for image in (ours, reference))
    mean, map_ = structural_similarity(
        ours, reference, data_range=1, channel_axis=-1, gaussian_weights=True, sigma=1.5,
        use_sample_covariance=False, full=True,
    )  # fmt: skip
    return float(mean), map_[:height, :width]


def without_flip() -> str:
    """A note where FLIP's package is not installed; "" where it is. Not every Python has wheels of it."""
    if importlib.util.find_spec("flip_evaluator") is not None:
        return ""
    return (
        "FLIP was not run, the other gates decide: install it, where this Python has wheels of it (3.13 and "
        f"older): {pip_install('flip-evaluator')}"
    )


def flip(ours: Array, reference: Array) -> tuple[float, Array] | None:
    """Mean LDR-FLIP error (Andersson et al. 2020) of encoded pictures, and its map (h, w).

    None where its package is not installed; `without_flip` says so.
    """
    if without_flip():
        return None
    _bound_threads()
    with hushed():  # OpenMP complains of its other variables
        import flip_evaluator

    pictures = (np.ascontiguousarray(image, dtype=np.float32) for image in (reference, ours))
    map_, mean, _ = flip_evaluator.evaluate(*pictures, "LDR", inputsRGB=True, applyMagma=False)
    return float(mean), np.asarray(map_, np.float64).reshape(reference.shape[:2])


def _bound_threads() -> None:
    """No more threads than cores, and stacks of the usual size: FLIP's OpenMP ends the process at too many.

    OpenMP reads its variables when its library is loaded.
    """
    cores, asked = os.cpu_count() or 1, os.environ.get("OMP_NUM_THREADS")
    if asked is not None and not (re.fullmatch("[0-9]{1,6}", asked) and 0 < int(asked) <= cores):
        os.environ["OMP_NUM_THREADS"] = str(cores)
    for name in ("OMP_STACKSIZE", "GOMP_STACKSIZE", "OMP_THREAD_LIMIT"):
        os.environ.pop(name, None)


def psnr(ours: Array, reference: Array) -> float:
    """Peak signal to noise ratio of encoded pictures in dB; inf where they are equal."""
    return decibels(float(np.mean((ours - reference) ** 2)))


def decibels(square: float) -> float:
    """PSNR of a mean square of differences of encoded values: dB, inf for 0."""
    return float(-10 * np.log10(square)) if square > 0 else float("inf")


def largest(difference: Array) -> Array:
    """Of a difference (h, w, 3), each pixel's largest channel without its sign: (h, w)."""
    return np.abs(difference).max(axis=-1)


def widest(difference: Array) -> int:
    """The side of the largest square all of whose pixels are off one way, by more than PLAIN of a channel.

    difference: (h, w, 3), of `extended` pictures; up to HALO. What is not there is a place; the edges that
    two right programs draw are a pixel or two wide, and noise has no way.
    """
    off = np.concatenate([difference > PLAIN, difference < -PLAIN], axis=-1)
    side = 0
    while side < HALO and off.any():
        side += 1
        off = off[1:, 1:] & off[1:, :-1] & off[:-1, 1:] & off[:-1, :-1]
    return side


def longest(difference: Array, here: Where) -> int:
    """How many pixels off one way, by more than PLAIN of a channel, lie together in places that are at least
    two wide: the most within a square of 2 HALO + 1 pixels about one of those `here`.

    difference: (h, w, 3), of `extended` pictures. What has as many is a thin thing, which no square shows: a
    rod of a pixel and a half has them within 24.
    """
    found = 0
    for off in (difference > PLAIN, difference < -PLAIN):
        for channel in range(off.shape[-1]):
            wide = _twice_wide(off[..., channel])
            if wide.any():
                found = max(found, int(_sums_around(wide, HALO)[here].max(initial=0)))
    return found


def _twice_wide(off: Array) -> Array:
    """The pixels (h, w) of a bool array that lie in a square of 2 x 2 of them."""
    squares = np.pad(off[1:, 1:] & off[1:, :-1] & off[:-1, 1:] & off[:-1, :-1], 1)
    wide: Array = squares[1:, 1:] | squares[1:, :-1] | squares[:-1, 1:] | squares[:-1, :-1]
    return wide


def _sums_around(values: Array, reach: int) -> Array:
    """The sum (h, w) of what lies no more than `reach` rows and columns away."""
    sums = values.astype(np.int32)
    for axis in (0, 1):
        total = np.cumsum(np.pad(sums, [(reach + 1, reach) if k == axis else (0, 0) for k in (0, 1)]), axis)
        step, many = 2 * reach + 1, sums.shape[axis]
        sums = np.take(total, range(step, step + many), axis) - np.take(total, range(many), axis)
    return sums


def relative(difference: Array, reference: Array) -> Array:
    """Differences from a reference: as they are up to white, and above it as parts of it."""
    return difference / np.maximum(np.abs(reference), 1.0)


def held(values: Array, reference: Array, shared: bool = False) -> Array:
    """Values with the reference's where their file's floats, rounded or cut off, tell none apart.

    Halves have 11 bits of a value; shared: Radiance's, 8 bits of a pixel's largest channel.
    """
    out = np.array(values)
    for part, other in zip(parts(out), parts(reference), strict=True):
        most = np.maximum(np.abs(part), np.abs(other))
        step = most.max(axis=-1, keepdims=True) / 128 if shared else np.maximum(most / 1024, _LEAST_HALF)
        with np.errstate(invalid="ignore"):  # infinite ones are equal
            near = np.abs(part - other) <= step
        part[near] = other[near]
    return out


def brightening(reference: Array) -> float:
    """By what a dim picture and its reference are to be multiplied before they are compared, a power of two.

    Figures are made for what a screen shows: to them radiance of 1e-5 and black are one, though floats hold
    it as well as any. 1 where more than a hundredth of all pixels that are lit reach 1/256.
    """
    most = np.concatenate([largest(part).ravel() for part in parts(np.asarray(reference))])
    lit = most[(most > 0) & np.isfinite(most)]
    level = float(np.quantile(lit, 0.99)) if lit.size else 1.0
    return 1.0 if level >= _DIM else float(2.0 ** min(-math.frexp(level)[1], 120))


def share(flags: Any) -> float:
    """The share of True; 0 of nothing."""
    return float(np.mean(flags)) if np.size(flags) else 0.0


def edge_mask(reference: Array, moved: Iterable[Array]) -> Array:
    """Pixels (h, w) where the reference differs by more than EDGE_CHANGE from one of its moved pictures.

    The pictures are the oracle's own, its samples moved by EDGE_STEP pixel towards each of DIAGONAL.
    """
    mask = np.zeros(reference.shape[:2], bool)
    for picture in moved:
        mask |= largest(relative(picture - reference, reference)) > EDGE_CHANGE
    return mask


def steep(reference: Array) -> Array:
    """An edge mask (h, w) from a picture alone: its neighbours say how fast it changes.

    For pictures that nobody can render again; wider than `edge_mask`: an edge lies between two pixels.
    """
    change = np.zeros(reference.shape[:2])
    for axis in (0, 1):
        step = largest(relative(np.diff(reference, axis=axis), np.delete(reference, -1, axis)))
        first, last = [slice(None)] * 2, [slice(None)] * 2
        first[axis], last[axis] = slice(0, -1), slice(1, None)
        change[tuple(first)] = np.maximum(change[tuple(first)], step)
        change[tuple(last)] = np.maximum(change[tuple(last)], step)
    return change * EDGE_STEP > EDGE_CHANGE
