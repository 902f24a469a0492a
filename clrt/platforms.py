"""The OpenCL devices of this machine, and the choice among them."""

from __future__ import annotations

import os
import re
from dataclasses import dataclass
from typing import Final

import pyopencl as cl

from clrt import kernelcache
from clrt.errors import DeviceError
from clrt.vendors import why_none

HOW_TO_INSTALL: Final = (
    "install a driver: pip install 'clrt[pocl]' (Linux, x86-64), or your system's "
    "(Debian: apt-get install pocl-opencl-icd); `clrt doctor` says what is wrong"
)
_process: list[int] = []  # the one that first asked for platforms


@dataclass(frozen=True)
class DeviceInfo:
    """One OpenCL device, as `clrt devices` lists it. `memory` is in bytes, `units` counts compute units."""

    index: int
    name: str
    platform: str
    version: str
    kind: str
    units: int
    memory: int

    @property
    def label(self) -> str:
        return f"{self.platform} {self.version} / {self.name}"


def _all_devices() -> list[tuple[DeviceInfo, cl.Device]]:
    check_process()
    kernelcache.prepare()  # PoCL looks at its folder once, now
    try:
        platforms = cl.get_platforms()
    except cl.Error as error:
        raise DeviceError(f"no OpenCL platform ({error}): {why_none()}; {HOW_TO_INSTALL}") from None
    if not _process:
        _process.append(os.getpid())
    found: list[tuple[DeviceInfo, cl.Device]] = []
    for platform in platforms:
        for device in _devices_of(platform):
            kind = (
                "CPU"
                if device.type & cl.device_type.CPU
                else "GPU"
                if device.type & cl.device_type.GPU
                else "other"
            )
            info = DeviceInfo(
                len(found),
                device.name.strip(),
                platform.name.strip(),
                _short_version(platform.version),
                kind,
                device.max_compute_units,
                device.global_mem_size,
            )
            found.append((info, device))
    return found


def _devices_of(platform: cl.Platform) -> list[cl.Device]:
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
    return [info for info, _ in _all_devices()]


def check_process() -> None:
    """DeviceError in a process that was forked after OpenCL was used: drivers wait there for ever."""
    if _process and _process[0] != os.getpid():
        raise DeviceError(
            "this process was forked from one that had used OpenCL, which drivers do not survive; start it "
            "afresh: multiprocessing.get_context('spawn'), or ProcessPoolExecutor(mp_context=...) with it"
        )


def pocl_version(info: DeviceInfo) -> tuple[int, ...]:
    match = re.search(r"PoCL (\d+)\.(\d+)", info.version)
    return tuple(int(part) for part in match.groups()) if match else ()


def choose(wanted: int | str | None = None) -> tuple[DeviceInfo, cl.Device]:
    """The device that `wanted` means: a number, a part of "platform version / name", or None.

    None looks at the environment variable CLRT_DEVICE, then takes the newest PoCL, then the first device.
    DeviceError lists what there is.
    """
    found = _all_devices()
    if wanted is None:
        wanted = os.environ.get("CLRT_DEVICE") or None
    if wanted is None:
        if not found:
            raise DeviceError(f"no OpenCL device, though there is a platform; {HOW_TO_INSTALL}")
        return max(found, key=lambda entry: (pocl_version(entry[0]), -entry[0].index))
    text = str(wanted).strip()
    matches = [entry for entry in found if text == str(entry[0].index)]
    matches = matches or [entry for entry in found if text.lower() in entry[0].label.lower()]
    if not matches:
        offered = "; ".join(f"{info.index}: {info.label}" for info, _ in found) or "nothing"
        raise DeviceError(
            f"device {text!r} is not here; this machine offers {offered}; choose with --device, device= or "
            "CLRT_DEVICE, or find out with `clrt doctor` why it is not seen"
        )
    return matches[0]
