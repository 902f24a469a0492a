"""Sizes that a file may declare without holding as much: what every structured change draws from."""

from __future__ import annotations

import random
from typing import Final

SIZES: Final = (
    -(2**31), -1, 0, 1, 2, 3, 7, 127, 255, 256, 1000, 2**15, 65535, 65536, 10**6, 2**24, 2**24 + 1, 2**26,
    2**28, 3 * 10**8, 2**31 - 1, 2**31, 2**32 - 1, 2**32, 2**40, 2**63 - 1, 10**19,
)  # fmt: skip
"""About the limits (2^24, 2^26), about the ends of the types that formats have, and between."""

COUNTS: Final = (2, 10, 30, 100, 300, 1000, 1000, 3000)
"""How often something small is said again: references to one mesh, entries of a list."""

RARE_COUNTS: Final = (10_000, 10_000, 30_000, 70_000)
"""Up to above 65,536, the most that 16 bits number; drawn seldom, because all of them are read."""

MOST: Final = 1 << 24
"""Bytes that repeating may come to; what is repeated may itself have been repeated."""


def size(draw: random.Random, bits: int = 64) -> int:
    """One of SIZES as an unsigned field of so many bits holds it."""
    return draw.choice(SIZES) & ((1 << bits) - 1)


def count(draw: random.Random, length: int = 0) -> int:
    """How often to repeat something: at least twice, and beyond that within MOST where its bytes are said."""
    wanted = draw.choice(RARE_COUNTS if draw.random() < 0.03 else COUNTS)
    return min(wanted, max(2, MOST // max(length, 1)))
