"""The command line: what it prints, where, with which exit code, and what it leaves on the disk."""

from __future__ import annotations

import json
import math
import pickle
import signal
import sys
from pathlib import Path
from typing import Any

import numpy as np
import OpenImageIO as oiio
import pytest

import clrt
from clrt.base import interrupts
from clrt.base.records import Unstated
from clrt.base.resources import scene_file, shipped_scenes, validation_module
from clrt.cli import main, options
from clrt.images.file import read_samples
from clrt.images.image import pixel_hash, read_image
from tests.cli_samples import SCENE, scene_in


@pytest.fixture
def scene(tmp_path: Path) -> Path:
    return scene_in(tmp_path)


def fault(capsys: pytest.CaptureFixture[str], *arguments: object) -> str:
    """Run a command that must fail: exit code 2, one line on stderr, nothing on stdout. Returns the line."""
    try:
        code: Any = main([str(argument) for argument in arguments])
    except SystemExit as leaving:
        code = leaving.code
    out, err = capsys.readouterr()
    assert (code, out, err.count("\n")) == (2, "", 1), (code, out, err)
    assert err.startswith("clrt: error: ")
    return err


def test_render_writes_the_picture_of_the_api_and_one_line(scene: Path, capsys: pytest.CaptureFixture[str]):
    out = scene.with_name("a.exr")
    assert main(["render", str(scene), "-o", str(out)]) == 0
    text, errors = capsys.readouterr()
    assert errors == ""
    assert text.count("\n") == 1 and text.startswith(f"{out}: 24 x 16, ")
    image = clrt.render(clrt.load(scene))
    assert " s, " in text and text.endswith(f" Mrays/s on {image.stats['device']}\n")
    assert pixel_hash(read_samples(out)) == image.hash


def test_every_option_reaches_the_render(scene: Path, monkeypatch: pytest.MonkeyPatch):
    seen: dict[str, Any] = {}

    def render(scene: Any, **options: Any) -> clrt.Image:
        seen.update(options)
        layer = np.zeros((3, 4, 3), np.float32)
        return clrt.Image(layer, {"direct": layer}, {"traced": 7, "device": "fake", "rays": {"camera": 7}})

    monkeypatch.setattr(clrt, "render", render)
    monkeypatch.setattr("clrt.cli.render._ahead", lambda scene, device, *_: device)  # not opened
    out, stats = scene.with_name("a.exr"), scene.with_name("a.json")
    size = ["--width", "40", "--height", "30", "--crop", "1", "2", "4", "3", "--spp", "9", "--max-depth", "6"]
    where = ["--device", "PoCL", "--threads", "1", "--layers", "direct, depth", "--stats", str(stats)]
    assert main(["render", str(scene), "-o", str(out), *size, *where, "--quiet"]) == 0
    assert seen.pop("settings") == clrt.Settings(threads=1)
    assert seen == {
        "width": 40, "height": 30, "crop": (1, 2, 4, 3), "spp": 9, "max_depth": 6, "device": "PoCL",
        "layers": ("direct", "depth"), "progress": None, "checkpoint": None,
    }  # fmt: skip
    assert json.loads(stats.read_text()) == {"traced": 7, "device": "fake", "rays": {"camera": 7}}
    assert main(["render", str(scene), "-o", str(out), "--device", "1"]) == 0
    assert seen["device"] == 1


def test_crop_layers_exposure_and_stats_for_real(scene: Path, capsys: pytest.CaptureFixture[str]):
    out, stats = scene.with_name("a.exr"), scene.with_name("a.json")
    options = ["--crop", "3", "2", "10", "8", "--layers", "depth,direct,shape", "--stats", str(stats)]
    assert main(["render", str(scene), "-o", str(out), *options, "--quiet"]) == 0
    assert capsys.readouterr() == ("", "")
    spec = oiio.ImageInput.open(str(out)).spec()
    assert (spec.width, spec.height) == (10, 8)
    assert {"depth.V", "direct.G", "shape.ID"} <= set(spec.channelnames)
    whole = clrt.render(clrt.load(scene)).pixels
    assert np.array_equal(read_image(out), whole[2:10, 3:13])
    assert json.loads(stats.read_text())["rays"]["camera"] == 80
    png = ["render", str(scene), "-o", str(scene.with_name("a.png"))]
    assert main([*png, "--exposure", "2", "--spp", "1"]) == 0
    clrt.Image(whole).save(scene.with_name("b.png"), exposure=2)
    assert np.array_equal(read_image(scene.with_name("a.png")), read_image(scene.with_name("b.png")))


