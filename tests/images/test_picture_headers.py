"""What picture files declare of their samples: followed as viewers do, told of, or refused."""

from __future__ import annotations

import os
import struct
import warnings
import zlib
from pathlib import Path
from typing import Any

import numpy as np
import OpenImageIO as oiio
import pytest
import tifffile
from PIL import Image as Pillow
from PIL import ImageCms

import clrt
from clrt.base.errors import ClrtWarning, LimitError, SceneError
from clrt.base.limits import Limits
from clrt.images import file
from clrt.images.image import read_image
from tests.image_samples import decode_by_hand

STORED = np.random.default_rng(5).integers(0, 256, (6, 8, 3)).astype(np.uint8)
LINEAR = np.random.default_rng(6).random((6, 8, 3)).astype(np.float32) + np.float32(0.1)
UPRIGHT: dict[int, Any] = {  # EXIF 2.3, table 6: where the first row and column of the file are seen
    1: lambda a: a,
    2: lambda a: a[:, ::-1],
    3: lambda a: a[::-1, ::-1],
    4: lambda a: a[::-1],
    5: lambda a: a.swapaxes(0, 1),
    6: lambda a: a.swapaxes(0, 1)[:, ::-1],
    7: lambda a: a[::-1, ::-1].swapaxes(0, 1),
    8: lambda a: a.swapaxes(0, 1)[::-1],
}


@pytest.fixture(autouse=True)
def silent() -> Any:
    """A warning is a failure, where no test asks for it."""
    with warnings.catch_warnings():
        warnings.simplefilter("error", ClrtWarning)
        yield


def exr(path: Path, parts: list[tuple[str, np.ndarray]], **fields: Any) -> Path:
    """An EXR of parts (channels, letters or names after commas; pixels)."""
    specs = []
    for names, pixels in parts:
        spec = oiio.ImageSpec(pixels.shape[1], pixels.shape[0], pixels.shape[2], "float")
        spec.channelnames = tuple(names.split(",") if "," in names else names)
        for key, value in fields.items():
            if hasattr(spec, key):
                setattr(spec, key, value)
            else:
                spec.attribute(key, "float[8]", value)
        spec.attribute("oiio:subimagename", names)
        specs.append(spec)
    output = oiio.ImageOutput.create(str(path))
    assert output.open(str(path), tuple(specs)) if len(specs) > 1 else output.open(str(path), specs[0])
    for number, (_, pixels) in enumerate(parts):
        assert not number or output.open(str(path), specs[number], "AppendSubimage")
        assert output.write_image(np.ascontiguousarray(pixels))
    assert output.close()
    return path


def png(path: Path, kind: bytes, content: bytes) -> Path:
    """`STORED` with one chunk more."""

    def chunk(kind: bytes, data: bytes) -> bytes:
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    header = chunk(b"IHDR", struct.pack(">IIBBBBB", 8, 6, 8, 2, 0, 0, 0)) + chunk(kind, content)
    body = chunk(b"IDAT", zlib.compress(b"".join(b"\0" + row.tobytes() for row in STORED)))
    path.write_bytes(b"\x89PNG\r\n\x1a\n" + header + body + chunk(b"IEND", b""))
    return path


def hdr(path: Path, axes: str, head: str = "", ends: str = "\n") -> np.ndarray:
    """Write rows of bytes after the resolution `axes`; what they are as linear numbers (rows, columns, 3)."""
    rows, columns = (int(word) for word in axes.split()[1::2])
    mantissas = np.random.default_rng(7).integers(128, 256, (rows, columns, 3))
    samples = np.dstack([mantissas, np.full((rows, columns, 1), 128)]).astype(np.uint8)
    text = f"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n{head}\n{axes}\n"
    path.write_bytes(text.replace("\n", ends).encode() + samples.tobytes())
    return mantissas / 256


def exif(orientation: int) -> bytes:
    return b"MM\0*\0\0\0\x08\0\x01\x01\x12\0\x03\0\0\0\x01\0" + bytes([orientation]) + bytes(6)


