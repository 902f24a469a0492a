"""What the headers of an EXR file list, counted before its library reads them.

The library looks through all attributes of a part for each new one, and sorts each channel in among those
before it: 1 MB of short attributes took 32 s, 4 MB of channels 25 s.
"""

from __future__ import annotations

import mmap
import struct
from typing import BinaryIO, Final

from clrt.base.errors import SceneError, show

MOST_ATTRIBUTES: Final = 1024
"""Of a part; renderers write a few hundred, with a manifest of mattes and what the scene was."""
MOST_CHANNELS: Final = 1024
"""Of a part: the library's own limit, which it looks at too late."""

_BEGINS: Final = 8  # where the first header does, after the magic and the version
_MANY_PARTS: Final = 0x10  # bit of the version's second byte
_LONGEST: Final = 255  # bytes of a name
_CHANNEL: Final = 16  # bytes of a channel after its name
_SAMPLING: Final = 8  # bytes of it before how many pixels have a sample, across and down
_CHANNELS: Final = b"chlist"  # the type of a list of channels, whatever attribute has it


class _Broken(Exception):
    """The place where a header is no header."""


def check_exr(file: BinaryIO, name: str) -> None:
    """Raise `SceneError` for an EXR file, open for reading, with too many attributes or channels in a part,
    or whose headers are not whole: the library may understand them otherwise."""
    with mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ) as data:
        many = len(data) > _BEGINS and data[5] & _MANY_PARTS
        place = _BEGINS
        try:
            while True:
                begins = place
                place = _after_header(data, place, name)
                if not many or place == begins + 1:  # an empty header ends them
                    return
        except _Broken as error:
            text = f"cannot be read: its header is broken, or cut short, at byte {error}"
            raise SceneError(f"{name}: {text}") from None


def _after_header(data: mmap.mmap, place: int, name: str) -> int:
    """Where the header that begins there ends."""
    for _ in range(MOST_ATTRIBUTES + 1):
        begins, place = place, _after_text(data, place)
        if place == begins + 1:
            return place
        kind, place = place, _after_text(data, place)
        size, begins = int.from_bytes(data[place : place + 4], "little"), place + 4
        if begins + size > len(data):
            raise _Broken(place)
        if data[kind : place - 1] == _CHANNELS:
            _check_channels(data, begins, begins + size, name)
        place = begins + size
    raise SceneError(f"{name}: has more than {MOST_ATTRIBUTES} attributes in a part; save it with fewer")


def _check_channels(data: mmap.mmap, place: int, ends: int, name: str) -> None:
    for _ in range(MOST_CHANNELS + 1):
        begins, place = place, _after_text(data, place)
        if place == begins + 1 or place >= ends:  # the library says what is wrong with one that is cut short
            return
        sampling = struct.unpack_from("<2i", data, place + _SAMPLING) if place + _CHANNEL <= ends else (1, 1)
        if sampling != (1, 1):  # which the library refuses, and forgets that it did
            called = show(data[begins : place - 1].decode("latin-1"))
            text = f"its channel {called} has a sample for {sampling[0]} x {sampling[1]} pixels; save it with"
            raise SceneError(f"{name}: {text} one for each")
        place += _CHANNEL
    raise SceneError(f"{name}: has more than {MOST_CHANNELS} channels in a part; save it with fewer")


def _after_text(data: mmap.mmap, place: int) -> int:
    """The place behind a name and the zero that ends it."""
    ends = data.find(b"\0", place, place + _LONGEST + 1)
    if ends < 0:
        raise _Broken(place)
    return ends + 1
