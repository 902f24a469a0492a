"""Drivers that build nothing are passed over, Intel's runtime is found where it lies; all of it is said."""

from __future__ import annotations

import json
import os
import shlex
import subprocess
import sys
from pathlib import Path

import pytest

from clrt.device import added, binaries, intel, platforms, trial, vendors
from clrt.device.opencl import cl

ROOT = Path(__file__).resolve().parents[2]
BROKEN = ROOT / "tests" / "broken_driver"
SCENE = {
    "camera": {"origin": [0, 1, 4], "target": [0, 0, 0], "width": 32, "height": 24},
    "lights": [{"type": "point", "position": [3, 5, 4]}],
    "shapes": [{"type": "sphere", "center": [0, 0, 0], "radius": 1}],
}
WHY = "its compiler is older than this processor and builds nothing for it (unknown target CPU)"


@pytest.fixture
def scene(tmp_path: Path) -> Path:
    file = tmp_path / "scene.json"
    file.write_text(json.dumps(SCENE))
    return file


def beside_a_broken_driver(cache: Path, *arguments: str, **more: str) -> subprocess.CompletedProcess[str]:
    """A command in a process in which the newest PoCL is one that builds nothing."""
    environment = {**os.environ, "PYTHONPATH": f"{ROOT}{os.pathsep}{BROKEN}", "XDG_CACHE_HOME": str(cache)}
    for name in ("CLRT_DEVICE", "POCL_CACHE_DIR"):
        environment.pop(name, None)
    # the real driver that the tests run on: the broken one takes its name where that is PoCL
    return subprocess.run(
        [sys.executable, "-m", "clrt", *arguments], env={**environment, "CLRT_DRIVER": "", **more},
        capture_output=True, text=True, check=False,
    )  # fmt: skip


@pytest.mark.usefixtures("hasty")
def test_a_driver_that_builds_nothing_is_passed_over_and_named_once(tmp_path: Path, scene: Path) -> None:
    picture = tmp_path / "picture.png"
    first = beside_a_broken_driver(tmp_path, "render", str(scene), "-o", str(picture))
    assert first.returncode == 0 and picture.exists()
    warnings = [line for line in first.stderr.splitlines() if "PoCL 99.0" in line]
    assert warnings == [
        f"clrt: warning: Portable Computing Language PoCL 99.0 / old: {WHY}; another driver is used"
    ]
    again = beside_a_broken_driver(tmp_path, "render", str(scene), "-o", str(picture))
    assert again.returncode == 0 and "PoCL 99.0" not in again.stderr  # the verdict is kept
    listing = beside_a_broken_driver(tmp_path, "devices")
    lines = listing.stdout.splitlines()
    assert lines[0].startswith("  0  ") and lines[0].endswith(f" does not work: {WHY}")
    assert sum(line.startswith("* ") for line in lines) == 1 and listing.returncode == 0
    forced = beside_a_broken_driver(tmp_path, "render", str(scene), "-o", str(picture), "--device", "0")
    assert forced.returncode == 2 and forced.stderr.count("\n") == 1
    assert "the kernels do not build" in forced.stderr and WHY in forced.stderr and "0x" not in forced.stderr


def test_where_no_driver_works_the_doctor_says_so_and_what_to_type(tmp_path: Path, scene: Path) -> None:
    alone = {"BROKEN_ALONE": "1", "CLRT_DRIVER": "pocl"}
    done = beside_a_broken_driver(tmp_path, "doctor", "--json", **alone)
    told = json.loads(done.stdout)["findings"]
    wrong = [finding for finding in told if finding["state"] == "wrong"]
    assert done.returncode == 1 and wrong and all(WHY in finding["text"] for finding in wrong)
    kept_out = intel.library() is not None
    for finding in wrong:
        if kept_out:
            assert finding["mend"].startswith("export CLRT_DRIVER=intel")
        else:
            assert finding["mend"] == vendors.install_command(WHY)
    # do what it says: where Intel's runtime is there, or installed, the same command works
    refused = beside_a_broken_driver(tmp_path, "render", str(scene), "-o", str(tmp_path / "a.png"), **alone)
    command = refused.stderr.rsplit("says: ", 1)[1].strip()
    assert shlex.split(command)[-1] == "doctor"
    asked = subprocess.run([*shlex.split(command), "--help"], capture_output=True, check=False)
    assert asked.returncode == 0
    if kept_out:
        mended = beside_a_broken_driver(
            tmp_path, "render", str(scene), "-o", str(tmp_path / "a.png"), CLRT_DRIVER="intel"
        )
        assert mended.returncode == 0, mended.stderr


def test_the_driver_asked_for_is_the_only_one(monkeypatch: pytest.MonkeyPatch) -> None:
    here = platforms.devices()
    name = here[0].platform
    monkeypatch.setenv("CLRT_DRIVER", name.upper())
    assert {info.platform for info in platforms.devices()} == {name}
    monkeypatch.setenv("CLRT_DRIVER", "voodoo")
    with pytest.raises(platforms.DeviceError, match=r"='voodoo' is no driver here; there is .*unset"):
        platforms.devices()


