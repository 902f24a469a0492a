"""Keywords and the like, which the picture library joins to one text, anew for each of them.

It keeps each of these texts until the process ends: 30,000 keywords, 181 kB of a JPEG, took 3 GB. They lie in
IPTC's records and in packets of XMP.
"""

from __future__ import annotations

import re
from typing import Final

from clrt.base.errors import SceneError

MOST_JOINED: Final = 32 << 20
"""Bytes of all texts that the library may make of IPTC's records: 1000 keywords of 20 letters take 13 MB."""
MOST_PACKETS: Final = 16
"""Of XMP: there is one in a file that is right, and the library makes 64 kB of lists of each."""

RECORD: Final = re.compile(rb"\x1c\x02")
"""How a record of IPTC begins."""
ANY_ORDER: Final = re.compile(rb"\x1c")
"""The same where bytes may be swapped before they are read."""


class Joined:
    """What a file's records of IPTC come to, and its packets of XMP, as they are found."""

    def __init__(self, name: str) -> None:
        self._name, self._length, self._taken, self._packets = name, 0, 0, 0

    def add_records(self, data: bytes, begins: re.Pattern[bytes] = RECORD) -> None:
        """SceneError where the texts of all records so far, each with those before it, are too long."""
        found = None
        for found in begins.finditer(data):
            self._taken += self._length + found.start()
            if self._taken > MOST_JOINED:
                text = f"each joined to all before it, have more than {MOST_JOINED >> 20} MiB"
                raise SceneError(f"{self._name}: its keywords (IPTC), {text}; save it without")
        self._length += len(data) if found else 0  # what is no text of IPTC does not count

    def add_packet(self) -> None:
        """SceneError where there are too many packets."""
        self._packets += 1
        if self._packets > MOST_PACKETS:
            raise SceneError(f"{self._name}: has more than {MOST_PACKETS} packets of XMP; save it with one")
