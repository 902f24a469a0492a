"""What a process may have that breaks drivers and libraries: odd variables, narrow limits, nothing left."""

from __future__ import annotations

import errno
import json
import os
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import pytest

import clrt
from clrt.base.arguments import public
from clrt.base.errors import exhausted
from clrt.device import cachefolder, platforms, trial

SCENE = {
    "camera": {"origin": [0, 1, 4], "target": [0, 0, 0], "width": 16, "height": 12},
    "lights": [{"type": "point", "position": [3, 5, 4]}],
    "shapes": [{"type": "sphere", "center": [0, 0, 0], "radius": 1}],
}
INFO = platforms.DeviceInfo(0, "name", "platform", "1.0", "CPU", 2, 1 << 30, "7")


def command(
    folder: Path, *arguments: str, limit: str = "", **variables: str
) -> subprocess.CompletedProcess[str]:
    """A command under a limit of the shell, in a folder with a scene."""
    (folder / "scene.json").write_text(json.dumps(SCENE))
    shell = f"ulimit {limit or '-c 0'}; exec \"$@\""
    return subprocess.run(
        ["bash", "-c", shell, "clrt", sys.executable, "-m", "clrt", *arguments],
        cwd=folder, env={**os.environ, **variables}, capture_output=True, text=True, timeout=120, check=False,
    )  # fmt: skip


def one_line(done: subprocess.CompletedProcess[str]) -> bool:
    return done.returncode == 2 and done.stderr.startswith("clrt: error: ") and done.stderr.count("\n") == 1


def own_lines(done: subprocess.CompletedProcess[str]) -> list[str]:
    """What a command said on stderr, but for its waiting for the tests that run beside it."""
    return [line for line in done.stderr.splitlines() if "waiting for process" not in line]


@pytest.fixture
def anew() -> None:
    trial.check_listing.cache_clear()


@pytest.mark.parametrize("name", ["POCL_MAX_WORK_GROUP_SIZE", "POCL_MAX_PTHREAD_COUNT"])
def test_a_driver_that_a_variable_breaks_is_an_error_that_names_it(tmp_path: Path, name: str) -> None:
    if not platforms.choose()[0].version.startswith("PoCL"):
        pytest.skip("the variable is PoCL's: CLRT_DEVICE=PoCL runs this, as CI does with Debian's")
    value = {"POCL_MAX_WORK_GROUP_SIZE": "x", "POCL_MAX_PTHREAD_COUNT": "-1"}[name]
    # PoCL 3.1 ends the process for both, 3.0 has no work-group for the first
    faults = ("it ends the process", "its largest work-group is of 0 work-items")
    for arguments in (("render", "scene.json", "-o", "a.png"), ("devices",)):
        done = command(tmp_path, *arguments, **{name: value})
        said = done.stdout + done.stderr
        assert one_line(done) or (arguments == ("devices",) and done.returncode == 1), done
        assert any(fault in said for fault in faults), said
        assert said.endswith(f"it may be due to {name}={value}: change that\n")
    assert command(tmp_path, "doctor", **{name: value}).returncode == 1
    right = {"POCL_MAX_WORK_GROUP_SIZE": "1", "POCL_MAX_PTHREAD_COUNT": "1"}[name]
    done = command(tmp_path, "render", "scene.json", "-o", "a.png", "--quiet", **{name: right})
    assert (done.returncode, own_lines(done)) == (0, [])


@pytest.mark.parametrize("limit", ["-v 100000", "-v 600000", "-d 200000", "-n 6", "-n 14", "-f 400"])
def test_limits_in_which_no_driver_works_are_an_error(tmp_path: Path, limit: str) -> None:
    done = command(tmp_path, "render", "scene.json", "-o", "a.png", limit=limit)
    assert one_line(done) and f"ulimit {limit}: " in done.stderr, done.stderr


def test_where_no_file_can_be_opened_any_more_the_doctor_says_so(tmp_path: Path) -> None:
    done = command(tmp_path, "doctor", limit="-n 8")
    assert one_line(done) and "(ulimit -n)" in done.stderr, done.stderr


