"""What a BMP file says of its colours and of where they lie in 32 bits, which its library takes as usual."""

from __future__ import annotations

import struct
from typing import BinaryIO, Final

from clrt.base.errors import SceneError

_MASKED: Final = (3, 6)  # BI_BITFIELDS and BI_ALPHABITFIELDS
_MASKS: Final = (0xFF0000, 0xFF00, 0xFF)  # of red, green and blue: the only ones that are read at 32 bits
_FIELDS: Final = struct.Struct("<I10xHI20x3I")  # of the second header, which begins after the first 14 bytes
_SPACE: Final = struct.Struct("<I52x4s9i")  # the same header's size, kind of colours and endpoints
_PROFILES: Final = (b"DEBM", b"KNIL")  # a profile within the file, or beside it


def check_bmp(file: BinaryIO, name: str) -> None:
    """Raise SceneError for a BMP file, open for reading, of 32 bits with colours at unusual bits."""
    file.seek(14)
    begins = file.read(_FIELDS.size)
    if len(begins) < _FIELDS.size:  # of another kind, or cut short
        return
    size, bits, compression, *masks = _FIELDS.unpack(begins)
    if size >= 40 and bits == 32 and compression in _MASKED and tuple(masks) != _MASKS:
        told, right = (", ".join(f"{mask:#x}" for mask in some) for some in (masks, _MASKS))
        raise SceneError(f"{name}: its masks of red, green and blue are {told}; of 32 bits {right} are read")


def _space(file: BinaryIO) -> tuple[bytes, list[int]]:
    """The kind of colours, b"" where unsaid, and three numbers each of where red, green and blue lie."""
    file.seek(14)
    begins = file.read(_SPACE.size)
    if len(begins) < _SPACE.size:
        return b"", []
    size, kind, *ends = _SPACE.unpack(begins)
    return (kind, ends) if size >= 108 else (b"", [])


def has_profile(file: BinaryIO) -> bool:
    """Whether a BMP file, open for reading, has a profile of its colours, or names one."""
    return _space(file)[0] in _PROFILES


def primaries(file: BinaryIO) -> list[float] | None:
    """x and y of red, green and blue, as it declares them; None where it does not."""
    kind, ends = _space(file)
    if kind != bytes(4):
        return None
    sums = [sum(ends[first : first + 3]) for first in (0, 3, 6)]
    if min(sums, default=0) <= 0:  # many writers leave them zero
        return None
    return [value / total for k, total in enumerate(sums) for value in ends[3 * k : 3 * k + 2]]
