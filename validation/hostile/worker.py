"""Reads and renders hostile inputs, one a line of standard input; answers each in a line of JSON.

A line is either `{"folder": F, "scene": NAME}` or `{"seed": S, "index": I}`, an input of `mutate.make`.
"""

from __future__ import annotations

import json
import sys
import tempfile
import time
import warnings
from pathlib import Path
from typing import Any, Final

import numpy as np

import clrt
from clrt.bench.machine import peak_bytes
from clrt.limits import Limits

from .mutate import make

# Small enough that whatever they let through takes well below a second
LIMITS: Final = Limits(
    file_bytes=4 << 20, primitives=20_000, vertices=20_000, lights=64, pixels=1 << 12, samples=16, depth=12,
    device_bytes=128 << 20, work=2_000_000, image_pixels=1 << 20, image_bytes=64 << 20,
)  # fmt: skip

PATIENT: Final = 1.0  # seconds of processor time
DEFAULT_SIZES: Final = ((640, 480), (800, 600))  # of files that do not say how large their picture is


def attempt(path: Path, device: int | str | None) -> dict[str, Any]:
    """What becomes of a scene file: {"status": "rendered" | "refused" | "foreign" | "not finite", "text"}."""
    try:
        scene = clrt.load(path, limits=LIMITS)
        default = scene.camera is not None and (scene.camera.width, scene.camera.height) in DEFAULT_SIZES
        width = 12 if default else None
        image = clrt.render(scene, width=width, device=device, settings=clrt.Settings(limits=LIMITS))
        if np.isfinite(image.pixels).all():
            return {"status": "rendered", "text": ""}
        return {"status": "not finite", "text": f"{np.count_nonzero(~np.isfinite(image.pixels))} values"}
    except clrt.ClrtError as error:
        text = str(error)
        fine = text and len(text) < 2000 and "\n" not in text
        return {"status": "refused" if fine else "foreign", "text": text[:2000]}
    except Exception as error:  # what must not happen: told, so that it can be mended
        import traceback

        return {"status": "foreign", "text": traceback.format_exc()[-3000:] or repr(error)}


def answer(task: dict[str, Any], folder: Path, device: int | str | None) -> dict[str, Any]:
    """One task done: its outcome, seconds of processor time, and the peak memory of this process so far."""
    path = Path(task["folder"], task["scene"]) if "folder" in task else None
    if path is None:
        for old in folder.iterdir():
            old.unlink()
        made = make(task["seed"], task["index"])
        for name, data in made.files.items():
            (folder / name).write_bytes(data)
        path = folder / made.scene
    for _ in range(2):  # again where it was slow: kernels for what rays carry are built once a machine
        start = time.process_time()
        outcome = attempt(path, device)
        busy = time.process_time() - start
        if busy < PATIENT:
            break
    return {**task, **outcome, "cpu": busy, "peak": peak_bytes()}


def main(device: str | None) -> None:
    """Answer until standard input ends."""
    warnings.simplefilter("ignore")
    # a device is opened and its kernels are built before any input is timed
    camera = {"origin": [0, 0, 5], "target": [0, 0, 0], "width": 2, "height": 2}
    clrt.render(clrt.load_dict({"camera": camera}), device=device)
    with tempfile.TemporaryDirectory() as folder:
        print(json.dumps({"ready": True}), flush=True)
        for line in sys.stdin:
            print(json.dumps(answer(json.loads(line), Path(folder), device)), flush=True)


if __name__ == "__main__":
    main(sys.argv[1] if len(sys.argv) > 1 else None)