def test_drivers_cannot_be_named_by_what_is_no_name(tmp_path: Path) -> None:
    done = command(tmp_path, "doctor", "--json", OCL_ICD_VENDORS="x" * 300)
    assert done.returncode == 1 and done.stderr == ""
    (found,) = [one for one in json.loads(done.stdout)["findings"] if one["topic"] == "driver files"]
    assert found["mend"] == "unset OCL_ICD_VENDORS"
    assert one_line(command(tmp_path, "devices", OCL_ICD_VENDORS="x" * 300, CLRT_DRIVER=""))


@pytest.mark.parametrize("name", ["OMP_NUM_THREADS", "OMP_PLACES"])
def test_variables_of_openmp_do_not_end_a_comparison(tmp_path: Path, name: str) -> None:
    pytest.importorskip("flip_evaluator", reason="needs FLIP of clrt[validation], for Python below 3.14")
    value = {"OMP_NUM_THREADS": "99999", "OMP_PLACES": "x"}[name]
    done = command(tmp_path, "compare", "scene.json", "scene.json", **{name: value})
    assert (done.returncode, own_lines(done)) == (0, [])


def test_what_is_kept_of_a_driver_depends_on_the_circumstances(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv(cachefolder.VARIABLE, str(tmp_path))
    monkeypatch.setattr(trial, "_tried", lambda info: "it ends the process (exit code -6)")
    assert trial.verdict(INFO)[1] and not trial.verdict(INFO)[1]
    monkeypatch.setenv("POCL_AFFINITY", "1")
    assert trial.verdict(INFO)[1]
    monkeypatch.delenv("POCL_AFFINITY")
    for name in ("PYOPENCL_BUILD_OPTIONS", "CL_CONFIG_CPU_TARGET_ARCH"):
        monkeypatch.setenv(name, "x")
        assert trial.verdict(INFO)[1]
        monkeypatch.delenv(name)
    assert not trial.verdict(INFO)[1]
    monkeypatch.setattr(trial, "process_limit", lambda name: 1 << 30)
    assert trial.verdict(INFO)[1] and "ulimit -v 1048576" in trial.circumstances()


def test_what_ends_a_trial_from_without_is_not_kept(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Somebody's SIGKILL, a full disk: this process asks no more, the next one does."""
    monkeypatch.setenv(cachefolder.VARIABLE, str(tmp_path))
    for said in ("(exit code -9)", "(exit code -15)", "(exit code 1: LLVM ERROR: File too large)"):
        fault = f"it ends the process {said}"
        monkeypatch.setattr(trial, "_unkept", {})
        monkeypatch.setattr(trial, "_tried", lambda info, fault=fault: fault)
        assert [trial.verdict(INFO), trial.verdict(INFO)] == [(fault, True), (fault, False)]
        assert not [*tmp_path.rglob("*.json")] and not trial.is_known_good(INFO)
        monkeypatch.setattr(trial, "_unkept", {})
        assert trial.verdict(INFO)[1]
    monkeypatch.setattr(trial, "_tried", lambda info: "")
    assert [trial.verdict(INFO, anew=True), trial.verdict(INFO)] == [("", True), ("", False)]


def test_what_is_kept_of_all_drivers_is_that_of_the_drivers_here(
    anew: None, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv(cachefolder.VARIABLE, str(tmp_path))
    monkeypatch.setenv("POCL_AFFINITY", "1")
    monkeypatch.setattr(trial, "_run", lambda what, _: tried.append(what) or "")
    folder, tried = tmp_path / "vendors", list[str]()
    folder.mkdir()
    for change in (None, ("OCL_ICD_VENDORS", str(folder)), ("OCL_ICD_FILENAMES", "x.so"), "a.icd"):
        if isinstance(change, tuple):
            monkeypatch.setenv(*change)
        elif change:
            (folder / change).write_text("liba.so")
        before = len(tried)
        for _ in range(2):
            trial.check_listing.cache_clear()
            trial.check_listing()
        assert len(tried) == before + 1, change


@pytest.mark.parametrize(
    ("fault", "kept"),
    [
        ("it ends the process (exit code -6)", False),
        ("a kernel of one line is not done after 120 s", False),
        ("error: unknown target CPU", True),
    ],
)
def test_a_bad_moment_is_forgotten_soon(
    fault: str, kept: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Under a narrow limit, or on a busy machine, a good driver fails its trial."""
    monkeypatch.setenv(cachefolder.VARIABLE, str(tmp_path))
    monkeypatch.setattr(trial, "_tried", lambda info: fault)
    trial.verdict(INFO)
    (file,) = (tmp_path / ".clrt" / "verdicts").iterdir()
    old = time.time() - 1000
    os.utime(file, (old, old))
    monkeypatch.setattr(trial, "_tried", lambda info: "")
    assert trial.verdict(INFO) == ((fault, False) if kept else ("", True))


def test_a_driver_that_ends_its_trial_is_refused_only_in_odd_circumstances(
    anew: None, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(trial, "verdict", lambda info: ("it ends the process (exit code -6)", True))
    monkeypatch.setattr(trial, "circumstances", list)
    assert clrt.devices() and platforms.choose(0)
    monkeypatch.setattr(trial, "circumstances", lambda: ["POCL_X=1"])
    with pytest.raises(clrt.DeviceError, match=r"ends the process .*; it may be due to POCL_X=1"):
        platforms.choose(0)


def fails_with(error: BaseException) -> Callable[[], None]:
    def fail() -> None:
        raise error

    return fail


@pytest.mark.parametrize(
    ("error", "says"),
    [
        (MemoryError(), "no memory left"),
        (OSError(errno.EMFILE, "x"), "ulimit -n"),
        (OSError(errno.ENFILE, "x"), "no more open files"),
        (OSError(errno.ENOMEM, "x"), "no memory left"),
        (BlockingIOError(errno.EAGAIN, "x"), "ulimit -u"),
        (RuntimeError("can't start new thread"), "ulimit -u"),
    ],
)
def test_what_the_machine_has_no_more_of_is_a_limit_error(error: Exception, says: str) -> None:
    with pytest.raises(clrt.LimitError, match=says):
        public(fails_with(error))()


def test_other_exceptions_pass() -> None:
    for error in (OSError(errno.EIO, "x"), RuntimeError("x"), OSError("x")):
        with pytest.raises(type(error)) as raised:
            public(fails_with(error))()
        assert raised.value is error
    assert exhausted(ImportError("x.so: failed to map segment from shared object"))
    assert not exhausted(ImportError("no module")) and not exhausted(ValueError("too many open files"))


@pytest.mark.skipif(sys.platform != "linux", reason="elsewhere nobody looks for PoCL's linker")
@pytest.mark.usefixtures("hasty")
def test_without_a_linker_there_is_a_line_that_names_it_and_nothing_is_kept(tmp_path: Path) -> None:
    """PoCL ended the process at the first kernel that it had not kept. Where nothing was kept, a refusal was,
    for a day, and other processes, with a linker, got it."""
    scene, empty = ["hash", "scene.json", "--width", "8"], tmp_path / "empty"
    empty.mkdir()
    for cache in ("warm", "cold"):
        variables = {"POCL_CACHE_DIR": "", "XDG_CACHE_HOME": str(tmp_path / cache)}
        if cache == "warm":
            assert command(tmp_path, *scene, **variables).returncode == 0
        done = subprocess.run(
            [sys.executable, "-m", "clrt", "hash", "showcase", "--width", "8"],
            cwd=tmp_path, env={**os.environ, **variables, "PATH": str(empty)},
            capture_output=True, text=True, timeout=120, check=False,
        )  # fmt: skip
        if done.returncode:  # a driver that needs none, as Intel's, goes on
            assert done.returncode == 2 and "no ld, with which PoCL links kernels, in PATH" in done.stderr
        assert command(tmp_path, *scene, **variables).returncode == 0


@pytest.mark.skipif(sys.platform != "linux", reason="elsewhere nobody looks for PoCL's linker")
def test_a_missing_linker_is_a_circumstance(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Whatever driver is here: the process above goes on where that needs none."""
    monkeypatch.setenv(cachefolder.VARIABLE, str(tmp_path))
    assert not [odd for odd in trial.circumstances() if odd.startswith("no ld")]
    there = trial._file("a driver")
    for path in (str(tmp_path), None):
        if path is None:
            monkeypatch.delenv("PATH")  # PoCL then finds none, though a shell would
        else:
            monkeypatch.setenv("PATH", path)
        assert "it may be due to no ld, with which PoCL" in trial.broken("it ends the process")
        assert trial._file("a driver") != there, "what is found out here is kept by itself"
