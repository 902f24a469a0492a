"""The float32 twin's arithmetic: vectors, elementary functions and hashes.

A vector is an array (3, ...) with its components first, so that `p + n * distance` reads as it is written;
all arrays are float32 and broadcast. numpy rounds each + - * / and sqrt correctly and fuses nothing, so the
same formula in the same order gives the same bits as on a device. `np.where` takes the place of a branch:
what the branch not taken would have computed may be NaN, without harm.
"""

from __future__ import annotations

from typing import Any

import numpy as np

Array = np.ndarray
ONE = np.float32(1.0)


def vector(x: Any, y: Any, z: Any) -> Array:
    """Components (...) to a vector (3, ...), float32."""
    return np.stack(np.broadcast_arrays(x, y, z)).astype(np.float32, copy=False)


def xyz(records: Array) -> Array:
    """The vectors (3, ...) in a field of `float4` records (..., 4)."""
    return np.ascontiguousarray(np.moveaxis(records, -1, 0)[:3])


def dot(a: Array, b: Array) -> Array:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def cross(a: Array, b: Array) -> Array:
    return vector(a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def unit(v: Array) -> Array:
    return v * (ONE / np.sqrt(dot(v, v)))


def unit_of_any(v: Array) -> Array:
    """The same of any vector that is not 0, also where its square leaves the range of float32."""
    with np.errstate(all="ignore"):
        square = dot(v, v)
        scale = np.where(square > 2.0**60, 2.0**-90, np.where(square < 2.0**-60, 2.0**90, 1.0))
        return unit(v * scale.astype(np.float32))


def larger(a: Any, b: Any) -> Array:
    """The larger number; `b` where `a` is NaN."""
    return np.where(a > b, a, b)


def smaller(a: Any, b: Any) -> Array:
    """The smaller number; `b` where `a` is NaN."""
    return np.where(a < b, a, b)


def largest_coordinate(v: Array) -> Array:
    a = np.abs(v)
    return larger(larger(a[0], a[1]), a[2])


def component(v: Array, k: Array) -> Array:
    """Component number `k` of each vector."""
    return np.where(k == 0, v[0], np.where(k == 1, v[1], v[2]))


def power(x: Array, y: Array) -> Array:
    """x^y = 2^(y log2 x) for 0 <= x <= 1, y >= 0: log2 by a series in (m - 1) / (m + 1), 2^r a polynomial."""
    bits = x.view(np.int32)
    exponent = (bits - np.int32(0x3F3504F3)) >> np.int32(23)
    m = (bits - (exponent << np.int32(23))).view(np.float32)
    s = (m - 1.0) / (m + 1.0)
    z = s * s
    series = 2.88539008 + z * (0.961796694 + z * (0.577078016 + z * (0.412198583 + z * 0.33)))
    t = y * (exponent.astype(np.float32) + s * series)
    k = np.floor(t + 0.5)
    r = t - k
    tail = 0.0555041086 + r * (0.00961812911 + r * (0.00133335581 + r * 0.000154353))
    two_r = 1.0 + r * (0.693147181 + r * (0.240226507 + r * tail))
    in_range = (t >= -125.0) & (x > 0.0)
    scale = (np.where(in_range, k, 0.0).astype(np.int32) + np.int32(127) << np.int32(23)).view(np.float32)
    return np.where(y == 0.0, ONE, np.where(in_range, two_r * scale, np.float32(0.0)))


def exponential(x: Array) -> Array:
    """e^x for x <= 0 (Cephes expf), 0 below e^-87."""
    in_range = x >= -87.0
    x = np.where(in_range, x, np.float32(0.0))
    k = np.floor(x * 1.44269504 + 0.5)
    r = x - k * 0.693359375 + k * 0.000212194440
    tail = 0.0416657959 + r * (0.00833345191 + r * (0.00139819995 + r * 0.000198756915))
    series = 0.5 + r * (0.166666655 + r * tail)
    scale = (k.astype(np.int32) + np.int32(127) << np.int32(23)).view(np.float32)
    return np.where(in_range, (r * r * series + r + 1.0) * scale, np.float32(0.0))


def arctan(a: Array) -> Array:
    """Arc tangent of a >= 0 (Cephes)."""
    steep, middle = a > 2.414213562, a > 0.4142135624
    base = np.where(
        steep, np.float32(1.570796327), np.where(middle, np.float32(0.7853981634), np.float32(0.0))
    )
    x = np.where(steep, -1.0 / a, np.where(middle, (a - 1.0) / (a + 1.0), a))
    z = x * x
    odd_series = ((0.0805374449538 * z - 0.138776856032) * z + 0.199777106478) * z - 0.333329491539
    return base + (odd_series * z * x + x)


def arctan2(y: Array, x: Array) -> Array:
    """Angle of (x, y) in (-pi, pi]; 0 for the zero vector."""
    a = arctan(np.abs(y) / np.abs(x))
    b = np.where(x < 0.0, 3.141592654 - a, a)
    return np.where((x == 0.0) & (y == 0.0), np.float32(0.0), np.where(y < 0.0, -b, b))


def arccos(x: Array) -> Array:
    """Arc cosine of x clamped to [-1, 1], through the half angle."""
    c = np.where(x > 1.0, ONE, np.where(x < -1.0, -ONE, x))
    return 2.0 * arctan2(np.sqrt(1.0 - c), np.sqrt(1.0 + c))


def sine_cosine(a: Array) -> tuple[Array, Array]:
    """Both for |a| <= pi/4 (Taylor)."""
    z = a * a
    sine = a * (1.0 - z * (0.166666667 - z * (0.00833333333 - z * 0.000198412698)))
    cosine = 1.0 - z * (0.5 - z * (0.0416666667 - z * (0.00138888889 - z * 0.0000248015873)))
    return sine, cosine


def disk(u1: Array, u2: Array) -> tuple[Array, Array]:
    """The unit square onto the unit disk (Shirley and Chiu 1997)."""
    a, b = 2.0 * u1 - 1.0, 2.0 * u2 - 1.0
    wide = np.abs(a) > np.abs(b)
    radius = np.where(wide, a, b)
    sine, cosine = sine_cosine(0.785398163 * (np.where(wide, b, a) / radius))
    along, across, middle = radius * cosine, radius * sine, radius == 0.0
    x, y = np.where(wide, along, across), np.where(wide, across, along)
    return np.where(middle, np.float32(0.0), x), np.where(middle, np.float32(0.0), y)


def turn(u: Array) -> tuple[Array, Array]:
    """Sine and cosine of `u` whole turns, 0 <= u < 1."""
    quarter = np.floor(4.0 * u + 0.5)
    s, c = sine_cosine(1.57079633 * (4.0 * u - quarter))
    aside, back = (quarter == 1.0) | (quarter == 3.0), (quarter == 2.0) | (quarter == 3.0)
    x, y = np.where(aside, -s, c), np.where(aside, c, s)
    return np.where(back, -y, y), np.where(back, -x, x)


def frame_about(n: Array) -> tuple[Array, Array]:
    """Two unit vectors that make an orthonormal frame with unit vectors n (Duff et al. 2017)."""
    sign = np.where(n[2] < 0.0, -ONE, ONE)
    a = -1.0 / (sign + n[2])
    b = n[0] * n[1] * a
    tangent = vector(1.0 + sign * n[0] * n[0] * a, sign * b, -sign * n[0])
    return tangent, vector(b, sign + n[1] * n[1] * a, -n[1])


def mix_bits(x: Array | np.uint32) -> Array:
    """Wellons' lowbias32 of uint32 words."""
    x = x ^ x >> np.uint32(16)
    x = x * np.uint32(0x7FEB352D)
    x = x ^ x >> np.uint32(15)
    x = x * np.uint32(0x846CA68B)
    return np.asarray(x ^ x >> np.uint32(16))


def combine(a: Array, b: Array | np.uint32) -> Array:
    """A word from two, uint32."""
    return mix_bits(a ^ mix_bits(b + np.uint32(0x9E3779B9)))


def unit_interval(words: Array) -> Array:
    """[0, 1) from the upper 24 bits, exactly."""
    return (words >> 8).astype(np.float32) * np.float32(2.0**-24)
