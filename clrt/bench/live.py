"""What it takes to follow a scene: updates beside a new Tracer, pictures beside their kernels."""

from __future__ import annotations

import math
import threading
import time
from collections.abc import Callable, Iterator
from dataclasses import replace
from itertools import cycle
from typing import Any, Final

import numpy as np

from clrt.bench import scenes
from clrt.bench.timing import Case, Measurement, Tell, measure
from clrt.device.settings import Settings
from clrt.engine.campath import turntable
from clrt.engine.tracer import Tracer
from clrt.formats.shipped import load_scene
from clrt.scene.scene import Scene, edited

NEW, KERNELS = "new Tracer", "kernels"
FRAMES: Final = 50  # of a series, of the second of these sizes
SIZES: Final = ((512, 512), (320, 180))
_CHANGES: Final[dict[str, dict[str, Any]]] = {
    "update, another light": {"lights[0].position": [5.0, 15.0, 4.0]},
    "update, another material": {"shapes[0].material.color": [0.3, 0.5, 0.7]},
}


def times(
    rounds: int, wanted: int | str | None, settings: Settings, quick: bool = False, tell: Tell | None = None
) -> list[Measurement]:
    """Processor time of updates and pictures of the terrain, on one core, in turns."""
    settings = replace(settings, threads=1)
    scene = scenes.make("terrain", quick)
    vertices = np.array(scene.shapes[0].data().vertices)  # type: ignore[union-attr]
    vertices[:, 1] += 0.01 * np.sin(3 * vertices[:, 0])
    changes = {"update, moved vertices": {"shapes[0].vertices": vertices}, **_CHANGES}
    tracer = Tracer(scene, wanted, settings)
    cpu = tracer.device.info.kind == "CPU"

    def case(name: str, how: str, run: Callable[[], float | None], items: int, unit: str) -> Case:
        return Case(
            group="live", scene="terrain", name=name, queue=how, run=run, items=items, unit=unit,
            clock="cpu" if cpu else "wall",
        )  # fmt: skip

    other = Tracer(scene, wanted, settings)  # that holds one scene alone
    triangles = len(tracer.flat.primitives)
    cases = [case(NEW, "", lambda: _new(scene, wanted, settings), triangles, "primitives")]
    for name, change in changes.items():
        cases.append(case(name, "", _updating(tracer, scene, scene.replace(change)), triangles, "primitives"))
    for width, height in ((size[0] // 8, size[1] // 8) if quick else size for size in SIZES):
        name, pixels = f"picture of {width} x {height}", width * height
        views = _views(scene, width, height)
        cases.append(case(name, "", _picture(other, views), pixels, "pixels"))
        cases.append(case(name, KERNELS, _picture(other, views, kernels=True, cpu=cpu), pixels, "pixels"))
    film, frames, (width, height) = load_scene("showcase"), 2 if quick else FRAMES, SIZES[1]
    size = (width // 8, height // 8) if quick else (width, height)
    for how in ("", KERNELS):
        name = f"series of {frames} pictures"
        made = _series(film, frames, size, wanted, settings, kernels=bool(how), cpu=cpu)
        cases.append(replace(case(name, how, made, frames * width * height, "pixels"), scene="showcase"))
    return measure(cases, rounds, tell)


def _series(
    scene: Scene, frames: int, size: tuple[int, int], wanted: int | str | None, settings: Settings,
    kernels: bool, cpu: bool,
) -> Callable[[], float | None]:  # fmt: skip
    """A turntable from its beginning to its end, the Tracer too, as `clrt.sweep` makes it."""
    assert scene.camera is not None
    views = turntable(scene.camera, frames)

    def run() -> float | None:
        start, seconds = _outside_python() if kernels and cpu else 0.0, 0.0
        with Tracer(scene, wanted, settings) as tracer:
            for view in views:
                tracer.update(edited(scene, {"camera": view}))
                seconds += sum(tracer.render(*size).stats["seconds"].values())
        if not kernels:
            return None
        return _outside_python() - start if cpu else seconds

    return run


def _new(scene: Scene, wanted: int | str | None, settings: Settings) -> None:
    Tracer(scene, wanted, settings).close()


def _updating(tracer: Tracer, scene: Scene, other: Scene) -> Callable[[], float]:
    """There alone is timed: the way back is the same."""

    def run() -> float:
        tracer.update(scene)
        clock = time.process_time if tracer.device.info.kind == "CPU" else time.perf_counter
        start = clock()
        tracer.update(other)
        return clock() - start

    return run


def _views(scene: Scene, width: int, height: int) -> Iterator[dict[str, Any]]:
    """Cameras around the scene, one after the other, without end."""
    assert scene.camera is not None
    x, y, z = scene.camera.origin
    reach, start = math.hypot(x, z), math.atan2(z, x)
    turns = (start + 0.1 * k for k in range(5))
    origins = [(reach * math.cos(angle), y, reach * math.sin(angle)) for angle in turns]
    size = {"fov": scene.camera.fov, "width": width, "height": height}
    return cycle([{"origin": origin, "target": scene.camera.target, **size} for origin in origins])


def _picture(
    tracer: Tracer, views: Iterator[dict[str, Any]], kernels: bool = False, cpu: bool = True
) -> Callable[[], float | None]:
    def run() -> float | None:
        start = _outside_python() if kernels and cpu else 0.0
        image = tracer.render(camera=next(views))
        if not kernels:
            return None
        return _outside_python() - start if cpu else sum(image.stats["seconds"].values())

    return run


def _outside_python() -> float:
    """Processor time of all threads but Python's: those of the driver, which runs the kernels in them."""
    own = sum(
        time.clock_gettime(time.pthread_getcpuclockid(thread.ident))
        for thread in threading.enumerate()
        if thread.ident is not None
    )
    return time.process_time() - own


def ratio(measurements: list[Measurement], mine: Measurement) -> float | None:
    """Which part of a new Tracer's time an update takes; a picture's time over that of its kernels."""
    if mine.queue or mine.name == NEW:
        return None
    for m in measurements:
        if (m.queue, m.name) == (KERNELS, mine.name) or (mine.name.startswith("update") and m.name == NEW):
            return mine.median / m.median
    return None
