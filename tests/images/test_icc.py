"""Profiles with another curve than that by which numbers are read are told of, whatever they are called."""

from __future__ import annotations

import random
import struct
import warnings
from pathlib import Path

import numpy as np
import pytest
import tifffile
from PIL import Image as Pillow
from PIL import ImageCms

from clrt.images import icc
from clrt.images.file import read_image

STORED = np.arange(6 * 9 * 3, dtype=np.uint8).reshape(6, 9, 3)
RAMP = np.linspace(0, 1, 1024)
SRGB = np.where(RAMP <= 0.04045, RAMP / 12.92, ((RAMP + 0.055) / 1.055) ** 2.4)


def table(values: np.ndarray) -> bytes:
    """A `curv` of these values."""
    numbers = np.round(values * 65535).astype(">u2").tobytes()
    return b"curv" + bytes(4) + struct.pack(">I", len(values)) + numbers


def power(exponent: float, kind: int = 0, more: tuple[float, ...] = ()) -> bytes:
    """A `para` of that exponent."""
    numbers = [round(value * 65536) for value in (exponent, *more)]
    return b"para" + bytes(4) + struct.pack(">HH", kind, 0) + struct.pack(f">{len(numbers)}i", *numbers)


LINEAR = {
    "no entry": table(np.zeros(0)), "exponent 1": b"curv" + bytes(4) + struct.pack(">IH", 1, 256),
    "a table": table(RAMP), "two entries": table(np.array([0.0, 1.0])), "para": power(1.0),
}  # fmt: skip
CURVED = {
    "exponent": b"curv" + bytes(4) + struct.pack(">IH", 1, 563), "a table": table(SRGB), "para": power(2.2),
    "para with a line": power(2.4, 3, (1 / 1.055, 0.055 / 1.055, 1 / 12.92, 0.04045)),
}  # fmt: skip


def profile(name: str, curve: bytes | None, grey: bool = False) -> bytes:
    """A profile of the second version with sRGB's primaries."""

    def xyz(*values: float) -> bytes:
        return b"XYZ " + bytes(4) + struct.pack(">3i", *(round(65536 * value) for value in values))

    text = name.encode() + bytes(1)
    described = b"desc" + bytes(4) + struct.pack(">I", len(text)) + text + bytes(4 + 4 + 2 + 1 + 67)
    tags = {b"desc": described, b"wtpt": xyz(0.9642, 1, 0.8249), b"rXYZ": xyz(0.43607, 0.22249, 0.01392),
            b"gXYZ": xyz(0.38515, 0.71687, 0.09708), b"bXYZ": xyz(0.14307, 0.06061, 0.71410)}  # fmt: skip
    if curve is not None:
        tags |= dict.fromkeys([b"kTRC"] if grey else [b"rTRC", b"gTRC", b"bTRC"], curve)
    index, body, at = b"", b"", 128 + 4 + 12 * len(tags)
    for key, data in tags.items():
        index += key + struct.pack(">II", at + len(body), len(data))
        body += data + bytes(-len(data) % 4)
    space = b"GRAY" if grey else b"RGB "
    head = struct.pack(">I4sI4s4s4s", at + len(body), b"lcms", 0x02100000, b"mntr", space, b"XYZ ")
    head += struct.pack(">6H", 2020, 1, 1, 0, 0, 0) + b"acsp" + bytes(28)
    head += struct.pack(">3i", 63190, 65536, 54061) + bytes(48)
    assert len(head) == 128
    return head + struct.pack(">I", len(tags)) + index + body


def said(path: Path) -> list[str]:
    with warnings.catch_warnings(record=True) as found:
        warnings.simplefilter("always")
        read_image(path)
    return [str(one.message) for one in found]


def test_curves_are_linear_or_not() -> None:
    for grey in (False, True):
        assert all(icc.is_linear(profile("a", curve, grey)) for curve in LINEAR.values())
        assert all(icc.is_linear(profile("a", curve, grey)) is False for curve in CURVED.values())
    assert icc.is_linear(ImageCms.ImageCmsProfile(ImageCms.createProfile("sRGB")).tobytes()) is False
    assert icc.is_linear(profile("a", None)) is None and icc.is_linear(b"") is None
    assert icc.is_linear(profile("a", b"mft2" + bytes(8))) is None


def test_broken_profiles_are_none() -> None:
    """Cut anywhere, and with bytes that are others."""
    whole = profile("a", table(RAMP), grey=True)
    assert all(icc.is_linear(whole[:cut]) is None for cut in range(128, len(whole) - 4, 7))
    draw = random.Random(3)
    for _ in range(2000):
        changed = bytearray(whole[:400])
        for _ in range(3):
            changed[draw.randrange(len(changed))] = draw.randrange(256)
        assert icc.is_linear(bytes(changed)) in (None, True, False)


@pytest.mark.parametrize("curve", LINEAR)
@pytest.mark.parametrize("name", ["GIMP built-in Linear sRGB", "sRGB-elle-V4-g10.icc", "sRGB IEC61966-2.1"])
def test_linear_numbers_in_integers_are_told_of(tmp_path: Path, name: str, curve: str) -> None:
    for suffix in ("png", "jpg", "tif"):
        path = tmp_path / f"a.{suffix}"
        Pillow.fromarray(STORED).save(path, icc_profile=profile(name, LINEAR[curve]))
        (text,) = said(path)
        assert f"those of the profile '{name}', linear ones; they are read as sRGB" in text


@pytest.mark.parametrize("curve", CURVED)
def test_curved_numbers_in_floats_are_told_of(tmp_path: Path, curve: str) -> None:
    name, floats = "sRGB IEC61966-2.1", STORED.astype(np.float32) / 255
    own = profile(name, CURVED[curve])
    tifffile.imwrite(tmp_path / "a.tif", floats, photometric="rgb", iccprofile=own)
    (text,) = said(tmp_path / "a.tif")
    assert f"those of the profile '{name}', curved ones; they are read as linear Rec.709" in text
    Pillow.fromarray(STORED).save(tmp_path / "a.png", icc_profile=own)
    assert not said(tmp_path / "a.png"), "integers are curved so"


@pytest.mark.parametrize("name", ["GIMP built-in Linear sRGB", "Linear Rec709 RGB", "Rec.709", "BT.709"])
def test_linear_floats_are_read_as_they_are(tmp_path: Path, name: str) -> None:
    floats = STORED.astype(np.float32) / 255
    tifffile.imwrite(tmp_path / "a.tif", floats, photometric="rgb", iccprofile=profile(name, LINEAR["para"]))
    assert not said(tmp_path / "a.tif")
    other = profile("Linear ACEScg", LINEAR["para"])
    tifffile.imwrite(tmp_path / "b.tif", floats, photometric="rgb", iccprofile=other)
    assert "of the profile 'Linear ACEScg'; they are read as linear" in said(tmp_path / "b.tif")[0]
