"""Views: ACES and others in place of the sRGB curve, in files and on the command line."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import OpenImageIO as oiio
import pytest

import clrt
from clrt.cli import main
from clrt.images import views
from clrt.images.file import decode, encode

ACES = "ACES 2.0 - SDR 100 nits (Rec.709)"
RAMP = np.repeat(np.geomspace(1e-4, 100, 64, dtype=np.float32)[None, :, None], 3, axis=2)


def stored(path: Path) -> np.ndarray:
    source = oiio.ImageInput.open(str(path))
    return source.read_image(source.spec().format)


def test_the_views_are_listed():
    assert {ACES, "Un-tone-mapped", "Raw"} <= set(clrt.views())


def test_aces_rolls_off_and_keeps_order():
    """ACES 2.0 shows 18 % grey at 10 of 100 nits; the sRGB curve alone clips from 1 on."""
    shown = views.encode_view(RAMP, bits=16, view=ACES)
    assert (np.diff(shown[0, :, 1].astype(int)) >= 0).all()
    light = decode(shown)[0, :, 1]
    assert abs(np.interp(0.18, RAMP[0, :, 0], light) - 0.10) < 2e-3
    assert 0.4 < np.interp(1.0, RAMP[0, :, 0], light) < 0.6 and light[-1] > 0.99
    assert np.abs(shown - shown[..., 1:2].astype(int)).max() <= 2  # grey stays grey


def test_without_a_tone_curve_it_is_srgb():
    for bits in (8, 16):
        shown = views.encode_view(RAMP, 1.0, bits, "Un-tone-mapped")
        assert np.abs(shown.astype(int) - encode(RAMP, 1.0, bits)).max() <= (bits == 16)
    assert np.array_equal(views.encode_view(RAMP, 1.0), encode(RAMP, 1.0))


def test_odd_numbers_are_shown():
    odd = np.float32([[[np.nan] * 3, [np.inf] * 3, [-np.inf] * 3, [1e30, 0, 0]]])
    for view in clrt.views():
        shown = views.encode_view(odd, view=view)
        assert (shown[0, 0] <= shown[0, 1]).all() and (shown[0, 1] == 255).all(), view
        assert (shown[0, 2] == 0).all()


def test_large_pictures_go_in_parts(monkeypatch: pytest.MonkeyPatch):
    pixels = np.random.default_rng(1).random((9, 64, 3), np.float32) * 4
    whole = views.encode_view(pixels, view=ACES)
    monkeypatch.setattr(views, "_SIDE", 130)
    assert np.array_equal(views.encode_view(pixels, view=ACES), whole)


def test_files_hold_the_view(tmp_path: Path):
    image = clrt.Image(RAMP.repeat(3, axis=0), {"direct": RAMP.repeat(3, axis=0) / 2,
                                               "normal": np.ones((3, 64, 3), np.float32)})  # fmt: skip
    image.save(tmp_path / "a.png", 1.0, 16, ACES)
    assert np.array_equal(stored(tmp_path / "a.png"), views.encode_view(image.pixels, 1.0, 16, ACES))
    assert oiio.ImageInput.open(str(tmp_path / "a.png")).spec().getattribute("clrt:view") == ACES
    image.save_layers(tmp_path / "b.png", 1.0, 16, ACES)
    assert np.array_equal(stored(tmp_path / "b.direct.png"),
                          views.encode_view(image.layers["direct"], 1.0, 16, ACES))  # fmt: skip
    image.save_layers(tmp_path / "c.png", bits=16)
    assert np.array_equal(stored(tmp_path / "b.normal.png"), stored(tmp_path / "c.normal.png"))


def test_faults_say_what_there_is(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    image = clrt.Image(RAMP)
    near = "aces 2.0 sdr 100 nits", "did you mean 'ACES 2.0 - SDR"
    for view, words in (near, ("?", "there are 'ACES 2.0 ")):
        with pytest.raises(clrt.ClrtError, match=words):
            image.save(tmp_path / "a.png", view=view)
    with pytest.raises(clrt.ClrtError, match=r"view = '.*', but \.exr holds the radiance itself"):
        image.save(tmp_path / "a.exr", view=ACES)
    with pytest.raises(clrt.ClrtError, match="view: 5 is not allowed; it must be the name of a view"):
        image.save(tmp_path / "a.png", view=5)  # type: ignore[arg-type]
    with monkeypatch.context() as broken:
        broken.setattr(views, "_LINEAR", "none such")
        with pytest.raises(clrt.ClrtError, match=r"view: 'ACES.*none such"):
            image.save(tmp_path / "a.png", view=ACES)
    monkeypatch.setattr(views, "CONFIG", "ocio://none-such")
    with pytest.raises(clrt.ClrtError, match=r"has no built-in views: OpenImageIO 3\.2 or newer"):
        image.save(tmp_path / "a.png", view=ACES)
    assert not list(tmp_path.iterdir())


def test_the_commands_take_a_view(tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    scene = tmp_path / "a.toml"
    scene.write_text("""
background = [0.5, 2.0, 0.1]
[camera]
origin = [0, 0, 5]
target = [0, 0, 0]
width = 6
height = 4
""")
    out = tmp_path / "a.png"
    assert main(["render", str(scene), "-o", str(out), "--view", ACES, "--exposure", "1", "-q"]) == 0
    light = np.broadcast_to(np.float32([0.5, 2.0, 0.1]), (4, 6, 3))
    assert np.array_equal(stored(out), views.encode_view(light, 1.0, view=ACES))
    series = ["--set", "camera.fov=20,30", "--view", ACES, "-q"]
    assert main(["sweep", str(scene), "-o", str(tmp_path / "s{index}.png"), *series]) == 0
    assert np.array_equal(stored(tmp_path / "s1.png"), views.encode_view(light, view=ACES))
    before = sorted(tmp_path.iterdir())
    unknown = "view: 'filmic' is none; there are 'ACES"
    for name, words in (("x.png", unknown), ("x.exr", "holds the radiance")):
        view = "filmic" if name == "x.png" else ACES
        assert main(["render", str(scene), "-o", str(tmp_path / name), "--view", view]) == 2
        assert words in capsys.readouterr().err and sorted(tmp_path.iterdir()) == before
