"""What a picture's file holds beside the picture: as much as programs write is read, more is refused at once.

The library makes attributes of it, in time and memory that grow with its square.
"""

from __future__ import annotations

import struct
import zlib
from io import BytesIO
from pathlib import Path

import numpy as np
import pytest
import tifffile
from PIL import Image as Pillow

from clrt.base.errors import ClrtWarning, SceneError
from clrt.images.image import read_image
from clrt.images.joined import MOST_PACKETS
from clrt.images.jpeg import MOST_COMMENTS
from tests.cost import bounded

PICTURE = np.full((2, 2, 3), 99, np.uint8)


def attribute(name: bytes, kind: bytes, value: bytes) -> bytes:
    return name + b"\0" + kind + b"\0" + struct.pack("<I", len(value)) + value


def channel_list(names: list[bytes]) -> bytes:
    return b"".join(name + b"\0" + struct.pack("<IIII", 2, 0, 1, 1) for name in names) + b"\0"


def header(names: list[bytes] | None = None, more: bytes = b"") -> bytes:
    """Of an EXR of 2 x 2 floats, not compressed, without the zero that ends it."""
    window = struct.pack("<4i", 0, 0, 1, 1)
    return b"".join(
        attribute(*one)
        for one in (
            (b"channels", b"chlist", channel_list(names or [b"B", b"G", b"R"])),
            (b"compression", b"compression", b"\0"),
            (b"dataWindow", b"box2i", window),
            (b"displayWindow", b"box2i", window),
            (b"lineOrder", b"lineOrder", b"\0"),
            (b"pixelAspectRatio", b"float", struct.pack("<f", 1)),
            (b"screenWindowCenter", b"v2f", bytes(8)),
            (b"screenWindowWidth", b"float", struct.pack("<f", 1)),
        )
    ) + more  # fmt: skip


def exr(path: Path, *headers: bytes, samples: int = 3) -> Path:
    """A file of one part, or of several, whose samples are all 0.5."""
    begins = struct.pack("<II", 20000630, 2 | 0x400 | (0x1000 if len(headers) > 1 else 0))
    if len(headers) > 1:
        own = (
            attribute(b"name", b"string", b"%d" % part)
            + attribute(b"type", b"string", b"scanlineimage")
            + attribute(b"chunkCount", b"int", struct.pack("<I", 2))
            for part in range(len(headers))
        )
        begins += b"".join(one + more + b"\0" for one, more in zip(headers, own, strict=True)) + b"\0"
    else:
        begins += headers[0] + b"\0"
    values = struct.pack("<f", 0.5) * 2 * samples
    rows = [struct.pack("<ii", y, len(values)) + values for y in (0, 1)] * len(headers)
    if len(headers) > 1:
        rows = [struct.pack("<I", number // 2) + row for number, row in enumerate(rows)]
    place, places = len(begins) + 8 * len(rows), b""
    for row in rows:
        places += struct.pack("<Q", place)
        place += len(row)
    path.write_bytes(begins + places + b"".join(rows))
    return path


def many(count: int, kind: bytes = b"int", value: bytes = bytes(4)) -> bytes:
    return b"".join(attribute(b"a%x" % number, kind, value) for number in range(count))


def segment(kind: int, data: bytes) -> bytes:
    return bytes([0xFF, kind]) + struct.pack(">H", len(data) + 2) + data


def jpeg(path: Path, *segments: bytes) -> Path:
    file = BytesIO()
    Pillow.fromarray(PICTURE).save(file, "JPEG")
    path.write_bytes(file.getvalue()[:2] + b"".join(segments) + file.getvalue()[2:])
    return path


def records(words: list[str]) -> bytes:
    return b"".join(b"\x1c\x02\x19" + struct.pack(">H", len(word)) + word.encode() for word in words)


def photoshop(data: bytes) -> bytes:
    return segment(0xED, b"Photoshop 3.0\x008BIM\x04\x04\0\0" + struct.pack(">I", len(data)) + data)


def packet(word: str) -> bytes:
    return f"<rdf:Description><dc:subject>{word}</dc:subject></rdf:Description>".encode()


def text_chunk(kind: bytes, data: bytes) -> bytes:
    return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))


def png(path: Path, *chunks: bytes) -> Path:
    file = BytesIO()
    Pillow.fromarray(PICTURE).save(file, "PNG")
    path.write_bytes(file.getvalue()[:33] + b"".join(chunks) + file.getvalue()[33:])
    return path


@pytest.mark.parametrize(("kind", "value"), [(b"int", bytes(4)), (b"string", b"xx"), (b"strange", b"xx")])
def test_attributes_of_an_exr_are_counted(tmp_path: Path, kind: bytes, value: bytes) -> None:
    found = bounded("picture", exr(tmp_path / "a.exr", header(more=many(30_000, kind, value))))
    assert found.error.endswith("a.exr: has more than 1024 attributes in a part; save it with fewer")


