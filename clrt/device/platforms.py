"""The OpenCL devices of this machine, and the choice among them."""

from __future__ import annotations

import ctypes
import os
import re
import shutil
import sys
from collections.abc import Iterator
from contextlib import contextmanager, nullcontext, suppress
from functools import cache
from pathlib import Path
from typing import Final

from clrt.base import child, handlers, notices
from clrt.base.elsewhere import relative, within
from clrt.base.errors import DeviceError, show
from clrt.base.resources import PACKAGE
from clrt.device import intel, kernelcache, trial
from clrt.device.harmful import left_out
from clrt.device.info import DeviceInfo
from clrt.device.opencl import cl
from clrt.device.vendors import PLACES, install_command, why_none
from clrt.device.vendors import VARIABLE as VENDORS

VARIABLE: Final = "CLRT_DRIVER"
_process: list[int] = []  # the one that first asked for platforms


def listed(beside: bool = True) -> list[tuple[DeviceInfo, cl.Device]]:
    """Every device with what is known of it. DeviceError when there is no driver.

    beside: also those of Intel's runtime beside clrt, which are the last, and take a while to load.
    """
    check_process()
    kernelcache.prepare()  # PoCL looks at its folder once, now
    found: list[tuple[DeviceInfo, cl.Device]] = []
    for platform in _platforms(beside):
        version = _short_version(platform.version)
        for device in _devices_of(platform):
            info = DeviceInfo(
                len(found), device.name.strip(), platform.name.strip(), version, _kind(device),
                device.max_compute_units, device.global_mem_size, device.driver_version.strip(),
            )  # fmt: skip
            found.append((info, device))
    return found


@contextmanager
def starting() -> Iterator[None]:
    """Let a driver start something: in a folder of ours, unless the user names places from here."""
    with handlers.kept(), nullcontext() if relative(*PLACES) else within(PACKAGE):
        yield


def _platforms(beside: bool = True) -> list[cl.Platform]:
    """The platforms that the loader finds, then Intel's beside clrt; of CLRT_DRIVER's driver only."""
    wanted = os.environ.get(VARIABLE, "").strip().lower()
    with starting():
        try:
            with left_out():
                found, error = cl.get_platforms(), ""
        except cl.Error as refused:
            found, error = [], f" ({refused})"
        if not _process:
            _process.append(os.getpid())
            if hasattr(os, "register_at_fork"):
                os.register_at_fork(after_in_child=_leave_out_drivers)
        if beside and _intel_wanted() and all(platform.name.strip() != intel.PLATFORM for platform in found):
            found = [*found, *intel.platforms()]
    if not found:
        raise DeviceError(f"no OpenCL platform{error}: {why_none()}; install a driver: {mending()}")
    names = [f"{platform.name.strip()} {_short_version(platform.version)}" for platform in found]
    chosen = [one for one, name in zip(found, names, strict=True) if wanted in name.lower()]
    if not chosen:
        raise DeviceError(
            f"{VARIABLE}={os.environ[VARIABLE]!r} is no driver here; there is {', '.join(names)}; unset it, "
            "or give a part of one of these names"
        )
    return chosen


def _leave_out_drivers() -> None:
    """End a forked process before drivers end themselves in it: they would wait for threads it has not."""
    libc = ctypes.CDLL(None)
    if hasattr(libc, "on_exit"):  # not where the C library is another than GNU's
        libc.on_exit(ctypes.cast(libc._exit, ctypes.c_void_p), None)


def _intel_wanted() -> bool:
    """Whoever names the drivers to load does not ask for another one, unless by its name."""
    wanted = os.environ.get(VARIABLE, "").strip().lower()
    return wanted in intel.PLATFORM.lower() if wanted else not os.environ.get(VENDORS)


def _kind(device: cl.Device) -> str:
    if device.type & cl.device_type.CPU:
        return "CPU"
    return "GPU" if device.type & cl.device_type.GPU else "other"


def _devices_of(platform: cl.Platform) -> list[cl.Device]:
    with handlers.kept():
        try:
            return platform.get_devices()
        except cl.Error:  # how some drivers say that they have none
            return []


def _short_version(version: str) -> str:
    """'OpenCL 3.0 PoCL 3.1+debian  Linux, ...' -> 'PoCL 3.1+debian'; other drivers: the whole text."""
    match = re.search(r"PoCL [\w.+-]+", version)
    return match.group(0) if match else version.strip()


def devices() -> list[DeviceInfo]:
    """The OpenCL devices of this machine. DeviceError when there is no OpenCL platform."""
    check_process()
    kernelcache.prepare()
    trial.check_listing()
    return [info for info, _ in listed()]


def is_forked() -> bool:
    """Whether this process was forked after OpenCL was used."""
    return bool(_process) and _process[0] != os.getpid()


def check_process() -> None:
    """DeviceError in a process that was forked after OpenCL was used: drivers wait there for ever."""
    if is_forked():
        raise DeviceError(
            "this process was forked from one that had used OpenCL, which drivers do not survive; start it "
            "afresh: multiprocessing.get_context('spawn'), or ProcessPoolExecutor(mp_context=...) with it"
        )