@pytest.mark.parametrize(
    ("suffix", "camera", "top", "options", "samples"),
    [
        ("png", "", "", [], 4), ("jpg", "", "", [], 4), ("jpeg", "", "", [], 4), ("BMP", "", "", [], 4),
        ("exr", "", "", [], 1), ("tif", "", "", [], 1),
        ("png", "spp = 1", "", [], 1), ("png", "spp = 9", "", [], 9), ("png", "", "", ["--spp", "1"], 1),
        ("png", "", "", ["--set", "camera.spp=1"], 1), ("png", "", "", ["--set", "camera.fov=30"], 4),
        ("png", "", "", ["--limit", "samples=2"], 1), ("png", "", "conformance = 'spd'", [], 1),
        ("png", "filter = 'tent'", "", [], 4), ("png", "filter = 'mitchell'", "", [], 16),
        ("jpg", "filter = 'gaussian'", "", [], 16), ("png", "filter = 'gaussian'\nspp = 4", "", [], 4),
        ("png", "filter = 'gaussian'", "", ["--limit", "samples=9"], 1),
        ("exr", "filter = 'tent'", "", [], 1),
    ],
)  # fmt: skip
@pytest.mark.filterwarnings("ignore:.*too few to be weighed")
def test_pictures_to_look_at_have_4_samples_where_nobody_says_a_number(
    tmp_path: Path, suffix: str, camera: str, top: str, options: list[str], samples: int
):
    scene, out, stats = (tmp_path / name for name in ("a.toml", f"a.{suffix}", "a.json"))
    scene.write_text(f"{top}\nambient = 1.0\n[camera]\norigin = [0, 0, 4]\ntarget = [0, 0, 0]\n{camera}\n")
    size = ["--width", "8", "--height", "6", "--quiet", "--stats", str(stats)]
    assert main(["render", str(scene), "-o", str(out), *size, *options]) == 0
    assert json.loads(stats.read_text())["rays"]["camera"] == 8 * 6 * samples
    assert clrt.load(scene).camera.spp == (int(camera[-1]) if "spp" in camera else 1)


def test_adaptive_keeps_the_scene_s_threshold(tmp_path: Path):
    """It took the default's, so that the same number of samples made another picture."""
    rays = []
    text = (
        "[camera]\norigin = [0, 0, 4]\ntarget = [0, 0, 0]\nwidth = 16\nheight = 12\n"
        "[[lights]]\ntype = 'point'\nposition = [3, 4, 5]\n"
        "[[shapes]]\ntype = 'sphere'\ncenter = [0, 0, 0]\nradius = 1\n"
    )
    own = "[adaptive]\nspp = 16\nthreshold = 0.0\n"
    for said, more in ((own, []), (own, ["--adaptive", "16"]), ("", ["--adaptive", "16"])):
        scene, stats = tmp_path / "a.toml", tmp_path / "a.json"
        scene.write_text(said + text)
        arguments = ["render", str(scene), "-o", str(tmp_path / "a.exr"), "--quiet", "--stats", str(stats)]
        assert main([*arguments, *more]) == 0
        rays.append(json.loads(stats.read_text())["rays"]["camera"])
    assert rays[0] == rays[1] > rays[2] > 16 * 12


def test_a_hash_is_that_of_the_scene_s_own_samples(scene: Path, capsys: pytest.CaptureFixture[str]):
    assert main(["hash", str(scene)]) == 0
    assert capsys.readouterr().out.split()[0] == clrt.render(clrt.load(scene)).hash


