"""Files that declare something else than they hold: all else in them is right, so that the change is met."""

from __future__ import annotations

import io
import json
import random
import struct
import zipfile
import zlib
from types import ModuleType

import pytest

from clrt.base.resources import validation_module

DRAWN = range(120)


@pytest.fixture(scope="module")
def seeds() -> ModuleType:
    return validation_module("hostile.seeds")


def spoiled(module: str, suffix: str, data: bytes) -> list[bytes]:
    """What is drawn from a good file, without what stayed as it was."""
    spoil = validation_module(f"hostile.{module}").spoil
    drawn = (spoil(random.Random(seed), suffix, data) for seed in DRAWN)
    return [found for found in drawn if found != data]


@pytest.mark.parametrize("suffix", [".png", ".jpg", ".bmp", ".tif", ".exr", ".hdr"])
def test_pictures_are_changed(seeds: ModuleType, suffix: str) -> None:
    assert len(set(spoiled("pictures", suffix, seeds.images()[suffix]))) > 30


@pytest.mark.parametrize("suffix", [".gltf", ".glb", ".ply", ".obj", ".stl", ".ascii.stl"])
def test_meshes_are_changed(seeds: ModuleType, suffix: str) -> None:
    found = spoiled("meshfiles", suffix.replace(".ascii", ""), seeds.meshes()[suffix])
    assert len(set(found)) > 10


def test_a_png_has_right_checksums(seeds: ModuleType) -> None:
    pictures = validation_module("hostile.pictures")
    whole = seeds.images()[".png"]
    assert pictures.png_bytes(pictures.png_chunks(whole)) == whole
    sizes = set()
    for data in spoiled("pictures", ".png", whole):
        at = 8
        while at < len(data):
            (length,) = struct.unpack_from(">I", data, at)
            body = data[at + 4 : at + 8 + length]
            assert data[at + 8 + length : at + 12 + length] == struct.pack(">I", zlib.crc32(body))
            at += 12 + length
        assert at == len(data)
        sizes.add(data[16:24])
    assert len(sizes) > 20, "widths and heights"


def test_an_exr_keeps_its_pixels_where_the_header_says(seeds: ModuleType) -> None:
    pictures = validation_module("hostile.pictures")
    whole = seeds.images()[".exr"]
    _, end = pictures.exr_parts(whole)
    (chunk,) = struct.unpack_from("<Q", whole, end)
    channels = set()
    for data in spoiled("pictures", ".exr", whole):
        attributes, end = pictures.exr_parts(data)
        channels.add({name: value for name, _, value in attributes}[b"channels"].count(b"\0c"))
        assert data[struct.unpack_from("<Q", data, end)[0] :] == whole[chunk:]
    assert max(channels) > 900


def test_a_glb_says_how_long_it_is(seeds: ModuleType) -> None:
    counts, right = set(), 0
    for data in spoiled("meshfiles", ".glb", seeds.meshes()[".glb"]):
        length, text = struct.unpack_from("<II", data, 8)
        if length != len(data) or 20 + text > len(data):
            continue
        tree = json.loads(data[20 : 20 + text])
        right += 1
        counts.add(max(int(accessor["count"]) for accessor in tree["accessors"]))
    assert right > 60 and max(counts) >= 2**31, "sparse accessors among them"


def test_checkpoints_are_whole_archives(seeds: ModuleType) -> None:
    archives = validation_module("hostile.archives")
    whole = seeds.checkpoint()
    assert {"pixels.npy", "done.npy", "told.npy"} == {name for name, _ in archives.contents(whole)}
    readable = 0
    for seed in DRAWN:
        data = archives.spoil(random.Random(seed), whole)
        try:
            with zipfile.ZipFile(io.BytesIO(data)) as archive:
                readable += archive.testzip() is None
        except Exception:  # one whose directory is what was spoiled
            continue
    assert readable > 70


def test_texts_are_small_and_mean_much() -> None:
    texts = validation_module("hostile.texts")
    tomls = {texts.toml(random.Random(seed)) for seed in DRAWN}
    assert any(data.startswith(b"a.a.a.") for data in tomls) and max(map(len, tomls)) < 1_500_000
    jsons = {texts.json(random.Random(seed)) for seed in DRAWN}
    assert any(data.startswith(b"[[[[") for data in jsons) and max(map(len, jsons)) < 4_000_000


def test_what_is_repeated_stays_small_enough_to_be_tried() -> None:
    """A line of half a megabyte, 70,000 times, ended the run for want of memory."""
    most, xml = validation_module("hostile.sizes").MOST, validation_module("hostile.xmlfiles")
    line = f'<string name="x" value="{"9" * (1 << 19)}"/>'
    text = xml.SCENE.replace("</scene>", "\n".join([line] * 40 + ["</scene>"]))
    longest = max(len(xml._repeated(random.Random(seed), text)) for seed in range(200))
    assert len(text) + len(line) < longest <= len(text) + most
