"""A process beside this one that compiles kernels for it (`clrt.device.compiler`), from the last on.

PoCL compiles a kernel when it is first launched, one at a time in a process: `showcase` waits for 22 of them,
one after the other. Two processes with one folder of kernels compile side by side, each kernel under its own
lock (`clrt.device.cachelock`), and meet in the middle.

Only a command of clrt starts one, and only where nobody has compiled its program before. Nobody waits for it
but for a kernel that it is compiling; where it cannot be started, fails or is ended, the other one compiles
all. It prints nothing, hears no Ctrl-C, and ends with the one that started it: its input is then at an end.
"""

from __future__ import annotations

import atexit
import json
import os
import subprocess
import sys
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import asdict
from typing import TYPE_CHECKING, Any, Final

from clrt.base import child, interrupts
from clrt.device import trial

if TYPE_CHECKING:
    from clrt import layout
    from clrt.device.settings import Settings

_SETTINGS: Final = ("threads", "lanes", "local_size")  # of which kernels depend


def start(label: str, settings: Settings, ray_format: layout.RayFormat, needed: Mapping[str, bool]) -> None:
    """Start one for kernels, in the order in which they will be launched, where there is a core for it.

    label: of the device. needed: whether their work-items take packets.
    """
    if not (needed and interrupts.running() and _cores() > 1 and settings.threads != 1):
        return
    if trial.circumstances():  # the driver may break
        return
    told = {name: getattr(settings, name) for name in _SETTINGS}
    asked = {"device": label, "settings": told, "rays": asdict(ray_format), "needed": needed}
    apart: dict[str, Any] = {"start_new_session": True}
    if sys.platform == "win32":
        apart = {"creationflags": subprocess.CREATE_NEW_PROCESS_GROUP}
    with suppress(OSError, ValueError):  # it is done without
        process = subprocess.Popen(
            child.command("clrt.device.compiler"), stdin=subprocess.PIPE,
            stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
            env=child.environment(), **apart,
        )  # fmt: skip
        interrupts.helpers.add(process.pid)
        atexit.register(_end, process)
        assert process.stdin
        process.stdin.write(json.dumps(asked).encode() + b"\n")
        process.stdin.flush()


def _end(process: subprocess.Popen[bytes]) -> None:
    """End it before the folder of kernels is, which may be a temporary one."""
    process.kill()
    interrupts.helpers.discard(process.pid)
    process.wait()


def _cores() -> int:
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
