"""What a BMP file says of where its colours lie in 32 bits, which its library takes for granted."""

from __future__ import annotations

import struct
from typing import BinaryIO, Final

from clrt.base.errors import SceneError

_MASKED: Final = (3, 6)  # BI_BITFIELDS and BI_ALPHABITFIELDS
_MASKS: Final = (0xFF0000, 0xFF00, 0xFF)  # of red, green and blue: the only ones that are read at 32 bits
_FIELDS: Final = struct.Struct("<I10xHI20x3I")  # of the second header, which begins after the first 14 bytes


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
