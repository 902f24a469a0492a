"""Layers as pictures to look at: what stands for a distance, a direction, a number (docs/layers.md).

The values themselves are in `.exr` files and in `Image.layers`.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Final

import numpy as np

from clrt.base.errors import ClrtError
from clrt.base.layers import find
from clrt.images.file import uncurved

_GOLDEN = 0.6180339887498949  # steps of this much of a circle of hues come near to no earlier one


def layer_pixels(name: str, layer: np.ndarray) -> np.ndarray:
    """Linear Rec.709 (h, w, 3) float32 of a layer (h, w), (h, w, 3) or (h, w, n); a miss is black.

    Light stays as it is. What is no light becomes values from 0 to 1 that stand in a picture file as they
    are, not bent by its sRGB curve. ClrtError for what is not shown: `bands` are too many
    for colours.
    """
    known, values = find(name), layer.shape[2] if layer.ndim == 3 else 1
    if known.is_shown and known.values == values:
        return _PICTURES[known.picture](layer)
    if not known.is_shown or values not in (1, 3):
        raise ClrtError(f"layers: {name!r} has {values} values a pixel, which only an .exr holds")
    return _number(layer) if layer.dtype.kind in "iu" else _light(layer)


def _light(layer: np.ndarray) -> np.ndarray:
    return layer if layer.ndim == 3 else _grey(layer)


def _grey(values: np.ndarray) -> np.ndarray:
    return np.repeat(values[..., None], 3, axis=-1).astype(np.float32)


def _luminance(xyz: np.ndarray) -> np.ndarray:
    return _grey(xyz[..., 1])


def _nearness(depth: np.ndarray) -> np.ndarray:
    """The nearest hit's distance over each one's: 1 there, 1/2 twice as far, 0 at infinity."""
    hit = np.isfinite(depth) & (depth > 0)
    if not hit.any():
        return _grey(np.zeros(depth.shape))
    near = np.where(hit, depth[hit].min() / np.where(hit, depth, 1.0).astype(np.float64), 0.0)
    return uncurved(_grey(near))


def _is_hit(vectors: np.ndarray) -> np.ndarray:
    """Where a ray hit something (h, w, 1): on a miss position and normal are 0."""
    return np.isfinite(vectors).all(axis=-1, keepdims=True) & (vectors != 0).any(axis=-1, keepdims=True)


def _direction(vectors: np.ndarray) -> np.ndarray:
    return uncurved(np.where(_is_hit(vectors), (vectors.astype(np.float64) + 1) / 2, 0.0))


def _place(points: np.ndarray) -> np.ndarray:
    """x, y, z as red, green, blue, from the 5th to the 95th of a hundred hits along each axis."""
    hit = _is_hit(points)
    if not hit.any():
        return np.zeros(points.shape, np.float32)
    low, high = np.percentile(points[hit[..., 0]].astype(np.float64), (5, 95), axis=0)
    span = np.where(high > low, high - low, 1.0)
    return uncurved(np.where(hit, np.clip((points - low) / span, 0.0, 1.0), 0.0))


def _number(numbers: np.ndarray) -> np.ndarray:
    """A colour for each number from 0 on, the same in every picture; below 0 black."""
    return uncurved(np.where(numbers[..., None] >= 0, _colours(numbers), 0.0))


def _colours(numbers: np.ndarray) -> np.ndarray:
    """(..., 3) from 0 to 1: hues one golden section after the other."""
    hue = (numbers.astype(np.float64) * _GOLDEN) % 1.0
    wheel = np.abs((6 * hue[..., None] + np.array([0.0, 4.0, 2.0])) % 6 - 3) - 1
    return 0.9 * (0.35 + 0.65 * np.clip(wheel, 0.0, 1.0))


def _coordinates(uv: np.ndarray) -> np.ndarray:
    return uncurved(np.dstack([uv - np.floor(uv), np.zeros(uv.shape[:2])]))


def _share(values: np.ndarray) -> np.ndarray:
    return uncurved(_grey(np.clip(values, 0.0, 1.0)))


def _mattes(ranked: np.ndarray) -> np.ndarray:
    """The names' colours, each by the part that it covers: what no name covers is black."""
    ids = np.ascontiguousarray(ranked[..., ::2], np.float32).view(np.uint32)
    colours = _colours(ids) * np.clip(ranked[..., 1::2, None], 0.0, 1.0)
    return uncurved(np.clip(colours.sum(axis=2), 0.0, 1.0))


def _part(counts: np.ndarray) -> np.ndarray:
    return uncurved(_grey(counts / max(float(counts.max(initial=0)), 1.0)))


_PICTURES: Final[dict[str, Callable[[np.ndarray], np.ndarray]]] = {
    "light": _light,
    "luminance": _luminance,
    "nearness": _nearness,
    "direction": _direction,
    "place": _place,
    "color": _light,
    "coordinates": _coordinates,
    "share": _share,
    "mattes": _mattes,
    "number": _number,
    "part": _part,
}  # by Layer.picture; layers.PICTURES says them in words
