"""`clrt.compare`: from pictures of any kind to a verdict, its gates and its report."""

from __future__ import annotations

import re
import sys
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import clrt
import compare_samples as samples
from clrt.base.install import install_extra
from clrt.cli import main
from clrt.images.file import encode


@pytest.fixture
def files(tmp_path: Path) -> dict[str, Any]:
    """The same picture in every form that `compare` takes."""
    pixels = samples.picture()
    image = clrt.Image(pixels)
    samples.scene().save(tmp_path / "scene.toml")
    return {
        "image": image, "array": pixels, "float64": pixels.astype(np.float64), "list": pixels.tolist(),
        "bytes": encode(pixels), "words": encode(pixels, bits=16),
        "exr": image.save(tmp_path / "a.exr"), "png": str(image.save(tmp_path / "a.png")),
        "scene": samples.scene(), "toml": tmp_path / "scene.toml", "dict": samples.SCENE,
    }  # fmt: skip


@pytest.mark.parametrize("b", ["image", "array", "exr", "png", "scene", "toml", "dict", "bytes"])
def test_every_form_of_a_picture_is_the_same_picture(files: dict[str, Any], b: str) -> None:
    exact = {"image", "array", "float64", "exr", "scene", "toml", "dict"}
    for a in ("image", "array", "float64", "bytes", "words", "exr", "png"):
        verdict = clrt.compare(files[a], files[b])
        assert verdict and verdict.passed and verdict.causes == (), (a, b, str(verdict))
        assert verdict.verdict == ("identical" if {a, b} <= exact or encoded_alike(a, b) else "equal")
    assert clrt.compare(files["list"], files[b]).verdict in ("identical", "equal")


def test_what_a_verdict_says_stays(files: dict[str, Any]) -> None:
    given = samples.picture().astype(np.float32)
    verdict = clrt.compare(given, files["image"])
    before = verdict.picture.tobytes()
    given[:] = 0
    assert verdict.picture.tobytes() == before
    with pytest.raises(ValueError, match="read-only"):
        verdict.reference[0] = 0
    with pytest.raises(clrt.ClrtError, match="stays as it is"):
        verdict.figures["SSIM"] = 1  # type: ignore[index]


def encoded_alike(a: str, b: str) -> bool:
    return {a, b} <= {"bytes", "png"}


def test_a_fault_is_named(files: dict[str, Any]) -> None:
    verdict = clrt.compare(samples.picture()[::-1], files["scene"])
    assert not verdict and not verdict.passed and verdict.causes[0].name == "vertical flip"
    assert re.fullmatch(r"different: SSIM 0\.\d+ \(at least 0.998\), .*; cause: vertical flip", str(verdict))
    dark = clrt.render(samples.with_lights(1, 0))
    verdict = clrt.compare(dark, files["toml"], mask=True)
    assert verdict.causes[0].name.startswith("light 2 of 2") and verdict.figures["edges left out"] > 0
    assert clrt.compare(dark, files["toml"], seconds=0).causes[:1] != verdict.causes[:1]
    assert "size" in [gate.name for gate in clrt.compare(dark.pixels[:-2], files["array"]).gates]


def test_gates_alone_decide(files: dict[str, Any]) -> None:
    brighter = samples.picture() * np.float32(1.001)
    assert not clrt.compare(brighter, files["array"]), "0.1 % more light fails FLIP"
    assert not clrt.compare(brighter, files["array"], {"largest difference": 1e-5})
    assert clrt.compare(brighter, files["array"], {"largest difference": 1e-2, "SSIM": 0.999})
    flipped = samples.picture()[::-1]
    assert clrt.compare(flipped, files["array"], {"SSIM": 0.1}), "what else differs was not asked"
    assert not clrt.compare(flipped, files["array"], {"SSIM": 0.1, "PSNR": 40})
    broken = samples.picture().copy()
    broken[3, 4] = np.nan
    assert not clrt.compare(broken, files["array"], {"SSIM": 0.0}), "NaN fails whatever is asked"
    assert not clrt.compare(flipped[:-1], files["array"], {"SSIM": 0.0}), "and so does another size"


@pytest.mark.parametrize(("arguments", "says"), [
    ((None, "array"), "a: None is not allowed; it must be a clrt.Image, an array"),
    (([[1, 2], [3]], "array"), "a: [[1, 2], [3]] is not allowed; it must be a clrt.Image, an array"),
    (("array", 3), "b: 3 is not allowed; it must be a clrt.Image"),
    (("scene", "array"), "a: a scene; only b, what the picture should show, may be one"),
    (("toml", "array"), "scene.toml: not a picture's file (.exr, .png"),
    ((np.zeros((4, 4)), "array"), "a: float64 (4, 4) is not floats or sRGB bytes of shape (h, w, 3)"),
    ((np.zeros((4, 4, 3), np.int64), "array"), "a: int64 (4, 4, 3) is not floats"),
    ((np.zeros((4, 4, 3), np.uint32), "array"), "a: uint32 is not allowed; sRGB values are uint8 or uint16"),
    (("array", "nothing.png"), "nothing.png: there is no such file"),
    (("array", {"shapes": []}), "b: camera: missing; a picture needs a [camera]"),
    (("array", "array", {"SIMM": 1}), "gates: 'SIMM' is no figure; did you mean 'SSIM'? (figures: SSIM"),
    (("array", "array", {}), "gates: {} asks for nothing; name a figure and its limit"),
    (("array", "array", {"SSIM": "high"}), "gates['SSIM']: 'high' is not allowed; it must be a number"),
    (("array", "array", {"SSIM": float("nan")}), "gates['SSIM']: nan is not allowed; it must be a number"),
    (("array", "array", 0.9), "gates: 0.9 is not allowed; it must be a dict"),
])  # fmt: skip
def test_wrong_arguments(files: dict[str, Any], arguments: tuple[Any, ...], says: str) -> None:
    given = [files.get(value, value) if isinstance(value, str) else value for value in arguments]
    with pytest.raises(clrt.ClrtError) as caught:
        clrt.compare(*given)
    assert says in str(caught.value) and "\n" not in str(caught.value)


