"""What looks random and is not: the hash that the image model states, and the ambient rays drawn from it."""

from __future__ import annotations

from typing import Any

import numpy as np

Array = np.ndarray
GATHERED = np.uint32(4)  # flag of a path word: the ray descends from an ambient one
FLAGS = np.uint32(15)


def mix(x: Any) -> Array:
    """A hash of 32-bit words (Wellons' lowbias32)."""
    x = np.asarray(x, np.uint32)
    with np.errstate(over="ignore"):
        x = (x ^ (x >> np.uint32(16))) * np.uint32(0x7FEB352D)
        x = (x ^ (x >> np.uint32(15))) * np.uint32(0x846CA68B)
    return np.asarray(x ^ (x >> np.uint32(16)))


def combine(a: Any, b: Any) -> Array:
    """The hash of a word and a number."""
    with np.errstate(over="ignore"):
        return mix(np.asarray(a, np.uint32) ^ mix(np.asarray(b, np.uint32) + np.uint32(0x9E3779B9)))


def unit(word: Array) -> Array:
    """A number in [0, 1) from a word's upper 24 bits."""
    return np.asarray((word >> np.uint32(8)) * 2.0**-24)


def camera_words(seed: int, pixel: Array, sample: int) -> Array:
    """The words of camera rays; their lower four bits are not yet free for flags."""
    return combine(combine(np.uint32(seed), pixel), sample)


def child_path(path: Array, number: int, masked: bool = True) -> Array:
    """The key of a ray's child: 1 reflected, 2 transmitted, 3 ambient; unmasked as randomness is drawn from
    it."""
    h = combine(path & ~FLAGS, number)
    return h & ~FLAGS if masked else h


def cosine_direction(h: Array, index: int, n: Array) -> Array:
    """Direction number `index` about unit normals n (m, 3): Shirley and Chiu's map of the square to the disk,
    lifted."""
    with np.errstate(over="ignore"):
        u1 = unit(mix(h + np.uint32(1)) + np.uint32(index * 0xC13FA9A9 & 0xFFFFFFFF))
        u2 = unit(mix(h + np.uint32(2)) + np.uint32(index * 0x91E10DA5 & 0xFFFFFFFF))
    x, y = on_disk(u1, u2)
    z = np.sqrt(np.maximum(0.0, 1 - x * x - y * y))
    t, s = basis(n)
    return np.asarray(x[:, None] * t + y[:, None] * s + z[:, None] * n)


def pair(h: Array, place: Array) -> tuple[Array, Array]:
    """Numbers `place` of the sequences that begin at hashes, both in [0, 1)."""
    place = np.asarray(place, np.uint32)
    with np.errstate(over="ignore"):
        u1 = unit(mix(h + np.uint32(1)) + place * np.uint32(0xC13FA9A9))
        return u1, unit(mix(h + np.uint32(2)) + place * np.uint32(0x91E10DA5))


def on_disk(u1: Array, u2: Array) -> tuple[Array, Array]:
    """Points of the unit disk for points of the unit square (Shirley and Chiu's map)."""
    a, b = 2 * u1 - 1, 2 * u2 - 1
    wide = np.abs(a) > np.abs(b)
    with np.errstate(all="ignore"):
        r = np.where(wide, a, b)
        angle = np.where(wide, np.pi / 4 * (b / a), np.pi / 2 - np.pi / 4 * (a / b))
    angle = np.where(r == 0, 0.0, angle)
    return r * np.cos(angle), r * np.sin(angle)


def basis(n: Array) -> tuple[Array, Array]:
    """Two unit vectors across unit normals (m, 3) (Duff et al. 2017)."""
    sign = np.where(n[:, 2] < 0, -1.0, 1.0)
    a = -1 / (sign + n[:, 2])
    b = n[:, 0] * n[:, 1] * a
    t = np.stack([1 + sign * n[:, 0] ** 2 * a, sign * b, -sign * n[:, 0]], -1)
    s = np.stack([b, sign + n[:, 1] ** 2 * a, -n[:, 1]], -1)
    return t, s