def pocl_version(info: DeviceInfo) -> tuple[int, ...]:
    """(3, 1) for PoCL 3.1; () for other drivers."""
    return _pocl_version(info.version)


@cache  # asked for after each launch
def _pocl_version(version: str) -> tuple[int, ...]:
    match = re.search(r"PoCL (\d+)\.(\d+)", version)
    return tuple(int(part) for part in match.groups()) if match else ()


def choose(wanted: int | str | None = None) -> tuple[DeviceInfo, cl.Device]:
    """The device that `wanted` means: a number, a part of "platform version / name", or None.

    None looks at the environment variable CLRT_DEVICE, then takes the newest PoCL, else the first device; one
    that fails its trial (`clrt.device.trial`) is passed over with a warning. DeviceError lists what there is.
    """
    check_process()
    kernelcache.prepare()  # where the trial's verdict is kept
    trial.check_listing()
    if wanted is None:
        wanted = os.environ.get("CLRT_DEVICE") or None
    soon = _chosen_soon(wanted)
    if soon:
        return soon
    found = listed()
    if wanted is None:
        return _default(found)
    text = str(wanted).strip()
    matches = _matching(text, found)
    if not matches:
        offered = "; ".join(f"{info.index}: {info.label}" for info, _ in found) or "nothing"
        raise DeviceError(
            f"device {text!r} is not here; this machine offers {offered}; choose with --device, device= or "
            f"CLRT_DEVICE, or find out why it is not seen: {command('doctor')}"
        )
    _check_here(matches[0][0])
    return matches[0]


Entry = tuple[DeviceInfo, cl.Device]
NO_DEVICE: Final = "no OpenCL device, though there is a platform"
_POCLS: Final = "POCL_DEVICES"


def _matching(text: str, found: list[Entry]) -> list[Entry]:
    """Those whose number is `text`, else those whose label has it."""
    numbered = [entry for entry in found if text == str(entry[0].index)]
    return numbered or [entry for entry in found if text.lower() in entry[0].label.lower()]


def _chosen_soon(wanted: int | str | None) -> Entry | None:
    """What `choose` gives, where that is known without the runtime beside clrt; None where it is not."""
    if os.environ.get(VARIABLE):
        return None
    with suppress(DeviceError):
        found = listed(beside=False)
        text = "" if wanted is None else str(wanted).strip()
        if wanted is None and found:
            best = max(found, key=_rank)
            return best if pocl_version(best[0]) and trial.is_known_good(best[0]) else None
        matches = [] if text.isdecimal() else _matching(text, found)
        if matches:
            _check_here(matches[0][0])
            return matches[0]
    return None


def _rank(entry: Entry) -> tuple[tuple[int, ...], int]:
    return pocl_version(entry[0]), -entry[0].index


def _check_here(info: DeviceInfo) -> None:
    """DeviceError where the driver of a device ends a process like this one, which asks for the unusual."""
    if trial.circumstances():
        fault = trial.verdict(info)[0]
        if trial.ended(fault):
            raise DeviceError(trial.broken(f"{info.label}: {fault}"))


def _default(found: list[tuple[DeviceInfo, cl.Device]]) -> tuple[DeviceInfo, cl.Device]:
    ranked = sorted(found, key=_rank, reverse=True)
    if not ranked:
        raise DeviceError(f"{NO_DEVICE}; {unhiding() or f'install a driver: {mending()}'}")
    if len(ranked) == 1:  # there is nothing to choose; what is wrong with it comes out when it builds kernels
        _check_here(ranked[0][0])
        return ranked[0]
    faults, ended = [], True
    for info, device in ranked:
        fault, tried = trial.verdict(info)
        if not fault:
            return info, device
        ended = ended and trial.ended(fault)
        faults.append(f"{info.label}: {fault}")
        if tried:
            notices.warn("", "", f"{faults[-1]}; another driver is used")
    text = f"no driver works here: {'; '.join(faults)}"
    if ended and trial.circumstances():
        raise DeviceError(trial.broken(text))
    raise DeviceError(f"{text}; what mends it: {mending(faults[0])}")


def unhiding() -> str:
    """What to type where a variable may be why a platform has no devices; '' where none is set."""
    said = os.environ.get(_POCLS)
    return "" if said is None else f"unset {_POCLS}   (it is {show(said)}, and says which devices PoCL has)"


def mending(fault: str = "") -> str:
    """What to type for a driver that works here, given what is wrong with those that are listed."""
    if fault and not _intel_wanted() and intel.library():
        return f"export {VARIABLE}=intel   (Intel's runtime is installed, and kept out)"
    return install_command(fault)


def command(name: str) -> str:
    """How a command of clrt is typed here: its script may not be on the PATH."""
    script = shutil.which("clrt")
    here = script and Path(script).absolute().parent == Path(sys.executable).absolute().parent
    return f"clrt {name}" if here else f"{child.interpreter() or 'python'} -m clrt {name}"
