"""What this machine offers for rendering, what is wrong with it, and the command that mends it.

Each check gives findings in plain words. What a driver does happens in a process of its own
(`clrt.diagnosis.probe`): a broken one may end it, or never come back.
"""

from __future__ import annotations

import importlib.metadata
import json
import os
import platform
import re
import shlex
import shutil
import subprocess
import sys
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final, Literal

from clrt.base import child
from clrt.base.errors import ClrtError, one_line
from clrt.base.install import install_extra, pip_install
from clrt.base.interrupts import ended_by
from clrt.base.limits import Limits
from clrt.base.resources import validation_module
from clrt.device import cachefolder, kernelcache, vendors
from clrt.version import __version__

State = Literal["fine", "advice", "wrong"]
PROBE_SECONDS: Final = 300.0  # kernels compile in half a minute where nothing is cached
_PACKAGES: Final = ("numpy", "pyopencl", "OpenImageIO", "msgspec", "rich", "trimesh", "mitsuba")
_GIB: Final = 1 << 30


@dataclass(frozen=True)
class Finding:
    """One fact. `mend` is what to type, or to do, where it is not fine."""

    topic: str
    state: State
    text: str
    mend: str = ""


def examine(device: int | str | None = None) -> list[Finding]:
    """All findings about this machine, and about one device: a number, a part of a name, or the default."""
    checks: tuple[Callable[[], Iterator[Finding]], ...] = (
        _versions,
        _drivers,
        lambda: _device(device),
        _cache,
        _memory,
        _oracle,
    )
    return [finding for check in checks for finding in check()]


def _versions() -> Iterator[Finding]:
    python = f"clrt {__version__}, Python {platform.python_version()}, {platform.platform(terse=True)}"
    yield Finding("version", "fine", f"{python}, {platform.machine()}")
    installed = []
    for name in _PACKAGES:
        try:
            installed.append(f"{name} {importlib.metadata.version(name)}")
        except importlib.metadata.PackageNotFoundError:
            continue
    yield Finding("packages", "fine", ", ".join(installed))


def _drivers() -> Iterator[Finding]:
    """The loader and the files that announce drivers; Linux has these only."""
    if sys.platform != "linux":
        return
    try:
        import pyopencl  # noqa: F401 - brings its loader
    except ImportError as error:
        yield Finding("OpenCL loader", "wrong", f"pyopencl does not load: {error}", pip_install("pyopencl"))
        return
    yield Finding("OpenCL loader", "fine", ", ".join(vendors.loaders()) or "none that has a name")
    wanted = os.environ.get(vendors.VARIABLE)
    if wanted and not os.path.exists(wanted):
        text = f"{vendors.VARIABLE} names {wanted}, which is not there: no driver is found"
        yield Finding("driver files", "wrong", text, f"unset {vendors.VARIABLE}")
        return
    found = vendors.vendors()
    if not found:
        yield Finding("driver files", "wrong", vendors.why_none(), vendors.install_command())
    yield from _intel()
    for vendor in found:
        if vendor.fault:
            text = f"{vendor.file} names {vendor.library or 'nothing'}: {vendor.fault}"
            # another driver may do: then this one is only in the way
            again = f"install that driver again, or: rm {_quoted(vendor.file)}"
            yield Finding("driver files", "advice", text, again)
        else:
            yield Finding("driver files", "fine", f"{vendor.file} names {vendor.library}")


def _intel() -> Iterator[Finding]:
    """Intel's runtime from PyPI, which no file announces."""
    from clrt.device import intel  # brings pyopencl

    file = intel.library()
    if file is None:
        return
    if intel.platforms():
        yield Finding("driver files", "fine", f"Intel's runtime: {file}")
    else:
        fault = vendors.load_fault(str(file)) or "it has no platform"
        again = vendors.install_command(fault)
        yield Finding("driver files", "advice", f"Intel's runtime: {file}: {fault}", again)


def _device(wanted: int | str | None) -> Iterator[Finding]:
    """What a small render on the device says."""
    if child.interpreter() is None:
        text = "not tried: this program is no Python that could be started in a process of its own"
        yield Finding("small render", "advice", text)
        return
    command = child.command("clrt.diagnosis.probe", *([] if wanted is None else [str(wanted)]))
    clean = _without_kernels()
    try:
        done = subprocess.run(
            command, capture_output=True, text=True, timeout=PROBE_SECONDS, check=False,
            env=child.environment(),
        )  # fmt: skip
    except subprocess.TimeoutExpired:
        text = f"a small picture is not done after {PROBE_SECONDS:.0f} s"
        yield Finding("small render", "wrong", text, f"{clean}   (then again: clrt doctor)")
        return
    try:
        told: dict[str, Any] = json.loads(done.stdout.splitlines()[-1])
    except (ValueError, IndexError):
        code = done.returncode
        ended = ended_by(code) if code < 0 else f"exit code {code}"
        text = f"the driver ended the process ({ended}): {one_line(done.stderr)[-300:] or 'without a word'}"
        yield Finding("small render", "wrong", text, f"{clean}   (the usual cause is a damaged kernel cache)")
        return
    yield from _probed(told)


def _without_kernels() -> str:
    """What to type so that no kept kernel is used. A folder that the user chose may hold all he has."""
    if kernelcache.given():
        return f"unset {cachefolder.VARIABLE}"
    return f"rm -r {_quoted(kernelcache.usual_folder())}"


