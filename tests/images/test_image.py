"""Pictures that are saved: what a file holds, bit by bit; that it is whole or untouched."""

from __future__ import annotations

import hashlib
import os
import shutil
import struct
import threading
from contextlib import nullcontext
from pathlib import Path
from typing import Any

import numpy as np
import OpenImageIO as oiio
import pytest

from clrt.base.errors import ClrtError
from clrt.images.file import encode
from clrt.images.image import Image, check_writable, pixel_hash, read_image
from clrt.version import __version__
from tests.disk import small_files
from tests.image_samples import decode_by_hand, gradient, picture


def samples(path: Path) -> tuple[np.ndarray, oiio.ImageSpec]:
    """All samples of a file as they are in it, read without any of our code."""
    source = oiio.ImageInput.open(str(path))
    return source.read_image(source.spec().format), source.spec()


def srgb(linear: float, top: int) -> int:
    """MODEL: clip, sRGB curve, floor(top v + 0.5), in Python's own floats."""
    v = min(max(linear, 0.0), 1.0)
    return int(top * (12.92 * v if v <= 0.0031308 else 1.055 * v ** (1 / 2.4) - 0.055) + 0.5)


def test_hash_is_sha256_of_shape_and_little_endian_pixels():
    pixels = np.arange(12, dtype=np.float32).reshape(2, 2, 3)
    expected = hashlib.sha256(struct.pack("<3i", 2, 2, 3) + struct.pack("<12f", *range(12))).hexdigest()
    assert Image(pixels).hash == expected == pixel_hash(pixels)
    assert Image(pixels.reshape(1, 4, 3)).hash != expected
    assert pixel_hash(pixels.astype(">f4")) == expected
    assert pixel_hash(np.asfortranarray(pixels)) == expected


def test_an_image_is_an_array_and_cannot_be_written_to():
    image = picture()
    assert np.asarray(image) is not None and np.shares_memory(np.asarray(image), image.pixels)
    assert np.asarray(image, dtype=np.float64).dtype == np.float64
    assert (image.height, image.width) == (5, 7)
    with pytest.raises(ValueError, match="read-only"):
        image.pixels[0, 0, 0] = 1
    copy = np.array(image)
    copy[0, 0, 0] = 1  # a copy may be changed
    assert image.pixels[0, 0, 0] != 1


@pytest.mark.parametrize(
    "pixels",
    [np.zeros((2, 2, 3)), np.zeros((2, 2), "f4"), np.zeros((2, 2, 4), "f4"), np.zeros((0, 2, 3), "f4")],
)
def test_pixels_of_another_kind_are_refused(pixels: np.ndarray):
    with pytest.raises(ClrtError, match="pixels"):
        Image(pixels)


def test_a_layer_of_another_size_is_refused():
    with pytest.raises(ClrtError, match="depth"):
        picture(layers={"depth": np.zeros((5, 8), np.float32)})


def test_eight_bits_are_clip_curve_and_rounding(tmp_path: Path):
    image = picture()
    image.save(tmp_path / "a.png")
    stored, spec = samples(tmp_path / "a.png")
    assert (spec.width, spec.height, spec.nchannels, str(spec.format)) == (7, 5, 3, "uint8")
    expected = [[[srgb(float(v), 255) for v in pixel] for pixel in row] for row in image.pixels]
    assert stored.tolist() == expected


def test_every_eight_bit_value_is_reached_and_survives_a_round_trip(tmp_path: Path):
    values = np.arange(256, dtype=np.uint8).reshape(16, 16, 1).repeat(3, axis=2)
    for name in ("a.png", "a.tif", "a.bmp"):
        linear = decode_by_hand(values)
        Image(linear).save(tmp_path / name)
        assert np.array_equal(samples(tmp_path / name)[0], values), name
        assert np.array_equal(read_image(tmp_path / name), linear), name


@pytest.mark.parametrize("name", ["a.png", "a.tif", "a.tiff"])
def test_sixteen_bits(tmp_path: Path, name: str):
    image = picture()
    image.save(tmp_path / name, bits=16)
    stored, spec = samples(tmp_path / name)
    assert str(spec.format) == "uint16"
    assert stored[2, 3].tolist() == [srgb(float(v), 65535) for v in image.pixels[2, 3]]
    assert np.allclose(read_image(tmp_path / name), image.pixels.clip(0, 1), atol=2e-5)


def test_jpeg_is_close(tmp_path: Path):
    smooth = np.linspace(0.1, 0.9, 64 * 64 * 3, dtype=np.float32).reshape(64, 64, 3)
    Image(smooth).save(tmp_path / "a.jpg")
    assert np.abs(encode(read_image(tmp_path / "a.jpg")).astype(int) - encode(smooth)).max() <= 8


