"""Checkpoints (numpy archives, zip files) that declare something else than they hold, with valid CRCs."""

from __future__ import annotations

import io
import json
import math
import random
import re
import struct
import zipfile
from typing import Any, Final

from .sizes import SIZES, size

_METHODS: Final = (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED, zipfile.ZIP_BZIP2, zipfile.ZIP_LZMA)
_TYPES: Final = (
    "|b1",
    "<f4",
    ">f4",
    "<f8",
    "<c16",
    "|u1",
    "<i8",
    "|O",
    "|V0",
    "<U9",
    "<M8[s]",
    "[('a', '<f4')]",
    "x",
)


def spoil(draw: random.Random, data: bytes) -> bytes:
    """One change of what a numpy archive declares."""
    entries = contents(data)
    at = draw.randrange(len(entries))
    name, array = entries[at]
    method = zipfile.ZIP_STORED
    choice = draw.random()
    if choice < 0.2:
        entries[at] = (name, _array(draw, array))
    elif choice < 0.35:
        entries[at] = (name, _number(draw, array))
    elif choice < 0.55:
        at = next(number for number, (name, _) in enumerate(entries) if name == "told.npy")
        entries[at] = ("told.npy", _told(draw, entries[at][1]))
    elif choice < 0.65:  # an array of zeros many times as long as the file
        entries[at] = (name, array + bytes(draw.choice((1 << 20, 1 << 26))))
        method = zipfile.ZIP_DEFLATED
    elif choice < 0.75:
        method = draw.choice(_METHODS)
    elif choice < 0.85:
        names = ("pixels.npy", "done.npy", "layer depth.npy", "../x.npy", "told", "\u202e\x1b[31m.npy", "")
        entries[at] = (draw.choice(names), array)
    elif choice < 0.92:
        entries += [entries[at]] * draw.choice((1, 2000))
    else:
        del entries[at]
    packed = _packed(entries, method)
    return _declared(draw, packed) if choice >= 0.65 and draw.random() < 0.6 else packed


def contents(data: bytes) -> list[tuple[str, bytes]]:
    """Names and bytes of the archive's files."""
    with zipfile.ZipFile(io.BytesIO(data)) as archive:
        return [(name, archive.read(name)) for name in archive.namelist()]


def _packed(entries: list[tuple[str, bytes]], method: int) -> bytes:
    """An archive of these; always the same bytes."""
    held = io.BytesIO()
    with zipfile.ZipFile(held, "w") as archive:
        names: set[str] = set()
        for name, body in entries:
            archive.NameToInfo.pop(name, None)  # else zipfile warns of a name that stands there twice
            names.add(name)
            info = zipfile.ZipInfo(name, (1980, 1, 1, 0, 0, 0))
            info.compress_type = method
            archive.writestr(info, body, compresslevel=1)
    return held.getvalue()


def _array(draw: random.Random, array: bytes) -> bytes:
    """Shape, type or order of a numpy array, or the header itself."""
    (length,) = struct.unpack_from("<H", array, 8)
    header, rest = array[10 : 10 + length].decode("latin-1"), array[10 + length :]
    choice = draw.random()
    if choice < 0.5:
        sides = ", ".join(str(draw.choice(SIZES)) for _ in range(draw.choice((0, 1, 2, 3, 3, 40))))
        header = re.sub(r"\([^()]*\)", lambda _: f"({sides},)" if sides else "()", header)
    elif choice < 0.8:
        header = re.sub(r"'descr': '[^']*'", lambda _: f"'descr': {draw.choice(_TYPES)!r}", header)
    elif choice < 0.9:
        header = draw.choice(("(" * 200_000, "[" * 3000, "{" + header, "9" * 5000, "{'a': 1}", "", "\0"))
    else:
        header = header.replace("False", "True")
    if len(header) > 65535:  # version 2 has room for it
        return array[:6] + b"\x02\x00" + struct.pack("<I", len(header)) + header.encode() + rest
    return array[:8] + struct.pack("<H", len(header)) + header.encode("latin-1") + rest


def _number(draw: random.Random, array: bytes) -> bytes:
    """Numbers of an array, which keeps its size, by those that no render makes."""
    (length,) = struct.unpack_from("<H", array, 8)
    start = 10 + length
    if len(array) < start + 8:
        return array + b"x"
    number = struct.pack("<f", draw.choice((math.nan, math.inf, -math.inf, -1.0, 1e38, -1e38, 2e30)))
    if draw.random() < 0.3:  # all of them
        return array[:start] + (number * (len(array) // 4))[: len(array) - start]
    at = start + 4 * draw.randrange((len(array) - start) // 4)
    return array[:at] + number + array[at + 4 :]


def _told(draw: random.Random, array: bytes) -> bytes:
    """The text of a checkpoint: what was rendered, and how many rays of each kind."""
    (length,) = struct.unpack_from("<H", array, 8)
    told: dict[str, Any] = json.loads(array[10 + length :])
    value: Any = draw.choice(
        (None, [], {}, "", "x", -1, 1e308, [[]], [None], [{"x": "y"}], [{}] * 10**5, [{"camera": size(draw)}],
         [{"photons": 1}], [{"camera": 2**63 - 1}], [{}, {"ambient": 2**62}])
    )
    key = draw.choice(("rays", "rays", "job", "mark"))
    if key == "job" and draw.random() < 0.7:
        told["job"][draw.choice(list(told["job"]))] = draw.choice((value, "x" * 10**6, "\x1b[31m\n"))
    else:
        told[key] = value
    text = json.dumps(told).encode() if draw.random() < 0.9 else b"[" * 100_000
    header = f"{{'descr': '|u1', 'fortran_order': False, 'shape': ({len(text)},), }}\n".encode()
    return array[:8] + struct.pack("<H", len(header)) + header + text


def _declared(draw: random.Random, packed: bytes) -> bytes:
    """Flags, method, lengths or place of an entry in the archive's directory."""
    at = packed.rindex(b"PK\x01\x02") if draw.random() < 0.5 else packed.index(b"PK\x01\x02")
    offset, form, bits = draw.choice(
        (
            (8, "<H", 16),
            (10, "<H", 16),
            (20, "<I", 32),
            (24, "<I", 32),
            (28, "<H", 16),
            (30, "<H", 16),
            (42, "<I", 32),
        )
    )
    value: Any = draw.choice((1, 8, 9, 12, 14, 93, 99)) if offset < 20 else size(draw, bits)
    at += offset
    return packed[:at] + struct.pack(form, value) + packed[at + struct.calcsize(form) :]
