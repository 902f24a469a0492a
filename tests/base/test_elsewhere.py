"""Nothing that lies in the current folder is run or obeyed: no modules, no libraries, no settings."""

from __future__ import annotations

import os
import re
import subprocess
import sys
import threading
from pathlib import Path

import pytest

from clrt.base import interrupts
from clrt.base.elsewhere import apart, relative, within
from clrt.base.resources import PACKAGE
from clrt.device import platforms

CLRT = [sys.executable, "-P", "-c", "import sys; sys.argv[0] = 'clrt'; from clrt.cli import program\n"
        "if __name__ == '__main__': program()"]  # fmt: skip
TRAP = "import os\nopen(os.path.join(os.path.dirname(__file__), 'sprung'), 'w')\nraise SystemExit(7)\n"


@pytest.fixture
def alone(monkeypatch: pytest.MonkeyPatch) -> None:
    """Neither a command nor a program with threads, whatever ran before."""
    monkeypatch.setattr(interrupts, "_main", None)
    monkeypatch.setattr(threading, "active_count", lambda: 1)


def test_one_is_elsewhere_for_a_moment(tmp_path: Path, alone: None, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    with pytest.raises(KeyError), within(PACKAGE):
        assert Path.cwd() == PACKAGE
        raise KeyError
    assert Path.cwd() == tmp_path
    monkeypatch.setattr(threading, "active_count", lambda: 2)
    with within(PACKAGE):
        assert Path.cwd() == tmp_path, "other threads have the same folder"
    monkeypatch.setattr(interrupts, "_main", sys._getframe())
    with within(PACKAGE):
        assert Path.cwd() == PACKAGE
    assert Path.cwd() == tmp_path
    for moved in (lambda: "/", _nowhere):  # its name leads elsewhere, or nowhere
        with monkeypatch.context() as patched:
            patched.setattr(os, "getcwd", moved)
            with within(PACKAGE):
                assert os.path.samefile(".", PACKAGE)
        assert Path.cwd() == tmp_path


def _nowhere() -> str:
    raise FileNotFoundError(2, "No such file or directory")


def test_drivers_are_loaded_elsewhere(tmp_path: Path, alone: None, monkeypatch: pytest.MonkeyPatch) -> None:
    """Intel's runtime reads `cl.cfg` and runs `librt.so.1` of the current folder."""
    monkeypatch.chdir(tmp_path)
    for name in platforms.PLACES:
        monkeypatch.delenv(name, raising=False)
    seen = []
    monkeypatch.setattr(platforms.cl, "get_platforms", lambda: seen.append(Path.cwd()) or [])
    monkeypatch.setattr(platforms, "_intel_wanted", lambda: True)
    monkeypatch.setattr(platforms.intel, "platforms", lambda: seen.append(Path.cwd()) or ())
    with pytest.raises(platforms.DeviceError):
        platforms._platforms()
    assert seen == [PACKAGE, PACKAGE] and Path.cwd() == tmp_path
    monkeypatch.setenv("LD_LIBRARY_PATH", "/usr/lib:libs")  # which the user wants
    with pytest.raises(platforms.DeviceError):
        platforms._platforms()
    assert seen[2:] == [tmp_path, tmp_path]


def can_be_apart() -> bool:
    return bool(apart(PACKAGE, Path.cwd) == PACKAGE)


def test_a_thread_has_a_current_folder_of_its_own(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    found = apart(PACKAGE, lambda: (Path.cwd(), threading.current_thread().name))
    assert found in ((PACKAGE, "clrt-apart"), (tmp_path, "clrt-apart")) and Path.cwd() == tmp_path
    with pytest.raises(KeyError):
        apart(PACKAGE, lambda: {}["a"])
    monkeypatch.setattr(threading.Thread, "start", lambda thread: exec("raise RuntimeError"))
    assert apart(PACKAGE, Path.cwd) == tmp_path, "there is no room for a thread"
    monkeypatch.undo()
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "platform", "darwin")
    assert apart(PACKAGE, Path.cwd) == tmp_path


@pytest.mark.skipif(not can_be_apart(), reason="threads have no current folder of their own here")
def test_contexts_and_programs_are_made_elsewhere(tmp_path: Path) -> None:
    """Intel's runtime reads its `cl.cfg` each time; one that is a pipe kept it waiting for ever."""
    os.mkfifo(tmp_path / "cl.cfg")
    command = [*CLRT, "render", "gallery", "-o", str(tmp_path / "a.png"), "--width", "8"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stderr


def test_variables_that_lead_from_the_current_folder(monkeypatch: pytest.MonkeyPatch) -> None:
    for value, is_so in ("", False), ("/a:/b", False), ("/a::/b", False), ("/a:b", True), ("./a", True):
        monkeypatch.setenv("A", value)
        assert relative("B", "A") == is_so


@pytest.mark.parametrize("command", [["doctor"], ["validate", "--case", "ambient"], ["devices"]])
def test_modules_in_the_current_folder_are_not_run(command: list[str], tmp_path: Path) -> None:
    for name in ("json", "ctypes", "numpy", "multiprocessing", "socket", "threading", "tempfile", "pyopencl",
                 "clrt", "validation", "sitecustomize", "usercustomize", "mitsuba", "drjit"):  # fmt: skip
        (tmp_path / f"{name}.py").write_text(TRAP)
    done = subprocess.run([*CLRT, *command], cwd=tmp_path, capture_output=True, text=True, timeout=300)
    assert not (tmp_path / "sprung").exists() and done.returncode in (0, 1), done.stderr


def test_every_process_that_is_started_is_told_so() -> None:
    """Benchmarks start theirs in a folder of their own."""
    starts = re.compile(r"\[\s*(sys\.executable|python)\b")
    lines = [
        (file.relative_to(PACKAGE), line)
        for file in PACKAGE.rglob("*.py") if file.parent.name != "bench"
        for line in file.read_text(encoding="utf-8").splitlines() if starts.search(line)
    ]  # fmt: skip
    assert len(lines) >= 2
    assert [line for line in lines if '"-P"' not in line[1]] == []
