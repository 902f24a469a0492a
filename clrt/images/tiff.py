"""What a TIFF file itself says of its pages, where its library is silent or takes more than the file has.

The library makes a grey picture of a page whose palette is short, tells nobody of primaries, and copies the
values of each field, even where thousands of fields share the same bytes.
"""

from __future__ import annotations

import os
import struct
from collections.abc import Iterator
from itertools import islice
from typing import BinaryIO, Final

import numpy as np

from clrt.base.errors import SceneError
from clrt.images.joined import ANY_ORDER, Joined

MEANING: Final = 262
"""The number of PhotometricInterpretation."""
SAMPLES_A_PIXEL: Final = 277
MOST_PARTS: Final = 100
"""Pages, or parts of an EXR, among which the picture is looked for."""
REC709: Final = (0.64, 0.33, 0.30, 0.60, 0.15, 0.06, 0.3127, 0.3290)
"""x and y of red, green, blue and white."""

_BIG: Final = 43  # the number of files with places of 64 bits
_KINDS: Final = {1: "B", 3: "H"}  # of whole numbers; others have 32 bits
_BYTES: Final = np.zeros(1 << 16)  # of one value, by its type; values of other types are passed over
_BYTES[1:14] = 1, 1, 2, 4, 8, 1, 1, 2, 4, 8, 4, 8, 4
_BYTES[16:19] = 8
_WITHIN: Final = (34665, 34853, 40965)  # fields that say where fields of Exif begin
_IPTC: Final = 33723
_SHARED: Final = 1 << 20  # bytes that fields of a real file may share, with room
_TRANSFER, _WHITE, _PRIMARIES, _RATIONAL, _SHORT = 301, 318, 319, 5, 3
_DEVIATES: Final = 0.03  # from sRGB's curve, more than one of gamma 2.2 does


class Pages:
    """The pages of an open TIFF file, each as its fields (n,): number, type, how many values, and these or
    their place. struct.error where the file ends before."""

    def __init__(self, file: BinaryIO) -> None:
        file.seek(0)
        begins = file.read(16)
        self.file, self.order = file, "<" if begins.startswith(b"II") else ">"
        self.big = struct.unpack_from(f"{self.order}H", begins, 2)[0] == _BIG
        self.place = struct.Struct(self.order + "IQ"[self.big])
        short, long = f"{self.order}u2", f"{self.order}u{self.place.size}"
        self.field = np.dtype([("number", short), ("kind", short), ("count", long), ("values", long)])
        (self.first,) = self.place.unpack_from(begins, self.place.size)

    def seek(self, place: int) -> None:
        """Go there, or to the file's end: the system takes no places beyond 63 bits."""
        self.file.seek(min(place, os.fstat(self.file.fileno()).st_size))

    def at(self, place: int) -> tuple[np.ndarray, int]:
        """The fields that begin there, and where the next page does; 0 after the last."""
        count = struct.Struct(self.order + "HQ"[self.big])
        self.seek(place)
        (fields,) = count.unpack(self.file.read(count.size))
        if fields * self.field.itemsize > _left(self.file):
            raise struct.error
        found = np.frombuffer(self.file.read(fields * self.field.itemsize), self.field)
        return found, self.place.unpack(self.file.read(self.place.size))[0]

    def __iter__(self) -> Iterator[np.ndarray]:
        place, seen = self.first, set[int]()
        while place and place not in seen:
            seen.add(place)
            fields, place = self.at(place)
            yield fields

    def numbers(self, fields: np.ndarray, number: int, kind: int, most: int) -> np.ndarray | None:
        """The first values, up to so many, of a field of shorts or rationals; None where there is none."""
        field = fields[(fields["number"] == number) & (fields["kind"] == kind)][:1]
        if not field.size:
            return None
        size, data = int(field["count"][0]) * int(_BYTES[kind]), field["values"].tobytes()
        if size > len(data):
            self.seek(int(field["values"][0]))
            data = self.file.read(most * int(_BYTES[kind]))
        data = data[: size // 8 * 8]
        if kind == _SHORT:
            return np.frombuffer(data, f"{self.order}u2").astype(np.float64)
        over, under = np.frombuffer(data, f"{self.order}u4").reshape(-1, 2).T
        return over / np.maximum(under, 1)


def _left(file: BinaryIO) -> int:
    return os.fstat(file.fileno()).st_size - file.tell()


def check_tiff(file: BinaryIO, name: str) -> None:
    """Raise `SceneError` for a TIFF file, open for reading, whose fields have more bytes than it, or with
    too many keywords."""
    size, taken, joined = os.fstat(file.fileno()).st_size, 0.0, Joined(name)
    try:
        found = Pages(file)
        for fields in islice(found, MOST_PARTS):
            waiting = [fields]
            for some in waiting:
                taken += some.nbytes + (some["count"] * _BYTES[some["kind"]]).sum()
                if taken > size + _SHARED:
                    text = f"its fields have {taken:.0f} bytes, the file {size}; save it anew"
                    raise SceneError(f"{name}: {text}")
                if some is fields:
                    inner = some[np.isin(some["number"], _WITHIN)]["values"][: len(_WITHIN)]
                    waiting += [found.at(int(place))[0] for place in inner]
                for field in some[some["number"] == _IPTC]:
                    found.seek(int(field["values"]))
                    joined.add_records(file.read(int(field["count"] * _BYTES[field["kind"]])), ANY_ORDER)
    except struct.error:  # it ends before: the library says so
        return


def first_values(file: BinaryIO, page: int, name: str) -> dict[int, int]:
    """The fields of a page, open for reading: number -> the first value of those two that have a name here.

    SceneError where the file ends before.
    """
    found = dict[int, int]()
    pages, fields = _page(file, page, name)
    for k in np.flatnonzero(np.isin(fields["number"], (MEANING, SAMPLES_A_PIXEL))):
        kind = pages.order + _KINDS.get(int(fields["kind"][k]), "I")
        (found[int(fields["number"][k])],) = struct.unpack_from(kind, fields["values"][k : k + 1].tobytes())
    return found


def _page(file: BinaryIO, page: int, name: str) -> tuple[Pages, np.ndarray]:
    try:
        pages = Pages(file)
        return pages, next(fields for number, fields in enumerate(pages) if number == page)
    except (struct.error, StopIteration):
        raise SceneError(f"{name}: cannot be read: it ends before the fields of its page do") from None


def primaries(file: BinaryIO, page: int, name: str) -> list[float] | None:
    """x and y of red, green, blue and white, as a page declares them; None where it does not."""
    pages, fields = _page(file, page, name)
    six = pages.numbers(fields, _PRIMARIES, _RATIONAL, 6)
    white = pages.numbers(fields, _WHITE, _RATIONAL, 2)
    if six is None and white is None:
        return None
    # of what is not said Rec.709's are meant
    return [*(REC709[:6] if six is None else six), *(REC709[6:] if white is None else white)]


def has_other_curve(file: BinaryIO, page: int, name: str) -> bool:
    """Whether a page has a table of what its numbers mean, and it is not sRGB's curve."""
    pages, fields = _page(file, page, name)
    table = pages.numbers(fields, _TRANSFER, _SHORT, 1 << 16)
    if table is None or len(table) < 2:
        return False
    if len(table) % 3 == 0:  # one for each colour, of a power of two
        table = table[: len(table) // 3]
    value = np.linspace(0.0, 1.0, len(table))
    curve = np.where(value <= 0.04045, value / 12.92, ((value + 0.055) / 1.055) ** 2.4)
    return bool((np.abs(table / 65535 - curve) > _DEVIATES).any())
