"""Mirrors and boundaries between media; directions and normals are unit vectors (m, 3), cos_i = -n.u >= 0."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .vectors import Array, dot, unit


def reflect(u: Array, n: Array) -> Array:
    """u - 2 (n.u) n (thesis 3.11)."""
    return unit(u - 2 * dot(n, u)[:, None] * n)


def refract(u: Array, n: Array, eta: Array) -> tuple[Array, Array]:
    """Transmitted direction for eta = eta_i / eta_t, and k = cos_t^2, < 0 at total internal reflection.

    eta u + (eta cos_i - sqrt(k)) n (thesis 3.26).
    """
    cos_i = -dot(n, u)
    k = 1 - eta**2 * (1 - cos_i**2)
    root = np.sqrt(np.maximum(k, 0))
    return unit(eta[:, None] * u + (eta * cos_i - root)[:, None] * n), k


def fresnel(eta_i: Array, eta_t: Array, cos_i: Array) -> Array:
    """Unpolarised reflectance of a boundary between dielectrics: 1 at total internal reflection."""
    k = 1 - (eta_i / eta_t) ** 2 * (1 - cos_i**2)
    cos_t = np.sqrt(np.maximum(k, 0))
    with np.errstate(invalid="ignore"):
        rs = (eta_i * cos_i - eta_t * cos_t) / (eta_i * cos_i + eta_t * cos_t)
        rp = (eta_t * cos_i - eta_i * cos_t) / (eta_t * cos_i + eta_i * cos_t)
    reflectance = np.where(k < 0, 1.0, (rs**2 + rp**2) / 2)
    return np.where(eta_i == eta_t, 0.0, reflectance)


def conductor(eta_i: Array, index: NDArray[np.complex128], cos_i: Array) -> Array:
    """Unpolarised reflectance (m, bands) of a metal of complex index (m, bands) in a medium eta_i (m, 1).

    Fresnel's equations with a complex cosine (Born, Wolf, ch. 14); the sign of k is that of the phase.
    """
    n, cosine = index / eta_i, cos_i[:, None]
    inner = np.sqrt(1 - (1 - cosine**2) / n**2)
    rs = (cosine - n * inner) / (cosine + n * inner)
    rp = (n * cosine - inner) / (n * cosine + inner)
    return np.asarray((np.abs(rs) ** 2 + np.abs(rp) ** 2) / 2)


def schlick(tint: Array, cosine: Array) -> Array:
    """A mirror's tint (m, bands), which goes to 1 at grazing angles (Schlick 1994; thesis 3.2.3)."""
    return np.asarray(tint + (1 - tint) * (1 - cosine[:, None]) ** 5)
