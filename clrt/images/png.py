"""What a PNG file itself says, looked at before its library reads it.

The library unpacks each text that is compressed, up to 8 MB of it, and keeps a thousand: 926 kB of file took
2.7 GB. It joins lists of all packets of XMP. And it tells nobody which primaries a file declares.
"""

from __future__ import annotations

import mmap
import zlib
from collections.abc import Iterator
from typing import BinaryIO, Final

from clrt.base.errors import SceneError
from clrt.images.joined import Joined

MOST_TEXT: Final = 8 << 20
"""Bytes of all texts and of the profile, unpacked."""

_BEGINS: Final = 8
_FRAME: Final = 12  # bytes of a chunk beside its own: length, kind, sum
_TEXTS: Final = (b"tEXt", b"zTXt", b"iTXt")
_XMP: Final = b"xml:com.adobe.xmp\0"  # a text's name, in small letters, and its end
_UNIT: Final = 1e-5  # of a chromaticity


def _chunks(data: mmap.mmap) -> Iterator[tuple[bytes, int, int]]:
    """Kind, first and last place of each chunk before the pixels' or the file's end."""
    place = _BEGINS
    while place + _FRAME <= len(data):
        length = int.from_bytes(data[place : place + 4], "big")
        first = place + 8
        yield data[place + 4 : first], first, min(first + length, len(data))
        place += length + _FRAME


def check_png(file: BinaryIO, name: str) -> None:
    """Raise `SceneError` for a PNG file, open for reading, whose texts unpack to more than `MOST_TEXT`, or
    with too many packets of XMP."""
    with mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ) as data:
        left, joined = MOST_TEXT, Joined(name)
        for kind, first, last in _chunks(data):
            if kind in _TEXTS and data[first : first + len(_XMP)].lower() == _XMP:
                joined.add_packet()
            left -= _unpacked(data, kind, first, last, left + 1)
            if left < 0:
                most = f"{MOST_TEXT >> 20} MiB"
                raise SceneError(f"{name}: its texts unpack to more than {most}; save it without")


def _unpacked(data: mmap.mmap, kind: bytes, first: int, last: int, most: int) -> int:
    """Bytes of a chunk's text, unpacked, up to so many; 0 of what is not packed."""
    begins = data.find(b"\0", first, last) + 1  # after the text's name
    if kind not in (b"zTXt", b"iTXt", b"iCCP") or not begins:
        return 0
    if kind == b"iTXt":
        if data[begins : begins + 1] != b"\1":
            return 0
        language = data.find(b"\0", begins + 2, last) + 1
        begins = data.find(b"\0", language, last) + 1 if language else 0  # after the name in that language
        if not begins:
            return 0
    else:
        begins += 1
    try:
        return len(zlib.decompressobj().decompress(data[begins:last], most))
    except zlib.error:  # the library passes over it
        return 0


def primaries(file: BinaryIO) -> list[float] | None:
    """x and y of red, green, blue and white, as it declares them; None where it does not, or says sRGB."""
    with mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ) as data:
        found = None
        for kind, first, last in _chunks(data):
            if kind in (b"sRGB", b"iCCP", b"cICP"):
                return None
            if kind == b"IDAT":
                break
            if kind == b"cHRM" and last - first == 32:
                numbers = [int.from_bytes(data[at : at + 4], "big") * _UNIT for at in range(first, last, 4)]
                found = [*numbers[2:], *numbers[:2]]
        return found
