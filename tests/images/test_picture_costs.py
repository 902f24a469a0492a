"""Pictures whose few bytes declare many: refused by what they declare, or read within it."""

from __future__ import annotations

import os
import struct
import subprocess
import sys
import zlib
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import OpenImageIO as oiio
import pytest

import clrt
from clrt.base.errors import LimitError, SceneError
from clrt.base.limits import Limits
from clrt.images.file import load_colours, own_colours
from clrt.images.image import read_image
from tests.cost import bounded


def made(
    path: Path, width: int, height: int, channels: int, kind: str, tile: int = 0, **more: object
) -> Path:
    """A picture whose first three channels of column x hold x / 256 or x, and the others nothing."""
    spec = oiio.ImageSpec(width, height, channels, kind)
    if tile:
        spec.tile_width = spec.tile_height = tile
    for name, value in more.items():
        spec.attribute(name.replace("__", ":"), value)
    pixels = np.zeros((height, width, channels), np.uint8 if kind == "uint8" else np.float32)
    pixels[:, :, :3] = np.arange(width)[None, :, None] % 256
    writer = oiio.ImageOutput.create(str(path))
    assert writer.open(str(path), spec), writer.geterror()
    assert writer.write_image(pixels), writer.geterror()
    writer.close()
    return path


def empty_png(path: Path, width: int, height: int, interlaced: int = 0) -> Path:
    """RGB, 8 bits, all black."""

    def chunk(kind: bytes, data: bytes) -> bytes:
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    packer = zlib.compressobj()
    rows = b"".join(packer.compress(bytes(1 + 3 * width)) for _ in range(height * (1 + interlaced)))
    header = struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, interlaced)
    data = chunk(b"IHDR", header) + chunk(b"IDAT", rows + packer.flush()) + chunk(b"IEND", b"")
    path.write_bytes(b"\x89PNG\r\n\x1a\n" + data)
    return path


def test_a_large_picture_takes_its_pixels_and_little_more(tmp_path: Path) -> None:
    side = 4096
    found = bounded("picture", empty_png(tmp_path / "a.png", side, side), declared=12 * side * side)
    assert not found.error


@pytest.mark.parametrize(
    ("name", "more"),
    [
        ("a.tif", {"compression": "zip", "tiff__RowsPerStrip": 32}),
        ("a.tif", {"compression": "zip", "planarconfig": "separate"}),
        ("a.exr", {"compression": "zip"}),
    ],
)
def test_of_many_channels_only_those_asked_for_are_kept(
    tmp_path: Path, name: str, more: dict[str, object]
) -> None:
    kind = "half" if name.endswith("exr") else "uint8"
    found = bounded("picture", made(tmp_path / name, 256, 512, 1000, kind, **more), declared=32 << 20)
    assert not found.error


@pytest.mark.parametrize(
    ("name", "kind", "tile", "more"),
    [
        ("a.tif", "uint8", 512, {}),
        ("a.tif", "uint8", 0, {"tiff__RowsPerStrip": 512}),
        ("a.exr", "half", 512, {}),
        ("a.exr", "half", 0, {}),
    ],
)
def test_what_a_decoder_unpacks_at_a_time_is_limited(
    tmp_path: Path, name: str, kind: str, tile: int, more: dict[str, object]
) -> None:
    path = made(tmp_path / name, 512, 512, 60, kind, tile, compression="zip", **more)
    with pytest.raises(LimitError, match=r"image_bytes: .* fewer channels and smaller tiles"):
        read_image(path, Limits(image_bytes=15 << 20))
    assert read_image(path).shape == (512, 512, 3)


def test_the_usual_pictures_of_any_allowed_size_are_within_the_limit_of_bytes() -> None:
    from clrt.images.file import bytes_to_read

    limits = Limits()
    side = int(limits.image_pixels**0.5)
    for reader, channels, kind in (("png", 4, "uint16"), ("jpeg", 3, "uint8"), ("hdr", 3, "float"),
                                   ("openexr", 40, "float"), ("bmp", 4, "uint8")):  # fmt: skip
        assert bytes_to_read(oiio.ImageSpec(side, side, channels, kind), reader) <= limits.image_bytes


@pytest.mark.parametrize(("width", "height", "tile"), [(70, 50, 16), (16, 900, 16), (3, 40_000, 0)])
def test_every_block_of_rows_is_at_its_place(tmp_path: Path, width: int, height: int, tile: int) -> None:
    path = made(tmp_path / "a.exr", width, height, 5, "half", tile)
    expected = np.broadcast_to(np.arange(width)[None, :, None], (height, width, 3))
    assert np.array_equal(read_image(path), expected)


