"""The figures of two pictures of one size, and the gates on them, block by block: pictures may be large."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from ..types import Gate
from .causes import BYTE
from .metrics import (
    BORDER,
    PLACE,
    THIN,
    Array,
    Where,
    blocks,
    decibels,
    encoded,
    extended,
    flip,
    largest,
    longest,
    share,
    ssim,
    to_white,
    widest,
)
from .oracle import gate, limits

FEWEST = 0.25  # of the pixels that have to be left for a verdict, where edges are left out
_BRIGHT = "PSNR above white"


@dataclass
class _Sums:
    """What blocks add up to, over the pixels that count; of differences the largest channel's."""

    pixels: int = 0
    light: Array = field(default_factory=lambda: np.zeros(2))
    squares: float = 0.0
    bright_squares: float = 0.0
    differ: int = 0
    off: float = 0.0
    largest_off: float = 0.0
    shown_off: float = 0.0
    largest_shown: float = 0.0
    windows: float = 0.0
    inner: int = 0
    worst: float = 1.0
    widest: int = 0
    longest: int = 0
    perceived: float | None = 0.0

    def add_values(self, a: Array, b: Array, tolerance: float) -> None:
        """Those of pixels (n, 3) each by itself."""
        beyond_a, beyond_b = extended(a), extended(b)
        off, shown_off = largest(a - b), largest(beyond_a - beyond_b)
        self.pixels += len(a)
        self.light += a.sum(), b.sum()
        self.squares += float(np.square(to_white(a) - to_white(b)).sum())
        self.bright_squares += float(np.square(np.maximum(beyond_a, 1.0) - np.maximum(beyond_b, 1.0)).sum())
        self.differ += int(np.count_nonzero(shown_off > tolerance))
        self.off, self.shown_off = self.off + float(off.sum()), self.shown_off + float(shown_off.sum())
        self.largest_off = max(self.largest_off, float(off.max(initial=0.0)))
        self.largest_shown = max(self.largest_shown, float(shown_off.max(initial=0.0)))

    def add_seen(self, a: Array, b: Array, here: Where, out: Array, inner: Array) -> None:
        """Those of encoded pixels in their surroundings: `here` of a, b, the others are their halo.

        out, inner (as large as `here`): which count, and for SSIM's mean.
        """
        windows = ssim(a, b)[1][here]
        self.windows += float(windows[inner].sum())
        self.inner += int(np.count_nonzero(inner))
        self.worst = min(self.worst, float(windows[out].min(initial=1.0)))
        seen = flip(a, b)
        if seen is None or self.perceived is None:
            self.perceived = None
        else:
            self.perceived += float(seen[1][here][out].sum())

    def metrics(self) -> dict[str, float]:
        """Figures by their names; where nothing counts, those of pictures that agree."""
        count, (light_a, light_b) = max(self.pixels, 1), self.light
        return {
            "SSIM": self.windows / (3 * self.inner) if self.inner else 1.0,
            **({} if self.perceived is None else {"FLIP": self.perceived / count}),
            "PSNR": decibels(self.squares / (3 * count)),
            "worst window": self.worst,
            "widest place": self.widest,
            "thin place": self.longest,
            "largest difference": self.largest_off,
            "mean difference": self.off / count,
            "largest, of 255": 255 * self.largest_shown,
            "mean, of 255": 255 * self.shown_off / count,
            "pixels that differ": self.differ / count,
            "brightness": float(light_a / light_b) if light_b else float("inf") if light_a else 1.0,
        }


def measured(a: Array, b: Array, mask: Array, tolerance: float) -> tuple[dict[str, float], tuple[Gate, ...]]:
    """Figures and gates of two finite pictures (h, w, 3) of one size.

    mask (h, w): edges. They count nowhere: what looks at a pixel's surroundings sees the reference there.
    """
    sums, inner = _Sums(), ~mask
    for axis, side in enumerate(mask.shape):
        if side > 2 * BORDER:  # SSIM's mean leaves out windows that reach beyond the picture, as usual
            np.moveaxis(inner, axis, 0)[[*range(BORDER), *range(-BORDER, 0)]] = False
    for block, around in blocks(mask.shape):
        rows, columns = (
            slice(part.start - wider.start, part.stop - wider.start)
            for part, wider in zip(block, around, strict=True)
        )
        here = rows, columns
        right = b[around].astype(np.float64)
        ours = np.where(mask[around][..., None], right, a[around].astype(np.float64))
        out = ~mask[block]
        sums.add_values(ours[here][out], right[here][out], tolerance)
        sums.add_seen(encoded(ours), encoded(right), here, out, inner[block])
        difference = extended(ours) - extended(right)
        sums.widest = max(sums.widest, widest(difference))
        sums.longest = max(sums.longest, longest(difference, here))
    metrics = {**sums.metrics(), "edges left out": share(mask)}
    if max(a.max(initial=0.0), b.max(initial=0.0)) > 1:
        metrics[_BRIGHT] = decibels(sums.bright_squares / (3 * max(sums.pixels, 1)))
    return metrics, _gates(metrics, bool(mask.any()), tolerance)


def _gates(metrics: dict[str, float], masked: bool, tolerance: float) -> tuple[Gate, ...]:
    limit = limits()
    assert limit.ssim and limit.flip and limit.psnr
    found = [gate("SSIM", metrics["SSIM"], limit.ssim, "high", "structural similarity, 1 is equal")]
    if "FLIP" in metrics:
        seen = "difference that an eye sees, 0 is equal"
        found.append(gate("FLIP", metrics["FLIP"], limit.flip, "low", seen))
    found.append(gate("PSNR", metrics["PSNR"], limit.psnr, "high", "signal to noise in dB, inf is equal"))
    if _BRIGHT in metrics:
        bright = "of what is brighter than white, where the others are blind"
        found.append(gate(_BRIGHT, metrics[_BRIGHT], limit.psnr, "high", bright))
    place = "pixels a side of what is off by more than 8 of 255"
    found.append(gate("widest place", metrics["widest place"], PLACE, "low", place))
    thin = "pixels of a place two or more wide that is off by more than 8 of 255"
    found.append(gate("thin place", metrics["thin place"], THIN, "low", thin))
    if masked:
        bound = 0.001 if tolerance < BYTE else 0.01
        found.append(gate("pixels that differ", metrics["pixels that differ"], bound, "low", "outside edges"))
        left = "what is an edge is not judged"
        found.append(gate("edges left out", metrics["edges left out"], 1 - FEWEST, "low", left))
    return tuple(found)
