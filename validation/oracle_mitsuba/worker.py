"""The worker process: reads requests from its standard input, answers on its standard output, both pickled.

Everything that Mitsuba prints goes to the standard error, so that answers stay clean.
"""

from __future__ import annotations

import os
import pickle
import struct
import traceback
from importlib import import_module
from typing import Any, BinaryIO

import numpy as np

HEADER = struct.Struct("<Q")  # length of the message that follows
BLOCK = 1 << 19  # camera rays traced together


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
    """Layer B: `mode` "table" or "bsdf" of a camera's view."""
    from .sensors import camera_rays

    shader = _shader(job)
    positions, paths = job["positions"], job["paths"]
    spp, pixels = paths.shape
    sums: dict[str, np.ndarray] = {}
    t, shape = np.full(spp * pixels, np.inf), np.full(spp * pixels, -1)
    for begin in range(0, spp * pixels, BLOCK):
        block = np.arange(begin, min(begin + BLOCK, spp * pixels))  # sample by sample
        origin, direction = camera_rays(job["sensor"], job["eye"], positions.reshape(-1, 2)[block])
        origin = origin + job["center"]
        path, start = (array.ravel()[block] for array in (paths, job["start"]))
        first = _trace(shader, origin, direction, block % pixels, path, start, pixels, sums)
        t[block], shape[block] = first.t, first.shape
    return {
        "by_ray": {name: total / spp for name, total in sums.items()},
        "whole": whole(sums),
        "t": t[:pixels],
        "shape": shape[:pixels],
    }


def radiance(job: dict[str, Any]) -> dict[str, Any]:
    """Layer B along any rays: `origin`, `direction` (n, 3)."""
    pixels = np.arange(len(job["origin"]))
    sums: dict[str, np.ndarray] = {}
    shader, rays = _shader(job), (job["origin"], job["direction"])
    hits = _trace(shader, *rays, pixels, job["paths"], job["start"][0], len(pixels), sums)
    return {"radiance": sum(sums[name] for name in whole(sums)), "t": hits.t, "shape": hits.shape}


def whole(sums: dict[str, Any]) -> list[str]:
    """The names of sums that are not parts of others: "generation 0 camera", not "generation 0 camera
    diffuse"."""
    return [name for name in sums if len(name.split()) == 3]


def _shader(job: dict[str, Any]) -> Any:
    module, name = {"table": ("table", "Table"), "bsdf": ("lobes", "Lobes")}[job["mode"]]
    return getattr(import_module(f".{module}", __package__), name)(job)


def _trace(shader: Any, origin: Any, direction: Any, pixel: Any, path: Any, media: Any, pixels: int,
           sums: Any) -> Any:  # fmt: skip
    from .whitted import Rays, trace

    nowhere = np.full(len(pixel), -1)
    rays = Rays(origin, direction, np.ones_like(direction), pixel, path & ~np.uint32(15), nowhere, media)
    with np.errstate(divide="ignore", invalid="ignore"):
        return trace(shader, rays, pixels, sums)


def stock(job: dict[str, Any]) -> list[dict[str, Any]]:
    """Layer A: stock integrators on stock scenes, one after the other."""
    from .sensors import stock_render

    return [stock_render(render) for render in job["renders"]]


def crash(_: Any) -> None:
    """End as an LLVM error ends the process; for the test of what the caller then says."""
    os.abort()


TASKS = {"versions": versions, "picture": picture, "radiance": radiance, "stock": stock, "crash": crash}