def test_a_window_of_data_that_does_not_begin_at_the_corner(tmp_path: Path) -> None:
    for tile in (0, 16):
        spec = oiio.ImageSpec(40, 30, 3, "half")
        spec.x, spec.y = spec.full_x, spec.full_y = -7, 11
        spec.tile_width = spec.tile_height = tile
        pixels = np.random.default_rng(1).random((30, 40, 3)).astype(np.float16).astype(np.float32)
        writer = oiio.ImageOutput.create(str(tmp_path / "a.exr"))
        assert writer.open(str(tmp_path / "a.exr"), spec) and writer.write_image(pixels) and writer.close()
        assert np.array_equal(read_image(tmp_path / "a.exr"), pixels)


def test_single_pixels_as_tiles_do_not_take_a_call_each(tmp_path: Path) -> None:
    data = made(tmp_path / "a.exr", 64, 64, 3, "half", 32).read_bytes()
    tiles = data.index(b"tiles\0tiledesc\0") + 19
    data = data[:tiles] + struct.pack("<2I", 1, 1) + data[tiles + 8 :]
    window = data.index(b"dataWindow\0box2i\0") + 21
    data = data[:window] + struct.pack("<4i", 0, 0, 0, 999_999) + data[window + 16 :]
    (tmp_path / "a.exr").write_bytes(data)
    assert "cannot be read" in bounded("picture", tmp_path / "a.exr", declared=12_000_000).error


def test_a_pipe_is_no_picture(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "a.png")
    with pytest.raises(SceneError, match=r"a\.png: is a named pipe, not a file"):
        read_image(tmp_path / "a.png")


def test_a_name_that_is_not_utf8(tmp_path: Path) -> None:
    name = os.fsencode(tmp_path) + b"/\xff\xfe.png"
    os.rename(empty_png(tmp_path / "a.png", 3, 2), name)
    assert read_image(Path(os.fsdecode(name))).shape == (2, 3, 3)


def test_the_first_number_that_is_not_finite_is_named_wherever_it_is(tmp_path: Path) -> None:
    spec = oiio.ImageSpec(9, 200, 3, "float")
    pixels = np.zeros((200, 9, 3), np.float32)
    pixels[150, 4, 1] = np.nan
    writer = oiio.ImageOutput.create(str(tmp_path / "a.exr"))
    assert writer.open(str(tmp_path / "a.exr"), spec) and writer.write_image(pixels) and writer.close()
    with pytest.raises(SceneError, match=r"pixel \(4, 150\) is nan"):
        read_image(tmp_path / "a.exr")


def test_a_table_of_colours_that_the_environment_names_is_not_read(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("OCIO", "/nowhere")
    monkeypatch.setattr("clrt.images.file._own_colours", False)
    own_colours()
    assert os.environ["OCIO"] == "/nowhere"
    os.mkfifo(tmp_path / "pipe.ocio")  # reading it would wait for ever
    code = (
        "import os, numpy as np, clrt\n"
        "view = clrt.views()[0]\n"
        "image = clrt.Image(np.ones((2, 2, 3), np.float32))\n"
        "image.save('a.png'), image.save('b.png', view=view), clrt.read_image('a.png')\n"
        "print(os.environ['OCIO'])"
    )
    named = {**os.environ, "OCIO": str(tmp_path / "pipe.ocio")}
    command = [sys.executable, "-c", code]
    done = subprocess.run(
        command, cwd=tmp_path, env=named, capture_output=True, text=True, timeout=120, check=False
    )
    assert done.stdout.strip() == named["OCIO"], done.stderr
    one, other = (clrt.read_image(tmp_path / name) for name in ("a.png", "b.png"))
    assert one[0, 0, 0] == 1 and other[0, 0, 0] < 1


@pytest.mark.parametrize(("table", "asked"), [(None, 1), ("/nowhere", 0)])
def test_a_table_of_somebodys_own_is_not_read_beside_a_driver(
    monkeypatch: pytest.MonkeyPatch, table: str | None, asked: int
) -> None:
    calls: list[str] = []
    config = SimpleNamespace(getColorSpaceNames=lambda: calls.append("asked"))
    kinds = SimpleNamespace(ColorConfig=SimpleNamespace(default_colorconfig=lambda: config))
    monkeypatch.setattr("clrt.images.file.oiio", kinds)
    monkeypatch.delenv("OCIO", raising=False)
    if table is not None:
        monkeypatch.setenv("OCIO", table)
    load_colours()
    assert len(calls) == asked
