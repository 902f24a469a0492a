"""`clrt compare`: what it prints about pictures and scenes, and with which exit code."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import clrt
import compare_samples as samples
from clrt.base.install import install_extra, pip_install
from clrt.cli import main

Printed = pytest.CaptureFixture[str]


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A scene, its picture as floats and as bytes, and the same upside down."""
    samples.scene().save(tmp_path / "scene.toml")
    image = clrt.Image(samples.picture())
    image.save(tmp_path / "right.exr")
    image.save(tmp_path / "right.png")
    clrt.Image(samples.picture()[::-1]).save(tmp_path / "flipped.png")
    return tmp_path


def compare(folder: Path, capsys: Printed, a: str, b: str, *options: str) -> tuple[int, str]:
    """Exit code and stdout, every run of white space as one space."""
    code = main(["compare", str(folder / a), str(folder / b), *options])
    return code, " ".join(capsys.readouterr().out.split())


@pytest.mark.parametrize(("a", "b", "verdict"), [
    ("right.exr", "right.exr", "identical: the same pixels, bit for bit"),
    ("right.png", "right.exr", "equal: they differ by rounding only"),
    ("right.exr", "scene.toml", "identical: the same pixels, bit for bit"),
    ("right.png", "scene.toml", "equal: they differ by rounding only"),
    ("scene.toml", "right.png", "equal: they differ by rounding only"),
    ("scene.toml", "scene.toml", "identical: the same pixels, bit for bit"),
])  # fmt: skip
def test_what_is_the_same_passes(folder: Path, capsys: Printed, a: str, b: str, verdict: str):
    code, out = compare(folder, capsys, a, b)
    assert code == 0 and out.endswith(verdict)
    assert f"{a} (A) against" in out and "SSIM 1.00000 >= 0.998 ok structure, 1 is equal" in out


@pytest.mark.parametrize("b", ["right.exr", "scene.toml"])
def test_a_wrong_picture_fails_and_says_why(folder: Path, capsys: Printed, b: str):
    code, out = compare(folder, capsys, "flipped.png", b)
    assert code == 1 and "SSIM" in out and "fails" in out
    assert "different: they show different things" in out
    assert "cause: vertical flip: top and bottom are swapped" in out
    assert out.endswith("Undoing it leaves 0 % of the error.")


def test_a_wrong_scene_is_found_out(folder: Path, capsys: Printed):
    clrt.render(samples.with_lights(1, 0)).save(folder / "dark.png")
    code, out = compare(folder, capsys, "dark.png", "scene.toml", "--mask")
    assert code == 1 and "cause: light 2 of 2 (direction 1, -1.5, -1) missing: " in out
    code, out = compare(folder, capsys, "scene.toml", "dark.png")
    assert code == 1 and "cause: light 2 of 2 (direction 1, -1.5, -1) missing: " in out
    code, out = compare(folder, capsys, "dark.png", "right.png")
    assert code == 1 and "possible cause: a missing light, or a shadow that should not be: it" in out
    assert "compare with the scene to be sure" in out and "cause: light" not in out


def test_what_nothing_explains(folder: Path, capsys: Printed):
    noise = np.random.default_rng(1).random(samples.picture().shape).astype(np.float32)
    clrt.Image(noise).save(folder / "noise.png")
    code, out = compare(folder, capsys, "noise.png", "right.png")
    assert code == 1 and "no usual mistake explains it; with the scene as B, lights" in out


def test_what_helps_nothing_is_not_said_to_leave_more_than_all(folder: Path, capsys: Printed):
    """Noise in another size: that the sizes differ is worth a line, undoing it changes nothing."""
    noise = np.random.default_rng(1).random((20, 20, 3)).astype(np.float32)
    clrt.Image(noise).save(folder / "small.png")
    code, out = compare(folder, capsys, "small.png", "right.png")
    assert code == 1 and "possible cause: another size" in out
    assert "Undoing it alone makes the error no smaller." in out and "e+02" not in out


def test_samples_of_the_scene_can_be_chosen(folder: Path, capsys: Printed):
    clrt.render(samples.scene(), spp=4).save(folder / "smooth.exr")
    assert compare(folder, capsys, "smooth.exr", "scene.toml", "--spp", "4", "--threads", "1")[0] == 0


def test_a_scene_is_rendered_in_the_size_of_the_picture(folder: Path, capsys: Printed):
    clrt.render(samples.scene(), width=64).save(folder / "small.exr")
    assert compare(folder, capsys, "small.exr", "scene.toml")[0] == 0
    clrt.render(samples.scene(), 64, 64).save(folder / "square.exr")
    code, out = compare(folder, capsys, "square.exr", "scene.toml")
    assert code == 1 and "size" in out and "another size" in out and "64 x 64 in place of 96 x 72" in out


def test_json(folder: Path, capsys: Printed):
    code, out = compare(folder, capsys, "flipped.png", "right.png", "--json")
    told = json.loads(out)
    assert code == 1 and told["verdict"] == "different" and told["passed"] is False
    assert told["causes"][0] | {"error_left": 0} == {
        "name": "vertical flip", "error_left": 0, "proven": True,
        "text": "top and bottom are swapped: y points the other way, or rows start at the bottom",
    }  # fmt: skip
    assert told["gates"][0]["name"] == "SSIM" and told["metrics"]["SSIM"] == told["gates"][0]["value"]
    code, out = compare(folder, capsys, "right.png", "right.png", "--json")
    assert code == 0 and json.loads(out)["metrics"]["PSNR"] is None, "JSON has no infinity"


