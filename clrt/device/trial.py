"""Does a driver work here? One small kernel tells, in a process of its own, once a driver and processor.

A driver may list a device and build nothing for it (PoCL 3.0 on processors that its LLVM does not know), end
the process or hang: so it is tried in `clrt.device.attempt`, and its verdict is kept beside the
compiled kernels, under the driver, the processor and what this process has that may break it
(`circumstances`). A refusal holds for a day, what may have been a bad moment for ten minutes: a machine that
was busy or out of memory.
"""

from __future__ import annotations

import hashlib
import json
import os
import shutil
import subprocess
import sys
import time
from collections.abc import Callable, Mapping
from contextlib import suppress
from functools import cache
from pathlib import Path
from typing import Final

from clrt.base import child
from clrt.base.atomic import replacing
from clrt.base.errors import ClrtError, DeviceError, one_line, show
from clrt.base.room import process_limit
from clrt.device import cachefolder, vendors
from clrt.device.added import added
from clrt.device.info import DeviceInfo
from clrt.device.processor import signature

PATIENCE: Final = 120.0  # seconds: a busy machine takes 5
_LISTED: Final = 30.0  # seconds, in which drivers are loaded
_TRIAL: Final = "CLRT_TRIAL"
"""A variable of a trial's own process, which tries no further one."""
_DAY: Final = 24 * 3600
_MOMENT: Final = 600
_PROCESSORS: Final = "/sys/devices/system/cpu"
LISTING: Final = "listing"  # a trial of the drivers' start alone
DONE: Final = "clrt: the trial is done"  # a line of stderr: drivers may end a process with any exit code
# limit of a process -> option of `ulimit` and its unit, what is plenty, what is the least. With 0.6 GB of
# addresses or 14 files PoCL 3.1 ends the process, with 0.8 GB some of its builds fail; its largest file, a
# program, takes 2.4 MB, and where that is cut short it ends the process.
_LIMITS: Final = {
    "RLIMIT_AS": ("-v", 1 << 10, 4 << 30, 1 << 30),
    "RLIMIT_DATA": ("-d", 1 << 10, 4 << 30, 0),
    "RLIMIT_NOFILE": ("-n", 1, 64, 24),
    "RLIMIT_STACK": ("-s", 1 << 10, 1 << 20, 0),
    "RLIMIT_FSIZE": ("-f", 1 << 10, 64 << 20, 4 << 20),
}
# what ends a trial from without, and says nothing of the driver: signals that others send, a disk
_FROM_WITHOUT: Final = ("(exit code -9", "(exit code -15", "No space left", "File too large")
_LINKER: Final = "ld"
_unkept: Final[dict[Path, str]] = {}  # verdicts of this process alone
_UNKNOWN_PROCESSOR: Final = "unknown target CPU"
_ENDS: Final = "it ends the process"
_HANGS: Final = "a kernel of one line is not done"
_WAITS: Final = "it does not go on"
_LONGEST: Final = 300  # characters of a driver's log that a message shows


def circumstances() -> list[str]:
    """What this process has, or lacks, that may break a driver which works elsewhere.

    Variables, narrow limits, and a /sys or a linker that sandboxes leave out: PoCL's library then ends the
    process.
    """
    found = sorted(
        f"{name}={value}" for name, value in os.environ.items()
        if name.startswith("POCL_") and name != cachefolder.VARIABLE
    )  # fmt: skip
    for name, (option, unit, plenty, _) in _LIMITS.items():
        limit = process_limit(name)
        if limit < plenty:
            found.append(f"ulimit {option} {limit // unit:.0f}")
    if sys.platform == "linux" and not os.path.isdir(_PROCESSORS):
        found.append(f"no {_PROCESSORS}")
    path = os.environ.get("PATH", "")
    if sys.platform == "linux" and shutil.which(_LINKER, path=path) is None:
        found.append(f"no {_LINKER}, with which PoCL links kernels, in PATH ({show(path)})")
    return found


@cache
def check_listing() -> None:
    """DeviceError where drivers end a process like this one, many as soon as they are asked for devices.

    Once a process, and only where `circumstances` make that likely: it takes half a second.
    """
    for name, (option, unit, _, least) in _LIMITS.items():
        limit = process_limit(name)
        if limit < least:
            raise DeviceError(
                f"ulimit {option} {limit // unit:.0f}: OpenCL drivers end a process that may have so little; "
                f"allow at least {least // unit}"
            )
    if circumstances():
        fault = listing(vendors.announced())[0]
        if fault:
            raise DeviceError(broken(f"the OpenCL driver: {fault}"))


def listing(key: str, variables: Mapping[str, str] | None = None) -> tuple[str, bool]:
    """As `verdict`, of drivers' start in a process that has these variables, too."""
    return _verdict(key, LISTING, lambda: _run(LISTING, variables), anew=False)


