"""A caller's rays from Python: what a call takes beside its kernels, and beside embreex where that is here.

Primary rays of the terrain, a picture's rows one after the other; and calls of few rays, which is what a
loop in Python makes. embreex (Embree for numpy, on PyPI) is a yardstick alone: nothing else needs it.
Embree's own calls, from C, stand beside the many rays where the run is against Embree.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from importlib import import_module
from typing import Any, Final

import numpy as np

from clrt.bench import embree, scenes
from clrt.bench.timing import Case, Measurement, Tell, measure
from clrt.device.settings import Settings
from clrt.device.shared import Work
from clrt.engine.batch import Batch
from clrt.engine.tracer import Tracer
from clrt.flatten.flatten import FlatScene

FEW: Final = (1000, 1)  # rays of short calls
KERNEL, EMBREEX = "kernel", "embreex"
CALLS: Final = tuple(f"Embree {mode}" for mode in embree.MODES)  # each is followed by which call it is
NEAREST, ALL, BLOCKED = "intersect, t and primitive", "intersect, all fields", "occluded"
_ALONE: Final = {NEAREST: "nearest", BLOCKED: "blocked"}  # the kernel that such a call launches
_OF_RAYS: Final = {"primary": NEAREST, "shadow": BLOCKED}  # what Embree's calls answer
# what embreex is asked, to give as much (`output=1`: distances, coordinates and normals)
_ASKED: Final[dict[str, dict[str, Any]]] = {NEAREST: {}, ALL: {"output": 1}, BLOCKED: {"query": "OCCLUDED"}}


def times(
    rounds: int, wanted: int | str | None, settings: Settings, quick: bool = False, tell: Tell | None = None,
    builds: Sequence[embree.Build] = (),
) -> list[Measurement]:  # fmt: skip
    """Processor time of queries, in turns with their kernels alone, with embreex's and these Embrees'."""
    scene = scenes.make("terrain", quick)
    assert scene.camera is not None
    tracer = Tracer(scene, wanted, replace(settings, threads=1))
    width = 128 if quick else 1024
    view = {"origin": scene.camera.origin, "target": scene.camera.target, "fov": scene.camera.fov}
    origins, directions = tracer.camera_rays({**view, "width": width, "height": width})
    rays = origins.reshape(-1, 3), directions.reshape(-1, 3)
    clock = "cpu" if tracer.device.info.kind == "CPU" else "wall"

    def case(name: str, how: str, run: Callable[[], Any], items: int) -> Case:
        def once() -> None:
            run()

        return Case(
            group="queries",
            scene="terrain",
            name=name,
            queue=how,
            run=once,
            items=items,
            unit="rays",
            clock=clock,
        )

    other = _embreex(tracer.flat)
    cases = []
    for n in (len(rays[0]), *FEW):
        some = rays[0][:n], rays[1][:n]
        for name, ask in _calls(tracer).items():
            text = f"{name}, {n} ray{'s' * (n > 1)}" if n in FEW else name
            cases.append(case(text, "", partial(ask, *some), n))
            if n not in FEW and name in _ALONE:
                cases.append(case(text, KERNEL, _alone(tracer, _ALONE[name], *some), n))
            if other is not None and name in _ASKED:
                how = _ASKED[name]
                cases.append(case(text, EMBREEX, partial(other.run, *some, **how), n))
    shape = embree.geometry(tracer.flat) if builds else None
    yardsticks = [embree.commit(build, shape, mode) for build in builds for mode in embree.MODES if shape]
    cases += _in_c(yardsticks, *rays, clock)
    found = measure(cases, rounds, tell)
    for yardstick in yardsticks:
        yardstick.close()
    return found


def _in_c(
    yardsticks: list[embree.Yardstick], origins: np.ndarray, directions: np.ndarray, clock: str
) -> list[Case]:
    """Each of Embree's calls on these rays."""
    endless = np.full((1, len(origins)), np.inf, np.float32)
    rays = np.ascontiguousarray(np.vstack([origins.T, directions.T, endless]), np.float32)
    cases = embree.tracing_cases(yardsticks, dict.fromkeys(_OF_RAYS, rays), "terrain")
    return [
        replace(case, group="queries", name=_OF_RAYS[case.queue], queue=f"Embree {case.name}", clock=clock)
        for case in cases
    ]


def _calls(tracer: Tracer) -> dict[str, Callable[[np.ndarray, np.ndarray], Any]]:
    fields = ("t", "primitive")
    return {
        NEAREST: lambda o, d: tracer.intersect(o, d, fields=fields),
        ALL: tracer.intersect,
        BLOCKED: tracer.occluded,
        "count_hits": tracer.count_hits,
        "all_hits, t and primitive": lambda o, d: tracer.all_hits(o, d, fields=fields),
    }


def _alone(tracer: Tracer, kernel: str, origins: np.ndarray, directions: np.ndarray) -> Callable[[], None]:
    """The launch alone, with all that it needs made before."""
    device, n = tracer.device, len(origins)
    work = Work(device)
    asked = Batch(origins, directions, 0.0, np.inf).piece(0, n).arguments(work)
    kinds = ("float", "int") if kernel == "nearest" else ("uchar",)
    answers = [device.buffer(4 * n, kind) for kind in kinds]

    def run() -> None:
        device.launch_packets(kernel, n, *tracer.world.arguments, *asked, *answers)
        device.finish()

    return run


def _embreex(flat: FlatScene) -> Any:
    """Embree's tree over the triangles, as embreex has it; None where that is not installed."""
    try:
        scene = import_module("embreex.rtcore_scene").EmbreeScene()
        mesh = import_module("embreex.mesh_construction").TriangleMesh
    except ImportError:
        return None
    corners = np.stack([flat.triangles[name][:, :3] for name in ("v0", "v1", "v2")], axis=1)
    faces = np.arange(3 * len(corners), dtype=np.int32).reshape(-1, 3)
    mesh(scene, np.ascontiguousarray(corners.reshape(-1, 3)), faces)
    scene.run(np.zeros((1, 3), np.float32), np.ones((1, 3), np.float32))  # it builds its tree now
    return scene


def compared(measurements: list[Measurement]) -> bool:
    """Whether embreex was there."""
    return any(m.queue == EMBREEX for m in measurements)


def ratio(measurements: list[Measurement], mine: Measurement, other: str) -> float | None:
    """How many times as fast a query is as its kernel alone, as embreex, or as the best of CALLS in a mode;
    None where that was not timed."""
    if mine.queue:
        return None
    theirs = [m.median for m in measurements if m.name == mine.name and m.queue.startswith(other)]
    return min(theirs) / mine.median if theirs else None


def said(measurements: list[Measurement], mine: Measurement, other: str) -> str:
    """`ratio` as a table shows it."""
    found = ratio(measurements, mine, other)
    return "" if found is None else f"{found:.2f}"