@pytest.mark.parametrize(("a", "says"), [
    ("missing.png", "missing.png: there is no such file"),
    ("missing.toml", "no such file"),
    ("broken.png", "not an EXR, HDR, PNG, JPEG, TIFF or BMP picture"),
    ("blind.toml", "camera: missing; a picture needs a [camera]"),
    ("mine.pfm", "the suffix '.pfm' is not known; pictures are .exr, .png, .tif"),
    ("", "this is a folder; pictures are .exr"),
])  # fmt: skip
def test_faults_are_one_line(folder: Path, capsys: Printed, a: str, says: str):
    (folder / "broken.png").write_text("no picture")
    (folder / "blind.toml").write_text("max_depth = 1")
    (folder / "mine.pfm").write_text("PF")
    assert main(["compare", str(folder / a), str(folder / "right.png")]) == 2
    err = capsys.readouterr().err
    assert err.startswith("clrt: error: ") and says in err and err.count("\n") == 1


def test_a_missing_package_is_named(folder: Path, capsys: Printed, monkeypatch: Any):
    monkeypatch.delitem(sys.modules, "skimage.metrics", raising=False)
    monkeypatch.setitem(sys.modules, "skimage", None)
    assert main(["compare", str(folder / "right.png"), str(folder / "right.exr")]) == 2
    err = capsys.readouterr().err
    assert "needs the package skimage" in err and install_extra("validation") in err


def test_without_flip_the_other_gates_decide(folder: Path, capsys: Printed, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setitem(sys.modules, "flip_evaluator", None)
    note = "note: FLIP was not run, the other gates decide: install it, where this Python has wheels of it "
    note += f"(3.13 and older): {pip_install('flip-evaluator')}"
    for name, code, verdict in (("right.png", 0, "equal"), ("flipped.png", 1, "different")):
        ended, out = compare(folder, capsys, name, "right.exr")
        assert ended == code and f"{verdict}: " in out and out.count(note) == 1
        assert "FLIP" not in out.replace(note, "") and "SSIM" in out and "nan" not in out
    _, out = compare(folder, capsys, "right.png", "right.exr", "--json")
    found = json.loads(out)
    assert [gate["name"] for gate in found["gates"]] == ["SSIM", "PSNR", "widest place", "thin place"]
    assert "FLIP" not in found["metrics"]
    assert note.removeprefix("note: ") in found["notes"]
    code, out = many(folder, capsys, "right.exr", "right.png", "flipped.png")
    assert code == 1 and "1 of 2 show the same" in out and "FLIP was not run" in out and "nan" not in out


def many(folder: Path, capsys: Printed, *names: str, options: tuple[str, ...] = ()) -> tuple[int, str]:
    code = main(["compare", *(str(folder / name) for name in names), *options])
    return code, capsys.readouterr().out


def test_many_pictures_are_judged_in_a_table(folder: Path, capsys: Printed, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.chdir(folder)
    code, out = many(Path(), capsys, "scene.toml", "right.png", "right.exr", "flipped.png")
    rows = {row.split()[0]: row for row in out.splitlines()}
    assert code == 1 and "3 show the same" in out and out.startswith("against scene.toml")
    assert "equal" in rows["right.png"] and "identical" in rows["right.exr"]
    assert "different" in rows["flipped.png"] and "cause: vertical flip" in rows["flipped.png"]
    assert "2 of 3" in out
    assert many(Path(), capsys, "right.exr", "right.png", "right.exr")[0] == 0


def test_one_that_cannot_be_read_does_not_stop_the_others(
    folder: Path, capsys: Printed, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.chdir(folder)
    (folder / "broken.png").write_text("no picture")
    clrt.Image(samples.picture()[:50]).save(folder / "small.png")
    names = ("right.exr", "broken.png", "small.png", "scene.toml", "right.png", "none.png")
    code = main(["compare", *names])
    out, err = capsys.readouterr()
    assert err.count("clrt: error: ") == 1 and "broken.png" in err and "(and 2 more of 5)" in err
    assert code == 2 and "1 of 5 show the same" in out
    assert out.count("not read") == 3 and "not an EXR" in out and "only the first may be one" in out
    assert "96 x 50 in place of 96 x 72" in out or "larger view" in out or "cropped" in out
    code, out = many(Path(), capsys, *names, options=("--json",))
    rows = json.loads(out)
    assert code == 2 and [row["a"] for row in rows] == list(names[1:])
    assert [("error" in row) for row in rows] == [True, False, True, False, True]
    assert rows[3]["verdict"] == "equal" and {row["b"] for row in rows} == {"right.exr"}


def test_a_search_without_time_says_so(folder: Path, capsys: Printed):
    noise = np.random.default_rng(1).random(samples.picture().shape).astype(np.float32)
    clrt.Image(noise).save(folder / "noise.png")
    code, out = compare(folder, capsys, "noise.png", "scene.toml", "--seconds", "0")
    assert code == 1 and "note: the search for causes stopped after 0 s; --seconds N" in out
    assert main(["compare", "a.png", "b.png", "--seconds", "-1"]) == 2
    assert "--seconds" in capsys.readouterr().err


def test_few_addresses_are_told_of(tmp_path: Path) -> None:
    """With few of them scipy's linear algebra waits for more for ever, and hears no signal but SIGKILL."""
    np_pixels = np.random.default_rng(1).random((16, 16, 3)).astype(np.float32)
    for name, pixels in (("a.png", np_pixels), ("b.png", np_pixels * 0.5)):
        clrt.Image(pixels).save(tmp_path / name)
    shell = 'ulimit -v 300000; exec "$@"'
    command = ["bash", "-c", shell, "-", sys.executable, "-m", "clrt", "compare", "a.png", "b.png"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, timeout=60, check=False)
    assert done.returncode == 2 and "ulimit -v 300000: scikit-image needs more; allow at least" in done.stderr
    assert done.stderr.count("\n") == 1
