"""What picture files declare beside their samples: colours are told of, too many bytes refused at once."""

from __future__ import annotations

import struct
import time
import warnings
import zlib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import tifffile
from PIL import Image as Pillow

from clrt.base.errors import ClrtWarning, SceneError
from clrt.images import file as pictures
from clrt.images import png as pngs
from clrt.images.image import read_image

STORED = np.random.default_rng(5).integers(0, 256, (6, 8, 3)).astype(np.uint8)
REC709 = (0.64, 0.33, 0.30, 0.60, 0.15, 0.06)
WHITE = (0.3127, 0.3290)
ADOBE = (0.64, 0.33, 0.21, 0.71, 0.15, 0.06)
WARM = (0.3457, 0.3585)


@pytest.fixture(autouse=True)
def silent() -> Any:
    """A warning is a failure, where no test asks for it."""
    with warnings.catch_warnings():
        warnings.simplefilter("error", ClrtWarning)
        yield


@pytest.fixture
def unopened(monkeypatch: pytest.MonkeyPatch) -> None:
    """The library never gets the file."""

    def opened(*given: object) -> None:
        raise AssertionError("opened")

    monkeypatch.setattr(pictures.oiio.ImageInput, "open", opened)


def chunk(kind: bytes, data: bytes) -> bytes:
    return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))


def png(path: Path, *chunks: tuple[bytes, bytes]) -> Path:
    """A PNG of STORED with more chunks after its first."""
    Pillow.fromarray(STORED).save(path)
    whole = path.read_bytes()
    path.write_bytes(whole[:33] + b"".join(chunk(*one) for one in chunks) + whole[33:])
    return path


def ztxt(size: int, key: bytes = b"k") -> tuple[bytes, bytes]:
    return b"zTXt", key + b"\0\0" + zlib.compress(b"a" * size, 9)


def itxt(size: int) -> tuple[bytes, bytes]:
    return b"iTXt", b"k\0\1\0en\0name\0" + zlib.compress(b"a" * size, 9)


def iccp(size: int) -> tuple[bytes, bytes]:
    return b"iCCP", b"k\0\0" + zlib.compress(b"a" * size, 9)


