"""What a TIFF file itself says of a page: its library makes a grey picture of one whose palette is short."""

from __future__ import annotations

import struct
from typing import BinaryIO, Final

from clrt.base.errors import SceneError

MEANING: Final = 262
"""The number of PhotometricInterpretation."""
SAMPLES_A_PIXEL: Final = 277

_BIG: Final = 43  # the number of files with places of 64 bits
_KINDS: Final = {1: "B", 3: "H"}  # of whole numbers; others have 32 bits


def first_values(file: BinaryIO, page: int, name: str) -> dict[int, int]:
    """The fields of a page, open for reading: number -> the first value of those two that have a name here.

    SceneError where the file ends before.
    """
    file.seek(0)
    try:
        return _first_values(file, file.read(16), page)
    except struct.error:
        raise SceneError(f"{name}: cannot be read: it ends before the fields of its page do") from None


def _first_values(file: BinaryIO, begins: bytes, page: int) -> dict[int, int]:
    order = "<" if begins.startswith(b"II") else ">"
    big = struct.unpack_from(f"{order}H", begins, 2)[0] == _BIG
    place, count = struct.Struct(order + "IQ"[big]), struct.Struct(order + "HQ"[big])
    field = struct.Struct(order + ("HHI4s", "HHQ8s")[big])  # its number, its type, how many values; they
    (at,) = place.unpack_from(begins, 8 if big else 4)
    for _ in range(page):
        file.seek(at)
        (fields,) = count.unpack(file.read(count.size))
        file.seek(at + count.size + fields * field.size)
        (at,) = place.unpack(file.read(place.size))
    file.seek(at)
    (fields,) = count.unpack(file.read(count.size))
    found = dict[int, int]()
    for _ in range(fields):
        number, kind, _, values = field.unpack(file.read(field.size))
        if number in (MEANING, SAMPLES_A_PIXEL):
            (found[number],) = struct.unpack_from(order + _KINDS.get(kind, "I"), values)
    return found
