"""The machine that times are of, and which of its cores this process may use."""

from __future__ import annotations

import os
import platform
import re
import resource
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Final

from clrt.device.device import Device
from clrt.version import __version__


def facts(device: Device) -> dict[str, Any]:
    """What times depend on, for the report."""
    return {
        "processor": processor_name(),
        "kind": processor_kind(),
        "cores": os.cpu_count(),
        "memory_bytes": os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES"),
        "system": platform.platform(),
        "python": platform.python_version(),
        "clrt": __version__,
        "device": device.info.label,
        "kernels": device.kernels.hash[:12],
    }


def processor_name() -> str:
    """The processor's own name where Linux tells it, and its widest vector unit."""
    try:
        text = Path("/proc/cpuinfo").read_text("utf-8", "replace")
    except OSError:
        return platform.processor() or platform.machine()
    name = re.search(r"model name\s*: (.*)", text)
    widest = next((unit for unit in ("avx512f", "avx2", "avx", "asimd") if f" {unit}" in text), "")
    return f"{name.group(1) if name else platform.machine()} {widest}".strip()


# by maker, family, and whether there is AVX-512, for two generations share a family
_FAMILIES: Final = {
    ("AuthenticAMD", 25, False): "Zen 3", ("AuthenticAMD", 25, True): "Zen 4",
    ("AuthenticAMD", 26, True): "Zen 5",
}  # fmt: skip


def processor_kind() -> str:
    """The processor's maker and family, by which figures are kept apart: "AuthenticAMD 26 (Zen 5)"."""
    try:
        text = Path("/proc/cpuinfo").read_text("utf-8", "replace")
    except OSError:
        return platform.processor() or platform.machine()
    maker, family = (re.search(rf"{name}\s*: (\S+)", text) for name in ("vendor_id", "cpu family"))
    if not maker or not family:
        return platform.machine()
    known = _FAMILIES.get((maker.group(1), int(family.group(1)), " avx512f" in text), "")
    return f"{maker.group(1)} {family.group(1)}" + (f" ({known})" if known else "")


def load() -> float:
    """Processes that wanted to run, over the last minute; nan where the system does not say."""
    try:
        return os.getloadavg()[0]
    except OSError:
        return float("nan")


def peak_bytes() -> int:
    """The most memory this process has held. (`ru_maxrss` would count what its parent held at the start.)"""
    try:
        found = re.search(r"VmHWM:\s*(\d+) kB", Path("/proc/self/status").read_text("utf-8", "replace"))
    except OSError:
        found = None
    if found:
        return int(found.group(1)) << 10
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss << (0 if sys.platform == "darwin" else 10)


@contextmanager
def one_core() -> Iterator[None]:
    """Keep all threads of this process, the driver's too, on one core, where the system can do that."""
    if not hasattr(os, "sched_setaffinity"):
        yield
        return
    before = os.sched_getaffinity(0)
    _move_threads({max(before)})
    try:
        yield
    finally:
        _move_threads(before)


def _move_threads(cores: set[int]) -> None:
    for task in Path("/proc/self/task").iterdir():
        try:
            os.sched_setaffinity(int(task.name), cores)
        except ProcessLookupError:  # has ended since
            continue
