"""Hostile command lines: what is wrong with how a process ended is noticed."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path
from types import ModuleType, SimpleNamespace

import numpy as np
import pytest

import clrt
from clrt.base.resources import validation_module
from clrt.cli import main
from clrt.cli.terminal import console
from tests.diagnosis.test_advice import options

ERROR = "sys.stderr.write('clrt: error: x\\n'); sys.exit(2)"
PICTURE = "import shutil; shutil.copy('good.png', 'out.png')"


@pytest.fixture(scope="module")
def process() -> ModuleType:
    return validation_module("hostile.process")


@pytest.fixture(scope="module")
def commands() -> ModuleType:
    return validation_module("hostile.commands")


def faults(
    process: ModuleType,
    commands: ModuleType,
    folder: Path,
    monkeypatch: pytest.MonkeyPatch,
    program: str,
    **how: object,
) -> list[str]:
    """What is found wrong with a program that was asked to render."""
    monkeypatch.setattr(process, "PROGRAM", (b"-c", f"import os, sys, time; {program}".encode()))
    files = {b"scene.toml": commands.SCENE, b"good.png": validation_module("hostile.seeds").images()[".png"]}
    arguments = [b"render", b"scene.toml", b"-o", b"out.png"]
    command = commands.Command(arguments, [b"out.png"], files, **how)
    command.prepare(folder / "run")
    for beside in ("home", "tmp"):
        (folder / beside).mkdir()
    before = process.contents(folder / "run")
    ended = process.run(command, folder / "run")
    return list(process.judged(command, ended, before, folder / "run"))


@pytest.mark.parametrize(
    ("program", "said"),
    [
        (PICTURE, ""),
        (ERROR, ""),
        ("sys.exit(3)", "exit code 3"),
        ("os.abort()", "exit code -6"),
        ("sys.exit(2)", "exit code 2 with 0 lines"),
        (f"sys.stderr.write('clrt: error: y\\n'); {ERROR}", "2 lines of errors"),
        (f"sys.stderr.write('clrt: error: y\\n'); {PICTURE}", "exit code 0 with 1 lines"),
        (f"print('Traceback (most recent call last):'); {ERROR}", "a traceback"),
        (f"print('\\x1b[31m'); {ERROR}", "a raw '\\x1b'"),
        (f"print('\\u202e'); {ERROR}", "a raw '\\u202e'"),
        (f"sys.stderr.write('libpng error\\n'); {ERROR}", "a line that is not ours"),
        (f"sys.stderr.write('clrt: ' + 'x' * 99999 + '\\n'); {ERROR}", "bytes on stderr"),
        (f"open('.clrt-1.png', 'w'); {ERROR}", ".clrt-1.png is left"),
        (f"open('scene.toml', 'w'); {ERROR}", "scene.toml is changed"),
        (f"open('out.png', 'w').write('half'); {ERROR}", "out.png is not whole"),
        (f"open(os.environ['TMPDIR'] + '/x', 'w'); {ERROR}", "left in TMPDIR"),
        ("pass", "no new picture"),
    ],
)
def test_what_ends_badly_is_noticed(
    process: ModuleType,
    commands: ModuleType,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    program: str,
    said: str,
) -> None:
    found = faults(process, commands, tmp_path, monkeypatch, program)
    assert [text for text in found if said in text] if said else not found, found


@pytest.mark.parametrize(("variable", "noticed"), [(b"POCL_WORK_GROUP_METHOD", False), (b"LANG", True)])
def test_a_driver_answers_its_own_variables(
    process: ModuleType, tmp_path: Path, variable: bytes, noticed: bool
) -> None:
    ended = process.Ended(0, b"", b"Unknown work group generation method.\n", 0.0, 0)
    command = SimpleNamespace(
        arguments=[b"check"], environment={variable: b"x"}, stdout="pipe", stderr="pipe", outputs=[]
    )
    found = process.judged(command, ended, {}, tmp_path / "nowhere")
    assert any("not ours" in fault for fault in found) == noticed


@pytest.mark.parametrize(
    ("program", "status", "bounds"),
    [
        (f"{PICTURE}; time.sleep(60)", "hangs", {"patience": 3.0}),
        (f"{PICTURE}\nwhile time.process_time() < 0.5: pass", "slow", {"seconds": 0.4}),
        (f"{PICTURE}; held = b'x' * (200 << 20); time.sleep(0.2)", "large", {"memory": 150 << 20}),
        ("sys.exit(3)", "ended badly", {}),
        (ERROR, "ended well", {}),
    ],
)
def test_each_status_of_a_command(
    process: ModuleType,
    commands: ModuleType,
    monkeypatch: pytest.MonkeyPatch,
    program: str,
    status: str,
    bounds: dict[str, float],
) -> None:
    """Each with the bound that it exceeds alone: on a busy machine an interpreter starts slowly."""
    good = {b"good.png": validation_module("hostile.seeds").images()[".png"]}
    made = commands.Command([b"render", b"x.toml", b"-o", b"out.png"], [b"out.png"], good)
    monkeypatch.setattr(process, "make", lambda seed, index: made)
    monkeypatch.setattr(process, "PROGRAM", (b"-c", f"import os, sys, time; {program}".encode()))
    gates = validation_module("hostile.gates")
    monkeypatch.setattr(gates, "pace", lambda: 1.0)
    monkeypatch.setattr(process, "PATIENCE", bounds.get("patience", process.PATIENCE))
    monkeypatch.setattr(gates, "COMMAND_SECONDS", bounds.get("seconds", gates.COMMAND_SECONDS))
    monkeypatch.setattr(gates, "COMMAND_MEMORY", bounds.get("memory", gates.COMMAND_MEMORY))
    answer = process.attempt({"seed": 1, "index": 2})
    assert answer["status"] == status, answer
    assert answer["command"]["arguments"] == ["render", "x.toml", "-o", "out.png"]


@pytest.mark.parametrize("kind", ["closed", "full", "broken", "unread", "terminal"])
def test_descriptors_are_as_said(
    process: ModuleType, commands: ModuleType, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, kind: str
) -> None:
    """The program says by its exit code what it saw; an odd one is the only fault then."""
    tell = (
        "code = 50\ntry: code += 10 * os.isatty(1) + (os.write(1, b'x') == 1)\n"
        "except OSError as error: code = error.errno\nos._exit(code)"
    )
    expected = {"closed": 9, "full": 28, "broken": 32, "unread": 51, "terminal": 61}[kind]
    found = faults(process, commands, tmp_path, monkeypatch, tell, stdout=kind)
    assert found == [f"exit code {expected}"]


def test_surroundings_are_as_said(
    process: ModuleType, commands: ModuleType, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    tell = "import resource; assert resource.getrlimit(resource.RLIMIT_NOFILE)[0] == 32; "
    tell += "assert os.environb[b'TERM'] == b'\\xff' and 'TZ' not in os.environ; sys.exit(7)"
    how = {"environment": {b"TERM": b"\xff", b"TZ": None}, "limits": {"n": 32}}
    assert faults(process, commands, tmp_path, monkeypatch, tell, **how) == ["exit code 7"]


def test_every_command_but_the_viewer_is_drawn(commands: ModuleType) -> None:
    """Those that end by themselves."""
    drawn = {words[0] for index in range(1500) if (words := commands.make(1, index).arguments)}
    known = {name.encode() for name in options()}
    assert known - drawn == {b"view"}


def test_a_check_tells_of_each_scene(process: ModuleType, commands: ModuleType, tmp_path: Path) -> None:
    """Exit code 1, and as many lines as scenes are wrong; none where it prints JSON."""
    for lines, code, fine in ((2, 1, True), (0, 1, True), (1, 0, False), (0, 2, False)):
        ended = process.Ended(code, b"", b"clrt: error: x\n" * lines, 0.0, 0)
        (tmp_path / "tmp").mkdir(exist_ok=True)
        made = commands.Command([b"check", b"a.toml"], [], {})
        assert (not process.judged(made, ended, {}, tmp_path / "run")) == fine


def test_what_is_made_below_an_output_is_no_fault(
    process: ModuleType, commands: ModuleType, tmp_path: Path
) -> None:
    for place in ("run/new/kernels", "run/newer", "tmp"):
        (tmp_path / place).mkdir(parents=True)
    made = commands.Command([b"exercise", b"start", b"1", b"new"], [b"new"], {})
    found = process.judged(made, process.Ended(0, b"", b"", 0.0, 0), {}, tmp_path / "run")
    assert found == ["newer is left"]


def test_everything_that_a_seed_draws_can_be_made(commands: ModuleType, tmp_path: Path) -> None:
    kinds = set()
    for index in range(300):
        made = commands.make(1, index)
        made.prepare(tmp_path / str(index))
        kinds |= {(what if isinstance(what, str) else "file") for what in made.files.values()}
        kinds |= set(made.environment) | set(made.limits) | {made.stdout}
    assert kinds >= {"fifo", "folder", "loop", "socket", "world", "spoiled", "n", "f", "v", "full", "closed"}
    assert kinds >= {b"HOME", b"LC_ALL", b"TMPDIR", b"XDG_CACHE_HOME", b"CLRT_DEVICE", b"OCL_ICD_VENDORS"}


@pytest.mark.parametrize(
    "command",
    ["render {} -o a.png", "check {}", "explain {} 1 1", "hash {}", "view {}", "convert {} a.toml",
     "compare {} {}", "bench --scene {} --only launch", "sweep {} -o a.png", "turntable {} -o a.png",
     "validate {}"],
)  # fmt: skip
def test_the_advice_about_limits_is_one(
    command: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Of each command that reads a scene: what it says to type is taken, and helps; or is not said."""
    monkeypatch.chdir(tmp_path)
    Path("a.json").write_text('{"x": ' + "[" * 20 + "]" * 20 + "}")
    words = command.format("a.json", "a.json").split()
    assert main(words) != 0
    said = "".join(capsys.readouterr())
    assert "nesting" in said
    if words[0] == "validate":
        assert "--limit" not in said
        return
    assert "--limit nesting=N" in said
    assert main([*words, "--limit", "nesting=30"]) != 0
    said = "".join(capsys.readouterr())
    assert "nesting" not in said and "'x'" in said


