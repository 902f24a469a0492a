"""Processes of clrt's own: none is a program that only holds Python, and a trial starts no further one."""

from __future__ import annotations

import os
import subprocess
import sys
import zipfile
from pathlib import Path

import numpy as np
import pytest

from clrt.base import child
from clrt.base.install import pip_install
from clrt.base.resources import PACKAGE
from clrt.device import trial, vendors
from clrt.diagnosis import doctor

HOST = """\
import pathlib, sys
sys.path.insert(0, sys.argv[2])
with open(sys.argv[1], "a") as file:
    print(sys.argv[3:], file=file)
if len(pathlib.Path(sys.argv[1]).read_text().splitlines()) > 3:
    sys.exit("it starts itself again and again")
sys.executable, sys.frozen = {program!r}, True
import clrt
print(clrt.render("room", width=16).pixels.mean())
"""


@pytest.mark.parametrize(
    ("name", "frozen", "known"),
    [
        ("/usr/bin/python3.13", False, True), ("/x/mayapy.exe", False, True), ("/x/pypy3", False, True),
        ("/x/pythonw.exe", False, True), ("/usr/bin/python3", True, False), ("/opt/app/render", False, False),
        ("/usr/autodesk/maya/bin/maya.bin", False, False), ("", False, False),
    ],
)  # fmt: skip
def test_what_is_an_interpreter(
    name: str, frozen: bool, known: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(sys, "executable", name)
    monkeypatch.setattr(sys, "frozen", frozen, raising=False)
    assert child.interpreter() == (name if known else None)
    monkeypatch.setattr(subprocess, "run", lambda *_, **__: pytest.fail("a process was started"))
    if not known:
        assert trial._run("0") is None and vendors.load_fault("libOpenCL.so") == ""
        assert pip_install("numpy").startswith("python -m pip")
        assert [finding.state for finding in doctor._device(None)] == ["advice"]


@pytest.mark.skipif(sys.platform == "win32", reason="a program that the shell starts")
def test_a_frozen_program_is_started_once(tmp_path: Path) -> None:
    """It started itself for the trial of each driver, which started it again."""
    (tmp_path / "app.py").write_text(HOST.format(program=str(tmp_path / "app")))
    program = tmp_path / "app"
    told = f'"{tmp_path}/starts" "{PACKAGE.parent}"'
    program.write_text(f'#!/bin/sh\nexec "{sys.executable}" "{tmp_path}/app.py" {told} "$@"\n')
    program.chmod(0o700)
    fresh = {**os.environ, "XDG_CACHE_HOME": str(tmp_path / "cache")}  # no verdict is known there
    done = subprocess.run([program], capture_output=True, text=True, timeout=300, check=False, env=fresh)
    assert done.returncode == 0 and float(done.stdout) > 0, done.stderr
    assert (tmp_path / "starts").read_text() == "[]\n"


def test_a_trial_tries_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    found: list[dict[str, str]] = []

    def run(*_: object, env: dict[str, str], **__: object) -> subprocess.CompletedProcess[bytes]:
        found.append(env)
        return subprocess.CompletedProcess([], 1, b"refused", trial.DONE.encode())

    monkeypatch.setattr(trial.subprocess, "run", run)
    assert trial._run("0") == "refused"
    monkeypatch.setattr(os, "environ", found[0])
    assert trial._run("0") is None and len(found) == 1


def test_within_an_archive_it_says_so(tmp_path: Path) -> None:
    with zipfile.ZipFile(tmp_path / "app.pyz", "w") as archive:
        for file in PACKAGE.rglob("*.py"):
            archive.write(file, file.relative_to(PACKAGE.parent))
    code = "import sys; sys.path.insert(0, sys.argv[1]); import clrt; clrt.load('room')"
    command = [sys.executable, "-I", "-c", code, str(tmp_path / "app.pyz")]
    done = subprocess.run(command, capture_output=True, text=True, cwd=tmp_path, check=False)
    assert done.returncode == 1
    last = done.stderr.splitlines()[-1]
    assert last.endswith("clrt cannot run from within an archive; unpack or install it")


def test_packages_are_where_a_program_put_them(tmp_path: Path) -> None:
    """With `sys.path`, as of Blender's add-ons: a trial found none, and the driver was called broken."""
    packages = Path(np.__file__).parents[1]
    code = f"import sys; sys.path += [{str(PACKAGE.parent)!r}, {str(packages)!r}]; " + """
from clrt.device import platforms, trial
for info, _ in platforms.listed():
    print(trial._tried(info))
"""
    bare = {**os.environ, "PYTHONPATH": "", "XDG_CACHE_HOME": str(tmp_path)}
    base = [getattr(sys, "_base_executable", sys.executable), "-S", "-c", code]
    done = subprocess.run(base, capture_output=True, text=True, env=bare, check=False, cwd=tmp_path)
    assert done.returncode == 0 and "None" not in done.stdout.split(), done.stderr
    assert done.stdout.split("\n")[0] == ""  # the first driver works


def test_what_a_script_lies_beside_is_no_package(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "here").mkdir()
    monkeypatch.chdir(tmp_path / "here")
    monkeypatch.setattr(sys.modules["__main__"], "__file__", str(tmp_path / "a.py"), raising=False)
    places = ["", ".", str(tmp_path), str(tmp_path / "here"), "beside", str(tmp_path / "packages")]
    monkeypatch.setattr(sys, "path", places)
    monkeypatch.delenv("PYTHONPATH", raising=False)
    found = child.environment()["PYTHONPATH"].split(os.pathsep)
    assert found == [str(PACKAGE.parent), str(tmp_path / "packages")]
    (tmp_path / "here").rmdir()
    assert child.environment(CLRT_A="b")["CLRT_A"] == "b"


def test_what_never_came_to_its_driver_is_no_verdict(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(trial.cachefolder, "ours", lambda *parts: tmp_path.joinpath(*parts))
    monkeypatch.setattr(trial, "_unkept", {})
    assert trial.kept_verdict("key", "label", lambda: None) == ""
    assert trial.kept_verdict("key", "label", lambda: pytest.fail("once a process is enough")) == ""
    assert [*tmp_path.rglob("*.json")] == []