def chlist(name: bytes, *sampling: int) -> bytes:
    """A float channel of an EXR's list."""
    return name + b"\0" + struct.pack("<i4x2i", 2, *sampling)


@pytest.mark.parametrize(("name", "across", "down"), [("RY", 2, 2), ("Z", 1, 2), ("B", 3, 1), ("G", 0, 1)])
def test_channels_of_fewer_samples_are_named(tmp_path: Path, name: str, across: int, down: int) -> None:
    """OpenImageIO refuses them, and forgets why."""
    path = exr(tmp_path / "a.exr", [(f"R,{name},X", LINEAR)])
    whole, old = path.read_bytes(), chlist(name.encode(), 1, 1)
    assert whole.count(old) == 1
    path.write_bytes(whole.replace(old, chlist(name.encode(), across, down)))
    with pytest.raises(SceneError, match=rf"its channel '{name}' has a sample for {across} x {down} pixels"):
        read_image(path)


def test_a_cube_is_told_of(tmp_path: Path) -> None:
    """As programs write it; OpenImageIO alone does not, and so as a number of the same length first."""
    path = tmp_path / "a.exr"
    spec = oiio.ImageSpec(4, 24, 3, "float")
    spec.attribute("envmap", 1)
    output = oiio.ImageOutput.create(str(path))
    assert output.open(str(path), spec) and output.write_image(np.zeros((24, 4, 3), np.float32))
    assert output.close()
    read_image(path)
    old, cube = b"envmap\0int\0" + struct.pack("<2i", 4, 1), b"envmap\0envmap\0" + struct.pack("<iB", 1, 1)
    assert path.read_bytes().count(old) == 1 and len(old) == len(cube)
    path.write_bytes(path.read_bytes().replace(old, cube))
    with pytest.warns(ClrtWarning, match="its header says that it is the six faces of a cube"):
        read_image(path)


@pytest.mark.parametrize("orientation", list(UPRIGHT))
def test_pictures_are_turned_as_they_say(tmp_path: Path, orientation: int) -> None:
    expected = decode_by_hand(UPRIGHT[orientation](STORED))
    tag = [(274, "H", 1, orientation, True)]
    tifffile.imwrite(tmp_path / "a.tif", STORED, photometric="rgb", extratags=tag)
    assert np.array_equal(read_image(tmp_path / "a.tif"), expected)
    assert np.array_equal(read_image(png(tmp_path / "a.png", b"eXIf", exif(orientation))), expected)
    flat = np.repeat(np.repeat(STORED, 16, 0), 16, 1)
    Pillow.fromarray(flat).save(
        tmp_path / "a.jpg", quality=100, subsampling=0, exif=b"Exif\0\0" + exif(orientation)
    )
    found = read_image(tmp_path / "a.jpg")
    expected = decode_by_hand(UPRIGHT[orientation](flat))
    assert found.shape == expected.shape and np.abs(found - expected).max() < 0.05
    assert found.flags.c_contiguous


@pytest.mark.parametrize("rows", [-1, 1])
@pytest.mark.parametrize("columns", [-1, 1])
@pytest.mark.parametrize("first", ["X", "Y"])
@pytest.mark.parametrize("ends", ["\n", "\r\n"])
def test_radiance_files_are_turned_as_they_say(
    tmp_path: Path, rows: int, columns: int, first: str, ends: str
) -> None:
    second = "Y" if first == "X" else "X"
    axes = f"{'+-'[rows < 0]}{first} 6 {'+-'[columns < 0]}{second} 8"
    stored = hdr(tmp_path / "a.hdr", axes, ends=ends)
    upright = stored if first == "Y" else stored.swapaxes(0, 1)
    x, y = (columns, rows) if first == "Y" else (rows, columns)
    assert np.allclose(read_image(tmp_path / "a.hdr"), upright[:: -y, ::x], atol=0.01)


