"""How Oclgrind gets to see everything, and nothing that is not there.

Found out with Oclgrind 21.10: a new context empties the log; a filled buffer does not count as written to; a
buffer is gone when Python frees it, although launches that use it still wait; and after a buffer or a program
was freed, later ones are accused of uninitialised values that they do not have. So there is one context,
nothing is freed, and zeros are copied. The memory pool of ordinary runs would hide small overruns, because it
rounds sizes up, and uninitialised reads, because it hands out old contents: buffers are exact and new.
"""

from __future__ import annotations

import os
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from clrt.device.device import Device
from clrt.device.driver import Driver, Kernels
from clrt.device.opencl import cl

_own = f".{os.environ.get('PYTEST_XDIST_WORKER', '')}"
if _own != "." and not os.environ.get("OCLGRIND_LOG", _own).endswith(_own):
    # Oclgrind opens it with the first context: one for each process. This has two names, and runs twice.
    os.environ["OCLGRIND_LOG"] += _own
buffers: list[cl.Buffer] = []
programs: dict[str, cl.Program] = {}
_Context, _program = cl.Context, Kernels.program.func  # before they are replaced


def buffer(self: Device, nbytes: int, kind: str | None = None) -> cl.Buffer:
    """Exactly as large as asked for, and never freed."""
    made: Any = cl.Buffer(self.driver.context, cl.mem_flags.READ_WRITE, max(nbytes, 4))
    made.kind = kind
    buffers.append(made)
    return made


def fill(self: Device, target: cl.Buffer, nbytes: int, word: int = 0) -> None:
    cl.enqueue_copy(self.queue, target, np.full(-(-nbytes // 4), word, np.int32), is_blocking=True)


@property
def program(self: Kernels) -> cl.Program:
    """Built once for each source, and kept."""
    if self.source not in programs:
        programs[self.source] = _program(self)
    return programs[self.source]


def context(devices: Any) -> cl.Context:
    return _context()


@cache
def _context() -> cl.Context:
    (platform,) = cl.get_platforms()
    assert "Oclgrind" in platform.name, "run this under oclgrind: see .ci/run"
    return _Context(platform.get_devices())


def findings() -> str:
    """What Oclgrind has reported so far."""
    return Path(os.environ["OCLGRIND_LOG"]).read_text()


PATCHES = (
    ("clrt.device.device.Device.buffer", buffer),
    ("clrt.device.device.Device.fill", fill),
    ("clrt.device.driver.Kernels.program", program),
    ("clrt.device.driver.cl.Context", context),
    ("clrt.device.driver.Driver.wait", Driver.guard),  # Oclgrind ends the process where another thread copies
)
