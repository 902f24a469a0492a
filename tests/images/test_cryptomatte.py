"""Cryptomatte as other programs read it: hashes, metadata, and channels whose coverages sum to alpha."""

from __future__ import annotations

import json
import struct
from itertools import product
from pathlib import Path

import numpy as np
import OpenImageIO as oiio
import pytest

import clrt
from clrt.base.layers import RANKS
from clrt.engine.coverage import covered
from clrt.images import cryptomatte
from validation.oracle64 import render64

HOSTILE = ['a"b', "back\\slash", "new\nline", "a\0b", "</script>", "mädchen", "\U0001f600", "{}", "\ud800"]
LAYERS = ["alpha", "crypto_shape", "crypto_material", "shape"]


def scene(spp: int = 16) -> clrt.Scene:
    """Three balls, two of one material, a disk without a name, a light that is seen; nothing behind."""
    ball = {"type": "sphere", "radius": 1.0}
    return clrt.load_dict({
        "camera": {"origin": [0, 0, 7], "target": [0, 0, 0], "width": 40, "height": 30, "spp": spp},
        "materials": {"red": {"color": [0.8, 0.1, 0.1]}, "glass": {"fresnel": True, "diffuse": 0.0}},
        "lights": [{"type": "point", "position": [3, 5, 4]},
                   {"type": "sphere", "center": [1.6, 1.9, 0], "radius": 0.4, "radiance": 2.0, "samples": 1}],
        "shapes": [
            {**ball, "center": [-1.4, 0, 0], "name": "left", "material": "red"},
            {**ball, "center": [1.4, 0, -0.5], "name": "right", "material": "red"},
            {**ball, "center": [0, 0.3, 1.5], "name": "middle", "material": "glass"},
            {"type": "disk", "center": [0, -1.5, 0], "normal": [0, 0.3, 1], "radius": 1.5},
        ],
    })  # fmt: skip


@pytest.fixture(scope="module")
def image() -> clrt.Image:
    return clrt.render(scene(), layers=LAYERS)


@pytest.mark.parametrize("name", ["mitchell", "gaussian", "box"])
def test_mattes_of_a_pixel_do_not_depend_on_others(name: str):
    """Under Mitchell's filter they did: alone a pixel had 1.07 of a ball, and tiles had other parts."""
    wide = scene().replace({"camera.filter": name, "camera.width": 16, "camera.height": 12})
    whole = clrt.render(wide, layers=["crypto_shape", "alpha"])
    tiled = clrt.render(wide, layers=["crypto_shape"], settings=clrt.Settings(tile=16))
    assert np.array_equal(whole.layers["crypto_shape"], tiled.layers["crypto_shape"])
    for x, y in product(range(0, 16, 3), range(0, 12, 2)):
        alone = clrt.render(wide, layers=["crypto_shape"], crop=(x, y, 1, 1)).layers["crypto_shape"]
        assert np.array_equal(alone[0, 0], whole.layers["crypto_shape"][y, x])
    shares = whole.layers["crypto_shape"][..., 1::2]
    assert shares.min() >= 0 and shares.sum(axis=2).max() <= 1 + 1e-6


def test_a_manifest_that_is_nested_thousands_deep_is_none(image: clrt.Image):
    key = next(name for name in image.metadata if name.endswith("/manifest"))
    deep = clrt.Image(image.pixels, image.layers, {}, {**image.metadata, key: "[" * 20_000})
    of = "shape" if "left" in image.metadata[key] else "material"
    name = "left" if of == "shape" else "red"
    assert np.array_equal(deep.matte(name, of), image.matte(name, of))


@pytest.mark.parametrize("layer", [np.zeros((3, 4)), np.zeros((3, 4, 3)), np.zeros((3, 4), np.int32)])
def test_a_layer_that_is_no_matte_is_named(layer: np.ndarray):
    other = clrt.Image(np.zeros((3, 4, 3), np.float32), {"crypto_shape": layer})
    with pytest.raises(clrt.ClrtError, match=r"layers\['crypto_shape'\]: .* is not allowed; .* float32"):
        other.matte("left")


def test_mattes_of_float64_are_those_of_float32(image: clrt.Image):
    ranked = image.layers["crypto_shape"].astype(np.float64)
    wide = clrt.Image(image.pixels, {**image.layers, "crypto_shape": ranked}, {}, image.metadata)
    assert np.array_equal(wide.matte("left"), image.matte("left"))


@pytest.mark.parametrize(
    ("data", "expected"),
    [(b"", 0), (b"test", 0xBA6BD213), (b"Hello, world!", 0xC0363E43), (b"\0\0\0\0", 0x2362F9DE),
     (b"The quick brown fox jumps over the lazy dog", 0x2E4FF723)],
)  # fmt: skip
def test_the_hash_is_murmur3(data: bytes, expected: int):
    """Published values of MurmurHash3_x86_32 with seed 0."""
    assert cryptomatte.murmur3(data) == expected