def test_the_display_window_is_the_picture(tmp_path: Path) -> None:
    inside = exr(tmp_path / "a.exr", [("RGB", LINEAR)], x=2, y=3, full_width=20, full_height=15)
    expected = np.zeros((15, 20, 3), np.float32)
    expected[3:9, 2:10] = LINEAR
    assert np.array_equal(read_image(inside), expected)
    over = exr(tmp_path / "b.exr", [("RGB", LINEAR)], x=-2, y=-1, full_width=4, full_height=3)
    assert np.array_equal(read_image(over), LINEAR[1:4, 2:6])
    tall = np.repeat(LINEAR, 40_000, axis=0)  # in several blocks, the first and the last ones outside
    far = exr(tmp_path / "c.exr", [("RGB", tall)], x=0, y=-200_000, full_width=8, full_height=2)
    assert np.array_equal(read_image(far), tall[200_000:200_002])
    for at in ({"x": 8}, {"x": -8}, {"y": 6}, {"y": -6}):
        with pytest.raises(SceneError, match="data window lies outside of its display window"):
            read_image(exr(tmp_path / "d.exr", [("RGB", LINEAR)], **at))
    with pytest.raises(LimitError, match="image_pixels"):
        read_image(exr(tmp_path / "e.exr", [("RGB", LINEAR)], full_width=100_000, full_height=100_000))
    with pytest.raises(LimitError, match="image_bytes"):
        read_image(inside, Limits(image_bytes=3600))