def test_a_stated_sample_is_saved_and_an_unstated_one_is_not(scene: Path):
    unstated = clrt.load(scene)
    one, four = (unstated.replace({"camera.spp": spp}) for spp in (1, 4))
    for loaded, said in ((unstated, False), (one, True), (four, True)):
        loaded.save(scene.with_name("b.toml"))
        assert ("spp" in scene.with_name("b.toml").read_text()) == said
        again = clrt.load(scene.with_name("b.toml")).camera.spp
        assert again == loaded.camera.spp and isinstance(again, Unstated) != said
    assert isinstance(pickle.loads(pickle.dumps(unstated)).camera.spp, Unstated)


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("max_depth = ", "wrong syntax"),
        ("[camera]\norigin = [0, 0, 4]\ntarget = [0, 0, 0]\nfov = nan", "camera.fov"),
        ("[camera]\norigin = [0, 0, 4]\ntarget = [0, 0, inf]", "camera.target"),
        ("max_depth = 3", "camera"),
        (SCENE + "radii = 3\n", "shapes[0]"),
        (SCENE.replace("radius = 1", "radius = 0"), "shapes[0].radius"),
        (SCENE.replace("width = 24", "width = 0"), "camera.width"),
        (SCENE.replace("width = 24", "width = 2000000000"), "camera.width"),
        (SCENE.replace("{ reflection = 0.3, diffuse = 0.6 }", '"gold"'), "gold"),
    ],
)
def test_a_wrong_scene_is_one_line_and_no_picture(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], text: str, says: str
):
    (tmp_path / "bad.toml").write_text(text)
    line = fault(capsys, "render", tmp_path / "bad.toml", "-o", tmp_path / "a.png")
    assert "bad.toml" in line and says in line
    assert [file.name for file in tmp_path.iterdir()] == ["bad.toml"]


@pytest.mark.parametrize(
    ("options", "says"),
    [
        (["-o", "{}/a.gif"], ".png"),
        (["-o", "{}/none/a.png"], "no folder"),
        (["-o", "{}/a.png", "--bits", "12"], "--bits"),
        (["-o", "{}/a.jpg", "--bits", "16"], "use 8"),
        (["-o", "{}/a.exr", "--exposure", "1"], "exposure"),
        (["-o", "{}/a.png", "--exposure", "inf"], "exposure"),
        (["-o", "{}/a.png", "--layers", "bands"], ".exr"),
        (["-o", "{}/a.exr", "--layers", "colour"], "colour"),
        (["-o", "{}/a.png", "--stats", "{}/none/a.json"], "no folder"),
        (["-o", "{}/a.png", "--stats", "{}/a.png"], "--stats"),
        (["-o", "{}/a.png", "--width", "0"], "width"),
        (["-o", "{}/a.png", "--height", "-3"], "height"),
        (["-o", "{}/a.png", "--width", "2000000", "--height", "2000000"], "pixels"),
        (["-o", "{}/a.png", "--width", "ten"], "ten"),
        (["-o", "{}/a.png", "--spp", "5"], "spp"),
        (["-o", "{}/a.png", "--max-depth", "-1"], "max_depth"),
        (["-o", "{}/a.png", "--max-depth", "100000"], "depth"),
        (["-o", "{}/a.png", "--threads", "0"], "threads"),
        (["-o", "{}/a.png", "--crop", "20", "0", "10", "3"], "crop"),
        (["-o", "{}/a.png", "--device", "Voodoo 2"], "Voodoo 2"),
        (["-o", "{}/a.png", "--device", "99"], "99"),
        ([], "--output"),
    ],
)
def test_wrong_options_are_one_line_and_no_picture(
    scene: Path, capsys: pytest.CaptureFixture[str], options: list[str], says: str
):
    before = sorted(scene.parent.iterdir())
    assert says in fault(capsys, "render", scene, *(option.format(scene.parent) for option in options))
    assert sorted(scene.parent.iterdir()) == before


