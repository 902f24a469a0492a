"""Names that are no text, a folder that is gone, numbers without end: one line, before the work is done."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
from platformdirs import user_cache_dir

import clrt
from clrt.base.atomic import write_json, write_text
from clrt.base.errors import legible
from clrt.base.resources import validation_module
from clrt.cli import main
from tests.cli.test_terminal import SCENE, fault

ODD = "a\udcff\x1b[31m\x00\u202e\uffffé\t\n\x85b"
SHOWN = "a\\udcff\\x1b[31m\\x00\\u202e\\uffffé\t\n\\x85b"
CLRT = [sys.executable, "-P", "-c", "import sys; sys.argv[0] = 'clrt'; from clrt.cli import program\n"
        "if __name__ == '__main__': program()"]  # fmt: skip


def test_what_no_file_of_text_holds_is_escaped(tmp_path: Path) -> None:
    assert legible(ODD) == SHOWN and legible(SHOWN) == SHOWN
    assert legible({ODD: [ODD, (1, ODD)], "n": 2.5}) == {SHOWN: [SHOWN, [1, SHOWN]], "n": 2.5}
    write_text(tmp_path / "a.txt", ODD)
    assert (tmp_path / "a.txt").read_text("utf-8") == SHOWN
    write_json(tmp_path / "a.json", {ODD: np.float32(0.5), "b": np.arange(2)})
    assert json.loads((tmp_path / "a.json").read_text("utf-8")) == {SHOWN: 0.5, "b": [0, 1]}
    every = legible("".join(map(chr, range(0x110000)))).replace("&", "").replace("<", "")
    ElementTree.fromstring(f"<a>{every}</a>")
    with pytest.raises(ValueError, match="Out of range"):
        write_json(tmp_path / "a.json", [np.inf], finite=True)


def test_a_comparison_with_a_scene_of_any_name_is_reported(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    name = os.fsdecode(b"\xffs.toml")
    Path(name).write_text(SCENE)
    clrt.render(clrt.load(name)).save("a.exr")
    assert main(["compare", "a.exr", name, "--report", "r.html"]) == 0
    assert r"\udcffs.toml" in Path("r.html").read_text()
    for output in ("s.pov", "s.xml"):
        assert main(["convert", name, output]) == 0


def test_standard_input_is_one_scene(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["render", "-", "-", "-o", str(tmp_path / "{index}.png")]) == 2
    assert "-: standard input can be read once" in capsys.readouterr().err


def test_a_run_told_by_any_name_is_reported(tmp_path: Path) -> None:
    """In the page, in JUnit's XML and in JSON."""
    types, files = validation_module("types"), validation_module("suite.files")
    check = types.CheckResult(ODD, False, ODD, 1.0)
    result = types.SuiteResult(
        cases=[], mutants=[], counts=[], coverage={}, versions={"a": ODD}, device=ODD, seconds=1.0,
        seed=None, command=ODD, started="now", notes=(ODD,), checks=(check,),
    )  # fmt: skip
    page = tmp_path / "a.html"
    validation_module("suite.report").write_report(result, page)
    files.write_beside(result, page)
    for path in (page, *files.write_beside(result, page)):
        text = path.read_text("utf-8")
        assert "a\\udcff" in text.replace("\\\\", "\\") and legible(text) == text
    assert json.loads(page.with_suffix(".json").read_text())["command"] == SHOWN
    case = ElementTree.parse(page.with_suffix(".xml")).find(".//testcase")
    assert case is not None and case.get("name") == SHOWN
    files.check_beside(page)  # which knows its own files again
    page.with_suffix(".json").write_text('["passed", "command", "versions", "cases", "coverage"]')
    with pytest.raises(clrt.ClrtError, match="not an older run's"):
        files.check_beside(page)
    page.with_suffix(".json").unlink()
    page.with_suffix(".xml").write_text("<!-- clrt validate -->")
    with pytest.raises(clrt.ClrtError, match="not an older run's"):
        files.check_beside(page)


@pytest.fixture
def gone(tmp_path: Path) -> Iterator[Path]:
    """The current folder is removed; a scene lies above it."""
    (tmp_path / "ball.toml").write_text(SCENE.replace("0.9", "0.5"))
    before = os.getcwd()
    (tmp_path / "here").mkdir()
    os.chdir(tmp_path / "here")
    (tmp_path / "here").rmdir()
    yield tmp_path
    os.chdir(before)