@pytest.mark.parametrize("name", [b"channels", b"others"])
def test_channels_of_an_exr_are_counted(tmp_path: Path, name: bytes) -> None:
    listed = channel_list([b"%x" % number for number in range(100_000)])
    head = attribute(name, b"chlist", listed) + (b"" if name == b"channels" else header())
    found = bounded("picture", exr(tmp_path / "a.exr", head))
    assert found.error.endswith("a.exr: has more than 1024 channels in a part; save it with fewer")


def test_each_part_of_an_exr_is_looked_at(tmp_path: Path) -> None:
    parts = [header()] * 3
    assert read_image(exr(tmp_path / "a.exr", *parts)).shape == (2, 2, 3)
    with pytest.raises(SceneError, match="more than 1024 attributes"):
        read_image(exr(tmp_path / "a.exr", *parts, header(more=many(1024))))
    with pytest.raises(SceneError, match="more than 1024 channels"):
        read_image(exr(tmp_path / "a.exr", header(), header([b"c%04d" % k for k in range(1025)])))


def test_an_exr_of_many_layers_and_attributes_is_read(tmp_path: Path) -> None:
    """64 view layers of six passes, as Blender names them, names of 250 bytes, 900 attributes."""
    passes = b"A", b"B", b"G", b"R", b"U", b"Z"
    layers = [b"%s%02d.%s" % (b"L" * 230, number, one) for number in range(64) for one in passes]
    names = sorted([*layers, b"B", b"G", b"R"])
    path = exr(tmp_path / "a.exr", header(names, many(900)), samples=len(names))
    assert (read_image(path) == 0.5).all()
    most = sorted([*(b"S%04d" % k for k in range(1021)), b"B", b"G", b"R"])
    assert (read_image(exr(tmp_path / "b.exr", header(most), samples=1024)) == 0.5).all()
    assert bounded("picture", exr(tmp_path / "c.exr", *[header(more=many(500))] * 60)).error == ""


def test_a_header_of_an_exr_that_is_not_whole(tmp_path: Path) -> None:
    whole = exr(tmp_path / "a.exr", header()).read_bytes()
    assert (read_image(tmp_path / "a.exr") == 0.5).all()
    ends = 8 + len(header())
    for data in (
        *(whole[:last] for last in range(5, ends, 7)),
        whole[:ends],
        whole[:8] + b"n" * 256 + b"\0" + whole[8:],
        whole[:8] + b"n\0" + b"t" * 256 + b"\0" + whole[8:],
        whole[:8] + b"n\0t\0" + b"\xff" * 4 + whole[8:],
        whole[:8] + attribute(b"c", b"chlist", b"n" * 256 + bytes(17)) + whole[8:],
    ):
        (tmp_path / "a.exr").write_bytes(data)
        with pytest.raises(SceneError, match="cannot be read: its header is broken, or cut short, at byte"):
            read_image(tmp_path / "a.exr")
    (tmp_path / "a.exr").write_bytes(whole.replace(channel_list([b"B", b"G", b"R"]), b"B" * 55))
    with pytest.raises(SceneError, match="cannot be read"):
        read_image(tmp_path / "a.exr")


def test_keywords_of_a_jpeg_are_counted(tmp_path: Path) -> None:
    block = photoshop(records(["k"] * 9000))
    found = bounded("picture", jpeg(tmp_path / "a.jpg", block, block, block))
    assert "its keywords (IPTC), each joined to all before it, have more than 32 MiB" in found.error
    assert read_image(jpeg(tmp_path / "b.jpg", *[photoshop(records(["k"] * 1500))] * 2)).shape == (2, 2, 3)
    with pytest.raises(SceneError, match=r"its keywords \(IPTC\)"):  # those of all segments are joined
        read_image(jpeg(tmp_path / "b.jpg", *[photoshop(records(["k"] * 1500))] * 3))


