"""TIFF whose strips are not what the header says."""

from __future__ import annotations

import struct
import zlib
from pathlib import Path

import pytest

import clrt

_SIDE = 16


def _tiff(more: int) -> bytes:
    """Red, green and blue in one strip, compressed, of so many bytes more than it should have."""
    strip = zlib.compress(bytes(3 * _SIDE * _SIDE + more))
    strip += bytes(len(strip) % 2)
    tags = {256: _SIDE, 257: _SIDE, 258: 8, 259: 8, 262: 2, 273: 8, 277: 3, 278: _SIDE, 279: len(strip)}
    fields = b"".join(struct.pack("<HHII", tag, 4, 1, value) for tag, value in tags.items())
    head = struct.pack("<2sHI", b"II", 42, 8 + len(strip))
    return head + strip + struct.pack("<H", len(tags)) + fields + bytes(4)


@pytest.mark.parametrize("more", [1000, -100])
def test_a_strip_of_another_size_is_told(more: int, tmp_path: Path) -> None:
    """The library has no words for it."""
    path = tmp_path / "a.tif"
    path.write_bytes(_tiff(0))
    assert clrt.read_image(path).shape == (_SIDE, _SIDE, 3)
    path.write_bytes(_tiff(more))
    with pytest.raises(clrt.ClrtError, match=r"a\.tif: cannot be read: a part of it is broken, or"):
        clrt.read_image(path)
