"""What a fault leaves for the people who write the driver: a folder that shows it without clrt.

    report.json     kernel, work-item, bits, build options, driver, machine
    kernels.cl      the whole program
    inputs.npz      what the kernel was given: buffers as uint32, numbers
    reproduce.py    builds, runs and compares; needs pyopencl and numpy; exits with 1 where the bits differ
"""

from __future__ import annotations

import json
import platform
import re
from pathlib import Path
from typing import Any, Final

import numpy as np

from clrt.base.atomic import replacing
from clrt.base.errors import ClrtError
from clrt.device import intel
from clrt.device.device import Device
from clrt.device.opencl import cl
from clrt.version import __version__

from .blame import Fault
from .watch import Launch

_TEMPLATE: Final = Path(__file__).with_name("reproduce.txt")


def check_folder(folder: Path) -> None:
    """ClrtError where bundles cannot be put into `folder`: it must be new or empty."""
    try:
        if folder.exists() and (not folder.is_dir() or any(folder.iterdir())):
            raise ClrtError(f"{folder}: is not empty; a bundle needs a folder of its own")
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise ClrtError(f"{folder}: cannot be made: {error.strerror or error}") from None


def write_bundle(folder: Path, check: str, detail: str, device: Device, fault: Fault | None) -> Path:
    """Write what is known of a check that failed into a folder of its own, in `folder`."""
    place = folder / (re.sub(r"[^a-z0-9]+", "-", check.lower()).strip("-") or "check")
    try:
        place.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise ClrtError(f"{place}: cannot be made: {error.strerror or error}") from None
    report: dict[str, Any] = {"check": check, "detail": detail, **about(device)}
    if fault is not None:
        launch, item = fault.launch, first_item(device, fault)
        report |= {
            "kernel": fault.kernel, "pass": fault.where, "build options": launch.options,
            "work-items": launch.items, "work-group": launch.local, "first work-item": item,
        }  # fmt: skip
        _text(place / "kernels.cl", device.driver.given(launch.source))
        _inputs(place / "inputs.npz", launch)
        if fault.argument is not None:
            assert fault.word is not None
            name = launch.names[fault.argument]
            report |= {
                "argument": name, "word": fault.word,
                "expected": f"{fault.expected:#010x}", "found": f"{fault.found:#010x}",
                "as float": [_as_float(fault.expected), _as_float(fault.found)],
                "shown by reproduce.py": replayed(device, fault) != fault.expected,
            }  # fmt: skip
            title = f"Kernel {fault.kernel}: a value that is not what IEEE 754 arithmetic gives."
            template = _TEMPLATE.read_text(encoding="utf-8")
            _text(place / "reproduce.py", template.format(
                title=title, version=__version__, kernel=fault.kernel, options=launch.options,
                items=launch.items, local=launch.local, argument=fault.argument, word=fault.word,
                name=name, item=item, expected=fault.expected, found=fault.found, label=device.info.label,
                platform=str(device.driver.device.platform.version), count=len(launch.before),
                library=_library(device),
            ))  # fmt: skip
    _text(place / "report.json", json.dumps(report, indent=1) + "\n")
    return place


def _library(device: Device) -> str | None:
    """Of a driver that clrt found where no loader looks."""
    found = intel.library() if device.info.platform == intel.PLATFORM else None
    return None if found is None else str(found)


def about(device: Device) -> dict[str, str]:
    """The driver and the machine, as people ask for them."""
    info = device.info
    return {
        "device": info.label, "driver": info.driver, "OpenCL": info.version, "clrt": __version__,
        "pyopencl": str(cl.VERSION_TEXT), "python": platform.python_version(), "system": platform.platform(),
    }  # fmt: skip


def replayed(device: Device, fault: Fault, items: int | None = None) -> int:
    """The word's bits after the kernel ran again, alone, on what it was given; with fewer work-items."""
    launch = fault.launch
    assert fault.argument is not None and fault.word is not None
    flags = cl.mem_flags.READ_WRITE | cl.mem_flags.COPY_HOST_PTR
    context = device.driver.context
    arguments = [
        cl.Buffer(context, flags, hostbuf=value.copy()) if isinstance(value, np.ndarray) else value
        for value in launch.before
    ]
    kernel = cl.Kernel(device.driver.build(launch.source), launch.kernel)
    kernel.set_args(*arguments)
    local = None if launch.local is None else (launch.local,)
    cl.enqueue_nd_range_kernel(device.queue, kernel, (items or launch.items,), local)
    out = np.empty_like(launch.before[fault.argument])
    return int(device.read(arguments[fault.argument], out)[fault.word])


def first_item(device: Device, fault: Fault) -> int | None:
    """The work-item that wrote the word, or the first of its work-group; None where that cannot be told.

    Without it, and all after it, the word stays as it was: found by halving.
    """
    launch = fault.launch
    if fault.item is not None or fault.argument is None or fault.word is None or launch.local is None:
        return fault.item
    before = int(launch.before[fault.argument][fault.word])
    if before == fault.found or replayed(device, fault) != fault.found:
        return None
    least, most = 0, launch.items // launch.local  # groups without and with which it is written
    while most - least > 1:
        middle = (least + most) // 2
        wrote = replayed(device, fault, middle * launch.local) == fault.found
        least, most = (least, middle) if wrote else (middle, most)
    return least * launch.local


def _inputs(path: Path, launch: Launch) -> None:
    given = {f"argument_{number}": value for number, value in enumerate(launch.before) if value is not None}
    with replacing(path) as temporary:
        np.savez_compressed(temporary, **given)


def _text(path: Path, text: str) -> None:
    with replacing(path) as temporary:
        temporary.write_text(text, encoding="utf-8")


def _as_float(bits: int) -> str:
    return float(np.array(bits, np.uint32).view(np.float32)).hex()
