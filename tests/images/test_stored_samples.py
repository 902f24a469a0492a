"""Samples that the picture library unpacks wrongly are refused, those that it unpacks rightly are read."""

from __future__ import annotations

import struct
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest
import tifffile

from clrt.base.errors import SceneError
from clrt.images.image import read_image
from clrt.images.tiff import first_values

SIZE = (6, 16)
RANDOM = np.random.default_rng(3)
Tag = tuple[int, str, list[int]]


def packed(values: np.ndarray, bits: int) -> bytes:
    """Rows of numbers of so many bits, each row filled up to whole bytes; in Intel's order where they are."""
    if bits == 16:
        return values.astype("<u2").tobytes()
    text = ["".join(f"{value:0{bits}b}" for value in row.ravel()) for row in values]
    return b"".join(int(row, 2).to_bytes(len(row) // 8, "big") for row in text)


def tiff(
    path: Path, data: bytes, bits: int, samples: int, meaning: int, *more: Tag, order: str = "<"
) -> Path:
    """A TIFF of one strip, from the 1992 specification."""
    height, width = SIZE
    tags: list[Tag] = [
        (256, "I", [width]), (257, "I", [height]), (258, "H", [bits] * samples), (259, "H", [1]),
        (262, "H", [meaning]), (273, "I", [0]), (277, "H", [samples]), (278, "I", [height]),
        (279, "I", [len(data)]), (284, "H", [1]), *more,
    ]  # fmt: skip
    beyond = 8 + 2 + 12 * len(tags) + 4
    fields, rest = b"", b""
    long = sum(size for _, kind, values in tags if (size := struct.calcsize(kind) * len(values)) > 4)
    for number, kind, values in sorted(tags):
        if number == 273:
            values = [beyond + long]
        content = struct.pack(f"{order}{len(values)}{kind}", *values)
        fields += struct.pack(f"{order}HHI", number, {"H": 3, "I": 4}[kind], len(values))
        if len(content) > 4:
            fields += struct.pack(f"{order}I", beyond + len(rest))
            rest += content
        else:
            fields += content.ljust(4, b"\0")
    mark = b"II*\0" if order == "<" else b"MM\0*"
    head = mark + struct.pack(f"{order}IH", 8, len(tags))
    path.write_bytes(head + fields + bytes(4) + rest + data)
    return path


def linear(values: np.ndarray) -> np.ndarray:
    return np.where(values <= 0.04045, values / 12.92, ((values + 0.055) / 1.055) ** 2.4)


@pytest.mark.parametrize("order", "<>")
@pytest.mark.parametrize("bits", [1, 2, 4, 8, 10, 12, 14])
def test_whole_numbers_of_few_bits(tmp_path: Path, bits: int, order: str) -> None:
    for samples, meaning in ((1, 1), (3, 2)):
        values = RANDOM.integers(0, 1 << bits, (*SIZE, samples))
        path = tiff(tmp_path / "a.tif", packed(values, bits), bits, samples, meaning, order=order)
        assert np.allclose(read_image(path), linear(values / ((1 << bits) - 1)), atol=1e-4)


def test_whole_numbers_of_other_bits_are_refused(tmp_path: Path) -> None:
    path = tiff(tmp_path / "a.tif", packed(RANDOM.integers(0, 64, SIZE), 6), 6, 1, 1)
    with pytest.raises(SceneError, match=r"a\.tif: samples of 6 bits as uint8; 1, 2, 4, 8, 10, .* are read$"):
        read_image(path)


@pytest.mark.parametrize("tile", [None, (16, 16)])
@pytest.mark.parametrize("planes", ["contig", "separate"])
@pytest.mark.parametrize("kind", ["f2", "f4", "f8"])
def test_floats_are_read_or_refused(
    tmp_path: Path, kind: str, planes: str, tile: tuple[int, int] | None
) -> None:
    values = RANDOM.random((21, 37, 3)).astype(kind)
    stored = values if planes == "contig" else np.moveaxis(values, -1, 0)
    tifffile.imwrite(tmp_path / "a.tif", stored, photometric="rgb", planarconfig=planes, tile=tile)
    if (kind, planes, tile) == ("f8", "contig", (16, 16)):
        with pytest.raises(SceneError, match="tiles of floats of 64 bits; strips of them are read"):
            read_image(tmp_path / "a.tif")
    else:
        assert np.array_equal(read_image(tmp_path / "a.tif"), values.astype(np.float32))


def test_tiles_of_one_channel_of_64_bits_are_refused(tmp_path: Path) -> None:
    """Also where a file says that its planes, of which it has one, are apart."""
    tifffile.imwrite(tmp_path / "a.tif", np.full((32, 32), 0.5), photometric="minisblack", tile=(16, 16))
    data = (tmp_path / "a.tif").read_bytes()
    said, apart = struct.pack("<HHIH", 296, 3, 1, 1), struct.pack("<HHIH", 284, 3, 1, 2)
    assert data.count(said) == 1  # its unit of length, which nobody asks for
    for content in (data, data.replace(said, apart)):
        (tmp_path / "a.tif").write_bytes(content)
        with pytest.raises(SceneError, match="tiles of floats of 64 bits"):
            read_image(tmp_path / "a.tif")


def test_floats_of_24_bits_are_refused(tmp_path: Path) -> None:
    values = np.full(SIZE, 0.5, "<f4").ravel()
    data = b"".join(value.tobytes()[1:] for value in values)
    path = tiff(tmp_path / "a.tif", data, 24, 1, 1, (339, "H", [3]))
    with pytest.raises(SceneError, match=r"samples of 24 bits as float; .* floats of 16, 32 or 64 are read"):
        read_image(path)


def palette(
    path: Path, bits: int, samples: int = 1, length: int | None = None, order: str = "<"
) -> np.ndarray:
    """Write a picture of a palette; its colours."""
    length = 1 << bits if length is None else length
    colours = RANDOM.integers(0, 256, (3, length)) * 257
    numbers = RANDOM.integers(0, 1 << bits, (*SIZE, samples))
    more: Sequence[Tag] = [(320, "H", colours.ravel().tolist())]
    more = [*more, (338, "H", [0])] if samples == 2 else more
    tiff(path, packed(numbers, bits), bits, samples, 3, *more, order=order)
    return colours.T[numbers[..., 0] % length] / 65535


@pytest.mark.parametrize("order", "<>")
@pytest.mark.parametrize("bits", [1, 2, 4, 8])
def test_palettes(tmp_path: Path, bits: int, order: str) -> None:
    expected = palette(tmp_path / "a.tif", bits, order=order)
    assert np.allclose(read_image(tmp_path / "a.tif"), linear(expected), atol=1e-4)


def test_other_palettes_are_refused(tmp_path: Path) -> None:
    palette(tmp_path / "a.tif", 6)
    with pytest.raises(SceneError, match="numbers of 6 bits in its palette; 1, 2, 4 or 8 bits are read"):
        read_image(tmp_path / "a.tif")
    for order in "<>":
        palette(tmp_path / "b.tif", 8, samples=2, order=order)
        with pytest.raises(SceneError, match="2 samples a pixel beside a palette; one alone is read"):
            read_image(tmp_path / "b.tif")
    palette(tmp_path / "c.tif", 8, length=128)
    with pytest.raises(SceneError, match="its palette is missing or short; save it as RGB"):
        read_image(tmp_path / "c.tif")


@pytest.mark.parametrize("big", [False, True])
def test_a_palette_on_a_later_page(tmp_path: Path, big: bool) -> None:
    """Pages before it, reduced copies, have three samples a pixel."""
    numbers = RANDOM.integers(0, 256, SIZE).astype(np.uint8)
    colours = (RANDOM.integers(0, 256, (3, 256)) * 257).astype(np.uint16)
    with tifffile.TiffWriter(tmp_path / "a.tif", bigtiff=big) as file:
        file.write(np.zeros((2, 2, 3), np.uint8), photometric="rgb", subfiletype=1)
        file.write(numbers, photometric="palette", colormap=colours)
    assert np.allclose(read_image(tmp_path / "a.tif"), linear(colours.T[numbers] / 65535), atol=1e-4)


def test_one_sample_a_pixel_need_not_be_said(tmp_path: Path) -> None:
    expected = palette(tmp_path / "a.tif", 8)
    data = (tmp_path / "a.tif").read_bytes()
    said, other = struct.pack("<HHI", 277, 3, 1), struct.pack("<HHI", 276, 3, 1)
    assert data.count(said) == 1
    (tmp_path / "a.tif").write_bytes(data.replace(said, other))
    assert np.allclose(read_image(tmp_path / "a.tif"), linear(expected), atol=1e-4)


def test_fields_that_end_early_are_refused(tmp_path: Path) -> None:
    palette(tmp_path / "a.tif", 8)
    data = (tmp_path / "a.tif").read_bytes()
    for cut in (3, 9, 30):
        (tmp_path / "a.tif").write_bytes(data[:cut])
        with (tmp_path / "a.tif").open("rb") as file, pytest.raises(SceneError, match="it ends before"):
            first_values(file, 0, "a.tif")


def test_two_channels_without_a_meaning_are_counted(tmp_path: Path) -> None:
    tiff(tmp_path / "a.tif", packed(RANDOM.integers(0, 256, (*SIZE, 2)), 8), 8, 2, 1)
    with pytest.raises(SceneError, match=r"its 2 channels are neither R, G and B nor .*; save it as RGB"):
        read_image(tmp_path / "a.tif")


def bmp(path: Path, words: np.ndarray, bits: int, masks: Sequence[int], compression: int = 3) -> Path:
    """A BMP of one row of numbers of so many bits."""
    data = words.astype(f"<u{bits // 8}").tobytes()
    table = struct.pack(f"<{len(masks)}I", *masks)
    begins = 54 + len(table)
    header = struct.pack("<IiiHHIIiiII", 40, len(words), 1, 1, bits, compression, len(data), 0, 0, 0, 0)
    path.write_bytes(b"BM" + struct.pack("<IHHI", begins + len(data), 0, 0, begins) + header + table + data)
    return path


@pytest.mark.parametrize("compression", [3, 6])
@pytest.mark.parametrize(
    "masks", [(0xFF, 0xFF00, 0xFF0000), (0x3FF00000, 0xFFC00, 0x3FF), (0xFF000000, 0xFF0000, 0xFF00)]
)
def test_unusual_masks_of_32_bits_are_refused(
    tmp_path: Path, masks: tuple[int, ...], compression: int
) -> None:
    path = bmp(tmp_path / "a.bmp", np.arange(4), 32, (*masks, 0)[: 3 + (compression == 6)], compression)
    told = ", ".join(map(hex, masks))
    text = rf"a\.bmp: its masks of red, green and blue are {told}; of 32 bits 0xff0000, 0xff00, 0xff are read"
    with pytest.raises(SceneError, match=text):
        read_image(path)


def test_usual_masks_and_those_of_16_bits_are_followed(tmp_path: Path) -> None:
    colours = np.array([[255, 0, 0], [0, 255, 0], [0, 0, 255], [16, 32, 64]])
    words = colours @ [1 << 16, 1 << 8, 1]
    expected = linear(colours / 255)[None]
    path = bmp(tmp_path / "a.bmp", words, 32, (0xFF0000, 0xFF00, 0xFF))
    assert np.allclose(read_image(path), expected, atol=1e-6)
    few = np.array([[31, 0, 0], [0, 31, 0], [0, 0, 31], [0, 0, 0]])
    path = bmp(tmp_path / "b.bmp", few @ [1, 1 << 5, 1 << 10], 16, (0x1F, 0x3E0, 0x7C00))
    assert np.allclose(read_image(path), (few / 31)[None], atol=1e-6)
    (tmp_path / "c.bmp").write_bytes(path.read_bytes()[:40])
    with pytest.raises(SceneError, match=r"c\.bmp: "):
        read_image(tmp_path / "c.bmp")