def test_wrong_options(files: dict[str, Any], tmp_path: Path) -> None:
    with pytest.raises(clrt.ClrtError, match=r"seconds: -1\.0 is not allowed"):
        clrt.compare(files["array"], files["array"], seconds=-1)
    with pytest.raises(clrt.ClrtError, match="mask: 1 is not allowed"):
        clrt.compare(files["array"], files["array"], mask=1)  # type: ignore[arg-type]
    verdict = clrt.compare(files["array"], files["array"])
    with pytest.raises(clrt.ClrtError, match=r"out\.txt: the report is a page; give a name that"):
        verdict.save_report(tmp_path / "out.txt")
    with pytest.raises(clrt.ClrtError, match="cannot be written"):
        verdict.save_report(tmp_path / "no" / "out.html")


class Page(HTMLParser):
    """The words of a page, and what it asks of other files."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.words, self.links, self.hidden = "", [], 0
        self.feed(text)

    def handle_starttag(self, tag: str, attributes: list[tuple[str, str | None]]) -> None:
        self.hidden = tag in ("script", "style")
        self.links += [value for key, value in attributes if key in ("src", "href") and value]

    def handle_data(self, data: str) -> None:
        if not self.hidden:
            self.words += " " + " ".join(data.split())


@pytest.mark.parametrize("rows", [samples.HEIGHT, samples.HEIGHT - 5])
def test_the_report_stands_alone(files: dict[str, Any], tmp_path: Path, rows: int) -> None:
    wrong = clrt.Image(np.ascontiguousarray(samples.picture()[::-1][:rows])).save(tmp_path / "<b>&.exr")
    verdict = clrt.compare(wrong, files["exr"], mask=rows == samples.HEIGHT)
    saved = verdict.save_report(tmp_path / "report.html")
    text = saved.read_text(encoding="utf-8")
    page = Page(text)
    assert saved == (tmp_path / "report.html").resolve()
    assert all(link.startswith("data:") for link in page.links) and len(page.links) >= 3
    assert "&lt;b&gt;&amp;.exr" in text and "<b>&.exr" not in text
    same_size = rows == samples.HEIGHT
    assert ("new Viewer" in text) == same_size and "different" in page.words
    assert ("cause: vertical flip" in page.words) == same_size
    for name in verdict.figures:
        assert name in page.words


def test_the_command_writes_the_report(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    clrt.Image(samples.picture()).save(tmp_path / "a.exr")
    clrt.Image(samples.picture()[::-1]).save(tmp_path / "b.exr")
    a, b, out = (str(tmp_path / name) for name in ("a.exr", "b.exr", "out.html"))
    assert main(["compare", b, a, "--report", out]) == 1
    assert "vertical flip" in Path(out).read_text(encoding="utf-8")
    assert main(["compare", a, b, a, "--report", out]) == 2
    assert "--report is the page of one comparison" in capsys.readouterr().err
    assert main(["compare", a, b, "--report", str(tmp_path / "out.png")]) == 2
    assert "give a name that ends in .html" in capsys.readouterr().err


def test_a_missing_package_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "skimage.metrics", None)
    monkeypatch.setitem(sys.modules, "skimage", None)
    with pytest.raises(clrt.ClrtError) as caught:
        clrt.compare(samples.picture(), samples.picture())
    assert "comparing pictures needs the package skimage" in str(caught.value)
    assert install_extra("validation") in str(caught.value)


def test_radiance_above_white_is_judged_as_that_below() -> None:
    """A screen's figures end at white: what is brighter has one of its own."""
    bright = 1000 * samples.picture() + 2
    for factor in (0.5, 1.02, 3.0):
        verdict = clrt.compare(bright * np.float32(factor), bright)
        failed = {gate.name for gate in verdict.gates if not gate.passed}
        assert not verdict and failed - {"widest place", "thin place"} == {"PSNR above white"}
        assert ("widest place" in failed) == (factor != 1.02)  # a step of 255 is a fortieth
        assert verdict.causes[0].name.startswith("exposure factor")
    assert clrt.compare(bright * np.float32(1 + 1e-5), bright).verdict == "equal"
    assert clrt.compare(bright, bright).verdict == "identical"
    assert not clrt.compare(bright * np.float32(0.5), bright, gates={"PSNR above white": 45})
    assert clrt.compare(samples.picture(), samples.picture(), gates={"PSNR above white": 45})


@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_pictures_that_are_not_finite_are_never_the_same(value: float) -> None:
    picture = samples.picture().copy()
    picture[0, 0, 0] = value
    verdict = clrt.compare(picture, picture)
    assert not verdict and [gate.name for gate in verdict.gates if not gate.passed] == ["not finite"]