@pytest.mark.parametrize("order", ["<", ">"])
@pytest.mark.parametrize("swapped", [False, True])
def test_keywords_of_a_tiff_are_counted(tmp_path: Path, order: str, swapped: bool) -> None:
    """Also where they are long whole numbers, which are turned round."""
    data = records(["k"] * 20_000)
    tag = (33723, "B", len(data), data, True)
    if swapped:
        tag = (33723, "I", len(data) // 4, np.frombuffer(data, ">u4").tolist(), True)
    tifffile.imwrite(tmp_path / "a.tif", PICTURE, photometric="rgb", byteorder=order, extratags=[tag])
    found = bounded("picture", tmp_path / "a.tif")
    assert "its keywords (IPTC), each joined to all before it, have more than 32 MiB" in found.error


def test_keywords_that_programs_write_are_no_matter(tmp_path: Path) -> None:
    """500 of them, before a small picture and paths in segments of 64 KiB, whose bytes may be any."""
    words = records([f"keyword number {number}" for number in range(500)])
    rest = np.random.default_rng(1).integers(0, 256, (16, 65_000)).astype(np.uint8)
    others = (segment(0xED, b"Photoshop 3.0\x008BIM\x04\x0c\0\0" + row.tobytes()) for row in rest)
    assert read_image(jpeg(tmp_path / "a.jpg", photoshop(words), *others)).shape == (2, 2, 3)
    tag = (33723, "B", len(words), words, True)
    tifffile.imwrite(tmp_path / "a.tif", PICTURE, photometric="rgb", extratags=[tag])
    assert read_image(tmp_path / "a.tif").shape == (2, 2, 3)
    assert read_image(jpeg(tmp_path / "b.jpg", segment(0xED, b"Adobe_CM" + words * 4))).shape == (2, 2, 3)


def test_comments_of_a_jpeg_are_counted(tmp_path: Path) -> None:
    path = tmp_path / "a.jpg"
    found = bounded("picture", jpeg(path, *(segment(0xFE, b"k%d:v" % number) for number in range(20_000))))
    assert found.error.endswith("a.jpg: has more than 1000 comments; save it without")
    comments = [segment(0xFE, b"k%d:v" % number) for number in range(MOST_COMMENTS + 1)]
    assert read_image(jpeg(path, *comments[1:])).shape == (2, 2, 3)
    with pytest.raises(SceneError, match="more than 1000 comments"):
        read_image(jpeg(path, *comments))


def test_packets_of_xmp_are_counted(tmp_path: Path) -> None:
    """Keywords of each are joined to those of all before it."""
    adobe = b"http://ns.adobe.com/"
    found = bounded("picture", jpeg(tmp_path / "a.jpg", *(
        segment(0xE1, adobe + b"xap/1.0/\0" + packet(f"{number:06}")) for number in range(10_000)
    )))  # fmt: skip
    assert found.error.endswith("a.jpg: has more than 16 packets of XMP; save it with one")
    key = b"XML:com.adobe.xmp\0"
    found = bounded("picture", png(tmp_path / "a.png", *(
        text_chunk(b"tEXt", key + packet(f"{number:06}" + "x" * 1000)) for number in range(900)
    )))  # fmt: skip
    assert found.error.endswith("a.png: has more than 16 packets of XMP; save it with one")
    extended = [segment(0xE1, adobe + b"xmp/extension/\0" + bytes(60_000))] * 50  # pictures with their depth
    some = [segment(0xE1, adobe + b"xap/1.0/\0" + packet("a"))] * MOST_PACKETS
    assert read_image(jpeg(tmp_path / "b.jpg", *some, *extended)).shape == (2, 2, 3)
    with pytest.raises(SceneError, match="more than 16 packets of XMP"):
        read_image(jpeg(tmp_path / "b.jpg", *some, some[0]))
    some = [text_chunk(kind, b"Comment\0" + packet("a")) for kind in (b"tEXt", b"iTXt") * 10]
    assert read_image(png(tmp_path / "b.png", *some, text_chunk(b"tEXt", key + packet("a")))).shape


@pytest.mark.parametrize("place", [2**63, 2**64 - 1, 10**6])
def test_a_tiff_whose_fields_lie_beyond_any_file(tmp_path: Path, place: int) -> None:
    path = tmp_path / "a.tif"
    path.write_bytes(b"II+\0\x08\0\0\0" + struct.pack("<Q", place) + bytes(100))
    with pytest.raises(SceneError, match=r"a\.tif: cannot be read"):
        read_image(path)
    primaries = struct.pack("<HHQQ", 319, 5, 6, place) + struct.pack("<HHQQ", 33723, 1, 99, place)
    tifffile.imwrite(path, PICTURE, photometric="rgb", bigtiff=True, metadata=None)
    data = path.read_bytes()
    (at,) = struct.unpack_from("<Q", data, 8)
    (count,) = struct.unpack_from("<Q", data, at)
    fields = data[at + 8 : at + 8 + 20 * count]
    path.write_bytes(
        data[:8] + struct.pack("<Q", len(data)) + data[16:]
        + struct.pack("<Q", count + 2) + fields + primaries + bytes(8)
    )  # fmt: skip
    with pytest.warns(ClrtWarning, match="its primaries are"):  # what of them there is
        assert read_image(path).shape == (2, 2, 3)