@pytest.mark.parametrize(
    ("name", "expected"),
    [("hello", 6.0705627102400005616e-17), ("cube", -4.08461912519e15), ("sphere", 2.79018604383e15),
     ("plane", 3.66557617593e-11), ("равнина", -1.3192631212399999468e-25),
     ("mädchen", 6.2361298211599995797e25)],
)  # fmt: skip
def test_names_have_the_numbers_that_psyops_own_tests_expect(name: str, expected: float):
    assert cryptomatte.ids_of([name])[0] == np.float32(expected)


def test_no_number_is_zero_infinite_or_nan():
    names = ["", *HOSTILE, *(f"n{number}" for number in range(4000))]
    hashes = [cryptomatte.murmur3(name.encode(errors="replace")) for name in names]
    exponents = {number >> 23 & 255 for number in hashes}
    assert {0, 255} <= exponents  # both that have to be changed come up
    found = np.abs(cryptomatte.ids_of(names))
    assert np.isfinite(found).all() and (found >= np.finfo(np.float32).tiny).all()
    changed = [cryptomatte.id_of(name) ^ number for name, number in zip(names, hashes, strict=True)]
    assert set(changed) == {0, 1 << 23}


def test_a_file_is_read_as_the_specification_says(image: clrt.Image, tmp_path: Path):
    """With nothing but OpenImageIO, json and struct."""
    source = oiio.ImageInput.open(str(image.save(tmp_path / "a.exr")))
    spec = source.spec()
    stored = source.read_image(0, 0, 0, spec.nchannels, oiio.FLOAT)
    channel = dict(zip(spec.channelnames, np.moveaxis(stored, 2, 0), strict=True))
    about = {a.name: a.value for a in spec.extra_attribs if a.name.startswith("cryptomatte/")}
    layers = {name.split("/")[1]: text for name, text in about.items() if name.endswith("/name")}
    assert set(layers.values()) == {"crypto_shape", "crypto_material"}
    for key, layer in layers.items():
        assert key == f"{cryptomatte.id_of(layer):08x}"[:7]
        assert about[f"cryptomatte/{key}/hash"] == "MurmurHash3_32"
        assert about[f"cryptomatte/{key}/conversion"] == "uint32_to_float32"
        manifest = json.loads(about[f"cryptomatte/{key}/manifest"])
        total = np.zeros((30, 40))
        for name, number in manifest.items():
            value = struct.unpack("<f", struct.pack("<I", int(number, 16)))[0]
            matte = np.zeros((30, 40), np.float32)
            for level in ("00", "01", "02"):
                for number_of, part in ("RG", "BA"):
                    here = channel[f"{layer}{level}.{number_of}"] == value
                    matte += np.where(here, channel[f"{layer}{level}.{part}"], 0)
            assert np.array_equal(matte, image.matte(name, layer.removeprefix("crypto_"))), name
            total += matte
        assert np.abs(total - image.layers["alpha"]).max() <= 1e-6
        if layer == "crypto_shape":
            assert [*manifest] == ["left", "right", "middle", "shapes[3]", "lights[1]"]
        else:
            assert [*manifest] == ["red", "glass", "(default)", "lights[1]"]


def test_mattes_and_alpha_are_the_float64_oracles(image: clrt.Image):
    """Of 16 samples; a sample next to an edge may fall on its other side."""
    exact = render64(scene(), layers=["alpha", "crypto_shape"]).layers
    for number, name in [*enumerate(("left", "right", "middle", "shapes[3]")), (5, "lights[1]")]:
        off = np.abs(image.matte(name) - exact["crypto_shape"][..., number])
        assert np.mean(off > 1e-6) <= 2e-3 and off.max() <= 1 / 16 + 1e-6, name
        assert exact["crypto_shape"][..., number].max() == 1.0
    off = np.abs(image.layers["alpha"] - exact["alpha"])
    assert np.mean(off > 1e-6) <= 2e-3 and 0 < np.mean(image.layers["alpha"] % 1 != 0) < 0.5
    both = image.matte("left") + image.matte("right")
    assert np.array_equal(image.matte("red", of="material"), both)
    one = clrt.render(scene(1), layers=LAYERS)
    assert np.array_equal(one.layers["alpha"], (one.layers["shape"] >= 0).astype(np.float32))
    assert np.array_equal(one.matte("middle") == 1, one.layers["shape"] == 2)