@pytest.mark.parametrize(
    "command",
    [["render", "{}/ball.toml", "-o", "o.png"], ["convert", "{}/ball.toml", "o.toml"],
     ["plot-spectrum", "D65"],
     ["plot-spectrum", "D65", "-o", "o.svg"], ["bench", "--json", "o.json"], ["doctor"],
     ["validate", "--case", "ambient", "--report", "o.html"]],
)  # fmt: skip
def test_where_the_current_folder_was_removed(
    command: list[str], gone: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert "the current folder was removed" in fault(capsys, *[word.format(gone) for word in command])


def test_a_scene_is_not_saved_nowhere(gone: Path) -> None:
    scene = clrt.load(gone / "ball.toml")
    with pytest.raises(clrt.ClrtError, match="the current folder was removed; change to another one"):
        scene.save("o.toml")
    scene.save(gone / "o.toml")
    assert clrt.load(gone / "o.toml") == scene


def test_numbers_and_names_without_end(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert "from 0 to 10000" in fault(capsys, "validate", "--random", 2**31 - 1)
    for name in (f"random {'9' * 5000}/0", f"random 0/{'9' * 19}", "random ٣/0"):
        assert "is not a case" in fault(capsys, "validate", "--case", name)
    assert "nesting" in fault(capsys, "plot-spectrum", "{" + "a." * 40_000 + "b = 1}")
    assert "nothing stands behind it" in fault(capsys, "plot-spectrum", '{name = "D65"}\nx = 1')
    assert "'' is no file's name" in fault(capsys, "hash", "")


def test_scenes_that_cannot_be_timed(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("clrt.bench.suite.run", lambda *_: pytest.fail("it measures"))
    for name in ("a.toml", "b/a.toml", "none.json"):
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text(SCENE.replace("0.9", "0.5") if name != "none.json" else "{}")
    files = [tmp_path / name for name in ("a.toml", "b/a.toml", "none.json")]
    assert "none.json: camera: missing" in fault(capsys, "bench", "--scene", files[0], files[2])
    assert "another one is called a, too" in fault(capsys, "bench", "--scene", *files[:2])


def test_a_date_that_is_none(capsys: pytest.CaptureFixture[str], tmp_path: Path,
                             monkeypatch: pytest.MonkeyPatch) -> None:  # fmt: skip
    """Of scipy, trimesh and others the import fails then."""
    black = np.zeros((9, 9, 3), np.float32)
    (tmp_path / "a.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    for date in ("abc", "-1", "9" * 400, "٣"):
        monkeypatch.setenv("SOURCE_DATE_EPOCH", date)
        for suffix in (".pdf", ".svg", ".png"):
            said = fault(capsys, "plot-spectrum", "D65", "-o", tmp_path / f"a{suffix}")
            assert "SOURCE_DATE_EPOCH: " in said and "seconds" in said
        assert "SOURCE_DATE_EPOCH: " in fault(capsys, "scenes")
        for reads in (lambda: clrt.load(tmp_path / "a.obj"), lambda: clrt.compare(black, black)):
            with pytest.raises(clrt.ClrtError, match="SOURCE_DATE_EPOCH: "):
                reads()
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "99999999999")
    assert main(["plot-spectrum", "D65", "-o", str(tmp_path / "a.pdf")]) == 0


def test_a_checkpoint_behind_a_link_is_removed_too(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "ball.toml").write_text(SCENE.replace("0.9", "0.5"))
    (tmp_path / "link.ck").symlink_to("real.ck")
    picture, checkpoint = str(tmp_path / "a.png"), str(tmp_path / "link.ck")
    assert main(["render", str(tmp_path / "ball.toml"), "-o", picture, "--checkpoint", checkpoint]) == 0
    assert not (tmp_path / "real.ck").exists() and (tmp_path / "link.ck").is_symlink()


def _validating(folder: Path) -> subprocess.Popen[str]:
    """The quick suite, which takes minutes: it is interrupted long before it is done."""
    command = [*CLRT, "validate"]
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE}
    return subprocess.Popen(command, cwd=folder, text=True, start_new_session=True, **pipes)  # type: ignore[call-overload]


def _alive(group: int) -> list[str]:
    """Processes of this session."""
    found = []
    for folder in Path("/proc").iterdir():
        try:
            words = (folder / "stat").read_text().rpartition(")")[2].split() if folder.name.isdigit() else []
        except OSError:
            continue
        if words and int(words[3]) == group and words[0] != "Z":
            found.append(folder.name)
    return found


@pytest.mark.slow
@pytest.mark.parametrize("seconds", [1.5, 3.0, 5.0])
@pytest.mark.parametrize("everybody", [False, True])
def test_ctrl_c_ends_the_suite_and_its_processes(seconds: float, everybody: bool, tmp_path: Path) -> None:
    """As the terminal sends it, to all of them, and as `kill` does, to one."""
    with _validating(tmp_path) as process:
        time.sleep(seconds)
        begin = time.monotonic()
        (os.killpg if everybody else os.kill)(process.pid, signal.SIGINT)
        _, said = process.communicate(timeout=60)
        lasted = time.monotonic() - begin
    lines = said.splitlines()
    kept = f"saved: {user_cache_dir('clrt', appauthor=False)}/results"  # what was done goes on from there
    assert process.returncode == 130, said
    assert lines[-1] in ("clrt: interrupted; nothing was saved", f"clrt: interrupted; {kept}"), said
    assert all(" of " in line for line in lines[:-1]), said  # what was done so far
    assert lasted < 10  # one by itself; the suite would go on for minutes
    _all_end(process.pid)


HELD = """
import os, signal, sys, time
sys.argv[:] = ["clrt"]
from clrt.base import interrupts
interrupts.install()
interrupts.catching()
from clrt.base.resources import validation_module
run = validation_module("suite.run")
try:
    with run._deaf():
        os.kill(os.getpid(), signal.{name})
        time.sleep(0.3)
        print("whole", flush=True)
    time.sleep(5)
except KeyboardInterrupt:
    print("then heard", interrupts.code())
"""


@pytest.mark.parametrize("name", ["SIGINT", "SIGTERM", "SIGHUP"])
def test_no_signal_comes_between_a_process_and_what_it_is_for(name: str) -> None:
    """A process that had begun, and was not told what for, printed a traceback."""
    command = [sys.executable, "-c", HELD.format(name=name)]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    assert done.stdout.splitlines() == ["whole", f"then heard {128 + getattr(signal, name)}"]


@pytest.mark.slow
def test_processes_end_with_who_started_them(tmp_path: Path) -> None:
    with _validating(tmp_path) as process:
        time.sleep(5)
        process.kill()
        process.communicate(timeout=60)
    _all_end(process.pid)


def _all_end(group: int) -> None:
    end = time.monotonic() + 20
    while _alive(group) and time.monotonic() < end:
        time.sleep(0.1)
    assert _alive(group) == []
