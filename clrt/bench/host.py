"""What surrounds the passes: the builder, launches, compiling, and the whole program as a user starts it."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Final

import numpy as np

from clrt.base.scratch import scratch
from clrt.bench.timing import Case, Measurement, Tell, measured
from clrt.device.device import Device
from clrt.engine.world import World
from clrt.flatten.flatten import FlatScene

_LAUNCHES: Final = 500
_BUILDER: Final = ("split_top", "build_subtree", "collapse", "pack_triangles", "pack_spheres", "pack_others")


def builder_cases(device: Device, flat: FlatScene, scene: str, threads: int) -> list[Case]:
    """The tree alone, by the driver's own clock, and all that a Tracer needs to be ready: upload and tree."""
    n = int(flat.scene["primitives"][0])
    device = device.variant(flat.ray_format)

    def tree() -> float:
        with device.driver.timed() as spent:
            World(device, flat)
        return sum(spent[name] for name in _BUILDER if name in spent)

    def world() -> None:
        World(device, flat)

    common: dict[str, Any] = {
        "group": "builder",
        "scene": scene,
        "threads": threads,
        "items": n,
        "unit": "primitives",
        "clock": "wall",
    }
    return [Case(name="tree", run=tree, **common), Case(name="upload and tree", run=world, **common)]


def launch_cases(device: Device) -> list[Case]:
    """What it costs to start a kernel that has nothing to do: without waiting, and waiting for each."""
    nothing = device.upload(np.zeros(1, np.float32))

    def launch() -> None:
        device.launch("resolve", 1, np.uint32(0), np.float32(1.0), nothing)

    def queued() -> None:
        for _ in range(_LAUNCHES):
            launch()
        device.finish()

    def waited() -> None:
        for _ in range(_LAUNCHES):
            launch()
            device.finish()

    return [
        Case(group="launch", name=name, run=run, items=_LAUNCHES, unit="launches", clock="wall")
        for name, run in (("queued", queued), ("and waited for", waited))
    ]


def compile_times(device: str | int | None, rounds: int, tell: Tell | None = None) -> list[Measurement]:
    """Seconds to build the kernels and run each for the first time, the driver's caches empty and filled."""
    cold: list[float] = []
    cached: list[float] = []
    for turn in range(rounds):
        if tell:
            tell(f"compiling, {turn + 1} of {rounds}")
        with empty_caches() as environment:
            del environment["PYTHONPYCACHEPREFIX"]  # kernels are meant, not Python's own compiling
            for kept in (cold, cached):
                kept.append(float(_python(_COMPILE, environment, json.dumps(device), json.dumps(_SMALL))))
    return [
        measured(Case(group="compile", name=name, run=_never, unit="programs", clock="wall"), seconds)
        for name, seconds in (("cold", cold), ("cached", cached))
    ]


def program_times(device: str | int | None, rounds: int, tell: Tell | None = None) -> list[Measurement]:
    """`clrt render` of a small scene as a user starts it: the process's wall time.

    Its caches hold what it needs and no more: to look through the kernels of a thousand scenes takes longer.
    """
    seconds = []
    with empty_caches() as environment, scratch() as folder:
        scene, picture = Path(folder) / "small.json", Path(folder) / "small.png"
        scene.write_text(json.dumps(_SMALL), "utf-8")
        command = [sys.executable, "-m", "clrt", "render", str(scene), "-o", str(picture), "--quiet"]
        command += [] if device is None else ["--device", str(device)]
        for turn in range(rounds + 1):
            if tell:
                tell(f"rendering from the command line, {turn} of {rounds}")
            start = time.perf_counter()
            subprocess.run(command, check=True, cwd=_ROOT, env=environment)
            seconds.append(time.perf_counter() - start)
    case = Case(group="program", name="clrt render", run=_never, unit="processes", clock="wall")
    return [measured(case, seconds[1:])]


_ROOT: Final = Path(__file__).resolve().parents[2]
_SMALL: Final = {
    "camera": {"origin": [0, 1, 4], "target": [0, 0, 0], "width": 160, "height": 120},
    "lights": [{"type": "point", "position": [3, 5, 4]}],
    "shapes": [
        {"type": "sphere", "center": [0, 0, 0], "radius": 1, "material": {"reflection": 0.2, "diffuse": 0.7}}
    ],
}  # fmt: skip

# every kernel that a picture needs runs once; the second picture's time is taken off
_COMPILE: Final = """
import json, sys, time
import clrt
scene = clrt.load_dict({**json.loads(sys.argv[2]), "ambient": 0.2, "ambient_samples": 1, "max_depth": 2})
clrt.devices()
start = time.perf_counter()
tracer = clrt.Tracer(scene, json.loads(sys.argv[1]))
tracer.render(32, 24)
first = time.perf_counter() - start
start = time.perf_counter()
clrt.Tracer(scene, json.loads(sys.argv[1])) and tracer.render(32, 24)
print(first - (time.perf_counter() - start))
"""


@contextmanager
def empty_caches() -> Iterator[dict[str, str]]:
    """Environment variables that give driver, pyopencl and Python new, empty folders for what they keep.

    Python keeps its bytecode whatever this process was told: a user's does.
    """
    kept = {name: value for name, value in os.environ.items() if name != "PYTHONDONTWRITEBYTECODE"}
    with scratch() as folder:
        places = {"POCL_CACHE_DIR": "pocl", "XDG_CACHE_HOME": "cache", "PYTHONPYCACHEPREFIX": "bytecode"}
        yield {**kept, **{name: f"{folder}/{place}" for name, place in places.items()}}


def _python(code: str, environment: dict[str, str], *arguments: str) -> str:
    command = [sys.executable, "-c", code, *arguments]
    done = subprocess.run(command, env=environment, cwd=_ROOT, check=True, stdout=subprocess.PIPE, text=True)
    return done.stdout


def _never() -> None:
    raise AssertionError("this case is timed by other processes")
