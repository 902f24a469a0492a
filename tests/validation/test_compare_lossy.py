"""EXR of lossy compression: what the file itself loses is no difference, and no cause is made of it."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import OpenImageIO as oiio
import pytest

import clrt
import compare_samples as samples
from clrt.base.resources import validation_module
from clrt.cli import main
from clrt.images.file import write
from clrt.judging.verdict import HALF, LOSSY, RADIANCE, bits_of_file

lossy = validation_module("compare.lossy")
BITS = {name: bits for bits, name in LOSSY.items()}


def put(path: Path, pixels: np.ndarray, compression: str, kind: str = "float16") -> Path:
    write(path, [pixels.astype(kind)], metadata={"compression": compression})
    return path


def with_grain() -> np.ndarray:
    """A picture that has something to lose, some of it above white."""
    grain = np.random.default_rng(3).random((96, 128, 3), np.float32)
    right = np.tile(samples.picture(), (4, 4, 1))[:96, :128] * np.float32(1.5)
    return np.ascontiguousarray(right * (0.9 + 0.1 * grain), np.float32)


@pytest.mark.parametrize("compression", list(BITS))
def test_a_right_picture_is_equal_whichever_of_the_two_it_is(tmp_path: Path, compression: str) -> None:
    right = with_grain()
    file, plain = put(tmp_path / "a.exr", right, compression), clrt.Image(right).save(tmp_path / "b.exr")
    assert np.abs(clrt.read_image(file) - right).max() > 0.005, "it loses nothing"
    for a, b in ((file, right), (right, file), (file, plain)):
        verdict = clrt.compare(a, b)
        assert verdict.verdict == "equal" and not verdict.causes, verdict
        assert [f"compression {compression}, which loses" in note for note in verdict.notes] == [True]
    assert clrt.compare(file, file).verdict == "identical"
    assert main(["compare", str(file), str(plain)]) == 0
    other = put(tmp_path / "c.exr", right, "b44" if compression[0] == "d" else "dwaa")
    assert clrt.compare(file, other) and len(clrt.compare(file, other).notes) == 2


@pytest.mark.parametrize("compression", list(BITS))
def test_what_is_wrong_is_wrong_all_the_same(tmp_path: Path, compression: str) -> None:
    right, path = with_grain(), tmp_path / "a.exr"
    verdict = clrt.compare(put(path, right * np.float32(0.9), compression), right)
    assert not verdict and verdict.causes[0].name == "exposure factor 0.9"
    verdict = clrt.compare(put(path, right[::-1], compression), right)
    assert not verdict and verdict.causes[0].name == "vertical flip" and verdict.causes[0].proven
    smooth = np.ascontiguousarray(np.tile(samples.picture(), (2, 2, 1)))
    dark = smooth.copy()
    dark[30:50, 40:60] *= 0.2
    verdict = clrt.compare(put(path, dark, compression), smooth)
    assert not verdict and verdict.causes[0].name == "a missing light, or a shadow that should not be"
    assert clrt.compare(put(path, right[:50], compression), right).verdict == "different"


@pytest.mark.parametrize("level", [150, 400])
def test_of_what_was_pressed_harder_no_object_is_made(tmp_path: Path, level: int) -> None:
    right = with_grain()
    verdict = clrt.compare(put(tmp_path / "a.exr", right, f"dwaa:{level}"), right)
    assert not verdict and not verdict.causes and "at its usual level" in verdict.notes[0]


def test_bits_of_files(tmp_path: Path) -> None:
    """B44 leaves floats of 32 bits as they are, DWA does not."""
    right, path = with_grain(), tmp_path / "a.exr"
    for compression, bits in BITS.items():
        assert bits_of_file(put(path, right, compression)) == bits
        whole = compression.startswith("b44")
        assert bits_of_file(put(path, right, compression, "float32")) == (RADIANCE if whole else bits)
        assert np.array_equal(clrt.read_image(path), right) == whole
    for compression in ("zip", "piz", "none", "rle"):
        assert bits_of_file(put(path, right, compression)) == HALF


@pytest.mark.parametrize(("compression", "bits"), [("zip", HALF), *BITS.items()])
def test_a_float_depth_beside_them_makes_no_floats_of_colours(
    tmp_path: Path, compression: str, bits: int
) -> None:
    """As many renderers write both. A right picture was wrong by what halves, and B44, lose."""
    right, path = with_grain(), str(tmp_path / "a.exr")
    spec = oiio.ImageSpec(128, 96, 4, oiio.FLOAT)
    spec.channelnames = "R", "G", "B", "Z"
    spec.attribute("compression", compression)
    pixels = oiio.ImageBuf(spec)
    pixels.set_pixels(oiio.ROI(), np.concatenate([right, 5 + right[..., :1]], axis=2))
    pixels.set_write_format((oiio.HALF, oiio.HALF, oiio.HALF, oiio.FLOAT))
    assert pixels.write(path) and bits_of_file(path) == bits
    assert oiio.ImageBuf(path).nativespec().channelformat(3) == "float"
    assert clrt.compare(path, right).verdict == "equal" and not clrt.compare(path, right * 1.01)


def test_layers_of_one_number() -> None:
    """DWA leaves depths alone, B44 does not."""
    depth = 5 + np.random.default_rng(4).random((40, 50), np.float32)
    assert lossy.loss(depth, BITS["dwaa"]).max() < 0.005
    assert 0.05 > lossy.loss(depth, BITS["b44"]).max() > 0.005
    assert np.array_equal(lossy.told_apart(depth * 1.001, depth, BITS["b44"]), depth)
    assert not np.isclose(lossy.told_apart(depth * 1.1, depth, BITS["b44"]), depth).all()


def test_what_no_half_holds_is_not_lost() -> None:
    bright = np.full((20, 20, 3), 1e6, np.float32)
    assert np.isfinite(lossy.told_apart(bright, bright, BITS["dwaa"])).all()


def test_wide_pictures_are_stored_in_parts(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of whole blocks: what is lost is the same, and no part is large, nor too wide for the compressions."""
    right = with_grain()
    whole = [lossy.loss(right, bits) for bits in LOSSY]
    monkeypatch.setattr(lossy, "_STORED", 96 * 28)
    stored, sizes = lossy._stored, set()
    monkeypatch.setattr(lossy, "_stored", lambda part, kind: sizes.add(part.shape) or stored(part, kind))
    for bits, expected in zip(LOSSY, whole, strict=True):
        assert np.array_equal(lossy.loss(right, bits), expected)
    assert sizes == {(96, 24, 3), (96, 8, 3)}
