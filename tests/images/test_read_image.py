"""Pictures that are read: which of a file's samples count, and that bad files are refused in one line."""

from __future__ import annotations

import struct
import zlib
from pathlib import Path

import numpy as np
import OpenImageIO as oiio
import pytest

from clrt.base.errors import ClrtError, LimitError, SceneError
from clrt.base.limits import Limits
from clrt.images.image import Image, read_image
from tests.image_samples import decode_by_hand, gradient, picture


def _png(width: int, height: int, colour_type: int, rows: bytes, palette: bytes = b"") -> bytes:
    def chunk(kind: bytes, data: bytes) -> bytes:
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    header = chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, 8, colour_type, 0, 0, 0))
    colours = chunk(b"PLTE", palette) if palette else b""
    body = chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b"")
    return b"\x89PNG\r\n\x1a\n" + header + colours + body


@pytest.mark.parametrize(
    ("colour_type", "row", "palette", "expected"),
    [
        (0, bytes([0, 188, 255]), b"", [[188] * 3, [255] * 3]),  # grey
        (4, bytes([0, 188, 10, 255, 0]), b"", [[188] * 3, [255] * 3]),  # grey, alpha
        (6, bytes([0, 1, 2, 188, 10, 4, 5, 6, 0]), b"", [[1, 2, 188], [4, 5, 6]]),  # colour, alpha
        (3, bytes([0, 1, 0]), bytes([9, 8, 7, 1, 2, 3]), [[1, 2, 3], [9, 8, 7]]),  # palette
    ],
)
def test_grey_alpha_and_palettes(
    tmp_path: Path, colour_type: int, row: bytes, palette: bytes, expected: list[list[int]]
):
    (tmp_path / "a.png").write_bytes(_png(2, 1, colour_type, row, palette))
    linear = read_image(tmp_path / "a.png")
    assert linear.shape == (1, 2, 3) and linear.dtype == np.float32
    assert np.array_equal(linear, decode_by_hand(np.array([expected])))


def test_colour_is_found_among_the_layers_of_an_exr(tmp_path: Path):
    spec = oiio.ImageSpec(2, 1, 4, "half")
    spec.channelnames = ("Z", "R", "G", "B")
    output = oiio.ImageOutput.create(str(tmp_path / "a.exr"))
    assert output.open(str(tmp_path / "a.exr"), spec)
    assert output.write_image(np.array([[[9, 1, 2, 3], [9, 4, 5, 6]]], np.float32)) and output.close()
    assert read_image(tmp_path / "a.exr").tolist() == [[[1, 2, 3], [4, 5, 6]]]


def test_the_first_bytes_decide_and_not_the_name(tmp_path: Path):
    picture().save(tmp_path / "a.exr")
    (tmp_path / "a.exr").rename(tmp_path / "a.png")
    assert np.array_equal(read_image(tmp_path / "a.png"), gradient())


@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_a_picture_for_a_scene_is_finite(tmp_path: Path, value: float):
    pixels = gradient()
    pixels[3, 2, 1] = value
    Image(pixels).save(tmp_path / "a.exr")
    with pytest.raises(SceneError, match=r"a\.exr: pixel \(2, 3\) is (nan|inf)"):
        read_image(tmp_path / "a.exr")


@pytest.mark.parametrize("name", ["a.exr", "a.png", "a.tif", "a.jpg", "a.bmp"])
def test_cut_files_are_errors_that_name_the_file(tmp_path: Path, name: str):
    Image(gradient(40, 40)).save(tmp_path / name)
    whole = (tmp_path / name).read_bytes()
    for length in (0, 1, 12, len(whole) // 4):
        (tmp_path / name).write_bytes(whole[:length])
        with pytest.raises(SceneError, match=name) as caught:
            read_image(tmp_path / name)
        assert "\n" not in str(caught.value)


def test_other_files_are_errors(tmp_path: Path):
    (tmp_path / "a.png").write_text("<svg/>")
    with pytest.raises(SceneError, match="not an EXR, HDR, PNG"):
        read_image(tmp_path / "a.png")
    with pytest.raises(SceneError, match=r"nothing\.png"):
        read_image(tmp_path / "nothing.png")
    with pytest.raises(SceneError):
        read_image(tmp_path)


def test_too_large_pictures_are_refused_before_they_are_read(tmp_path: Path):
    (tmp_path / "a.png").write_bytes(_png(20_000, 20_000, 2, b"\0" * 1000))  # claims more than it has
    with pytest.raises(ClrtError, match=r"a\.png"):
        read_image(tmp_path / "a.png")
    picture().save(tmp_path / "b.png")
    with pytest.raises(LimitError, match="file_bytes"):
        read_image(tmp_path / "b.png", Limits(file_bytes=100))
    with pytest.raises(LimitError, match="image_pixels: 35 is above the limit of 34"):
        read_image(tmp_path / "b.png", Limits(image_pixels=34))


def test_more_channels_than_the_library_takes(tmp_path: Path):
    """Its own words would be that it is broken, and come late."""
    file, most = tmp_path / "many.exr", oiio.get_int_attribute("limits:channels")
    too_many = f"many.exr: has more than {most} channels in a part"
    for count, words in ((most, "R, G and B are read"), (most + 1, too_many)):
        spec = oiio.ImageSpec(2, 2, count, "half")
        spec.channelnames = [f"c{i:04d}" for i in range(count)]
        output = oiio.ImageOutput.create(str(file))
        assert output.open(str(file), spec) and output.write_image(np.zeros((2, 2, count), np.float16))
        output.close()
        with pytest.raises(SceneError, match=words):
            read_image(file)