def test_parts_are_ranked_weighted_and_at_most_six():
    flat = clrt.Tracer(clrt.load_dict({"shapes": [
        {"type": "sphere", "center": [4 * k, 0, 0], "radius": 1} for k in range(8)]})).flat  # fmt: skip
    names = [f"ball {min(k, 6)}" for k in range(8)]  # the last two share a name
    ids = {"crypto_shape": cryptomatte.ids_of(names)}
    met = np.array([[0, 1, 1, 2, 3, 4, 5, 6], [7, 6, 3, -1, -1, -1, -1, -1], [-1] * 8], np.int32)
    found = covered(("crypto_shape", "alpha"), flat, met, ids)
    assert found["alpha"].tolist() == [1.0, 0.375, 0.0]
    pairs = found["crypto_shape"].reshape(3, RANKS, 2)
    assert pairs[0, 0].tolist() == [ids["crypto_shape"][1], 0.25]
    assert (pairs[0, 1:, 1] == 0.125).all() and len({*pairs[0, :, 0].tolist()}) == RANKS
    assert pairs[1, 0].tolist() == [ids["crypto_shape"][6], 0.25] and pairs[1, 1, 1] == 0.125
    assert not pairs[1, 2:].any() and not pairs[2].any()
    # a filter that takes from some samples: nothing is below 0, and the others together are alpha
    weights = np.array([4, -1, 0, 1, 1, 1, 1, 1.0])
    found = covered(("crypto_shape", "alpha"), flat, met[:2], ids, weights)
    assert found["alpha"].tolist() == [1.0, 0.375]
    pairs = found["crypto_shape"].reshape(2, RANKS, 2)
    assert pairs[0, 0].tolist() == [ids["crypto_shape"][0], np.float32(4 / 9)] and (pairs[..., 1] >= 0).all()
    assert pairs[..., 1].sum(axis=1) == pytest.approx([1.0, 0.375])
    assert ids["crypto_shape"][1] not in pairs[0, :, 0]


def test_hostile_names_come_through(tmp_path: Path):
    shapes = [{"type": "sphere", "center": [3 * k, 0, 0], "radius": 1, "name": name}
              for k, name in enumerate(HOSTILE)]  # fmt: skip
    camera = {"origin": [12, 0, 40], "target": [12, 0, 0], "width": 64, "height": 8}
    image = clrt.render({"camera": camera, "shapes": shapes}, layers=["crypto_shape"])
    back = clrt.read_image(image.save(tmp_path / "a.exr"), layers="all")
    assert back.metadata == {**image.metadata}
    told = cryptomatte.manifest_of("crypto_shape", back.metadata)
    assert [*told] == [*HOSTILE[:-1], "?"]  # half a character is none
    for name in told:
        assert back.matte(name).max() == 1, repr(name)


def test_faults_say_what_there_is(image: clrt.Image):
    with pytest.raises(clrt.ClrtError, match="'lefty' is no shape of this image; did you mean 'left'"):
        image.matte("lefty")
    with pytest.raises(clrt.ClrtError, match="'left' is no material of this image; there are red, glass, "):
        image.matte("left", of="material")
    with pytest.raises(clrt.ClrtError, match="of: 'colour' is not allowed; it must be 'shape' or 'material'"):
        image.matte("left", of="colour")
    with pytest.raises(clrt.ClrtError, match=r"no crypto_shape; render it with layers=\['crypto_shape'\]"):
        clrt.Image(image.pixels).matte("left")
    bare = clrt.Image(image.pixels, image.layers)
    assert np.array_equal(bare.matte("left"), image.matte("left")) and not bare.matte("nobody").any()
    key = f"cryptomatte/{cryptomatte.id_of('crypto_shape'):08x}"[:-1] + "/manifest"
    for text in ("{", "[1]"):
        broken = clrt.Image(image.pixels, image.layers, metadata={key: text})
        assert np.array_equal(broken.matte("left"), image.matte("left"))


@pytest.mark.parametrize("name", ["tent", "mitchell"])
def test_alpha_and_mattes_are_weighed_as_the_picture_is(name: str):
    table = scene().replace({"camera.filter": name, "camera.spp": 16})
    ours = clrt.render(table, layers=["alpha", "crypto_shape"]).layers
    exact = render64(table, layers=["alpha"]).layers["alpha"]
    off = np.abs(ours["alpha"] - exact)
    assert np.mean(off > 1e-5) <= 2e-3 and 0 <= ours["alpha"].min() <= ours["alpha"].max() <= 1
    parts = ours["crypto_shape"][..., 1::2]
    assert parts.min() >= 0 and parts.max() <= 1 and np.abs(parts.sum(axis=-1) - ours["alpha"]).max() < 1e-6
    part = ours["alpha"][(ours["alpha"] > 0) & (ours["alpha"] < 1)] * 16
    assert np.mean(np.abs(part - np.rint(part)) > 1e-3) > 0.5, "samples count alike"
