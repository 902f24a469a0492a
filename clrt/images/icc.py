"""The curve of an ICC profile: whether its numbers are light, or curved (ICC.1:2010, 7.3, 10.5 and 10.15)."""

from __future__ import annotations

from struct import error, unpack_from
from typing import Final

import numpy as np

_CURVES: Final = (b"rTRC", b"kTRC")  # of red, which those of green and blue are like, and of a grey
_MOST: Final = 256  # tags that are looked at
_NEAR: Final = 0.01  # of the identity, of a table from 0 to 1; the curve of sRGB is up to 0.3 off


def is_linear(profile: bytes) -> bool | None:
    """Whether a profile's numbers are proportional to light; None where it has no curve, or is broken."""
    try:
        (count,) = unpack_from(">I", profile, 128)
        for k in range(min(count, _MOST)):
            name, start = unpack_from(">4sI", profile, 132 + 12 * k)
            if name in _CURVES:
                return _is_identity(profile, start)
    except (error, ValueError):  # shorter than it says
        return None
    return None


def _is_identity(profile: bytes, start: int) -> bool | None:
    (kind,) = unpack_from(">4s", profile, start)
    if kind == b"para":  # beside the exponent some have a line and what is added
        (exponent,) = unpack_from(">i", profile, start + 12)
        return bool(exponent == 1 << 16)
    if kind != b"curv":
        return None
    (count,) = unpack_from(">I", profile, start + 8)
    if count == 0:
        return True
    if count == 1:  # an exponent, in 256ths
        return bool(unpack_from(">H", profile, start + 12)[0] == 256)
    table = np.frombuffer(profile, ">u2", count, start + 12) / 65535
    return bool(np.abs(table - np.linspace(0, 1, count)).max() < _NEAR)
