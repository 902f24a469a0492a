"""What a JPEG file declares, looked at before its library decodes it.

The library decodes the whole picture once for each scan of a progressive file: 75 kB of empty scans over
4000 x 4000 pixels took 4 s. And where the file ends early, or has too little of a picture, it makes the rest
grey and says nothing. Of each comment `name:value` it makes an attribute, and looks through all others first:
20,000 took 5 s.
"""

from __future__ import annotations

import mmap
import re
from typing import BinaryIO, Final

from clrt.base.errors import SceneError
from clrt.images.joined import Joined

MOST_SCANS: Final = 100
"""Encoders write about ten."""
MOST_COMMENTS: Final = 1000
"""Programs write one, or a few."""

_START, _END, _SCAN, _XMP, _IPTC, _COMMENT = 0xD8, 0xD9, 0xDA, 0xE1, 0xED, 0xFE
_XMP_BEGINS: Final = b"http://ns.adobe.com/xap/1.0/"
_IPTC_BEGINS: Final = b"Photoshop 3.0\0"
_HUFFMAN: Final = (0xC0, 0xC1, 0xC2)  # frames whose scans give each block of 8 x 8 pixels one bit or more
_ALONE: Final = (0x01, _START, *range(0xD0, 0xD8))  # markers that no length follows
# the end of a scan's data, in which 0xff stands before 0 or a restart only; of many 0xff the last counts, for
# to look from each for the end of their row takes time in its square
_MARKER: Final = re.compile(rb"\xff[^\x00\xd0-\xd7\xff]")


def check_jpeg(file: BinaryIO, name: str) -> None:
    """Raise `SceneError` for a JPEG file, open for reading, cut short or of too many scans, comments
    or keywords."""
    with mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ) as data:
        place, scans, comments, joined = 0, 0, 0, Joined(name)
        while True:
            found = _MARKER.search(data, place)
            if found is None:
                raise SceneError(f"{name}: cannot be read: it ends before its picture does")
            place = found.end()
            kind = data[place - 1]
            if kind == _END:
                return
            if kind in _ALONE:
                continue
            if kind in _HUFFMAN:
                height, width = (int.from_bytes(data[at : at + 2], "big") for at in (place + 3, place + 5))
                if len(data) < width * height // 512:
                    what = f"its {len(data)} bytes are not a whole picture of {width} x {height} pixels"
                    raise SceneError(f"{name}: cannot be read: {what}")
            begins, place = place + 2, place + int.from_bytes(data[place : place + 2], "big")
            if kind == _XMP and data[begins : begins + len(_XMP_BEGINS)] == _XMP_BEGINS:
                joined.add_packet()
            if kind == _IPTC and data[begins : begins + len(_IPTC_BEGINS)] == _IPTC_BEGINS:
                joined.add_records(data[begins:place])
            comments += kind == _COMMENT
            if comments > MOST_COMMENTS:
                raise SceneError(f"{name}: has more than {MOST_COMMENTS} comments; save it without")
            scans += kind == _SCAN
            if scans > MOST_SCANS:
                raise SceneError(f"{name}: has more than {MOST_SCANS} scans; save it as an ordinary JPEG")
