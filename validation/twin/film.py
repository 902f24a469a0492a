"""The float32 twin's film: sums of what rays bring to their pixels, and the layers."""

from __future__ import annotations

import re

import numpy as np

from clrt import layout
from clrt.base import layers
from clrt.base.layers import Paths, Term, comes_from
from clrt.spectra.colorimetry import finished

from .local import SPAWN, Feelers, Shaded
from .math import Array
from .queues import Queue

# layers of all generations: rays whose path word & mask == value
_BY_PATH = {
    "image": (0, 0),
    "direct": (layout.PATH["PATH_ROUTE"], 0),
    "reflection": (layout.PATH["PATH_ROUTE"], 1),
    "transmission": (layout.PATH["PATH_ROUTE"], 2),
    "ambient": (layout.PATH["PATH_GATHERED_FIRST"], layout.PATH["PATH_GATHERED_FIRST"]),
}
TERMS = {name: layout.TERMS[f"TERM_{name.upper()}"] for name in layers.TERMS}


class Film:
    """Planes (bands, pixels) of sums: the picture, then the layers of radiance among `names`.

    weights (pixels, samples): what samples count for in their pixels; they are then summed apart.
    """

    def __init__(
        self,
        pixels: int,
        names: tuple[str, ...] = (),
        bands: int = layout.BANDS,
        weights: Array | None = None,
    ) -> None:
        self.weights = weights
        pixels = pixels if weights is None else weights.size
        self.planes = ("image", *(name for name in names if comes_from(name, Paths, Term)))
        self.sums = np.zeros((len(self.planes), bands, pixels), np.float32)

    def add(self, queue: Queue, found: Shaded, shadows: Feelers, generation: int) -> None:
        """What a queue brings, to the picture and to every layer it belongs to."""
        value = arriving(found, shadows)
        for plane, name in enumerate(self.planes):
            numbered = re.fullmatch(r"generation_(\d+)", name)
            if name in _BY_PATH or (numbered and int(numbered.group(1)) == generation):
                mask, match = _BY_PATH.get(name, (0, 0))
                self._put(plane, queue, value, queue.path & np.uint32(mask) == match)

    def add_term(self, name: str, queue: Queue, found: Shaded, shadows: Feelers) -> None:
        """What one term of generation 0 brings, to its layer."""
        self._put(self.planes.index(name), queue, arriving(found, shadows), np.ones(len(queue), bool))

    def _put(self, plane: int, queue: Queue, value: Array, chosen: Array) -> None:
        """A pixel's rays are summed in the order of the queue, and that sum is added."""
        total = np.zeros_like(self.sums[plane])
        for band in range(len(total)):
            np.add.at(total[band], queue.pixel_of[chosen], value[band, chosen])
        self.sums[plane] += total

    def means(self, samples: int, response: Array | None = None) -> dict[str, Array]:
        """Pixels of each plane, (pixels, bands); (pixels, rows) with a `response` (rows, bands)."""
        means = self.resolved(samples)
        if response is None:
            return dict(zip(self.planes, means.transpose(0, 2, 1), strict=True))
        return dict(zip(self.planes, finished(developed(means, response).transpose(0, 2, 1)), strict=True))


    def resolved(self, samples: int) -> Array:
        """(planes, bands, pixels) means of the samples of each pixel, or their weighted means."""
        if self.weights is None:
            return _bounded(self.sums / np.float32(samples))
        light = _bounded(self.sums).reshape(*self.sums.shape[:2], -1, samples)
        total, plain = np.zeros_like(light[..., 0]), np.zeros_like(light[..., 0])
        whole, sizes = np.zeros_like(self.weights[:, 0]), np.zeros_like(self.weights[:, 0])
        for s in range(samples):
            weight = self.weights[:, s]
            total = total + weight * light[..., s]
            plain = plain + light[..., s]
            whole, sizes = whole + weight, sizes + np.abs(weight)
        means = np.where(whole > np.float32(0.25) * sizes, total / whole, plain / np.float32(samples))
        return _bounded(means)


def _bounded(values: Array) -> Array:
    brightest = np.float32(layout.BRIGHTEST)
    return np.where(values <= brightest, values, brightest)


def developed(means: Array, response: Array) -> Array:
    """(planes, rows, pixels) of (planes, bands, pixels): row by row, from the first band on."""
    total = response[:, 0, None] * means[:, None, 0]
    for band in range(1, response.shape[1]):
        total = total + response[:, band, None] * means[:, None, band]
    return total


def arriving(found: Shaded, shadows: Feelers) -> Array:
    """Local light and then every light seen, in order: (bands, n)."""
    value = found.local.copy()
    seen = shadows.seen != 0
    for band in range(len(value)):
        np.add.at(value[band], shadows.ray[seen], shadows.contribution[band, seen])
    return value


def rays_counted(queue: Queue, found: Shaded, shadows: Feelers) -> dict[str, int]:
    """A queue's part of the statistics."""
    hits = len(found.which)
    inside = int(np.count_nonzero(found.spawn & SPAWN["SPAWN_TOTAL_INTERNAL"]))
    counts = {
        "hits": hits,
        "total_internal_reflection": inside,
        "feelers": len(shadows.ray),
        queue.kind: len(queue),
    }
    return counts | ({"camera_hits": hits} if queue.kind == "camera" else {})
