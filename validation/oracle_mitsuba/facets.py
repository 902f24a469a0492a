"""GGX's facets of rough mirrors in float64 (Walter et al. 2007; Heitz 2018)."""

from __future__ import annotations

import numpy as np

Array = np.ndarray


def facet(v: Array, alpha: Array, a: Array, b: Array) -> Array:
    """Normals (n, 3) of facets that are seen from v (n, 3), z along the normal, for points of a disk.

    A hemisphere of GGX's stretched facets, seen from v, is a disk less what of it is turned away.
    """
    wide = np.stack([alpha, alpha, np.ones_like(alpha)], -1)
    top = _normalized(v * wide)
    slant = np.hypot(top[:, 0], top[:, 1])
    with np.errstate(invalid="ignore"):
        x = np.stack([-top[:, 1], top[:, 0], np.zeros_like(slant)], -1) / slant[:, None]
    x[slant == 0] = (1.0, 0.0, 0.0)
    share = (1 + top[:, 2]) / 2
    b = share * b + (1 - share) * np.sqrt(np.maximum(0.0, 1 - a**2))
    c = np.sqrt(np.maximum(0.0, 1 - a**2 - b**2))
    stretched = a[:, None] * x + b[:, None] * np.cross(top, x) + c[:, None] * top
    stretched[:, 2] = np.maximum(stretched[:, 2], 0.0)
    return _normalized(stretched * wide)


def smith(r: Array, alpha: Array) -> Array:
    """Smith's share (n,) of GGX's facets that directions r (n, 3) leave without meeting another; 0 below."""
    with np.errstate(divide="ignore"):
        tan2 = (1 - np.minimum(r[:, 2] ** 2, 1.0)) / r[:, 2] ** 2
    return np.where(r[:, 2] > 0, 2 / (1 + np.sqrt(1 + alpha**2 * tan2)), 0.0)


def _normalized(a: Array) -> Array:
    return np.asarray(a / np.linalg.norm(a, axis=1, keepdims=True))
