"""`clrt sweep` and `clrt turntable`: files, manifest and video; what is there is not rendered again."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import clrt
from clrt.cli import main
from clrt.engine.tracer import Tracer
from clrt.formats.native import value_list
from clrt.images.file import encode
from clrt.images.naming import frame_name
from tests.series_samples import TOML, rows, run, times


def test_files_and_manifest(scene: Path) -> None:
    assert run("--set", "camera.fov=20:40:3", "--set", "shapes[0].material=red,=1+1") == 0
    found = rows()
    assert [row["file"] for row in found] == [
        "00_20.png", "01_20.png", "02_30.png", "03_30.png", "04_40.png", "05_40.png"
    ]  # fmt: skip
    assert [row["shapes[0].material"] for row in found[:2]] == ["red", "'=1+1"], "no formulas"
    base = clrt.load("s.toml")
    for row, fov in zip(found, (20, 20, 30, 30, 40, 40), strict=True):
        material = row["shapes[0].material"].strip("'")
        right = clrt.render(base.replace({"camera.fov": fov, "shapes[0].material": material}))
        assert row["picture"] == right.hash and int(row["rays"]) == right.stats["traced"]
        right.save("right.png")
        assert Path(row["file"]).read_bytes() == Path("right.png").read_bytes()


def test_what_is_there_is_not_rendered_again(scene: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    rendered: list[float] = []
    render = Tracer.render

    def counted(self: Tracer, *arguments: Any, **named: Any) -> clrt.Image:
        rendered.append(self.scene.camera.fov)  # type: ignore[union-attr]
        return render(self, *arguments, **named)

    monkeypatch.setattr(Tracer, "render", counted)
    sets = ("--set", "camera.fov=20:40:3")
    assert run(*sets) == 0 and rendered == [20, 30, 40]
    first = rows()
    assert run(*sets) == 0 and len(rendered) == 3, "nothing is"
    assert [row["picture"] for row in rows()] == [row["picture"] for row in first]
    Path("01_30.png").write_bytes(b"damaged")
    Path("02_40.png").unlink()
    assert run(*sets) == 0 and rendered[3:] == [30, 40]
    scene.write_text(TOML.replace("0.3", "0.4"))
    assert run(*sets) == 0 and rendered[5:] == [20, 30, 40], "of another scene all are"
    Path("frames.csv").write_text("index,file\n0,\x00")
    assert run(*sets) == 0 and len(rendered) == 11, "without a manifest nobody knows"


def test_a_series_that_was_broken_off_goes_on(scene: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    render, done = Tracer.render, []

    def failing(self: Tracer, *arguments: Any, **named: Any) -> clrt.Image:
        if len(done) == 2:
            raise KeyboardInterrupt
        done.append(1)
        return render(self, *arguments, **named)

    monkeypatch.setattr(Tracer, "render", failing)
    assert run("--set", "camera.fov=20:40:3") == 130
    assert [row["file"] for row in rows()] == ["00_20.png", "01_30.png"]
    monkeypatch.setattr(Tracer, "render", render)
    before, told = times(), rows()
    assert run("--set", "camera.fov=20:40:3") == 0
    assert len(before) == 2 and before.items() <= times().items() and rows()[:2] == told
    assert all(int(row["rays"]) > 0 for row in rows())


def test_nearly_equal_exposures_are_not_the_same(scene: Path) -> None:
    given = ("--set", "camera.fov=20", "--exposure")
    assert run(*given, "1.0000001") == 0
    before = times()
    assert run(*given, "1.0000002") == 0 and times() != before
    assert run(*given, "1") == 0 and rows()[0]["identity"].endswith(" 1"), "as it always was"


KEYS = """
[[keyframes]]
time = 0
[[keyframes]]
time = 0.12
origin = [3, 1, 4]
fov = 30
"""


def test_a_path_of_keyframes(scene: Path) -> None:
    """Its pictures are those of `camera_path`; what is there is not rendered again."""
    Path("path.toml").write_text(KEYS)
    given = ("--keyframes", "path.toml", "--set", "ambient=0,0.2", "--set", "camera.aperture=0.01")
    assert run(*given) == 0
    base = clrt.load("s.toml").replace({"camera.aperture": 0.01})
    assert base.camera is not None
    end = base.replace({"camera.origin": [3, 1, 4], "camera.fov": 30}).camera
    assert end is not None
    path = clrt.camera_path([base.camera, end], 4, times=[0, 0.12])  # 25 a second, and the first
    found = rows()
    assert [row["ambient"] for row in found] == ["0"] * 4 + ["0.2"] * 4
    for row, camera in zip(found, path * 2, strict=True):
        right = base.replace({"ambient": float(row["ambient"]), "camera": camera})
        assert row["picture"] == clrt.render(right).hash and row["camera.fov"] == str(camera.fov)
        assert row["camera.origin"] == str(camera.origin) and "camera.aperture" not in row
    before = times()
    assert run(*given) == 0 and times() == before
    assert run(*given[:2], "-o", "n{index}.png", "--frames", "2", "--manifest", "n.csv") == 0
    assert [row["camera.origin"] for row in rows("n.csv")] == ["(0.0, 1.0, 5.0)", "(3.0, 1.0, 4.0)"]


def test_what_is_the_same_in_all_keyframes_is_no_value_of_the_pictures(scene: Path) -> None:
    """It came out as 29.999999999999996 for some, and so had a column of the manifest."""
    Path("path.toml").write_text("keyframes = [{fov = 30}, {origin = [3, 1, 4], fov = 30}]")
    assert run("-o", "n{index}.png", "--keyframes", "path.toml", "--frames", "7") == 0
    assert len(rows()) == 7 and "camera.fov" not in rows()[0]


WRONG_PATHS = {
    "path.toml:7: keyframes[1].fov: 300 is not": (KEYS.replace("30\n", "300\n"), ()),
    "path.toml: keyframes[0] and keyframes[1]: between them the path leads through its target": (
        "keyframes = [{origin = [0, 0, 1]}, {origin = [0, 0, -1]}]", ("--frames", "3")),
    "path.toml: 1 pictures of a path are not allowed; from 2 to 100000 are": (KEYS, ("--frames", "1")),
    "path.toml: 50001 pictures of a path are not allowed; from 2 to 50000 are": (
        KEYS, ("--frames", "50001", "--set", "ambient=0,1")),
    "--set camera.fov: 2 values are too many; what changes along": (KEYS, ("--set", "camera.fov=20,30")),
    "--fps: 0.0 is not allowed": (KEYS, ("--fps", "0")),
    "path.toml: is the keyframes; give --manifest": (KEYS, ("--manifest", "path.toml", "--frames", "2")),
}  # fmt: skip


@pytest.mark.parametrize("says", WRONG_PATHS)
def test_wrong_paths_are_one_line(says: str, scene: Path, capsys: pytest.CaptureFixture[str]) -> None:
    Path("path.toml").write_text(WRONG_PATHS[says][0])
    assert run("-o", "{index}.png", "--keyframes", "path.toml", *WRONG_PATHS[says][1]) == 2
    said = capsys.readouterr().err
    assert says in said and said.count("\n") == 1, said
    assert sorted(path.name for path in Path().iterdir()) == ["path.toml", "s.toml"]


def test_a_lossless_video_holds_the_frames(scene: Path) -> None:
    av = pytest.importorskip("av", reason="needs the optional dependency clrt[video]")
    given = ["--frames", "5", "-o", "spin.mkv", "--manifest", "m.csv", "--quiet"]
    assert main(["turntable", "s.toml", *given]) == 0
    with av.open("spin.mkv") as container:
        frames = [frame.to_ndarray(format="rgb24") for frame in container.decode(video=0)]
        assert float(container.streams.video[0].average_rate) == 25
    base = clrt.load("s.toml")
    assert base.camera is not None
    for frame, camera, row in zip(frames, clrt.turntable(base.camera, 5), rows("m.csv"), strict=True):
        image = clrt.render(base, camera=camera)
        assert np.array_equal(frame, encode(image.pixels)) and row["picture"] == image.hash
    for rate, exact in (("0.001", 0.001), ("0.0015", 1 / 667), ("29.97", 29.97)):
        assert main(["turntable", "s.toml", "--frames", "2", "-o", "a.mkv", "--fps", rate, "--quiet"]) == 0
        with av.open("a.mkv") as container:
            assert float(container.streams.video[0].average_rate) == exact
    for name in ("a.mp4", "a.webm"):
        assert main(["turntable", "s.toml", "--frames", "2", "-o", name, "--fps", "10", "--quiet"]) == 0
        with av.open(name) as container:
            assert sum(1 for _ in container.decode(video=0)) == 2


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (["--set", "camera.fv=1,2"], "did you mean 'fov'?"),
        (["--set", "camera.fov=20:300:3"], "camera.fov: 300"),
        (["--set", "camera.fov=20:30:0"], "'20:30:0' asks for no value"),
        (["--set", "camera.fov=20:30:1000000"], "too many values; FIRST:LAST:COUNT, COUNT from 1 to 999999"),
        (["--set", "camera.fov=20:30:999999", "--set", "max_depth=1:2:999999"], "pictures are too many"),
        (["--set", "camera.fov=20,30", "-o", "x.png"], "several pictures would be x.png; put {index}"),
        (["--set", "camera.fov=20,30", "-o", "{camera.fv}.png"], "did you mean 'camera.fov'?"),
        (["--set", "camera.fov=20,30", "-o", "{index.png"], "a brace that is not closed"),
        (["--set", "camera.fov=20,30", "-o", "{index:x}.png"], "'x' is no format of a number"),
        (["--set", "camera.fov=20,30", "-o", "x.gif"], "unknown suffix '.gif' of a picture"),
        (["--set", "camera.fov=20,30", "-o", "{index}.gif"], "unknown suffix '.gif' of a picture"),
        (["--set", "camera.width=15", "-o", "a.mp4"], "a.mp4: .mp4 needs an even width and height"),
        (["--width", "1", "--height", "13", "-o", "a.mp4"], "an even width and height, not 1 x 13\n"),
        (["--width", "1", "--height", "13", "-o", "a.mkv"], "another width and height, not 1 x 13\n"),
        (["--width", "20000", "--height", "2", "-o", "a.mp4"], "another width and height, not 20000 x 2; or"),
        (["--set", "camera.width=14,16", "-o", "a.mkv"], "a video's frames have one size"),
        (["-o", "a.mkv", "--fps", "0"], "--fps: 0.0 is not allowed"),
        (["-o", "a.mkv", "--fps", "1e-5"], "--fps: 1e-05 is not allowed; it must be from 0.001 to 1000"),
        (["--set", "camera.width=15,16", "--width", "9"], "--width: it would hold for all pictures"),
        (["--set", "camera.spp=1,4", "--spp", "4"], "--spp: it would hold for all pictures"),
        (["--set", "max_depth=0,1", "--max-depth", "2"], "--max-depth: it would hold for all"),
        (["--set", "camera.height=8,9", "--height", "9"], "give one of the two"),
        (["--set", 'camera."width"=15,16', "--width", "9"], "--width: it would hold for all pictures"),
        (["--set", "camera.fov=20,30", "--set", 'camera."fov"=25'], "it stands in the place of"),
        (["--frames", "3"], "--frames: is of --keyframes; --set has a count of its own"),
        (["--keyframes", "no.toml"], "no.toml: "),
        (["--set", "camera.fov=20", "-o", "s.toml"], "s.toml: is the scene"),
        (["--set", "camera.fov=20", "-o", "{index}.png", "--manifest", "s.toml"], "s.toml: is the scene;"),
    ],
)
def test_faults_are_one_line_and_leave_nothing(
    arguments: list[str], says: str, scene: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(*arguments) == 2
    said = capsys.readouterr().err
    assert says in said and said.count("\n") == 1, said
    assert [path.name for path in Path().iterdir()] == ["s.toml"] and scene.read_text() == TOML


def test_values_in_names_lead_nowhere_else() -> None:
    values = {"a": "../../etc/passwd", "b": [1.5, -2], "c": "x" * 500, "d": {"k": 1}, "e": "", "f": "\0\n"}
    values["g"] = 0.1
    names = {key: frame_name(f"out/{{{key}}}.png", 0, values) for key in values}
    assert all(name.count("/") == 1 and ".." not in name and len(name) < 80 for name in names.values()), names
    for pattern in ("out/{a}{b}/x.png", ".{a}/x.png", "{a}./x.png", "{a}{a}/x.png", "x/{a}{b}", "x\\.{a}\\y"):
        name = frame_name(pattern, 0, {"a": ".", "b": "."})
        assert not {"..", "."} & {*re.split(r"[/\\]", name)}, name
    assert frame_name("../{a}/./x.png", 0, {"a": 1}) == "../1/./x.png"
    assert names["b"] == "out/1.5_-2.png" and names["g"] == "out/0.1.png"
    assert frame_name("{{{index:03}}}_{g:.3f}", 7, values) == "{007}_0.100"


@pytest.mark.parametrize(
    ("text", "values"),
    [
        ("20:60:5", [20, 30, 40, 50, 60]), ("1:2:1", [1]), ("3:1:3", [3, 2, 1]), ("-1:1e0:3", [-1, 0, 1]),
        ("1.3,1.5", [1.3, 1.5]), ("5", [5]), ("[0, 0, 0], [0, 1, 0]", [[0, 0, 0], [0, 1, 0]]),
        ("gold,glass", ["gold", "glass"]), ("true,false", [True, False]), ('"a,b",c', ['"a', 'b"', "c"]),
        ("\u0661:\u0662:\u0663", ["\u0661:\u0662:\u0663"]),
        ('"a,b"', ["a,b"]), ("", [""]), ("{color = 1}, {color = 0}", [{"color": 1}, {"color": 0}]),
    ],
)  # fmt: skip
def test_lists_of_values(text: str, values: list[Any]) -> None:
    assert value_list(text, clrt.Limits(), "x") == values


def test_a_range_of_whole_numbers_is_of_whole_numbers() -> None:
    assert all(type(value) is int for value in value_list("-2:+6:5", clrt.Limits(), "x"))
    assert all(type(value) is float for value in value_list("0:1:3", clrt.Limits(), "x"))
    scene = clrt.load_dict({"max_depth": 1}).replace({"max_depth": value_list("0:3:2", clrt.Limits(), "")[1]})
    assert scene.max_depth == 3


@pytest.mark.parametrize("text", ["1:2:-1", "30:inf:3", "1:2:1.5", "1::3", "20:30", "7:3,4"])
def test_what_is_no_range_is_said(text: str) -> None:
    with pytest.raises(clrt.ClrtError, match="is no range; FIRST:LAST:COUNT are two numbers"):
        value_list(text, clrt.Limits(), "--set camera.fov")


REFUSED: dict[str, tuple[str, ...]] = {
    "--set camera.spp, picture 1: samples: 16 384 is above": ("--set", "camera.spp=1,16384"),
    "--set adaptive, picture 1: s.toml: adaptive.spp: 16 is not allowed": (
        "--set", "adaptive={spp = 36},{spp = 16}", "--spp", "9"),
    "--set camera.width, picture 2: crop: 8 0 4 4 is not a part of the picture of 8 x 12 pixels": (
        "--set", "camera.width=16,12,8", "--crop", "8", "0", "4", "4"),
}  # fmt: skip


@pytest.mark.parametrize("says", REFUSED)
@pytest.mark.parametrize("more", [(), ("--cluster", "local:1")], ids=["here", "cluster"])
def test_no_picture_is_made_of_a_series_one_of_which_is_refused(
    says: str, more: tuple[str, ...], scene: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["sweep", "s.toml", "-o", "{index}.png", "--quiet", *REFUSED[says], *more]) == 2
    assert says in capsys.readouterr().err
    assert not [*Path().glob("*.png")] and not Path("frames.csv").exists()


def test_a_video_of_two_sizes_is_refused_before_it_is_begun(
    scene: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(Tracer, "render", lambda *_, **__: pytest.fail("rendered"))
    assert main(["sweep", "s.toml", "--set", "camera.width=16,16,8", "-o", "a.mkv", "--quiet"]) == 2
    assert not Path("a.mkv").exists()


def test_a_picture_of_a_path_that_is_refused_has_its_number(
    scene: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    Path("path.toml").write_text("keyframes = [{}, {origin = [0, 1, 9]}]")
    command = ["sweep", "s.toml", "--keyframes", "path.toml", "--frames", "3", "--set", "max_depth=1,65"]
    assert main([*command, "-o", "{index}.png", "--quiet"]) == 2
    assert "--set max_depth, picture 3: depth: 65 is above the limit of 64" in capsys.readouterr().err
    assert not [*Path().glob("*.png")]
