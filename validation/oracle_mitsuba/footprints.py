"""How far footprints of rays reach in pictures, and mip levels of these, by docs/model.md, "Images"."""

from __future__ import annotations

import numpy as np

from .places import Chart

Array = np.ndarray


def reaches(at: Chart, normal: Array, u: Array, width: Array) -> Array:
    """Of cones of widths (n,) about rays along `u` that meet planes of these normals: (n, 2) in u, v."""
    least = np.zeros_like(u)
    least[np.arange(len(u)), np.argmin(np.abs(u), axis=1)] = 1.0
    first = np.cross(u, least)
    first /= np.linalg.norm(first, axis=1, keepdims=True)
    squares = np.zeros((len(u), 2))
    with np.errstate(all="ignore"):
        for beside in (first, np.cross(u, first)):
            way = beside - u * (_dot(normal, beside) / _dot(normal, u))[:, None]
            # way = a du + b dv
            aa, ab, bb = _dot(at.du, at.du), _dot(at.du, at.dv), _dot(at.dv, at.dv)
            a, b = _dot(way, at.du), _dot(way, at.dv)
            area = aa * bb - ab**2
            squares += (np.stack([bb * a - ab * b, aa * b - ab * a], 1) / area[:, None]) ** 2
        found = width[:, None] * np.sqrt(squares)
    return np.where(width[:, None] > 0, found, 0.0)


def smaller(texels: Array) -> list[Array]:
    """A picture (h, w, 3), and its mip levels."""
    found = [np.asarray(texels, float)]
    while max(found[-1].shape[:2]) > 1:
        found.append(_means(_means(found[-1]).swapaxes(0, 1)).swapaxes(0, 1))
    return [texels, *(np.ascontiguousarray(level, np.float32) for level in found[1:])]


def _means(rows: Array) -> Array:
    """Half as many rows: what the rows sum to up to a place, taken at the ends of each of the new ones."""
    n, m = len(rows), max(1, len(rows) // 2)
    sums = np.concatenate([np.zeros_like(rows[:1]), np.cumsum(rows, axis=0)])
    place = np.arange(m + 1) * n / m
    whole = np.minimum(place.astype(int), n - 1)
    part = (place - whole).reshape(-1, *(1,) * (rows.ndim - 1))
    return np.asarray(np.diff(sums[whole] + part * rows[whole], axis=0) * m / n)


def _dot(a: Array, b: Array) -> Array:
    return np.asarray(np.sum(a * b, axis=1))