def test_the_part_with_colours_is_the_picture(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    depth = LINEAR[..., :1]
    assert np.array_equal(read_image(exr(tmp_path / "a.exr", [("Z", depth), ("RGB", LINEAR)])), LINEAR)
    with monkeypatch.context() as few:
        few.setattr("clrt.images.header.MOST_PARTS", 1)
        assert np.array_equal(read_image(tmp_path / "a.exr")[..., 1], depth[..., 0])
    two = exr(tmp_path / "b.exr", [("Z", depth), ("XYZ", LINEAR)])
    assert np.array_equal(read_image(two), np.repeat(depth, 3, axis=2))
    for names in ("Red,Green,Blue", "rgb"):
        assert np.array_equal(read_image(exr(tmp_path / "c.exr", [(names, LINEAR)])), LINEAR)
    grey = exr(tmp_path / "d.exr", [("A,Q,Y", LINEAR)])
    assert np.array_equal(read_image(grey)[..., 0], LINEAR[..., 2])
    alone = exr(tmp_path / "e.exr", [("AY", LINEAR[..., :2])])
    assert np.array_equal(read_image(alone)[..., 0], LINEAR[..., 1])
    with tifffile.TiffWriter(tmp_path / "a.tif") as file:
        file.write(STORED[:2, :2], photometric="rgb", subfiletype=1)
        file.write(STORED, photometric="rgb")
        file.write(255 - STORED, photometric="rgb")
    assert np.array_equal(read_image(tmp_path / "a.tif"), decode_by_hand(STORED))


@pytest.mark.parametrize("names", ["d.R,d.G,d.B", "XYZ", "Y,RY,BY", "RG", "RB"])
def test_other_channels_are_no_grey(tmp_path: Path, names: str) -> None:
    count = len(names.split(",")) if "," in names else len(names)
    with pytest.raises(SceneError, match=r"its channels are '.*'; R, G and B are read, or a grey one alone"):
        read_image(exr(tmp_path / "a.exr", [(names, LINEAR[..., :count])]))


@pytest.mark.parametrize(
    ("pixels", "photometric"),
    [
        (STORED[..., 0].astype(np.uint16), "miniswhite"),
        (LINEAR[..., 0], "miniswhite"),
        (STORED, "cielab"),
        (STORED[..., 0], "cfa"),
    ],
)
def test_samples_that_mean_something_else_are_refused(
    tmp_path: Path, pixels: np.ndarray, photometric: str
) -> None:
    tifffile.imwrite(tmp_path / "a.tif", pixels, photometric=photometric)
    with pytest.raises(SceneError, match=r"its PhotometricInterpretation is \d+.*; save it as RGB"):
        read_image(tmp_path / "a.tif")


def test_samples_of_which_rgb_can_be_made(tmp_path: Path) -> None:
    tifffile.imwrite(tmp_path / "a.tif", STORED[..., 0], photometric="miniswhite")
    white = np.repeat(255 - STORED[..., :1], 3, axis=2)
    assert np.array_equal(read_image(tmp_path / "a.tif"), decode_by_hand(white))
    four = np.dstack([STORED, STORED[..., :1]])
    tifffile.imwrite(tmp_path / "b.tif", four, photometric="separated")
    share = four / 255
    expected = np.round(255 * (1 - share[..., :3]) * (1 - share[..., 3:])).astype(np.uint8)
    assert np.abs(read_image(tmp_path / "b.tif") - decode_by_hand(expected)).max() < 0.01  # rounded once more


def test_deep_pixels_are_refused(tmp_path: Path) -> None:
    """OpenImageIO's readers of flat pictures hand out their samples, and memory that nobody wrote."""
    spec = oiio.ImageSpec(4, 4, 3, "float")
    spec.deep = True
    deep = oiio.ImageBuf(spec)
    for x, y in np.ndindex(4, 4):
        deep.set_deep_samples(x, y, 0, 2)
    assert deep.write(str(tmp_path / "a.exr"))
    for read in (read_image, clrt.compare):
        with pytest.raises(SceneError, match="its pixels are deep"):
            read(*[tmp_path / "a.exr"] * (1 + (read is clrt.compare)))


def test_layers_of_pixels_are_refused(tmp_path: Path) -> None:
    tifffile.imwrite(
        tmp_path / "a.tif", np.stack([STORED] * 16), photometric="rgb", volumetric=True, tile=(16, 16, 16)
    )
    with pytest.raises(SceneError, match="16 layers of pixels"):
        read_image(tmp_path / "a.tif")


def test_colours_that_are_read_as_others_are_told_of(tmp_path: Path) -> None:
    profile = ImageCms.ImageCmsProfile(ImageCms.createProfile("sRGB")).tobytes()
    Pillow.fromarray(STORED).save(tmp_path / "a.png", icc_profile=profile)
    read_image(tmp_path / "a.png")
    name = "sRGB".encode("utf-16-be")
    assert profile.count(name) == 1
    other = profile.replace(name, "wide".encode("utf-16-be"))
    for path in (tmp_path / "b.png", tmp_path / "b.tif", tmp_path / "b.jpg"):
        Pillow.fromarray(STORED).save(path, icc_profile=other)
        with pytest.warns(ClrtWarning, match=rf"{path.name}: .* the profile 'wide built-in'; .* as sRGB"):
            read_image(path)
    read_image(png(tmp_path / "c.png", b"gAMA", struct.pack(">I", 45455)))
    for kind, content in ((b"gAMA", struct.pack(">I", 100_000)), (b"gAMA", struct.pack(">I", 55_556))):
        with pytest.warns(ClrtWarning, match=r"d\.png: its colours are declared as '\w+'; .* read as sRGB"):
            read_image(png(tmp_path / "d.png", kind, content))
    usual = (0.64, 0.33, 0.3, 0.6, 0.15, 0.06, 0.3127, 0.329)
    read_image(exr(tmp_path / "e.exr", [("RGB", LINEAR)], chromaticities=usual))
    with pytest.warns(ClrtWarning, match="its primaries are 0.7347, .* read as linear Rec.709"):
        wide = (0.7347, 0.2653, 0, 1, 0.0001, -0.077, 0.32168, 0.33767)
        read_image(exr(tmp_path / "f.exr", [("RGB", LINEAR)], chromaticities=wide))


@pytest.mark.parametrize(
    ("kind", "value", "told"),
    [
        ("string", "x", "'x'"), ("string[8]", ("x",) * 8, r"\('x', .*"), ("float", 0.5, "0.5"),
        ("int", 7, "7"), ("float[8]", (float("nan"),) * 8, "nan, .*"), ("float[9]", (0.5,) * 9, "0.5, .*"),
    ],
)  # fmt: skip
def test_primaries_of_any_type_are_told_of(tmp_path: Path, kind: str, value: Any, told: str) -> None:
    spec = oiio.ImageSpec(8, 6, 3, "float")
    spec.attribute("chromaticities", kind, value)
    output = oiio.ImageOutput.create("a.exr")
    assert output is not None
    assert output.open(str(tmp_path / "a.exr"), spec) and output.write_image(LINEAR) and output.close()
    with pytest.warns(ClrtWarning, match=f"its primaries are {told}; they are read as linear Rec.709"):
        assert np.array_equal(read_image(tmp_path / "a.exr"), LINEAR)


def test_samples_of_32_bits_are_refused_wherever_they_are_read(tmp_path: Path) -> None:
    """Beside floats, which no TIFF has: OpenImageIO would read them as fractions of 2^32."""
    names = ("R", "G", "B", "id")
    for kinds, which in (("float float float uint", "id"), ("half uint half float", "G")):
        spec = oiio.ImageSpec(8, 6, 4, "float")
        spec.channelnames, spec.channelformats = names, tuple(map(oiio.TypeDesc, kinds.split()))
        output = oiio.ImageOutput.create("a.exr")
        assert output is not None
        pixels = np.dstack([LINEAR, LINEAR[..., :1]])
        assert output.open(str(tmp_path / "a.exr"), spec) and output.write_image(pixels) and output.close()
        with pytest.raises(SceneError, match=f"samples of type uint in channel '{which}'; 8 or 16 bits"):
            clrt.read_image(tmp_path / "a.exr", layers="all")
        if which == "id":
            assert np.array_equal(read_image(tmp_path / "a.exr"), LINEAR)
        else:
            with pytest.raises(SceneError, match="samples of type uint in channel 'G'"):
                read_image(tmp_path / "a.exr")


def test_lines_of_a_radiance_header_that_change_its_numbers_are_told_of(tmp_path: Path) -> None:
    same = "EXPOSURE= 1.0\nCOLORCORR=1 1 1\nPRIMARIES=0.64 0.33 0.29 0.60 0.15 0.06 0.3333 0.3333\n"
    hdr(tmp_path / "a.hdr", "-Y 6 +X 8", same + "PRIMARIES=0 0 0 0 0 0 0 0\n# EXPOSURE=2\n")
    read_image(tmp_path / "a.hdr")
    for line in ("EXPOSURE=4", "COLORCORR=2 1 1", "PRIMARIES=.7 .3 .2 .7 .1 .1 .33 .33", "EXPOSURE=x"):
        hdr(tmp_path / "a.hdr", "-Y 6 +X 8", line + "\n", "\r\n" if "X" in line else "\n")
        with pytest.warns(ClrtWarning, match=f"its header says '{line}', of which no account is taken"):
            read_image(tmp_path / "a.hdr")


def test_what_takes_a_file_s_name_meanwhile_is_not_read(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "a.jpg"
    Pillow.fromarray(np.full((16, 16, 3), 200, np.uint8)).save(path, quality=100)
    expected = read_image(path)

    def swap(file: Any, name: str) -> None:
        """Looking at the file takes so long that a pipe, which nobody writes to, stands in its place."""
        path.unlink()
        os.mkfifo(path)

    monkeypatch.setitem(file._CHECKS, "jpeg", swap)
    assert np.array_equal(read_image(path), expected)


def test_messages_do_not_name_what_stands_for_the_file(tmp_path: Path) -> None:
    whole = png(tmp_path / "a.png", b"sRGB", b"\0").read_bytes()
    for cut in range(8, len(whole), 40):
        (tmp_path / "a.png").write_bytes(whole[:cut])
        with pytest.raises(SceneError, match=r"a\.png: ") as caught:
            read_image(tmp_path / "a.png")
        assert "/proc/" not in str(caught.value)


def test_where_open_files_have_no_names_their_own_are_used(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = png(tmp_path / "a.png", b"sRGB", b"\0")
    monkeypatch.setattr("clrt.images.file.os.path.exists", lambda name: False)
    assert np.array_equal(read_image(path), decode_by_hand(STORED))