def test_exposure_is_in_stops(tmp_path: Path):
    image = picture()
    image.save(tmp_path / "a.png", exposure=1.5)
    expected = [srgb(float(v) * 2**1.5, 255) for v in image.pixels[1, 2]]
    assert samples(tmp_path / "a.png")[0][1, 2].tolist() == expected


def test_not_a_number_and_infinity_have_a_colour():
    wild = np.array([[[np.nan, np.inf, -np.inf]]], np.float32)
    assert encode(wild).tolist() == [[[0, 255, 0]]]


def test_encoding_in_blocks_of_rows_changes_nothing():
    tall = np.linspace(-0.1, 1.1, 200 * 3 * 3).reshape(200, 3, 3).astype(np.float32)
    assert np.array_equal(encode(tall), np.concatenate([encode(row[None]) for row in tall]))


def test_encoding_without_threads_changes_nothing(monkeypatch: pytest.MonkeyPatch):
    pixels = np.random.default_rng(2).random((300, 7, 3), np.float32)
    expected = encode(pixels)

    def none(thread: threading.Thread) -> None:
        raise RuntimeError("can't start new thread")  # as where `ulimit -v` leaves no room for one

    monkeypatch.setattr(threading.Thread, "start", none)
    assert np.array_equal(encode(pixels), expected)


def test_exr_holds_pixels_layers_and_metadata_exactly(tmp_path: Path):
    pixels = gradient()
    layers = {
        "direct": pixels * 2,
        "normal": -pixels,
        "depth": np.where(pixels[..., 0] > 0, pixels[..., 1], np.inf).astype(np.float32),
        "shape": np.arange(-1, 34, dtype=np.int32).reshape(5, 7),
    }
    image = Image(pixels, layers, metadata={"scene_hash": "abc", "device": "PoCL"})
    image.save(tmp_path / "a.exr")
    stored, spec = samples(tmp_path / "a.exr")
    channel = dict(zip(spec.channelnames, np.moveaxis(stored, 2, 0), strict=True))
    assert set(channel) == {
        "R", "G", "B", "direct.R", "direct.G", "direct.B", "normal.X", "normal.Y", "normal.Z", "depth.V",
        "shape.ID",
    }  # fmt: skip
    assert str(spec.format) == "float"
    assert np.array_equal(np.stack([channel[c] for c in "RGB"], 2), pixels)
    assert np.array_equal(np.stack([channel[f"direct.{c}"] for c in "RGB"], 2), layers["direct"])
    assert np.array_equal(np.stack([channel[f"normal.{c}"] for c in "XYZ"], 2), layers["normal"])
    assert np.array_equal(channel["depth.V"], layers["depth"])
    assert np.array_equal(channel["shape.ID"], layers["shape"])
    expected = {"scene_hash": "abc", "device": "PoCL", "image_hash": image.hash, "version": __version__}
    assert {name: spec.getattribute(f"clrt:{name}") for name in expected} == expected
    assert np.array_equal(read_image(tmp_path / "a.exr"), pixels)


def test_exr_names_bands_by_their_wavelengths(tmp_path: Path):
    bands = np.random.default_rng(1).random((5, 7, 3), np.float32)
    image = Image(gradient(), {"xyz": gradient() * 2, "bands": bands}, wavelengths=(395.5, 2000 / 3, 700.0))
    image.save(tmp_path / "a.exr")
    stored, spec = samples(tmp_path / "a.exr")
    channel = dict(zip(spec.channelnames, np.moveaxis(stored, 2, 0), strict=True))
    assert np.array_equal(channel["S0.395,500000nm"], bands[..., 0])
    assert np.array_equal(channel["S0.666,666667nm"], bands[..., 1])
    assert np.array_equal(channel["S0.700,000000nm"], bands[..., 2])
    assert np.array_equal(np.stack([channel[f"xyz.{c}"] for c in "XYZ"], 2), gradient() * 2)
    assert spec.getattribute("spectralLayoutVersion") == "1.0"
    assert np.array_equal(read_image(tmp_path / "a.exr"), gradient())
    with pytest.raises(ClrtError, match=r"layers\['bands'\]: float32 \(5, 7, 3\) does not fit"):
        Image(gradient(), {"bands": bands}, wavelengths=(400.0, 500.0))


