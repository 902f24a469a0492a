"""What the terminal is told, and whatever becomes of it: the work is done, the exit code is right."""

from __future__ import annotations

import os
import subprocess
import sys
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

import clrt
from clrt.base.errors import LINE, ClrtError, one_line, printable
from clrt.base.notices import MOST
from clrt.base.resources import shipped_scenes
from clrt.cli import main, terminal

# it warns: above 1 a surface makes light
SCENE = """
ambient = 1.0
[camera]
origin = [0, 0, 4]
target = [0, 0, 0]
width = 8
height = 8
[[shapes]]
type = "sphere"
center = [0, 0, 0]
radius = 1
material = { reflection = 0.3, diffuse = 0.9 }
"""
CLRT = [sys.executable, "-m", "clrt"]


@pytest.fixture
def scene(tmp_path: Path) -> Path:
    path = tmp_path / "ball.toml"
    path.write_text(SCENE)
    return path


def fault(capsys: pytest.CaptureFixture[str], *arguments: object) -> str:
    """Run a command that must fail: exit code 2, one line on stderr, nothing on stdout. Returns the line."""
    code = main([str(argument) for argument in arguments])
    out, err = capsys.readouterr()
    assert (code, out, err.count("\n")) == (2, "", 1), (code, out, err)
    assert err.startswith("clrt: error: ") and len(err) <= LINE + 1 and err[:-1].isprintable(), err
    return err


def _broken_pipe() -> int:
    reading, writing = os.pipe()
    os.close(reading)
    return writing


def _full() -> int:
    return os.open("/dev/full", os.O_WRONLY)


def _run(command: list[Any], redirected: dict[int, Callable[[], int] | None], **how: Any) -> Any:
    """The command with some standard streams leading elsewhere; None: they are closed."""
    streams: dict[str, Any] = {}
    words = ""
    for number, opened in redirected.items():
        if opened is None:
            words += f" {number}>&-"
        else:
            streams["stdout" if number == 1 else "stderr"] = opened()
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE}
    try:
        shell = ["/bin/sh", "-c", f'exec "$@"{words}', "sh", *command]
        return subprocess.run(shell, **{**pipes, **streams}, timeout=120, **how)
    finally:
        for stream in streams.values():
            os.close(stream)


@pytest.mark.parametrize(
    "redirected",
    [{2: _broken_pipe}, {2: None}, {2: _full}, {1: _full}, {1: None, 2: None}],
    ids=["stderr without a reader", "stderr closed", "stderr full", "stdout full", "both closed"],
)
def test_a_picture_is_saved_whatever_becomes_of_the_terminal(scene: Path, redirected: dict[int, Any]) -> None:
    out = scene.with_name("a.png")
    done = _run([*CLRT, "render", scene, "-o", out], redirected)
    assert done.returncode == 0
    assert clrt.read_image(out).shape == (8, 8, 3)
    assert sorted(file.name for file in scene.parent.iterdir()) == ["a.png", "ball.toml"]
    if redirected == {1: _full}:
        assert done.stderr.startswith(b"clrt: warning: ball.toml: shapes[0]: ")
        assert done.stderr.count(b"\n") == 1


@pytest.mark.parametrize("arguments", [["scenes"], ["scenes", "--json"], ["--help"], ["hash", "--help"]])
@pytest.mark.parametrize(("stdout", "says"), [(_full, "No space left"), (None, "Bad file descriptor")])
def test_an_answer_that_cannot_be_written_is_a_fault(arguments: list[str], stdout: Any, says: str) -> None:
    done = _run([*CLRT, *arguments], {1: stdout})
    assert done.returncode == 2
    assert done.stderr.decode().startswith("clrt: error: the answer cannot be written to standard output: ")
    assert says in done.stderr.decode() and done.stderr.count(b"\n") == 1


def test_an_answer_whose_reader_has_gone_is_none() -> None:
    done = _run([*CLRT, "scenes"], {1: _broken_pipe})
    assert (done.returncode, done.stderr) == (0, b"")


def test_errors_are_exit_codes_where_nobody_reads_them() -> None:
    for stderr in (_broken_pipe, _full, None):
        done = _run([*CLRT, "hash", "nothing.toml"], {2: stderr})
        assert (done.returncode, done.stdout) == (2, b"")


def test_a_terminal_of_few_characters_and_names_that_are_not_utf8(scene: Path) -> None:
    out = scene.with_name("bläck.png")
    bare = {"LC_ALL": "C", "PYTHONUTF8": "0", "PYTHONCOERCECLOCALE": "0", "PYTHONIOENCODING": "ascii"}
    done = _run([*CLRT, "render", scene, "-o", out], {}, env={**os.environ, **bare})
    assert done.returncode == 0 and done.stdout.isascii() and b": 8 x 8, " in done.stdout
    assert out.exists()