def test_missing_files_and_names(tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    out = tmp_path / "a.png"
    missing = fault(capsys, "render", tmp_path / "nothing.toml", "-o", out)
    assert "nothing.toml: there is no such file" in missing
    assert "did you mean 'showcase'" in fault(capsys, "render", "shoowcase", "-o", out)
    assert "clrt scenes" in fault(capsys, "render", "xyzzy", "-o", out)
    assert "rendr" in fault(capsys, "rendr")
    assert "COMMAND" in fault(capsys)
    assert not list(tmp_path.iterdir())


def test_shipped_scenes_have_names(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    assert main(["scenes"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert [line.split()[0] for line in lines[:-1]] == list(shipped_scenes())
    assert Path(lines[-1].removeprefix("in ")).is_dir()
    assert scene_file("showcase") == shipped_scenes()["showcase"]
    monkeypatch.chdir(tmp_path)
    (tmp_path / "showcase").write_text("a file of that name comes first")
    assert scene_file("showcase") == Path("showcase")


def test_a_scene_script_is_run_only_if_it_ships(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
):
    script = shipped_scenes()["tetrahedron"]
    monkeypatch.chdir(script.parent)
    for name in ("tetrahedron", str(script), script.name):
        assert main(["hash", name, "--width", "16"]) == 0
    assert len({line.split()[0] for line in capsys.readouterr().out.splitlines()}) == 1
    trap = f"open({str(tmp_path / 'trapped')!r}, 'w')\n"
    (tmp_path / "tetrahedron.py").write_text(trap + script.read_text())
    assert "suffix '.py'" in fault(capsys, "hash", tmp_path / "tetrahedron.py")
    assert not (tmp_path / "trapped").exists()


def test_devices_are_listed_with_the_default_marked(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
):
    offered = clrt.devices()
    for number in range(len(offered)):
        monkeypatch.setenv("CLRT_DEVICE", str(number))
        assert main(["devices"]) == 0
        lines = capsys.readouterr().out.splitlines()
        assert [line.startswith("*") for line in lines] == [index == number for index in range(len(offered))]
        for line, info in zip(lines, offered, strict=True):
            assert line[2:].split()[0] == str(info.index) and info.name in line and info.version in line
    monkeypatch.setenv("CLRT_DEVICE", "Voodoo 2")
    assert "Voodoo 2" in fault(capsys, "devices")


def test_hash_is_the_one_of_the_picture(scene: Path, capsys: pytest.CaptureFixture[str]):
    image = clrt.render(clrt.load(scene), width=12)
    assert main(["hash", str(scene), "--width", "12"]) == 0
    assert capsys.readouterr().out == f"{image.hash}  {scene}\n"
    image.save(scene.with_name("a.exr"))
    assert main(["hash", str(scene.with_name("a.exr"))]) == 0
    assert capsys.readouterr().out == f"{image.hash}  {scene.with_name('a.exr')}\n"
    for option, *given in (("--width", 5), ("--set", "max_depth=1"), ("--adaptive", 64), ("--device", 0),
                           ("--crop", 0, 0, 1, 1), ("--max-depth", 0), ("--limit", "depth=1")):  # fmt: skip
        said = fault(capsys, "hash", scene.with_name("a.exr"), option, *given)
        assert option in said and "a.exr is a picture already; only a scene is rendered" in said
    said = fault(capsys, "hash", "a.PNG")
    assert said == "clrt: error: a.PNG: of pictures only an .exr has a hash; .png rounds its values\n"


@pytest.mark.parametrize("text", ["1_0", "\u0661", "\uff11", " 1", "0x1", "", "1e", "."])
def test_numbers_of_options_are_plain(text: str, capsys: pytest.CaptureFixture[str]) -> None:
    said = fault(capsys, "render", "ball", "-o", "a.png", f"--exposure={text}")
    assert "argument --exposure: " in said and "is not a number" in said
    assert [options.number(one) for one in ("-1.5", ".5", "+2.", "1e-3", "-inf")] == [
        -1.5, 0.5, 2.0, 0.001, -math.inf]  # fmt: skip


def test_convert_keeps_the_picture(scene: Path, capsys: pytest.CaptureFixture[str]):
    first = clrt.render(clrt.load(scene)).hash
    for name in ("a.json", "b.toml"):
        out = scene.with_name(name)
        assert main(["convert", str(scene), str(out)]) == 0
        assert clrt.render(clrt.load(out)).hash == first
    assert capsys.readouterr() == ("", "")
    assert ".toml" in fault(capsys, "convert", scene, scene.with_name("a.obj"))
    assert not scene.with_name("a.obj").exists()


def test_selftest_reports_each_check_and_fails_with_one(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
):
    selftest = validation_module("selftest")
    for passed, code, last in ((True, 0, "all 2 checks passed"), (False, 1, "1 of 2 checks failed")):
        checks = (("spheres", True, "all"), ("meshes", passed, "here"))
        results = [selftest.Result(*check, 0.1) for check in checks]
        monkeypatch.setattr(selftest, "run_selftest", lambda *_, results=results: iter(results))
        monkeypatch.setattr(selftest, "names", lambda quick, checks=checks: [name for name, *_ in checks])
        assert main(["selftest", "--device", "0"]) == code
        lines = capsys.readouterr().out.splitlines()
        assert lines[0] == f"on {clrt.devices()[0].label}:" and lines[-1] == last
        assert lines[1].startswith("same ") and lines[2].startswith("same " if passed else "DIFFERENT ")
        assert "meshes" in lines[2] and "here" in lines[2]


def test_a_quick_selftest_needs_no_optional_package(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.setitem(sys.modules, "trimesh", None)
    assert main(["selftest", "--quick"]) == 0
    printed = capsys.readouterr()
    last = printed.out.splitlines()[-2]
    assert last.startswith("same ")
    assert "not run, for they need clrt's extra [mesh] (trimesh): cabinet, mesh" in last
    assert "dispersion" not in printed.out and "half a minute" in printed.err


def test_warnings_are_one_line(scene: Path, capsys: pytest.CaptureFixture[str]):
    scene.write_text(SCENE.replace("diffuse = 0.6", "diffuse = 0.9"))
    assert main(["render", str(scene), "-o", str(scene.with_name("a.png")), "--quiet"]) == 0
    out, err = capsys.readouterr()
    assert out == "" and err.startswith("clrt: warning: ball.toml: shapes[0]") and err.count("\n") == 1


def test_values_are_set_at_places(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    scene = {"camera": {"origin": [0, 0, 5], "target": [0, 0, 0], "width": 8, "height": 6}, "ambient": 1,
             "materials": {"a": {"color": 0.3}, "b": {"color": 0.9}},
             "shapes": [{"type": "sphere", "center": [0, 0, 0], "radius": 1, "material": "a"}]}  # fmt: skip
    (tmp_path / "s.json").write_text(json.dumps(scene))
    given = ["--set", "camera.fov=30", "--set", "shapes[0].material=b"]
    given += ["--set", 'materials."b".color=[1, 0.5, 0]']
    assert main(["convert", str(tmp_path / "s.json"), str(tmp_path / "t.toml"), *given]) == 0
    changed = clrt.load(tmp_path / "t.toml")
    assert changed.camera.fov == 30 and changed.shapes[0].material == "b"
    assert changed.materials["b"].color == (1, 0.5, 0)
    assert main(["hash", str(tmp_path / "s.json"), *given]) == 0
    assert capsys.readouterr().out.startswith(clrt.render(changed).hash)


@pytest.mark.parametrize("option", ["limit", "set", "width", "spp", "adaptive", "exposure", "output"])
def test_two_dashes_are_a_value_like_any_other(option: str, capsys: pytest.CaptureFixture[str]) -> None:
    """Until 3.13 argparse takes them out, and leaves an empty list as the option's value."""
    assert main(["render", "bubble", "-o", "a.png", f"--{option}=--"]) == 2
    said = capsys.readouterr().err
    assert "'--'" in said or "--: unknown suffix" in said


@pytest.mark.parametrize("given", [
    ["plot-spectrum", "D65", "-o", ""], ["compare", "room", "room", "--report", ""], ["selftest", "--junit="],
    ["sweep", "room", "--set", "max_depth=1,2", "-o", "{index}.png", "--manifest", ""],
    ["render", "room", "-o", "a.png", "--view="],
], ids=lambda given: given[0])  # fmt: skip
def test_an_empty_name_is_not_one_that_was_left_out(
    given: list[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(given) == 2
    assert "'' is empty; it must not be" in capsys.readouterr().err and not list(tmp_path.iterdir())


def test_what_is_given_twice_is_said(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Of two values for one place the first was lost without a word."""
    for name, given in (("--set", ["camera.fov=30", "camera.fov=40"]), ("--limit", ["depth=3", "depth=4"])):
        assert main(["render", "bubble", "-o", str(tmp_path / "a.png"), name, given[0], name, given[1]]) == 2
        assert f"argument {name}: '{given[0].partition('=')[0]}' is given twice" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ("render bubble -o a.png -o b.exr", "-o/--output: is given twice, 'a.png' and 'b.exr'; it takes one"),
        ("render bubble -o a.png --width 3 --width=4", "--width: is given twice, 3 and 4; it takes one"),
        ("render bubble -o a.png --layers depth --layers normal", "--layers: is given twice, ('depth',) and"),
        ("view bubble --port 0 --port 1", "--port: is given twice, 0 and 1"),
        ("exercise start 1 d --device 0 --device 0", "--device: is given twice, 0 and 0"),
    ],
)
def test_an_option_of_one_value_is_given_once(
    words: str, said: str, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """The last alone counted: of two pictures one was written, and nothing told of the other."""
    monkeypatch.chdir(tmp_path)
    assert main(words.split()) == 2
    told = capsys.readouterr().err
    assert f"argument {said}" in told and told.count("\n") == 1 and not list(tmp_path.iterdir())


def test_what_a_comparison_needs_is_a_second_picture(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["compare", "a.png"]) == 2
    assert "the following arguments are required: B;" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("given", "says"),
    [
        ("camera.fov", "'camera.fov' is not KEY=VALUE, such as camera.fov=30"),
        ("=3", "'=3' is not KEY=VALUE"),
        ("camera.fv=3", "s.json: camera: unknown key 'fv'; did you mean 'fov'?"),
        ("camera.fov=wide", "s.json: camera.fov: 'wide' is not allowed"),
        ("camera.fov=30\nmax_depth = 1", "is not allowed"),
        ("ambient=" + "[" * 5000, "nesting"),
        ("ambient={" + "a." * 20000 + "b=1}", "nesting"),
    ],
)
def test_a_value_that_cannot_be_set_is_one_line(
    given: str, says: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "s.json").write_text('{"camera": {"origin": [0, 0, 5], "target": [0, 0, 0]}, "ambient": 1}')
    assert main(["convert", str(tmp_path / "s.json"), str(tmp_path / "t.toml"), "--set", given]) == 2
    said = capsys.readouterr().err
    assert says in said and said.count("\n") == 1 and not (tmp_path / "t.toml").exists()


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ("sweep s.toml --se x -o a.png", "--se x; `clrt sweep --help`"),
        ("hash a b", "b; `clrt hash --help`"),
        ("exercise list --jsn", "--jsn; `clrt exercise list --help`"),
        ("--verbos hash a", "--verbos; `clrt --help`"),
    ],
)
def test_what_a_command_does_not_have_names_its_own_help(
    words: str, said: str, capsys: pytest.CaptureFixture[str]
) -> None:
    """`clrt --help` shows no option of any command."""
    assert main(words.split()) == 2
    assert capsys.readouterr().err == f"clrt: error: unrecognized arguments: {said} shows what there is\n"


def test_an_interrupt_that_a_library_takes_for_a_fault_ends_as_one(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """numpy made a TypeError of a KeyboardInterrupt within a comparison: a traceback, and another code."""

    def run(_: object) -> int:
        monkeypatch.setattr(interrupts, "_received", signal.SIGINT)
        raise TypeError("Cannot compare structured arrays unless they have a common dtype")

    monkeypatch.setattr("clrt.cli.scenes.run", run)
    assert main(["scenes"]) == 130
    assert capsys.readouterr().err == "clrt: interrupted; nothing was saved\n"


def test_a_black_picture_is_told(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    ball = {"type": "sphere", "center": [0, 0, 0], "radius": 1}
    for place, black in ([0, 0, 0], True), ([0, 0, 5], False):
        light = {"type": "point", "position": place}
        table = {"camera": {"origin": [0, 0, 5], "target": [0, 0, 0]}, "lights": [light], "shapes": [ball]}
        (tmp_path / "a.json").write_text(json.dumps(table))
        assert main(["render", str(tmp_path / "a.json"), "-o", str(tmp_path / "a.png"), "--width", "8"]) == 0
        assert ("the picture is black: no light comes to what it shows" in capsys.readouterr().err) == black