def _quoted(file: str | os.PathLike[str]) -> str:
    return shlex.quote(os.fspath(file))


def _probed(told: dict[str, Any]) -> Iterator[Finding]:
    from clrt.device.platforms import NO_DEVICE, mending, unhiding

    odd = _unset(told.get("error", ""))
    for device in told.get("devices", []):
        mark = ", used" if device["used"] else ""
        memory = f"{device['memory'] / _GIB:.1f} GiB"
        kind = f"{device['kind']}, {device['units']} units, {memory}{mark}"
        text = f"{device['index']}: {device['label']} ({kind})"
        if not device["fault"]:
            yield Finding("devices", "fine", text)
        else:  # in the way only where no other device works
            mend = "clrt takes another device by itself" if told["works"] else odd or mending(text)
            state: State = "advice" if told["works"] else "wrong"
            yield Finding("devices", state, f"{text} does not work: {device['fault']}", mend)
    if "error" in told:
        mend = odd or mending(told["error"] if told.get("devices") else "")
        mend = (unhiding() if told["error"].startswith(NO_DEVICE) else "") or mend
        yield Finding("devices", "wrong", told["error"], mend)
        return
    for check in told["checks"]:
        if check["passed"]:
            yield Finding(check["name"], "fine", check["detail"])
        else:
            mend = "clrt devices   (and use another one: --device)"
            yield Finding(check["name"], "wrong", check["detail"], mend)
    text = f"{told['pixels']} pixels in {told['seconds']:.2f} s, hash {told['hash'][:16]}"
    yield Finding("small render", "fine", text)
    if told["old_pocl"]:
        yield Finding("speed", "advice", told["old_pocl"], "apt-get install pocl-opencl-icd   (Debian: 3.1)")


def _unset(error: str) -> str:
    """What to type where it is no driver's fault, but what was asked for or where it runs; '' elsewhere."""
    blamed = re.search(r"it may be due to (.*): change that", error)
    error = blamed.group(1) if blamed else error
    limit = re.match(r"ulimit -\w", error)
    if limit:
        return f"{limit.group()} unlimited"
    if error.startswith("no /sys"):
        return "mount /sys there, too   (bwrap --ro-bind /sys /sys; docker has it by itself)"
    if error.startswith("no ld"):
        return "export PATH=$PATH:/usr/bin   (where ld is; where it is missing: apt-get install binutils)"
    if error.startswith("device "):
        named = "CLRT_DEVICE" in os.environ and repr(os.environ["CLRT_DEVICE"]) in error
        return "unset CLRT_DEVICE" if named else "clrt devices   (and choose one of them: --device)"
    variable = re.match(r"[A-Z]+_[A-Z_]+(?=[:=])", error)
    return f"unset {variable.group()}" if variable and variable.group() in os.environ else ""


def _cache() -> Iterator[Finding]:
    folder = kernelcache.usual_folder()
    said = f" ({cachefolder.VARIABLE} says so)" if kernelcache.given() else ""
    fault = kernelcache.problem(folder)
    if fault:
        mend = f"export {cachefolder.VARIABLE}=FOLDER   (one that can be written to; or mend that one)"
        yield Finding("kernel cache", "wrong", f"{fault}: kernels are compiled anew in each run", mend)
        return
    # all versions' kernels, which stand side by side in clrt's own folder
    top = folder if kernelcache.given() else folder.parent
    sizes = [*cachefolder.regular_files(top)]
    text = f"{folder}{said}: {sum(sizes) / 1e6:.1f} MB in {len(sizes)} files"
    yield Finding("kernel cache", "fine", text)


def _memory() -> Iterator[Finding]:
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    yield Finding("processors", "fine", f"{cores} usable of {os.cpu_count()}")
    if "SC_AVPHYS_PAGES" in os.sysconf_names:
        page = os.sysconf("SC_PAGE_SIZE")
        free, total = page * os.sysconf("SC_AVPHYS_PAGES"), page * os.sysconf("SC_PHYS_PAGES")
        text = f"{total / _GIB:.1f} GiB, {free / _GIB:.1f} GiB of it unused"
        least = Limits().device_bytes
        if total < least:
            mend = "allow less: Settings(limits=Limits(device_bytes=...))"
            yield Finding("memory", "advice", f"{text}; a render may take {least / _GIB:.0f} GiB", mend)
        else:
            yield Finding("memory", "fine", text)
    free = shutil.disk_usage(Path.cwd()).free
    text = f"{free / _GIB:.1f} GiB free in {Path.cwd()}"
    if free > kernelcache.ROOM:
        yield Finding("disk", "fine", text)
    else:
        yield Finding("disk", "wrong", text, "make room, or save pictures elsewhere")


def _oracle() -> Iterator[Finding]:
    """Mitsuba and its LLVM, which `clrt validate` needs, and nothing else."""
    try:
        client = validation_module("oracle_mitsuba.client")
        with client.Mitsuba(install=pip_install) as mitsuba:
            reason = mitsuba.available()
            found = None if reason else mitsuba.versions()
    except (ClrtError, ImportError) as error:
        reason, found = one_line(str(error)), None
    if found is None:
        text = f"{reason}; only `clrt validate` needs it"
        yield Finding("Mitsuba", "advice", text, install_extra("validation"))
    else:
        yield Finding("Mitsuba", "fine", ", ".join(f"{name} {version}" for name, version in found.items()))