@pytest.mark.parametrize("name", ["a.exr", "a.png", "a.tif", "a.jpg", "a.bmp"])
def test_tall_pictures_are_written_in_blocks_of_rows(tmp_path: Path, name: str):
    tall = np.random.default_rng(1).random((201, 3, 3), np.float32)
    image = Image(tall, {"depth": tall[..., 0]})
    image.save(tmp_path / name)
    stored, _ = samples(tmp_path / name)
    if name.endswith("exr"):
        assert np.array_equal(stored, np.concatenate([tall, tall[..., :1]], axis=2))
    elif not name.endswith("jpg"):
        assert np.array_equal(stored, encode(tall))
    assert np.abs(encode(read_image(tmp_path / name)).astype(int) - encode(tall)).mean() < 8


@pytest.mark.parametrize("name", ["a.exr", "a.png", "a.tif", "a.jpg", "a.bmp"])
def test_equal_pictures_give_equal_files(tmp_path: Path, name: str):
    picture().save(tmp_path / name)
    first = (tmp_path / name).read_bytes()
    picture().save(tmp_path / name)
    assert (tmp_path / name).read_bytes() == first
    assert b"DateTime" not in first


@pytest.mark.parametrize(
    ("name", "options", "right"),
    [
        ("a.gif", {}, ".png"),
        ("picture", {}, ".png"),
        ("a.jpg", {"bits": 16}, "use 8"),
        ("a.exr", {"bits": 8}, "holds 32 bits, not 8; say nothing of bits"),
        ("a.exr", {"exposure": 1.0}, "use 0"),
        ("a.png", {"exposure": float("nan")}, "-100 to 100"),
        ("missing/a.png", {}, "make it first"),
        ("file/a.png", {}, "is not a folder"),
        ("folder.png", {}, "is a folder"),
    ],
)
def test_what_cannot_be_saved_is_said_in_one_line_and_leaves_nothing(
    tmp_path: Path, name: str, options: dict[str, float], right: str
):
    (tmp_path / "file").write_text("text")
    (tmp_path / "folder.png").mkdir()
    before = sorted(tmp_path.rglob("*"))
    for attempt in (picture().save, check_writable):
        with pytest.raises(ClrtError, match=right) as caught:
            attempt(tmp_path / name, **options)
        assert name in str(caught.value) and "\n" not in str(caught.value)
    assert sorted(tmp_path.rglob("*")) == before


def test_checking_leaves_an_existing_file_alone(tmp_path: Path):
    (tmp_path / "a.png").write_bytes(b"old")
    assert check_writable(tmp_path / "a.png") == 8
    assert (tmp_path / "a.png").read_bytes() == b"old"
    assert [file.name for file in tmp_path.iterdir()] == ["a.png"]


def test_a_failed_or_interrupted_write_leaves_the_old_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    (tmp_path / "a.png").write_bytes(b"old")
    for error in (OSError(28, "No space left on device"), KeyboardInterrupt()):

        def fail(path: Path, error: BaseException = error) -> None:
            raise error

        monkeypatch.setattr("clrt.base.atomic._sync", fail)
        seen = ClrtError if isinstance(error, OSError) else KeyboardInterrupt
        with pytest.raises(seen, match=r"No space|^$"):
            picture().save(tmp_path / "a.png")
        assert (tmp_path / "a.png").read_bytes() == b"old"
        assert [file.name for file in tmp_path.iterdir()] == ["a.png"]


def test_a_reader_never_sees_half_a_file(tmp_path: Path):
    path = tmp_path / "a.exr"
    images = [Image(np.full((64, 64, 3), value, np.float32)) for value in (0.25, 0.75)]
    images[0].save(path)
    writer = threading.Thread(target=lambda: [image.save(path) for image in images * 20])
    writer.start()
    seen = set()
    while writer.is_alive():
        seen.add(pixel_hash(read_image(path)))
    writer.join()
    assert seen and seen <= {image.hash for image in images}


def test_a_link_keeps_pointing(tmp_path: Path):
    (tmp_path / "real").mkdir()
    (tmp_path / "link.png").symlink_to(tmp_path / "real" / "a.png")
    picture().save(tmp_path / "link.png")
    assert (tmp_path / "link.png").is_symlink() and (tmp_path / "real" / "a.png").is_file()


def test_notebooks_get_a_png():
    data = picture()._repr_png_()
    assert data.startswith(b"\x89PNG\r\n\x1a\n") and data.endswith(b"IEND\xaeB`\x82")


