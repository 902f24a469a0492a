"""Cryptomatte 1.2: names as numbers in a picture's channels, which compositing programs make masks of.

Psyop's specification: a layer's channels are pairs of a name's hash, its bits read as a float, and the part
of the pixel that the name covers, the largest first. What hash stands for what name is a text in the file.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from typing import Final

import numpy as np

PREFIX: Final = "cryptomatte/"
_LAST: Final = 0xFFFFFFFF
_EXPONENT: Final = 0xFF << 23


def murmur3(data: bytes) -> int:
    """MurmurHash3_x86_32 of seed 0 (Appleby 2011)."""
    whole = len(data) // 4 * 4
    h = 0
    for start in range(0, whole, 4):
        h ^= _scrambled(int.from_bytes(data[start : start + 4], "little"))
        h = ((h << 13 | h >> 19) * 5 + 0xE6546B64) & _LAST
    h ^= _scrambled(int.from_bytes(data[whole:], "little")) ^ len(data)
    h = (h ^ h >> 16) * 0x85EBCA6B & _LAST
    h = (h ^ h >> 13) * 0xC2B2AE35 & _LAST
    return h ^ h >> 16


def _scrambled(k: int) -> int:
    k = k * 0xCC9E2D51 & _LAST
    return (k << 15 | k >> 17) * 0x1B873593 & _LAST


def id_of(name: str) -> int:
    """The number of a name: 32 bits that are a normal float, neither 0, infinite nor NaN."""
    number = murmur3(_bytes(name))
    return number ^ 1 << 23 if number & _EXPONENT in (0, _EXPONENT) else number


def ids_of(names: Sequence[str]) -> np.ndarray:
    """The numbers of names as the floats that channels hold, (n,) float32."""
    known = {name: id_of(name) for name in set(names)}
    return np.array([known[name] for name in names], np.uint32).view(np.float32)


def metadata(layer: str, names: Sequence[str]) -> dict[str, str]:
    """What a file with this layer says of it, by attribute."""
    start = f"{PREFIX}{id_of(layer):08x}"[:-1]
    manifest = {name.encode(errors="replace").decode(): f"{id_of(name):08x}" for name in dict.fromkeys(names)}
    return {
        f"{start}/name": layer,
        f"{start}/hash": "MurmurHash3_32",
        f"{start}/conversion": "uint32_to_float32",
        f"{start}/manifest": json.dumps(manifest),
    }


def manifest_of(layer: str, metadata: Mapping[str, str]) -> dict[str, str]:
    """Name to number, in hexadecimal, as an image's metadata have it for a layer; {} where they have none."""
    text = metadata.get(f"{PREFIX}{id_of(layer):08x}"[:-1] + "/manifest", "")
    try:
        found = json.loads(text)
    except (ValueError, RecursionError):  # nested thousands deep
        return {}
    return found if isinstance(found, dict) else {}


def matte(ranked: np.ndarray, name: str) -> np.ndarray:
    """The part of each pixel that a name covers, float32 (h, w), from a layer (h, w, 2 ranks)."""
    mine = ranked[..., ::2].view(np.uint32) == np.uint32(id_of(name))
    return np.where(mine, ranked[..., 1::2], np.float32(0.0)).sum(axis=2, dtype=np.float32)


def _bytes(name: str) -> bytes:
    """UTF-8, halves of characters (which JSON can hold) as a question mark: no file can hold them."""
    return name.encode(errors="replace")
