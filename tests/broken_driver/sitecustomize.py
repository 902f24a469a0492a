"""In a process that finds this file: a driver that lists a device and builds nothing, before the real ones.

It fails as PoCL 3.0 does on processors that its LLVM does not know, with that driver's log. BROKEN_ALONE:
there is no other driver.
"""

from __future__ import annotations

import os
from typing import Any

LOG = (
    "clBuildProgram failed: BUILD_PROGRAM_FAILURE\n\nBuild on <pyopencl.Device 'old' at 0x5563>:\n\n"
    "error: unknown target CPU 'generic'\nDevice old failed to build the program"
)


class Stand:
    """In the place of a driver's object: its own attributes, then the other's."""

    def __init__(self, real: Any, **own: Any) -> None:
        self.__dict__.update(own, real=real)

    def __getattr__(self, name: str) -> Any:
        return getattr(self.__dict__["real"], name)


def break_one(cl: Any) -> None:
    platforms, context, program = cl.get_platforms, cl.Context, cl.Program

    def listed() -> list[Any]:
        real = platforms()
        platform = Stand(real[0], name="Portable Computing Language", version="OpenCL 3.0 PoCL 99.0 Old")
        device = Stand(real[0].get_devices()[0], name="old", driver_version="99.0", platform=platform)
        platform.__dict__["get_devices"] = lambda: [device]
        return [platform] if os.environ.get("BROKEN_ALONE") else [platform, *real]

    broken = []

    def opened(devices: list[Any]) -> Any:
        made = context([getattr(device, "real", device) for device in devices])
        if isinstance(devices[0], Stand):
            broken.append(made)
        return made

    def built(where: Any, *rest: Any) -> Any:
        made = program(where, *rest)
        if any(where is one for one in broken):

            def fails(*_: Any, **__: Any) -> None:
                raise cl.RuntimeError(LOG)

            return Stand(made, build=fails)
        return made

    def queue(where: Any, device: Any = None, **named: Any) -> Any:
        return commands(where, getattr(device, "real", device), **named)

    commands = cl.CommandQueue
    cl.get_platforms, cl.Context, cl.Program, cl.CommandQueue = listed, opened, built, queue


os.environ.setdefault("PYOPENCL_NO_CACHE", "1")
import pyopencl  # noqa: E402

break_one(pyopencl)