def test_showing_without_a_desktop_says_what_to_do(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr("sys.platform", "linux")
    for name in ("DISPLAY", "WAYLAND_DISPLAY"):
        monkeypatch.delenv(name, raising=False)
    with pytest.raises(ClrtError, match=r"image\.save"):
        picture().show()


def test_a_viewer_gets_a_file_and_what_cannot_be_shown_leaves_none(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    monkeypatch.setattr("clrt.images.image._viewer", lambda: ["true"])
    with pytest.raises(ClrtError, match="exposure"):
        picture().show(exposure=1e30)
    assert not list(tmp_path.iterdir())
    picture().show()
    (shown,) = tmp_path.glob("*/*.png")
    assert shown.read_bytes() == picture()._repr_png_()


@pytest.mark.parametrize("memory", [True, False])
@pytest.mark.parametrize("name", ["a.exr", "a.png", "a.tif", "a.jpg", "a.bmp"])
def test_a_disk_that_is_full_leaves_the_old_file(
    tmp_path: Path, name: str, memory: bool, monkeypatch: pytest.MonkeyPatch
):
    """OpenImageIO writes to memory, where there are files in memory; else what it wrote is read.

    libjpeg ends the process where it cannot write: of `ulimit -f` we speak before it does.
    """
    image = Image(np.random.default_rng(1).random((90, 120, 3), np.float32))
    image.save(tmp_path / name)
    before = (tmp_path / name).read_bytes()
    if not memory:
        monkeypatch.delattr(os, "memfd_create", raising=False)
        image.save(tmp_path / name)
        assert (tmp_path / name).read_bytes() == before
    copy = shutil.copyfileobj
    for most in (0, 100, 4096):

        def on_a_full_disk(source: Any, target: Any, length: int, most: int = most) -> None:
            with small_files(most):
                copy(source, target, length)

        monkeypatch.setattr(shutil, "copyfileobj", on_a_full_disk)
        says = pytest.raises(ClrtError, match=f"{name}: cannot be written: .")
        with nullcontext() if memory else small_files(most), says as caught:
            image.save(tmp_path / name)
        assert "\n" not in str(caught.value)
        assert [file.name for file in tmp_path.iterdir()] == [name]
        assert (tmp_path / name).read_bytes() == before


@pytest.mark.parametrize("text", ["\ud800", "a\udcffb", "a\0b", None, 5, ["a"], b"a", np.zeros(2)])
def test_texts_that_no_file_can_hold_are_refused(text: Any, tmp_path: Path) -> None:
    pixels = np.zeros((2, 2, 3), np.float32)
    with pytest.raises(ClrtError, match=r"metadata\['a'\]: .* it must be a text that UTF-8 can hold"):
        Image(pixels, metadata={"a": text})
    if isinstance(text, str):
        with pytest.raises(ClrtError, match=r"metadata: .* it must be a text that UTF-8 can hold"):
            Image(pixels, metadata={text: "a"})
        with pytest.raises(ClrtError, match=r"layers: .* it must be a text that UTF-8 can hold"):
            Image(pixels, {text: pixels})


@pytest.mark.parametrize("letter", ["x", "é"])
def test_a_name_that_an_exr_would_lose_is_refused(letter: str, tmp_path: Path) -> None:
    pixels, file = np.zeros((2, 2, 3), np.float32), tmp_path / "a.exr"
    for most, made in (
        (255, lambda name: Image(pixels, {name: pixels})),
        (255, lambda name: Image(pixels, {name: pixels[..., 0]})),
        (250, lambda name: Image(pixels, metadata={name: "held"})),
    ):  # fmt: skip
        name = letter * (most // len(letter.encode()))
        again = read_image(made(name).save(file), layers="all")
        assert name in again.layers or again.metadata[name] == "held"
        with pytest.raises(ClrtError, match=f"too many for a name in an .exr; it takes {most}"):
            made(f"{name}{letter}").save(file)
        assert read_image(file).shape == (2, 2, 3)  # the old one


@pytest.mark.parametrize("wavelengths", [
    (500, 500), (500, 500.0000001), (np.nan, 500), (np.inf, 500), (-5, 500), (0, 500), (1e-9, 500),
])  # fmt: skip
def test_wavelengths_are_above_0_and_apart(wavelengths: tuple[float, float]) -> None:
    pixels = np.zeros((2, 2, 3), np.float32)
    with pytest.raises(ClrtError, match=r"wavelengths: .* is not allowed; they must be above 0"):
        Image(pixels, {"bands": np.zeros((2, 2, 2), np.float32)}, wavelengths=wavelengths)


def test_any_other_text_is_held(tmp_path: Path) -> None:
    pixels = np.zeros((2, 2, 3), np.float32)
    image = Image(pixels, {"Höhe\u202e\x1b": pixels}, metadata={"\x1b[31m": "\u202e\n\x7f😀", "": ""})
    for suffix in (".png", ".exr", ".tif", ".jpg", ".bmp"):
        assert read_image(image.save(tmp_path / f"a{suffix}")).shape == (2, 2, 3)
