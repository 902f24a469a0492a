"""Does a driver work here? One small kernel tells, in a process of its own, once a driver and processor.

A driver may list a device and build nothing for it (PoCL 3.0 on processors that its LLVM does not know), end
the process or hang: so the trial is `python -m clrt.trial NUMBER`, and its verdict is kept beside the
compiled kernels. A bad verdict holds for a day: what was wrong may have been mended.
"""

from __future__ import annotations

import hashlib
import json
import os
import subprocess
import sys
import time
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Final

from clrt import kernelcache
from clrt.atomic import replacing
from clrt.errors import ClrtError
from clrt.files import read_bytes
from clrt.limits import Limits
from clrt.processor import signature

if TYPE_CHECKING:
    from clrt.platforms import DeviceInfo

PATIENCE: Final = 120.0  # seconds: a busy machine takes 5
_MOST: Final = 1 << 16  # bytes of a verdict that are read
_DAY: Final = 24 * 3600
_SOURCE: Final = "__kernel void trial(__global float *x) { int i = get_global_id(0); x[i] = 2 * i + 1; }"
_UNKNOWN_PROCESSOR: Final = "unknown target CPU"
_LONGEST: Final = 300  # characters of a driver's log that a message shows


def verdict(info: DeviceInfo, anew: bool = False) -> tuple[str, bool]:
    """What is wrong with a device ('' where nothing is), and whether it was tried just now.

    anew: try it whatever is known.
    """
    file = _file(info)
    if not anew:
        with suppress(OSError, ClrtError, ValueError, TypeError, KeyError, RecursionError):
            age = time.time() - file.stat().st_mtime
            known = str(json.loads(read_bytes(file, Limits(file_bytes=_MOST)))["fault"])
            if not known or 0 <= age < _DAY:
                return known, False
    fault = _tried(info)
    with suppress(OSError, ClrtError):  # it is tried again next time
        file.parent.mkdir(mode=0o700, exist_ok=True)
        with replacing(file) as temporary:
            temporary.write_text(json.dumps({"device": info.label, "fault": fault}), encoding="utf-8")
    return fault, True


def plain(text: str) -> str:
    """Why a driver builds nothing, in plain words, from what it said."""
    if _UNKNOWN_PROCESSOR in text:
        return f"its compiler is older than this processor and builds nothing for it ({_UNKNOWN_PROCESSOR})"
    lines = [" ".join(line.split()) for line in text.splitlines() if line.strip()]
    telling = [line for line in lines if "error" in line.lower()] or lines[-1:] or ["it does not say why"]
    return telling[0][:_LONGEST]


def _file(info: DeviceInfo) -> Path:
    name = hashlib.sha256("\0".join((info.label, info.driver, signature())).encode()).hexdigest()[:32]
    return Path(os.environ[kernelcache.VARIABLE]) / "verdicts" / f"{name}.json"


def _tried(info: DeviceInfo) -> str:
    if not sys.executable:  # embedded in another program: nothing can be started
        return ""
    root = str(Path(__file__).resolve().parents[1])  # a checkout need not be installed
    paths = os.pathsep.join(part for part in (root, os.environ.get("PYTHONPATH")) if part)
    try:
        done = subprocess.run(
            [sys.executable, "-m", "clrt.trial", str(info.index)],
            capture_output=True, timeout=PATIENCE, check=False, stdin=subprocess.DEVNULL,
            env={**os.environ, "PYTHONPATH": paths},
        )  # fmt: skip
    except subprocess.TimeoutExpired:
        return f"a kernel of one line is not done after {PATIENCE:.0f} s"
    except OSError:  # no process can be started here
        return ""
    said = done.stdout.decode(errors="replace")
    if done.returncode == 0:
        return ""
    if done.returncode == 1 and said.strip():
        return said.strip()
    return f"it ends the process (exit code {done.returncode})"


def _try(number: int) -> str:
    """What goes wrong with a device in this process."""
    import numpy as np

    from clrt.binaries import quietly
    from clrt.opencl import cl
    from clrt.platforms import listed

    try:
        device = listed()[number][1]
        context = cl.Context([device])
        queue = cl.CommandQueue(context)
        kernel = cl.Kernel(quietly(cl.Program(context, _SOURCE), ["-cl-std=CL1.2"]), "trial")
        found = np.zeros(64, np.float32)
        buffer = cl.Buffer(context, cl.mem_flags.READ_WRITE, found.nbytes)
        kernel(queue, found.shape, None, buffer)
        cl.enqueue_copy(queue, found, buffer)
    except cl.Error as error:
        return str(error)
    right = np.array_equal(found, 2 * np.arange(64, dtype=np.float32) + 1)
    return "" if right else "error: 2 x + 1 comes out wrong"


if __name__ == "__main__":
    fault = _try(int(sys.argv[1]))
    print(plain(fault) if fault else "")
    sys.exit(1 if fault else 0)