def test_a_library_is_asked_for_its_platform_without_a_loader(monkeypatch: pytest.MonkeyPatch) -> None:
    """On any driver's library, as for Intel's; what the process sees otherwise stays as it was."""
    before = [platform.int_ptr for platform in cl.get_platforms()]
    own = intel.library()
    libraries = [own] if own else [Path(one.library) for one in vendors.vendors() if not one.fault]
    assert libraries
    found = []
    for library in libraries:
        monkeypatch.setattr(intel, "library", lambda library=library: library)
        intel.platforms.cache_clear()
        found += [platform.name.strip() for platform in intel.platforms()]
    intel.platforms.cache_clear()
    assert intel.PLATFORM in found if own else "Portable Computing Language" in found
    assert [platform.int_ptr for platform in cl.get_platforms()] == before


def test_a_library_that_is_none_gives_no_platform(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for content in (b"", b"not a library"):
        file = tmp_path / "libintelocl.so"
        file.write_bytes(content)
        monkeypatch.setattr(intel, "library", lambda file=file: file)
        intel.platforms.cache_clear()
        assert intel.platforms() == ()
    intel.platforms.cache_clear()


def test_intel_is_kept_out_where_drivers_are_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(intel, "library", lambda: Path("/somewhere"))
    for driver, files, wanted in (
        ("", "", True), ("", "/etc/OpenCL/vendors", False), ("pocl", "", False), ("intel", "/x.icd", True),
    ):  # fmt: skip
        monkeypatch.setenv("CLRT_DRIVER", driver)
        monkeypatch.setenv("OCL_ICD_VENDORS", files)
        assert platforms._intel_wanted() is wanted
        assert platforms.mending("it is old").startswith("export CLRT_DRIVER=intel") is not wanted


@pytest.mark.parametrize("name", added._VARIABLES)
def test_programs_compiled_for_another_processor_are_not_taken(
    name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Intel's runtime compiles for what a variable says."""
    device = platforms.choose()[1]
    monkeypatch.delenv(name, raising=False)
    usual = binaries._place(device, "", [])
    monkeypatch.setenv(name, "core-avx2")
    assert binaries._place(device, "", []) != usual


def test_a_verdict_is_kept_by_driver_and_processor_and_a_bad_one_for_a_day(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("POCL_CACHE_DIR", str(tmp_path))
    tried: list[str] = []
    faults = {"label": "it is broken"}
    monkeypatch.setattr(trial, "_tried", lambda info: tried.append(info.driver) or faults["label"])
    info = platforms.DeviceInfo(0, "name", "platform", "1.0", "CPU", 2, 1 << 30, "7")
    assert trial.verdict(info) == ("it is broken", True)
    assert trial.verdict(info) == ("it is broken", False)
    assert trial.verdict(info, anew=True) == ("it is broken", True)
    for other in ({"driver": "8"}, {"version": "2.0"}, {"name": "other"}):
        assert trial.verdict(platforms.DeviceInfo(**{**vars(info), **other}))[1]
    monkeypatch.setattr(trial, "signature", lambda: "another processor")
    assert trial.verdict(info)[1]
    file = trial._file(f"{info.label}\0{info.driver}")
    assert file in (tmp_path / ".clrt" / "verdicts").iterdir()
    faults["label"] = ""
    os.utime(file, (0, 0))
    assert trial.verdict(info) == ("", True)  # it was mended meanwhile
    os.utime(file, (0, 0))
    assert trial.verdict(info) == ("", False)
    for damage in (b"", b"[", b"[]", b"\xff\xfe", b'{"device": 1}', b"[" * 60_000, b" " * (1 << 24)):
        file.write_bytes(damage)
        assert trial.verdict(info) == ("", True)
    file.unlink()
    os.mkfifo(file)
    assert trial.verdict(info) == ("", True)


@pytest.mark.parametrize(
    ("code", "out", "told", "says"),
    [
        (1, "error: unknown target CPU 'generic'\n", trial.DONE, "error: unknown target CPU 'generic'"),
        (0, "", f"a driver's word\n{trial.DONE}\nits last", ""),
        (1, "", "ModuleNotFoundError: no pyopencl", None),
        (-6, "", "an assertion", "it ends the process (exit code -6: an assertion)"),
        (1, "", "LLVM ERROR: x", "it ends the process (exit code 1: LLVM ERROR: x)"),
        (1, "a driver's word", "", "it ends the process (exit code 1)"),
        (0, "", "", "it ends the process (exit code 0)"),
    ],
)
def test_how_a_trial_ends(
    code: int, out: str, told: str, says: str | None, monkeypatch: pytest.MonkeyPatch
) -> None:
    """What ends before it has said that it is done was ended by a driver, whatever the code."""
    ended = subprocess.CompletedProcess([], code, out.encode(), told.encode())
    monkeypatch.setattr(trial.subprocess, "run", lambda *_, **__: ended)
    assert trial._tried(platforms.DeviceInfo(0, "", "", "", "", 1, 1)) == says


def test_a_trial_that_hangs(monkeypatch: pytest.MonkeyPatch) -> None:
    def hangs(*_: object, **__: object) -> None:
        raise subprocess.TimeoutExpired("trial", trial.PATIENCE)

    monkeypatch.setattr(trial.subprocess, "run", hangs)
    assert "not done after 120 s" in trial._tried(platforms.DeviceInfo(0, "", "", "", "", 1, 1))


def test_plain_words() -> None:
    assert trial.plain("a\nerror: unknown target CPU 'generic'\nb") == WHY
    assert trial.plain("one\nx.cl:3: Error:  no such\ttype\nmore") == "x.cl:3: Error: no such type"
    assert trial.plain("\n\nonly this\n") == "only this"
    assert trial.plain("") == "it does not say why"
    assert len(trial.plain("error " * 1000)) <= 300