def is_known_to_list(key: str) -> bool:
    """Whether drivers' start has gone well before."""
    return _kept(_file(key)) == ""


def is_listing() -> bool:
    """Whether this process is a trial of all drivers' start."""
    return os.environ.get(_TRIAL) == LISTING


def broken(fault: str) -> str:
    """What to say of a driver that breaks under the circumstances of this process."""
    odd = ", ".join(circumstances())
    return f"{fault}; it may be due to {odd}: change that" if odd else fault


def verdict(info: DeviceInfo, anew: bool = False) -> tuple[str, bool]:
    """What is wrong with a device ('' where nothing is), and whether it was tried just now.

    anew: try it whatever is known.
    """
    return _verdict(_key(info), info.label, lambda: _tried(info), anew)


def _key(info: DeviceInfo) -> str:
    return f"{info.label}\0{info.driver}"


def is_known_good(info: DeviceInfo) -> bool:
    """Whether a device has passed its trial before."""
    return _kept(_file(_key(info))) == ""


def kept_verdict(key: str, label: str, tried: Callable[[], str | None]) -> str:
    """What is wrong with a device ('' where nothing is) by another trial, kept as those of drivers are."""
    return _verdict(key, label, tried, anew=False)[0]


def _verdict(key: str, label: str, tried: Callable[[], str | None], anew: bool) -> tuple[str, bool]:
    """The verdict that is kept under a key, or that of a new trial; "" where there was none."""
    file = _file(key)
    known = None if anew else _unkept.get(file, _kept(file))
    if known is not None:
        return known, False
    fault = tried()
    _unkept.pop(file, None)
    if fault is None or any(sign in fault for sign in _FROM_WITHOUT):
        _unkept[file] = fault or ""
        return fault or "", True
    with suppress(OSError, ClrtError):  # it is tried again next time
        cachefolder.make(file.parent)
        with replacing(file, told=False) as temporary:
            temporary.write_text(json.dumps({"device": label, "fault": fault}), encoding="utf-8")
    return fault, True


def _kept(file: Path) -> str | None:
    """The verdict that a file holds; None where there is none that still counts."""
    with suppress(OSError, ValueError, TypeError, KeyError, RecursionError):
        age = time.time() - file.stat().st_mtime
        known = str(json.loads(cachefolder.contents(file))["fault"])
        if not known or 0 <= age < (_MOMENT if ended(known) else _DAY):
            return known
    return None


def ended(fault: str) -> bool:
    """Whether a driver ended or held up its trial, and did not just refuse: it may not do so again."""
    return fault.startswith((_ENDS, _HANGS, _WAITS))


def plain(text: str) -> str:
    """Why a driver builds nothing, in plain words, from what it said."""
    if _UNKNOWN_PROCESSOR in text:
        return f"its compiler is older than this processor and builds nothing for it ({_UNKNOWN_PROCESSOR})"
    lines = [" ".join(line.split()) for line in text.splitlines() if line.strip()]
    telling = [line for line in lines if "error" in line.lower()] or lines[-1:] or ["it does not say why"]
    return telling[0][:_LONGEST]


def _file(key: str) -> Path:
    parts = "\0".join((key, signature(), repr(added()), *circumstances()))
    name = hashlib.sha256(os.fsencode(parts)).hexdigest()[:32]
    return cachefolder.ours("verdicts", f"{name}.json")


def _tried(info: DeviceInfo) -> str | None:
    return _run(str(info.index))


def _run(what: str, variables: Mapping[str, str] | None = None) -> str | None:
    """What goes wrong in a trial; None where there was none, since no process gets as far as the driver."""
    if os.environ.get(_TRIAL):  # this is one, whatever was started
        return None
    patience = _LISTED if what == LISTING else PATIENCE
    try:
        done = subprocess.run(
            child.command("clrt.device.attempt", what),
            capture_output=True, timeout=patience, check=False, stdin=subprocess.DEVNULL,
            env=child.environment(**{_TRIAL: what, **(variables or {})}),
        )  # fmt: skip
    except subprocess.TimeoutExpired:
        return f"{_HANGS if what != LISTING else _WAITS} after {patience:.0f} s"
    except OSError:  # no process can be started here
        return None
    told = done.stderr.decode(errors="replace").strip().splitlines()
    if DONE in told:
        return done.stdout.decode(errors="replace").strip() if done.returncode else ""
    last = told[-1:]
    if done.returncode == 1 and last and last[0].startswith("ModuleNotFoundError"):
        return None
    why = f": {one_line(last[0])[-_LONGEST:]}" if last else ""
    return f"{_ENDS} (exit code {done.returncode}{why})"
