"""What users of command lines expect: pipes, several scenes, examples, quiet and loud, JSON, `check`."""

from __future__ import annotations

import io
import json
import logging
import os
import shlex
import subprocess
from pathlib import Path

import pytest

import clrt
from clrt.cli import main, terminal
from clrt.cli.examples import EXAMPLES
from clrt.cli.options import parser
from tests.cli.test_terminal import CLRT, SCENE, fault

ROOM = SCENE.replace("0.9", "0.5")


@pytest.fixture
def scene(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> str:
    monkeypatch.chdir(tmp_path)
    Path("ball.toml").write_text(ROOM)
    return "ball.toml"


def typed(monkeypatch: pytest.MonkeyPatch, data: bytes) -> None:
    """Let standard input hold this."""
    monkeypatch.setattr("sys.stdin", io.TextIOWrapper(io.BytesIO(data)))


# --- pipes


@pytest.mark.parametrize("form", ["toml", "json", "byte order mark"])
def test_a_scene_comes_from_standard_input(
    scene: str, form: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    data = ROOM.encode()
    if form == "json":
        data = b"\n " + json.dumps(clrt.load(scene).to_dict()).encode()
    elif form == "byte order mark":
        data = b"\xef\xbb\xbf" + data
    typed(monkeypatch, data)
    assert main(["hash", "-"]) == 0
    assert capsys.readouterr().out == f"{clrt.render(scene).hash}  -\n"
    clrt.render(scene).save("ball.exr")
    typed(monkeypatch, data)
    assert main(["compare", "ball.exr", "-"]) == 0


@pytest.mark.parametrize(
    ("data", "said"),
    [
        (b"", "standard input: camera: missing"),
        (b"ambient = \n", "standard input: wrong syntax"),
        (b"ambient = -1\n", "standard input:1: ambient: -1.0 is not allowed"),
        (b'{"ambient": 1,}', "standard input: wrong syntax"),
        (b"\xff", "standard input: line 1 is not UTF-8 text"),
    ],
)
def test_faults_of_standard_input_have_its_name(
    scene: str, data: bytes, said: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    typed(monkeypatch, data)
    assert said in fault(capsys, "hash", "-")


def test_standard_input_has_limits_and_may_be_closed(
    scene: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    typed(monkeypatch, ROOM.encode())
    assert "text_bytes" in fault(capsys, "render", "-", "-o", "a.png", "--limit", "text_bytes=10")
    monkeypatch.setattr("sys.stdin", None)
    assert "standard input is closed" in fault(capsys, "hash", "-")
    assert "standard input can be read once" in fault(capsys, "check", "-", "-")


def test_files_of_a_scene_from_a_pipe_lie_in_the_current_folder(
    scene: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    clrt.render(scene, width=8).save("sky.exr")
    typed(monkeypatch, b'background = "sky.exr"\n' + ROOM.encode())
    assert main(["render", "-", "-o", "a.png", "--quiet"]) == 0
    typed(monkeypatch, b'background = "sky.exr"\n' + ROOM.encode())
    assert "sky.exr, which is read; give" in fault(capsys, "render", "-", "-o", "sky.exr")


def test_a_picture_goes_to_standard_output(scene: str, tmp_path: Path) -> None:
    done = subprocess.run([*CLRT, "render", scene, "-o", "-"], capture_output=True, check=True, cwd=tmp_path)
    Path("a.png").write_bytes(done.stdout)
    assert main(["render", scene, "-o", "b.png", "--quiet"]) == 0
    assert clrt.read_image("a.png").tobytes() == clrt.read_image("b.png").tobytes() and done.stderr == b""
    assert sorted(os.listdir()) == ["a.png", "b.png", "ball.toml"]


@pytest.mark.parametrize("command", ["render {scene} -o -", "convert {scene} -"])
def test_a_full_standard_output_is_said(scene: str, command: str, tmp_path: Path) -> None:
    with open("/dev/full", "wb") as full:
        words = [*CLRT, *command.format(scene=scene).split()]
        done = subprocess.run(words, stdout=full, stderr=subprocess.PIPE, cwd=tmp_path, check=False)
    assert done.returncode == 2 and done.stderr.count(b"\n") == 1 and b"standard output" in done.stderr


@pytest.mark.parametrize("more", [["-o", "a.html"], []])
def test_what_is_saved_counts_as_done(scene: str, more: list[str], tmp_path: Path) -> None:
    with open("/dev/full", "wb") as full:
        words = [*CLRT, "explain", scene, "1", "1", *more]
        done = subprocess.run(words, stdout=full, stderr=subprocess.PIPE, cwd=tmp_path, check=False)
    assert done.returncode == (0 if more else 2)
    assert (tmp_path / "a.html").exists() == bool(more)


def test_a_closed_standard_output_is_said(scene: str, tmp_path: Path) -> None:
    done = subprocess.run(f"{shlex.join([*CLRT, 'render', scene, '-o', '-'])} >&-", shell=True,
                          stderr=subprocess.PIPE, cwd=tmp_path, check=False)  # fmt: skip
    assert done.returncode == 2 and done.stderr.count(b"\n") == 1


def test_who_left_is_no_fault(scene: str, tmp_path: Path) -> None:
    words = shlex.join([*CLRT, "render", scene, "-o", "-", "--width", "600"])
    line = f"set -o pipefail; {words} | head -c 10"
    done = subprocess.run(["bash", "-c", line], capture_output=True, cwd=tmp_path, check=False)
    assert (done.returncode, done.stderr) == (0, b"")


def test_a_scene_goes_to_standard_output(
    scene: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["convert", scene, "-", "--set", "ambient=0.25"]) == 0
    typed(monkeypatch, capsys.readouterr().out.encode())
    assert main(["convert", "-", "again.toml"]) == 0
    assert clrt.load("again.toml") == clrt.load(scene).replace({"ambient": 0.25})


@pytest.mark.parametrize(("sink", "code"), [("> /dev/full", 2), ("| true", 0), ("> out.png", 0)])
def test_a_checkpoint_stays_until_the_picture_is_delivered(sink: str, code: int, scene: str) -> None:
    assert main(["render", scene, "-o", "a.exr", "--quiet"]) == 0  # so that the kernels are there
    words = shlex.join([*CLRT, "render", scene, "-o", "-", "--checkpoint", "c.ck"])
    line = f"set -o pipefail; {words} {sink}"
    done = subprocess.run(["bash", "-c", line], stderr=subprocess.PIPE, check=False)
    assert done.returncode == code
    assert Path("c.ck").exists() == (sink != "> out.png")


def test_layers_need_files(scene: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert "--layers needs files" in fault(capsys, "render", scene, "-o", "-", "--layers", "depth")


def test_a_terminal_is_no_place_for_a_picture(monkeypatch: pytest.MonkeyPatch) -> None:
    with terminal.surviving() as (out, _):
        out.inner = type("Inner", (), {"buffer": io.BytesIO(), "isatty": lambda self: True,
                                       "flush": lambda self: None, "encoding": "utf-8"})()  # fmt: skip
        with pytest.raises(clrt.ClrtError, match="a terminal cannot show a picture"):
            terminal.write_bytes(b"x")


# --- several scenes


def test_several_scenes_are_rendered(scene: str, capsys: pytest.CaptureFixture[str]) -> None:
    Path("other.toml").write_text(ROOM.replace("radius = 1", "radius = 0.5"))
    assert main(["render", scene, "other.toml", "-o", "{index}_{name}.exr"]) == 0
    for name in (scene, "other.toml"):
        number = 0 if name == scene else 1
        saved = clrt.read_image(f"{number}_{Path(name).stem}.exr")
        assert saved.tobytes() == clrt.render(name).pixels.tobytes()
    assert capsys.readouterr().out.count("Mrays/s") == 2


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["-o", "a.png"], "a.png: several pictures would be a.png; put {name} or {index} into the name"),
        (["-o", "{nam}.png"], "nam"),
        (["-o", "{name}.png", "--stats", "a.json"], "--stats: is for one scene"),
        (["-o", "{name}.toml"], ".toml"),
        (["-o", "none/{name}.png"], "there is no folder"),
    ],
)
def test_faults_of_several_scenes(
    scene: str, words: list[str], said: str, capsys: pytest.CaptureFixture[str]
) -> None:
    Path("other.toml").write_text(ROOM)
    assert said in fault(capsys, "render", scene, "other.toml", *words)
    assert sorted(os.listdir()) == ["ball.toml", "other.toml"]


def test_scenes_of_one_name_are_told_what_keeps_them_apart(
    scene: str, capsys: pytest.CaptureFixture[str]
) -> None:
    said = fault(capsys, "render", scene, scene, "-o", "{name}.png")
    assert "several pictures would be ball.png; put {index} into the name" in said


def test_one_scene_is_named_as_several_are(scene: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["render", scene, "-q", "-o", "{name}_{index:02}.exr", "--stats", "a.json"]) == 0
    assert sorted(os.listdir()) == ["a.json", "ball.toml", "ball_00.exr"]
    said = fault(capsys, "render", scene, "-o", "{name}.png", "--stats", "ball.png")
    assert "ball.png: is the file of --output; give --stats a file of its own" in said
    assert main(["render", scene, "-q", "-o", "{other}.exr"]) == 0 and Path("{other}.exr").exists()


# --- check


def test_scenes_are_checked(scene: str, capsys: pytest.CaptureFixture[str]) -> None:
    Path("wrong.toml").write_text("ambient = -1\n")
    Path("odd.toml").write_text(SCENE)
    assert main(["check", scene]) == 0
    said = capsys.readouterr()
    assert said.out.startswith("ball.toml: right; 1 shape, 1 primitive, 0 lights, 0 materials; 8 x 8 pixels")
    assert main(["check", scene, "wrong.toml", "odd.toml", "nowhere.toml"]) == 1
    said = capsys.readouterr()
    assert said.out.count("right;") == 2
    assert "error: wrong.toml:1: ambient: -1.0 is not allowed" in said.err
    assert "error: nowhere.toml: there is no such file" in said.err and "warning: odd.toml" in said.err
    assert main(["check", "-q", scene]) == 0 and capsys.readouterr().out == ""
    assert main(["check", "--json", scene, "wrong.toml"]) == 1
    right, wrong = json.loads(capsys.readouterr().out)
    assert (right["error"], right["shapes"], right["camera"]) == (None, 1, [8, 8, None])
    assert wrong["error"].startswith("wrong.toml:1: ambient") and "shapes" not in wrong
    assert main(["check", scene, "--set", "camera.width=0"]) == 1
    assert "camera.width: 0 is not allowed" in capsys.readouterr().err


def test_check_finds_what_flattening_would(scene: str, capsys: pytest.CaptureFixture[str]) -> None:
    Path("flat.toml").write_text(
        '[[shapes]]\ntype = "disk"\ncenter = [0, 0, 0]\nnormal = [0, 0, 1]\nradius = 1\n'
        "transform = [{scale = [1, 2, 1]}]\n"
    )
    assert main(["check", "flat.toml", "--limit", "lights=0"]) == 1
    assert "would make a disk (or cap) an ellipse" in capsys.readouterr().err
    assert main(["check", scene, "--set", "camera.spp=4"]) == 0


@pytest.mark.parametrize(
    ("change", "limit", "says"),
    [
        ("max_depth=65", "", "depth: 65 is above the limit of 64"),
        ("max_depth=3", "depth=2", "depth: 3 is above the limit of 2"),
        ("camera.width=9", "pixels=71", "pixels: 72 is above the limit of 71"),
        ("camera.spp=16", "samples=15", "samples: 16 is above the limit of 15"),
        ("max_depth=0", "work=63", "work: 64 is above the limit of 63"),
        ("camera.width=1", "host_bytes=127", "host_bytes: 128 is above the limit of 127"),
    ],
)
def test_check_refuses_what_render_refuses(
    scene: str, capsys: pytest.CaptureFixture[str], change: str, limit: str, says: str
) -> None:
    said = ["--set", change, *(["--limit", limit] if limit else [])]
    assert main(["check", scene, *said]) == 1
    checked = capsys.readouterr().err
    assert main(["render", scene, "-o", "x.exr", *said]) == 2
    assert f"error: ball.toml: {says}" in checked and says in capsys.readouterr().err
    name, _, most = (limit or "depth=64").partition("=")
    assert main(["check", scene, "--set", change, "--limit", f"{name}={int(most) + 1}"]) == 0


def test_check_looks_where_the_camera_is(scene: str, capsys: pytest.CaptureFixture[str]) -> None:
    """Within nine balls of glass; a lens or a near plane starts rays elsewhere, which only a render finds."""
    glass = {f"glass{k}": {"diffuse": 0, "transmission": 0.9, "ior": 1.1 + k / 100} for k in range(9)}
    ball = {"type": "sphere", "center": [0, 0, 0]}
    balls = [{**ball, "radius": k + 1, "material": f"glass{k}"} for k in range(9)]
    nested = {"camera": {"origin": [0, 0, 0.05], "target": [0, 0, -1]}, "materials": glass, "shapes": balls}
    Path("nested.json").write_text(json.dumps(nested))
    says = "nested.json: shapes: rays enter more than 8 media that lie in one another"
    assert main(["check", "nested.json"]) == 1 and says in capsys.readouterr().err
    assert main(["render", "nested.json", "-o", "x.png", "--width", "8"]) == 2
    assert says in capsys.readouterr().err
    assert main(["check", "nested.json", "--set", "camera.origin=[0, 0, 1.5]"]) == 0
    assert main(["check", "nested.json", "--set", "camera.near=0.5"]) == 0


# --- words


def test_every_command_has_examples_that_it_takes(capsys: pytest.CaptureFixture[str]) -> None:
    made = parser()
    assert set(EXAMPLES) == set(made.commands)
    for command, shown in EXAMPLES.items():
        for line, what in shown:
            part = next(words for words in line.split(" | ") if words.startswith(f"clrt {command}"))
            words = shlex.split(part.split(" < ")[0].split(" > ")[0])[1:]
            assert made.parse_args(words).command == command and what
        with pytest.raises(SystemExit):
            made.parse_args([command, "--help"])
        said = capsys.readouterr().out
        assert "examples:" in said and shown[0][0] in said
    with pytest.raises(SystemExit):
        made.parse_args(["--help"])
    first = capsys.readouterr().out.partition("examples:")[2]
    assert all(EXAMPLES[command][0][0] in first for command in ("scenes", "render", "check"))


def test_clrt_says_what_it_does_when_asked(scene: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["hash", scene]) == 0
    assert capsys.readouterr().err == ""
    assert main(["hash", scene, "-v"]) == 0
    said = capsys.readouterr().err.splitlines()
    assert any(line.startswith("clrt: device: ") for line in said)
    assert any("tree of" in line for line in said)
    assert not [handler for handler in logging.getLogger("clrt").handlers if "Lines" in str(handler)]
    assert main(["hash", scene]) == 0
    assert capsys.readouterr().err == ""


def test_programs_hear_it_through_logging(scene: str, caplog: pytest.LogCaptureFixture) -> None:
    with caplog.at_level(logging.INFO, logger="clrt"):
        clrt.render(scene)
    assert any(record.name == "clrt" and "device" in record.getMessage() for record in caplog.records)


def test_a_hash_is_json_where_asked(scene: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["hash", scene, "--json"]) == 0
    assert json.loads(capsys.readouterr().out) == {"hash": clrt.render(scene).hash, "scene": scene}


def test_a_name_of_two_lines_is_told_in_one(scene: str, capsys: pytest.CaptureFixture[str]) -> None:
    """Who reads the hashes of many scenes would take the second for another's."""
    odd = "a\n0123  b\r.toml"
    Path(odd).write_text(Path(scene).read_text())
    for command in ("hash", "check"):
        assert main([command, odd]) == 0
        assert r"a\n0123  b\r.toml" in capsys.readouterr().out.splitlines()[0]


def test_short_options_are_the_long_ones(scene: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["render", scene, "-q", "-o", "a.png"]) == 0
    assert capsys.readouterr().out == "" and Path("a.png").exists()


def test_a_conversion_is_quiet_where_asked(scene: str, capsys: pytest.CaptureFixture[str]) -> None:
    """What Mitsuba lacks stands in the file itself, too."""
    Path(scene).write_text(ROOM.replace("material = {", "material = { highlight_color = [1, 0, 0],"))
    for words, lines in (([], 1), (["-q"], 0)):
        assert main(["convert", *words, scene, "a.xml"]) == 0
        assert len(capsys.readouterr().err.splitlines()) == lines


def test_a_terminal_of_one_column_gets_lines_all_the_same(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("COLUMNS", "1")
    assert terminal.console().width == 20 and terminal.console(width=200).width == 200


def test_selftest_and_validation_answer_programs(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["selftest", "--only", "arithmetic", "--json"]) == 0
    said = capsys.readouterr()
    found = json.loads(said.out)
    assert found["passed"] and [check["name"] for check in found["checks"]] == ["arithmetic"]
    assert "same" in said.err and found["device"] in said.err
    assert main(["validate", "--list", "--json"]) == 0
    rows = json.loads(capsys.readouterr().out)
    assert len(rows) > 50 and all(row["case"] and row["shows"] for row in rows)
