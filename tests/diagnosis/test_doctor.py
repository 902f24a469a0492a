"""`clrt doctor` where something is wrong: it says so, and what mends it; the errors say the same."""

from __future__ import annotations

import json
import os
import shlex
import subprocess
import sys
import types
from pathlib import Path
from typing import Any

import pytest

import clrt
from clrt.base.install import install_extra
from clrt.cli import main
from clrt.device import cachefolder, kernelcache, platforms, trial, vendors
from clrt.device.platforms import devices
from clrt.diagnosis import doctor

NOWHERE = "/proc/none"  # not even root can make a folder there


def doctors(**environment: str) -> tuple[int, list[dict[str, Any]]]:
    """Exit code and findings of `clrt doctor --json` in a changed environment."""
    done = subprocess.run(
        [sys.executable, "-m", "clrt", "doctor", "--json"],
        env={**os.environ, **environment}, capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.stderr == ""
    told = json.loads(done.stdout)
    assert told["wrong"] == sum(finding["state"] == "wrong" for finding in told["findings"])
    assert all(finding["mend"] for finding in told["findings"] if finding["state"] != "fine")
    return done.returncode, told["findings"]


def about(findings: list[dict[str, Any]], topic: str) -> list[dict[str, Any]]:
    return [finding for finding in findings if finding["topic"] == topic]


def test_nothing_is_wrong_here() -> None:
    code, findings = doctors()
    assert code == 0, findings
    assert about(findings, "devices")[0]["text"].startswith("0: ")
    (small,) = about(findings, "small render")
    assert "768 pixels in" in small["text"] and small["state"] == "fine"
    assert about(findings, "records")[0]["state"] == about(findings, "arithmetic")[0]["state"] == "fine"
    versions = {info.version for info in devices()}
    assert bool(about(findings, "speed")) == all(version.startswith("PoCL 3.0") for version in versions)


def test_the_plain_page_marks_what_is_wrong_and_says_what_to_do(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    good, bad = doctor.Finding("this", "fine", "is so"), doctor.Finding("that", "wrong", "is not", "mend it")
    odd = doctor.Finding("other", "advice", "may be", "try it")
    monkeypatch.setattr(doctor, "examine", lambda device: [good, bad, odd])
    assert main(["doctor"]) == 1
    out = capsys.readouterr().out.splitlines()
    assert out[:4] == ["  this   is so", "! that   is not", "         -> mend it", "? other  may be"]
    assert out[-1] == "1 fault (!); 1 piece of advice (?)"
    monkeypatch.setattr(doctor, "examine", lambda device: [good])
    assert main(["doctor"]) == 0
    assert capsys.readouterr().out.splitlines()[-1] == "nothing is wrong"


@pytest.mark.skipif(sys.platform != "linux", reason="drivers are found by files on Linux alone")
def test_a_folder_of_drivers_that_no_file_can_be_called(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("OCL_ICD_VENDORS", "a" * 300)
    assert "which is not there" in [finding.text for finding in doctor._drivers()][-1]


@pytest.mark.skipif(sys.platform != "linux", reason="drivers are found by files on Linux alone")
def test_no_driver(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "broken.icd").write_text("libnowhere.so\nmore\n")
    for wanted, says, mends in (
        (tmp_path / "missing", "which is not there", "unset OCL_ICD_VENDORS"),
        (tmp_path / "broken.icd", "libnowhere.so: cannot open shared object", str(tmp_path / "broken.icd")),
    ):
        monkeypatch.setenv("OCL_ICD_VENDORS", str(wanted))
        monkeypatch.delenv("CLRT_DRIVER", raising=False)  # it may ask for a driver that no file announces
        found = [finding for finding in doctor._drivers() if finding.topic == "driver files"]
        (files,) = [finding for finding in found if finding.state != "fine"]
        assert says in files.text and mends in files.mend
        (platform,) = doctor._device(None)
        assert (platform.topic, platform.state) == ("devices", "wrong")
        assert platform.mend == vendors.install_command()
        for part in ("no OpenCL platform", says, f"install a driver: {vendors.install_command()}"):
            assert part in platform.text  # the text of the error that a render gives
    monkeypatch.undo()
    code, _ = doctors(OCL_ICD_VENDORS=str(tmp_path / "missing"), CLRT_DRIVER="")
    assert code == 1


def test_a_variable_that_leaves_no_device(monkeypatch: pytest.MonkeyPatch) -> None:
    """No driver that could be installed helps; what it says does."""
    monkeypatch.delenv("CLRT_DEVICE", raising=False)
    platform = types.SimpleNamespace(get_devices=list, version="OpenCL 1.2", name="none")
    monkeypatch.setattr(platforms, "_platforms", lambda beside=True: [platform])
    for value in ("none", ""):
        monkeypatch.setenv("POCL_DEVICES", value)
        with pytest.raises(clrt.DeviceError, match="though there is a platform; unset POCL_DEV") as caught:
            clrt.Tracer(clrt.load_dict({"shapes": []}))
        (found,) = doctor._probed({"error": str(caught.value)})
        assert found.state == "wrong" and found.mend.startswith("unset POCL_DEVICES")
    monkeypatch.delenv("POCL_DEVICES")
    (found,) = doctor._probed({"error": platforms.NO_DEVICE})
    assert found.mend == vendors.install_command()


def test_no_driver_file_at_all(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("OCL_ICD_VENDORS", str(tmp_path))
    monkeypatch.setattr(vendors, "bundled_folder", lambda: None)
    assert vendors.why_none() == f"no driver is announced in {tmp_path}"
    monkeypatch.setattr(doctor, "_intel", lambda: iter(()))
    found = [finding for finding in doctor._drivers() if finding.topic == "driver files"]
    assert [(finding.state, finding.mend) for finding in found] == [("wrong", vendors.install_command())]


@pytest.mark.usefixtures("hasty")
def test_an_unwritable_kernel_cache_is_named_and_pictures_are_made_all_the_same() -> None:
    code, findings = doctors(POCL_CACHE_DIR=NOWHERE)
    (cache,) = about(findings, "kernel cache")
    assert code == 1 and NOWHERE in cache["text"] and "export POCL_CACHE_DIR=" in cache["mend"]
    assert about(findings, "small render")[0]["state"] == "fine"


def test_a_full_disk_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(kernelcache, "ROOM", 1 << 60)
    assert "is full" in kernelcache.problem(tmp_path)
    found = {finding.topic: finding.state for check in (doctor._cache, doctor._memory) for finding in check()}
    assert found["kernel cache"] == found["disk"] == "wrong"


def test_a_missing_llvm_is_advice(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("DRJIT_LIBLLVM_PATH", "/nowhere/libLLVM.so")
    (mitsuba,) = doctor._oracle()
    assert mitsuba.state == "advice"
    assert mitsuba.mend == install_extra("validation") and "only `clrt validate`" in mitsuba.text


def test_no_advice_removes_what_the_user_may_keep(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A folder that he chose may hold all he has; what a shell reads is one word, whatever its name."""
    monkeypatch.setattr(kernelcache, "_own", [])
    monkeypatch.setenv(cachefolder.VARIABLE, str(tmp_path))
    assert doctor._without_kernels() == "unset POCL_CACHE_DIR"
    monkeypatch.delenv(cachefolder.VARIABLE)
    monkeypatch.setattr(kernelcache, "user_cache_dir", lambda *_, **__: "/home/jane d'or/my cache")
    command, option, folder = shlex.split(doctor._without_kernels())
    assert (command, option) == ("rm", "-r") and folder.startswith("/home/jane d'or/my cache/kernels/")
    broken = vendors.Vendor(Path("/a b/c.icd"), "lib.so", "is broken")
    monkeypatch.setattr(vendors, "vendors", lambda: [broken])
    (mend,) = (found.mend for found in doctor._drivers() if "is broken" in found.text)
    assert mend.endswith("or: rm '/a b/c.icd'")


def test_a_driver_that_ends_the_process_or_never_answers(monkeypatch: pytest.MonkeyPatch) -> None:
    def ends(*_: Any, **__: Any) -> subprocess.CompletedProcess[str]:
        return subprocess.CompletedProcess([], -6, "", "LLVM ERROR: no space\nleft")

    monkeypatch.setattr(subprocess, "run", ends)
    (finding,) = doctor._device(None)
    assert finding.state == "wrong" and "SIGABRT" in finding.text
    assert finding.text.endswith("LLVM ERROR: no space left")
    assert finding.mend.startswith("rm -r ")

    def hangs(*_: Any, **__: Any) -> None:
        raise subprocess.TimeoutExpired("clrt.diagnosis.probe", 1)

    monkeypatch.setattr(subprocess, "run", hangs)
    (finding,) = doctor._device(None)
    assert finding.state == "wrong" and "not done after" in finding.text


def test_a_device_that_computes_otherwise_and_an_old_driver() -> None:
    told = {
        "devices": [{"index": 0, "label": "x", "kind": "CPU", "units": 2, "memory": 1 << 31, "used": True,
                     "fault": ""}],
        "checks": [{"name": "arithmetic", "passed": False, "detail": "a + b differs"}],
        "pixels": 1, "seconds": 1.0, "hash": "abc", "old_pocl": "too old",
    }  # fmt: skip
    found = {finding.topic: finding for finding in doctor._probed(told)}
    assert found["arithmetic"].state == "wrong" and "clrt devices" in found["arithmetic"].mend
    assert found["speed"].state == "advice" and "pocl-opencl-icd" in found["speed"].mend
    assert found["devices"].text == "0: x (CPU, 2 units, 2.0 GiB, used)"


def test_an_unknown_device_is_wrong(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["doctor", "--device", "Voodoo"]) == 1
    assert "! devices" in (out := capsys.readouterr().out) and "'Voodoo' is not here" in out


MENDED = {
    "CLRT_KERNELS=/nonexist": "unset CLRT_KERNELS",
    "CLRT_DEVICE=99": "unset CLRT_DEVICE",
    "CLRT_DRIVER=nonsense": "unset CLRT_DRIVER",
}


@pytest.mark.parametrize("said", MENDED)
def test_what_was_asked_for_is_not_mended_by_another_driver(said: str) -> None:
    """It told to install hundreds of megabytes, which mended nothing."""
    code, found = doctors(**dict([said.split("=")]))
    assert [one["mend"] for one in found if one["state"] == "wrong"] == [MENDED[said]] and code == 1


@pytest.mark.parametrize(
    ("error", "mend"),
    [
        ("ulimit -v 1000000: OpenCL drivers end a process that may have so little", "ulimit -v unlimited"),
        ("x: it may be due to POCL_DEBUG=all, ulimit -n 30: change that", "unset POCL_DEBUG"),
        ("x: it may be due to ulimit -n 30: change that", "ulimit -n unlimited"),
        ("x: it may be due to no /sys/devices/system/cpu: change that", "mount /sys there, too"),
        ("x: it may be due to no ld, with which PoCL links, in PATH ('/x'): change that", "export PATH="),
        ("device 'x' is not here; this machine offers 0: y", "devices   (and choose one of them: --device)"),
    ],
)
def test_circumstances_are_mended_by_changing_them(
    error: str, mend: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("POCL_DEBUG", "all")
    monkeypatch.delenv("CLRT_DEVICE", raising=False)
    (found,) = doctor._probed({"error": error})
    assert mend in found.mend


def test_a_system_without_its_folder_of_processors_is_an_error(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    """In a sandbox without /sys PoCL's library ends the process."""
    assert not [odd for odd in trial.circumstances() if "/sys" in odd]
    monkeypatch.setattr(trial, "_PROCESSORS", str(tmp_path / "sys"))
    assert trial.broken("it ends the process").endswith(f"no {tmp_path / 'sys'}: change that")