@pytest.mark.parametrize("made", [ztxt, itxt, iccp])
def test_texts_of_a_png_that_unpack_to_too_much(
    made: Callable[[int], tuple[bytes, bytes]], tmp_path: Path, unopened: None
) -> None:
    """As a whole: each alone is what the library takes."""
    for many, size in ((3, pngs.MOST_TEXT // 3 + 1), (1, 50 * pngs.MOST_TEXT)):
        path = png(tmp_path / "a.png", *[made(size)] * many)
        start = time.process_time()
        with pytest.raises(SceneError, match=r"a\.png: its texts unpack to more than 8 MiB; save it without"):
            read_image(path)
        assert time.process_time() - start < 1


def test_texts_of_a_png_that_are_few_or_broken(tmp_path: Path) -> None:
    expected = read_image(png(tmp_path / "a.png"))
    odd = [(b"zTXt", b""), (b"zTXt", b"k\0\0" + bytes(9)), (b"iTXt", b"k\0\1"),
           (b"iTXt", b"k\0\1\0en"), (b"iTXt", b"k\0\1\0en\0x"), (b"iTXt", b"k\0\0\0en\0x\0text"),
           (b"tEXt", b"k\0" + bytes(9))]  # fmt: skip
    for more in ([ztxt(1000, b"k%d" % k) for k in range(100)], [itxt(1 << 20)], *([one] for one in odd)):
        assert np.array_equal(read_image(png(tmp_path / "b.png", *more)), expected), more


def tiff(path: Path, fields: list[tuple[int, int, int, bytes]], order: Any = "<", **more: Any) -> Path:
    """A TIFF of STORED with more fields: number, type, count, bytes."""
    for number, kind, count, data in fields:
        more.setdefault("extratags", []).append((number, kind, count, data, True))
    tifffile.imwrite(path, STORED, photometric="rgb", byteorder=order, metadata=None, **more)
    return path


def shared(path: Path, fields: int, size: int, within: int = 0) -> Path:
    """A TIFF of so many unknown fields, all with the same bytes; or in the directory of that field."""
    pixels = bytes(range(48))
    own: list[Any] = [(256, 3, 1, 4), (257, 3, 1, 4), (258, 3, 3, "bits"), (259, 3, 1, 1),
        (262, 3, 1, 2), (273, 4, 1, "pixels"), (277, 3, 1, 3), (278, 3, 1, 4), (279, 4, 1, 48)]  # fmt: skip
    extra = [(40_000 + k, 7, size, "shared") for k in range(fields)]
    first = sorted([*own, (within, 4, 1, "within")] if within else [*own, *extra])
    begins = [8, 8 + 6 + 12 * len(first)]
    data = begins[1] + (6 + 12 * len(extra) if within else 0)
    places = {"bits": data, "pixels": data + 6, "shared": data + 54, "within": begins[1]}
    directories = b"".join(
        struct.pack("<H", len(some))
        + b"".join(struct.pack("<HHII", *field[:3], places.get(field[3], field[3])) for field in some)
        + bytes(4)
        for some in ([first, extra] if within else [first])
    )
    path.write_bytes(b"II*\0\x08\0\0\0" + directories + struct.pack("<3H", 8, 8, 8) + pixels + bytes(size))
    return path


@pytest.mark.parametrize("within", [0, 34665, 34853])
def test_fields_of_a_tiff_that_share_their_bytes(within: int, tmp_path: Path, unopened: None) -> None:
    with pytest.raises(SceneError, match=r"a\.tif: its fields have \d+ bytes, the file 10\d+; save it anew"):
        read_image(shared(tmp_path / "a.tif", 2000, 10**6, within))


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("within", [0, 34665])
def test_fields_of_a_tiff_that_take_what_the_file_has(within: int, tmp_path: Path) -> None:
    """A few that share a little are nobody's attack."""
    assert read_image(shared(tmp_path / "a.tif", 10, 10_000, within)).shape == (4, 4, 3)


def test_a_page_of_a_tiff_that_comes_after_itself(tmp_path: Path, unopened: None) -> None:
    whole = bytearray(shared(tmp_path / "a.tif", 50, 100).read_bytes())
    fields = int.from_bytes(whole[8:10], "little")
    whole[10 + 12 * fields : 14 + 12 * fields] = struct.pack("<I", 8)  # the page after the first is the first
    (tmp_path / "a.tif").write_bytes(whole)
    with pytest.raises(AssertionError, match="opened"):  # the library sees that, too
        read_image(tmp_path / "a.tif")


def test_a_jpeg_s_fill_bytes_take_time_in_proportion(tmp_path: Path) -> None:
    Pillow.fromarray(STORED.repeat(8, 0).repeat(8, 1)).save(tmp_path / "a.jpg")
    whole = (tmp_path / "a.jpg").read_bytes()
    took = []
    for count in (200_000, 800_000):
        scan = whole.index(b"\xff\xda") + 40
        (tmp_path / "b.jpg").write_bytes(whole[:scan] + b"\xff" * count + b"\0" + whole[scan:])
        start = time.process_time()
        with (tmp_path / "b.jpg").open("rb") as file:
            pictures.check_jpeg(file, "b.jpg")
        took.append(time.process_time() - start)
    assert took[1] < 6 * took[0] + 0.1 and took[1] < 1


def chrm(six: tuple[float, ...], white: tuple[float, ...] = WHITE) -> tuple[bytes, bytes]:
    return b"cHRM", struct.pack(">8I", *(round(value * 1e5) for value in (*white, *six)))


def test_primaries_of_a_png(tmp_path: Path) -> None:
    read_image(png(tmp_path / "a.png", chrm(REC709)))
    read_image(png(tmp_path / "a.png", (b"sRGB", b"\0"), chrm(ADOBE)))
    read_image(png(tmp_path / "a.png", chrm(ADOBE), (b"sRGB", b"\0")))
    read_image(png(tmp_path / "a.png", (b"cHRM", bytes(7))))
    for given in (chrm(ADOBE), chrm(REC709, WARM)):
        with pytest.warns(ClrtWarning, match=r"a\.png: its primaries are 0\.64, .*; they are read as sRGB"):
            read_image(png(tmp_path / "a.png", given))


@pytest.mark.parametrize("order", ["<", ">"])
@pytest.mark.parametrize("big", [False, True])
def test_primaries_and_curve_of_a_tiff(order: str, big: bool, tmp_path: Path) -> None:
    def told(*fields: tuple[int, int, int, bytes]) -> None:
        read_image(tiff(tmp_path / "a.tif", [*fields], order, bigtiff=big))

    def packed(kind: str, *values: int) -> bytes:
        return struct.pack(f"{order}{len(values)}{kind}", *values)

    def of(*values: float) -> bytes:
        return packed("I", *(part for value in values for part in (round(value * 10_000), 10_000)))

    value = np.linspace(0, 1, 256)
    curves = {"sRGB": np.where(value <= 0.04045, value / 12.92, ((value + 0.055) / 1.055) ** 2.4),
              "2.2": value**2.2, "1.8": value**1.8, "straight": value}  # fmt: skip
    tables = {name: packed("H", *np.rint(curve * 65535).astype(int)) for name, curve in curves.items()}
    told()
    told((318, 5, 2, of(*WHITE)), (319, 5, 6, of(*REC709)), (301, 3, 256, tables["sRGB"]))
    told((301, 3, 768, tables["2.2"] * 3))
    told((301, 3, 1, packed("H", 7)), (318, 3, 2, packed("H", 1, 1)))
    for fields in ((319, 5, 6, of(*ADOBE)), (318, 5, 2, of(*WARM))):
        with pytest.warns(ClrtWarning, match=r"its primaries are 0\.64, 0\.33, .*; they are read as sRGB"):
            told(fields)
    for name, count in (("1.8", 1), ("straight", 3)):
        with pytest.warns(ClrtWarning, match="its TransferFunction is not that of sRGB; they are"):
            told((301, 3, 256 * count, tables[name] * count))


@pytest.mark.parametrize(("space", "index"), [(1, "R98"), (65535, "R03"), (2, "")])
def test_colours_of_exif(space: int, index: str, tmp_path: Path) -> None:
    """As the rule for cameras' files (DCF) has it, Adobe RGB is "uncalibrated"."""
    exif = Pillow.Exif()
    exif.get_ifd(0x8769)[0xA001] = space
    exif.get_ifd(0xA005)[1] = index
    Pillow.fromarray(STORED).save(tmp_path / "a.jpg", exif=exif)
    if space == 1:
        read_image(tmp_path / "a.jpg")
        return
    with pytest.warns(ClrtWarning, match=r"a\.jpg: its colours are not sRGB, as its Exif says; .* as sRGB"):
        read_image(tmp_path / "a.jpg")


def bmp(path: Path, kind: bytes, ends: tuple[float, ...] = ()) -> Path:
    """A BMP of STORED with a header of version 4."""
    numbers = [round(value * 2**30) for value in ends] or [0] * 9
    rows = STORED[::-1, :, ::-1].tobytes()
    header = struct.pack("<IiiHHIIiiII16x4s9i12x", 108, 8, 6, 1, 24, 0, len(rows), 0, 0, 0, 0, kind, *numbers)
    path.write_bytes(b"BM" + struct.pack("<I4xI", 122 + len(rows), 122) + header + rows)
    return path


def test_colours_of_a_bmp(tmp_path: Path) -> None:
    def ends(six: tuple[float, ...]) -> tuple[float, ...]:
        return tuple(part for x, y in zip(six[::2], six[1::2], strict=True) for part in (x, y, 1 - x - y))

    path = tmp_path / "a.bmp"
    expected = read_image(bmp(path, b"BGRs"))
    for kind, given in ((bytes(4), ()), (bytes(4), ends(REC709)), (b" niW", ends(ADOBE))):
        assert np.array_equal(read_image(bmp(path, kind, given)), expected)
    with pytest.warns(ClrtWarning, match=r"its primaries are 0\.64, 0\.33, 0\.21, 0\.71, 0\.15, 0\.06; they"):
        read_image(bmp(path, bytes(4), ends(ADOBE)))
    with pytest.warns(ClrtWarning, match="its colours are those of a profile; they are read as sRGB"):
        read_image(bmp(path, b"DEBM"))