def test_files_in_folders_whose_names_are_not_utf8(
    scene: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = Path(os.fsdecode(os.fsencode(scene.parent) + b"/\xff\xfe"))
    folder.mkdir()
    clrt.Image(clrt.render(clrt.load_dict(_table()), width=4).pixels).save(folder / "sky.exr")
    (folder / "ball.toml").write_text('background = "sky.exr"\n' + SCENE)
    out = folder / "a.exr"
    assert main(["render", str(folder / "ball.toml"), "-o", str(out)]) == 0
    assert main(["hash", str(out)]) == 0
    shown, _ = capsys.readouterr()
    assert "\\udcff\\udcfe/a.exr" in shown and shown.count("\n") == 2
    monkeypatch.setattr("clrt.images.file.os.path.exists", lambda name: False)  # as where there is no /proc
    assert "not UTF-8" in fault(capsys, "hash", out)


def _table() -> dict[str, Any]:
    import tomllib

    return tomllib.loads(SCENE.replace("0.9", "0.5"))


def test_what_is_shown_is_printable(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    evil = "\x1b]0;owned\x07\x1b[2J\u202ecod.toml\udc80"
    line = fault(capsys, "hash", tmp_path / evil)
    assert r"\x1b]0;owned\x07\x1b[2J\u202ecod.toml\udc80" in line
    (tmp_path / "a\x1b[31m.toml").write_text(SCENE)
    assert main(["hash", str(tmp_path / "a\x1b[31m.toml")]) == 0
    out, err = capsys.readouterr()
    assert out.endswith(r"a\x1b[31m.toml" + "\n") and r"a\x1b[31m.toml: shapes[0]" in err
    fault(capsys, evil)
    fault(capsys, "render", evil, f"--{evil}")
    fault(capsys, "hash", "room", "--device", evil)
    fault(capsys, "hash", "room", "--limit", evil)
    fault(capsys, "plot-spectrum", evil, "-o", tmp_path / "a.png")


def test_a_message_is_never_long(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    names = [f"{letter * 50_000}" for letter in "abcdefghijklmnopqrst"]
    (tmp_path / "a.toml").write_text(SCENE.replace("{ reflection = 0.3, diffuse = 0.9 }", '"none"')
                                     + "".join(f"[materials.{name}]\n" for name in names))
    assert "shapes[0].material" in fault(capsys, "hash", tmp_path / "a.toml")
    assert "..." in fault(capsys, "hash", "x" * 100_000)
    for text in ("x" * 10**6, "x " * 10**6, "\x1b" * 10**6, "\u202e " * 10**5):
        for said in (str(ClrtError(text)), str(clrt.ClrtWarning(text)), one_line(text)):
            assert len(said) <= LINE and said.isprintable()


def test_ordinary_texts_stay_as_they_are() -> None:
    for text in ("ball.toml: shapes[0].radius: -1.0 is not allowed", "größe 光線 é", ""):
        assert printable(text) == one_line(text) == text
    assert one_line("a\tb\n c") == "a b c"


def test_a_name_is_no_markup(capsys: pytest.CaptureFixture[str]) -> None:
    terminal.console(width=200).print(terminal.marked("[/] [bold]x\x1b[31m"))
    assert capsys.readouterr().out == "[/] [bold]x\\x1b[31m\n"
    terminal.console(width=200).print("\x1b[31mx")
    assert capsys.readouterr().out == "\\x1b[31mx\n"


def test_a_stream_that_failed_stays_silent() -> None:
    with os.fdopen(_full(), "w", closefd=True) as full:
        stream = terminal.Stream(full)
        stream.write("x")
        stream.flush()
        failure = stream.failure
        assert failure is not None and "No space" in str(failure) and not stream.isatty()
        assert stream.write("more") == 4 and stream.failure is failure
        raw = stream.raw()
        raw.write("x")
        assert raw.failure is failure


def test_warnings_are_told_once_and_not_without_end(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "words.txt"
    path.write_text("".join(f"word{number}\n" for number in range(1000)) + "Sphere 0 0 0 1 none\n")
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        with pytest.raises(clrt.SceneError):
            clrt.load(path)
    texts = [str(warning.message) for warning in caught]
    assert len(texts) == MOST + 1 and texts[-1] == f"words.txt: {1000 - MOST} more warnings like these"
    assert {warning.filename for warning in caught} == {__file__}
    main(["hash", str(path)])
    assert capsys.readouterr().err.count("clrt: warning: ") == MOST + 1


def test_a_warning_points_to_the_line_that_caused_it(scene: Path) -> None:
    for call in (
        lambda: clrt.load(scene),
        lambda: clrt.load_dict({**_table(), "shapes": clrt_shapes()}),
        lambda: clrt.Scene(shapes=clrt_shapes()),
        lambda: clrt.Tracer(clrt.load_dict(small())),
    ):
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            call()
        assert [warning.filename for warning in caught] == [__file__]


def clrt_shapes() -> list[dict[str, Any]]:
    return [{"type": "sphere", "center": [0, 0, 0], "radius": 1, "material": {"diffuse": 2}}]


def small() -> dict[str, Any]:
    table = _table()
    table["shapes"][0]["radius"] = 1e-25
    return table


def test_a_warning_names_its_file_once(tmp_path: Path) -> None:
    (tmp_path / "a.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl gold\nf 1 2 3\n")
    with pytest.warns(clrt.ClrtWarning, match="materials and colours are ignored") as caught:
        clrt.load(tmp_path / "a.obj")
    assert str(caught[0].message).count("a.obj") == 1


def test_a_command_that_is_none(capsys: pytest.CaptureFixture[str]) -> None:
    assert "'rendr' is no command; did you mean 'render'?" in fault(capsys, "rendr")
    assert "did you mean 'devices'?" in fault(capsys, "device", "--json")


def test_devices_and_scenes_as_json(capsys: pytest.CaptureFixture[str]) -> None:
    import json

    assert main(["devices", "--json"]) == 0
    rows = json.loads(capsys.readouterr().out)
    assert [row["label"] for row in rows] == [info.label for info in clrt.devices()]
    assert sum(row["default"] for row in rows) == 1 and rows[0]["index"] == 0
    assert main(["scenes", "--json"]) == 0
    rows = json.loads(capsys.readouterr().out)
    assert {row["name"]: Path(row["file"]) for row in rows} == shipped_scenes()
    assert all(row["about"] for row in rows)