@pytest.mark.parametrize(
    ("command", "says"),
    [
        ("selftest --junit s.toml", "--junit writes XML; give it a name such as results.xml"),
        ("plot-spectrum D65 -o -", "a plot goes to a file"),
        ("check s.nff", "line 1: -1e+200 is not allowed; a radius must be from -1e+15 on"),
        ("check far.nff", "line 2: its ends are too far apart: more than 1.8e308"),
        ("sweep s.toml --keyframes k.toml -o a.mkv", "it must be a number of seconds, from -1e9 to 1e9"),
    ],
)
def test_what_is_wrong_is_said_in_one_line(
    command: str, says: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:  # fmt: skip
    monkeypatch.chdir(tmp_path)
    Path("s.toml").write_text("camera = {origin = [0, 0, 5], target = [0, 0, 0]}\n")
    Path("s.nff").write_text("s 0 0 0 -1e200\n")
    Path("far.nff").write_text("c 1.5e308 1.5e308 0 -1\n0 0 0 -2\n")
    Path("k.toml").write_text("".join(f"[[keyframes]]\ntime = {t}\n" for t in (0, 1, 2e9)))
    assert main(command.split()) != 0
    said = capsys.readouterr().err
    assert says in said and said.count("\n") == 1 and not Path("-").exists()


def test_a_name_is_no_emoji(capsys: pytest.CaptureFixture[str]) -> None:
    console().print(":heart:.png")
    assert capsys.readouterr().out == ":heart:.png\n"


def test_python_without_docstrings_is_told(tmp_path: Path) -> None:
    for size in (10, 20):
        clrt.Image(np.full((size, size, 3), 0.5, np.float32)).save(tmp_path / f"{size}.png")
    files = [str(tmp_path / f"{size}.png") for size in (10, 20)]
    words = [sys.executable, "-OO", "-m", "clrt", "compare", *files]
    done = subprocess.run(words, capture_output=True, text=True, check=False)
    assert "Traceback" not in done.stderr and done.stderr.count("\n") <= 1, done.stderr
    assert done.returncode != 2 or "leave out python -OO" in done.stderr
