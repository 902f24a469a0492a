"""What a surface passes on of light, and the vectors that say so, a row a ray."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

Array = np.ndarray


@dataclass(frozen=True, eq=False)
class Optics:
    """Directions that light goes on in (n, 3), its shares (n, 3), and where reflection is total (n,)."""

    reflected: Array
    transmitted: Array
    reflects: Array
    transmits: Array
    total: Array


def conductor(n: Array, k: Array, eta_i: Array, cosine: Array) -> Array:
    """Unpolarised reflectance (m, 3) of a metal with index n + ik (m, 3) beside eta_i, both (m,).

    In real numbers (Hecht, "Optics", 4.6; Pharr, Humphreys, "Physically Based Rendering", 1st edition, 9.2).
    """
    n, k = n / eta_i[:, None], k / eta_i[:, None]
    c2 = (cosine**2)[:, None]
    s2, c = 1 - c2, cosine[:, None]
    difference = n**2 - k**2 - s2
    both = np.sqrt(difference**2 + 4 * n**2 * k**2)  # a^2 + b^2
    a = np.sqrt(np.maximum((both + difference) / 2, 0))
    across = (both + c2 - 2 * a * c) / (both + c2 + 2 * a * c)
    within = (c2 * both + s2**2 - 2 * a * c * s2) / (c2 * both + s2**2 + 2 * a * c * s2)
    return np.asarray(across * (1 + within) / 2)


def dot(a: Array, b: Array) -> Array:
    return np.asarray(np.einsum("ni,ni->n", a, b))


def normalized(a: Array) -> Array:
    return np.asarray(a / np.linalg.norm(a, axis=1, keepdims=True))
