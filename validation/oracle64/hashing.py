"""What looks random is a hash of the path: the same for every order of work. Words are uint32 and wrap.

A path is a word of 28 bits of key and 4 flags; each ray's key is a hash of its parent's.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from .vectors import Array, Words, dot

ROUTE, GATHERED, GATHERED_FIRST, FLAGS = 3, 4, 8, 15
REFLECTION, TRANSMISSION, AMBIENT = 1, 2, 3  # routes; also the numbers of a ray's children


def word(x: Any) -> Words:
    """Whole numbers modulo 2^32."""
    return np.asarray(np.asarray(x, np.int64) & 0xFFFFFFFF, np.uint32)


def mix(x: Words) -> Words:
    """lowbias32 (Wellons 2018)."""
    with np.errstate(over="ignore"):  # numpy warns of what wraps where x is a single number
        x = (x ^ x >> np.uint32(16)) * np.uint32(0x7FEB352D)
        x = (x ^ x >> np.uint32(15)) * np.uint32(0x846CA68B)
    return x ^ x >> np.uint32(16)


def combine(a: Words, b: Any) -> Words:
    """A hash of two words."""
    return mix(a ^ mix(word(b) + np.uint32(0x9E3779B9)))


def interval(x: Words) -> Array:
    """Words to [0, 1)."""
    return np.asarray((x >> np.uint32(8)) * 2.0**-24, float)


def camera_path(seed: int, pixel: Any, sample: Any) -> Words:
    """The hash of a camera ray; without FLAGS it is its path."""
    return combine(combine(word(np.full(np.shape(pixel), seed)), pixel), sample)


def child(path: Words, number: int) -> Words:
    """The hash of a child ray (REFLECTION, TRANSMISSION or AMBIENT)."""
    return combine(path & ~np.uint32(FLAGS), number)


def key(h: Words) -> Words:
    """A hash as a path without flags."""
    return h & ~np.uint32(FLAGS)


def jitter(h: Words) -> tuple[Array, Array]:
    """A camera ray's place in its cell, in [0, 1)^2."""
    return interval(mix(h + np.uint32(1))), interval(mix(h + np.uint32(2)))


def pair(h: Words, i: Any) -> tuple[Array, Array]:
    """Numbers i (one, or one for each) of the sequences that begin at hashes, in [0, 1)^2."""
    return interval(mix(h + np.uint32(1)) + word(i * 0xC13FA9A9)), interval(
        mix(h + np.uint32(2)) + word(i * 0x91E10DA5)
    )


def lens(seed: int, pixel: Any, sample: Any) -> tuple[Array, Array]:
    """Where on the unit disk the rays of a lens start."""
    h = combine(combine(word(np.full(np.shape(pixel), seed)), pixel), 0x80000000)
    u1 = interval(mix(h + np.uint32(1)) + word(np.asarray(sample, np.int64) * 0x9E3779B9))
    u2 = interval(mix(h + np.uint32(2)) + word(np.asarray(sample, np.int64) * 0x6A09E667))
    return concentric(u1, u2)


def cosine_direction(h: Words, i: int, n: Array) -> Array:
    """Direction i of the cosine-distributed ones about the unit normals n (m, 3).

    A point of the R2 sequence (Roberts 2018), moved by the hash, taken to the disk, lifted to the hemisphere.
    """
    a, b = concentric(*pair(h, i))
    t, s = frame(n)
    c = np.sqrt(np.maximum(0, 1 - a * a - b * b))
    d = a[:, None] * t + b[:, None] * s + c[:, None] * n
    return np.asarray(d / np.sqrt(dot(d, d))[:, None])


def concentric(u1: Array, u2: Array) -> tuple[Array, Array]:
    """The unit square onto the unit disk, squares to circles (Shirley, Chiu 1997)."""
    x, y = 2 * u1 - 1, 2 * u2 - 1
    wide = np.abs(x) > np.abs(y)
    radius = np.where(wide, x, y)
    ratio = np.divide(np.where(wide, y, x), radius, out=np.zeros_like(radius), where=radius != 0)
    angle = np.where(wide, np.pi / 4 * ratio, np.pi / 2 - np.pi / 4 * ratio)
    return radius * np.cos(angle), radius * np.sin(angle)


def frame(n: Array) -> tuple[Array, Array]:
    """Two unit vectors that make an orthonormal basis with n (Duff et al. 2017)."""
    x, y, z = n.T
    sign = np.where(z < 0, -1.0, 1.0)
    a = -1 / (sign + z)
    b = x * y * a
    first = np.stack([1 + sign * x * x * a, sign * b, -sign * x], axis=1)
    return first, np.stack([b, sign + y * y * a, -y], axis=1)
