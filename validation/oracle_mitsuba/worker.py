"""The worker process: reads requests from its standard input, answers on its standard output, both pickled.

Everything that Mitsuba prints goes to the standard error, so that answers stay clean.
"""

from __future__ import annotations

import os
import pickle
import struct
import sys
import traceback
from typing import Any, BinaryIO

import numpy as np

HEADER = struct.Struct("<Q")  # length of the message that follows


def send(stream: BinaryIO, message: Any) -> None:
    """Write one message."""
    data = pickle.dumps(message, protocol=5)
    stream.write(HEADER.pack(len(data)) + data)
    stream.flush()


def main() -> None:
    """Answer requests (name, job) with ("done", value) or ("failed", text) until the input ends."""
    answers = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)
    with os.fdopen(os.dup(0), "rb") as requests:
        while header := requests.read(HEADER.size):
            name, job = pickle.loads(requests.read(HEADER.unpack(header)[0]))
            try:
                answer = ("done", TASKS[name](job))
            except Exception:
                answer = ("failed", traceback.format_exc())
            send(answers, answer)


def versions(_: Any) -> dict[str, str]:
    """Of Mitsuba, Dr.Jit and LLVM; compiles and runs a kernel, so that an LLVM which cannot fails here."""
    from .engine import dr, mi

    total = float(np.array(dr.sum(dr.arange(mi.Float, 1000)))[0])
    if total != 499500.0:
        raise RuntimeError(f"Dr.Jit adds 0 to 999 up to {total}")
    found = {"mitsuba": mi.__version__, "drjit": dr.__version__, "variant": mi.variant()}
    return {**found, "llvm": os.environ.get("DRJIT_LIBLLVM_PATH", "")}


def picture(job: dict[str, Any]) -> dict[str, Any]:
    """A scene's picture by `mode`: what rendering.picture gives."""
    from .rendering import picture

    return picture(_scene(job), job["mode"], job["paths"])


def radiance(job: dict[str, Any]) -> Any:
    """Radiance (n, 3) along any rays: `origin`, `direction` (n, 3)."""
    from .rendering import radiance

    return radiance(_scene(job), job["mode"], job["origin"], job["direction"])


def _scene(job: dict[str, Any]) -> Any:
    from .reading import read
    from .records import Source

    return read(Source(**job["source"]))


def stock(job: dict[str, Any]) -> list[dict[str, Any]]:
    """Layer A: stock integrators on stock scenes, one after the other."""
    from .sensors import stock_render

    return [stock_render(render) for render in job["renders"]]


def crash(_: Any) -> None:
    """End as an LLVM error ends the process; for the test of what the caller then says."""
    os.abort()


def modules(_: Any) -> list[str]:
    """The modules that are loaded here; for the test that this process has nothing of the renderer's."""
    return sorted(sys.modules)


TASKS = {"versions": versions, "picture": picture, "radiance": radiance, "stock": stock, "crash": crash,
         "modules": modules}  # fmt: skip
