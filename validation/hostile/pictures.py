"""Pictures whose headers declare something else than they hold, whole otherwise: lengths and CRCs are right.

Each function takes a good file apart, changes a declared field, and puts it together again, so that the
change reaches what decodes the pixels, and is not refused as damage before.
"""

from __future__ import annotations

import random
import re
import struct
import zlib
from collections.abc import Callable
from typing import Final

from .sizes import size

_PNG_TEXT: Final = (
    b"tEXt",
    b"zTXt",
    b"iTXt",
    b"iCCP",
    b"eXIf",
    b"tRNS",
    b"PLTE",
    b"gAMA",
    b"cHRM",
    b"sBIT",
    b"acTL",
)
_OF_MATTES: Final = (
    b"", b"[]", b"null", b"{", b'{"shapes[0]": 1}', b'{"shapes[0]": []}', b'{"a": "zz"}', b"[" * 20_000,
    b'{"a":' * 9999, b"\xff" * 99, b"crypto_shape", b"crypto_nothing", b"9" * 5000,
    b'{"\\ud800": "00000000"}', b'"' + b"a" * 1_000_000 + b'"',
)  # fmt: skip
"""What the attributes of mattes hold: names of layers, manifests in JSON."""


def spoil(draw: random.Random, suffix: str, data: bytes) -> bytes:
    """One change of a declared field of a picture of this format; other formats as they are."""
    change = _FORMATS.get(suffix)
    return change(draw, data) if change else data


def png_chunks(data: bytes) -> list[tuple[bytes, bytes]]:
    """Kind and contents of all chunks."""
    chunks, at = [], 8
    while at + 12 <= len(data):
        (length,) = struct.unpack_from(">I", data, at)
        chunks.append((data[at + 4 : at + 8], data[at + 8 : at + 8 + length]))
        at += 12 + length
    return chunks


def png_bytes(chunks: list[tuple[bytes, bytes]]) -> bytes:
    """A PNG file of these chunks, with their lengths and CRCs."""
    parts = [b"\x89PNG\r\n\x1a\n"]
    for kind, body in chunks:
        parts.append(struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body)))
    return b"".join(parts)


def _png(draw: random.Random, data: bytes) -> bytes:
    chunks = png_chunks(data)
    choice = draw.random()
    if choice < 0.5:
        header = list(struct.unpack(">IIBBBBB", chunks[0][1]))
        for _ in range(draw.choice((1, 1, 2))):
            field = draw.randrange(7)
            header[field] = size(draw, 32) if field < 2 else draw.choice((0, 1, 2, 3, 4, 6, 8, 16, 255))
        chunks[0] = (b"IHDR", struct.pack(">IIBBBBB", *header))
    elif choice < 0.7:  # as many pixels as declared, which deflate holds in a thousandth
        width, height = draw.choice(((4096, 2048), (1, 1 << 22), (1 << 22, 1), (1024, 1024)))
        packed = zlib.compress(bytes(height * (width + 1)), 1)
        chunks = [
            (b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 0, 0, 0, 0)),
            (b"IDAT", packed),
            (b"IEND", b""),
        ]
    elif choice < 0.9:
        kind = draw.choice(_PNG_TEXT)
        body = draw.choice((b"", b"\xff" * 12, b"a\0\0" + zlib.compress(bytes(1 << 24), 1), bytes(1 << 16)))
        chunks[1:1] = [(kind, body)] * draw.choice((1, 1, 2, 1000))
    else:
        chunks.insert(draw.randrange(len(chunks)), draw.choice(chunks))
    return png_bytes(chunks)


def _jpeg(draw: random.Random, data: bytes) -> bytes:
    """Size, samples and components of the frame, and lengths of segments."""
    marks = [match.start() for match in re.finditer(rb"\xff[\xc0-\xc2\xc4\xda\xdb\xdd\xe0-\xef]", data)]
    frame = next((at for at in marks if data[at + 1] in (0xC0, 0xC1, 0xC2)), None)
    if frame is not None and draw.random() < 0.7:
        field = draw.choice(((4, ">B", 8), (5, ">H", 16), (7, ">H", 16), (9, ">B", 8), (11, ">B", 8)))
        return _put(data, frame + field[0], field[1], size(draw, field[2]))
    return _put(data, draw.choice(marks) + 2, ">H", size(draw, 16)) if marks else data


def _bmp(draw: random.Random, data: bytes) -> bytes:
    """Sizes of file and header, where pixels begin, width, height, planes, bits, compression, colours."""
    fields = (
        (2, 32),
        (10, 32),
        (14, 32),
        (18, 32),
        (22, 32),
        (26, 16),
        (28, 16),
        (30, 32),
        (34, 32),
        (46, 32),
    )
    at, bits = draw.choice(fields)
    return _put(data, at, "<I" if bits == 32 else "<H", size(draw, bits))


def _tiff(draw: random.Random, data: bytes) -> bytes:
    """Kind, count or value of an entry of the directory, the number of entries, or the next directory."""
    order = "<" if data[:2] == b"II" else ">"
    (folder,) = struct.unpack_from(order + "I", data, 4)
    (entries,) = struct.unpack_from(order + "H", data, folder)
    choice = draw.random()
    if choice < 0.05:
        return _put(data, folder, order + "H", size(draw, 16))
    if choice < 0.1:  # again from the first one, without end
        return _put(data, folder + 2 + 12 * entries, order + "I", folder)
    entry = folder + 2 + 12 * draw.randrange(entries)
    if choice < 0.2:  # tile sizes, sample formats, subfiles, depth, in place of what the entry was
        return _put(
            data, entry, order + "H", draw.choice((322, 323, 324, 325, 330, 339, 32997, 34377, 34675))
        )
    if choice < 0.3:
        return _put(data, entry + 2, order + "H", draw.choice((0, 1, 2, 3, 4, 5, 12, 13, 16, 255)))
    if choice < 0.5:
        return _put(data, entry + 4, order + "I", size(draw, 32))
    return _put(data, entry + 8, order + "I", size(draw, 32))


def exr_parts(data: bytes) -> tuple[list[tuple[bytes, bytes, bytes]], int]:
    """Attributes (name, type, value) of an EXR header, and where the header ends."""
    attributes, at = [], 8
    while data[at]:
        name, kind, rest = data[at:].split(b"\0", 2)
        at += len(name) + len(kind) + 2
        (length,) = struct.unpack_from("<i", rest)
        attributes.append((name, kind, data[at + 4 : at + 4 + length]))
        at += 4 + length
    return attributes, at + 1


def _exr(draw: random.Random, data: bytes) -> bytes:
    attributes, end = exr_parts(data)
    named = {name: index for index, (name, _, _) in enumerate(attributes)}
    mattes = [index for index, (name, _, _) in enumerate(attributes) if name.startswith(b"cryptomatte/")]
    choice = draw.random()
    if mattes and choice < 0.4:
        index = draw.choice(mattes)
        attributes[index] = (*attributes[index][:2], draw.choice(_OF_MATTES))
    elif choice < 0.45:
        name = draw.choice((b"dataWindow", b"displayWindow"))
        box = list(struct.unpack("<4i", attributes[named[name]][2]))
        for _ in range(draw.choice((1, 1, 2, 4))):
            box[draw.randrange(4)] = (size(draw, 32) ^ 1 << 31) - (1 << 31)
        attributes[named[name]] = (name, b"box2i", struct.pack("<4i", *box))
    elif choice < 0.75:
        named_so = (b"R", b"G", b"B") if draw.random() < 0.5 else ()
        many = draw.choice((0, 1, 4, 100, 1000, 1024, 5000))
        names = sorted([*named_so, *(b"c%05d" % number for number in range(many))])
        kind, step = draw.choice((0, 1, 2, 2, 9)), draw.choice((1, 1, 1, 0, 2, -1, 2**31 - 1))
        channels = b"".join(n + b"\0" + struct.pack("<iiii", kind, 0, step, step) for n in names)
        attributes[named[b"channels"]] = (b"channels", b"chlist", channels + b"\0")
    elif choice < 0.9:
        name = draw.choice(
            (b"compression", b"lineOrder", b"tiles", b"chunkCount", b"type", b"maxSamplesPerPixel")
        )
        value = draw.choice(
            (b"\x00", b"\x09", b"\xff", bytes(9), b"\xff" * 9, struct.pack("<IIB", 2**31 - 1, 1, 2))
        )
        attributes = [(n, k, v) for n, k, v in attributes if n != name] + [(name, name, value)]
    else:
        text = draw.choice((b"a" * 10, b"a" * 1_000_000, b"\x1b[31m\n"))
        attributes += [(b"x%d" % number, b"string", text) for number in range(draw.choice((1, 3)))]
    header = b"".join(n + b"\0" + k + b"\0" + struct.pack("<i", len(v)) + v for n, k, v in attributes)
    moved = len(header) + 9 - end  # the table of chunks counts from the file's beginning
    (chunk,) = struct.unpack_from("<Q", data, end)
    return data[:8] + header + b"\0" + struct.pack("<Q", max(chunk + moved, 0)) + data[end + 8 :]


def _hdr(draw: random.Random, data: bytes) -> bytes:
    """The line with the size, or another line of the header."""
    numbers = b"%d" % draw.choice((0, 1, 7, 9, 65536, 2**26, 2**31 - 1, 2**31, 2**32, 2**64, -1))
    choice = draw.random()
    if choice < 0.6:
        axis = draw.choice((rb"(?<=-Y )\d+", rb"(?<=\+X )\d+"))
        return re.sub(axis, numbers, data, count=1)
    if choice < 0.8:
        return re.sub(
            rb"-Y (\d+) \+X", draw.choice((rb"+Y \1 -X", rb"+X \1 +Y", rb"-Y \1 \1 +X")), data, count=1
        )
    line = draw.choice((b"EXPOSURE=" + numbers, b"GAMMA=0", b"FORMAT=32-bit_rle_xyze", b"#" * 1_000_000))
    return data.replace(b"\n", b"\n" + line + b"\n", 1)


def _put(data: bytes, at: int, form: str, value: int) -> bytes:
    """The data with one number overwritten; as they are where they end before."""
    length = struct.calcsize(form)
    if at + length > len(data):
        return data
    return data[:at] + struct.pack(form, value & ((1 << 8 * length) - 1)) + data[at + length :]


_FORMATS: Final[dict[str, Callable[[random.Random, bytes], bytes]]] = {
    ".png": _png, ".jpg": _jpeg, ".bmp": _bmp, ".tif": _tiff, ".exr": _exr, ".hdr": _hdr,
}  # fmt: skip
