"""Every pass alone, on the queues that a real picture gives it, on one core."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any, Final

import numpy as np

from clrt import passes
from clrt.bench.recorder import CLASSES, TRACING, Recording, case, record
from clrt.bench.timing import Case
from clrt.bench.walk import Walk, count_visits, rays_on_host, read_nodes
from clrt.queues import CAMERA, Queue
from clrt.scene import Scene
from clrt.settings import Settings

RAY_KINDS: Final = ("primary", "shadow", *CLASSES.values())
_SAMPLE: Final = 512  # rays that are walked on the host

# Floating-point operations a ray, counted in the source for one light and one material, good to about a
# third: where a pass stands between the two roofs. Most move more than they compute.
_FLOPS: Final = {
    "generate": 40, "surface": 60, "cross_boundaries": 60, "light": 80, "feelers": 40, "illuminate": 90,
    "reflect": 60, "transmit": 110, "gather_ambient": 70, "gather": 6, "resolve": 3,
}  # fmt: skip


# Bytes a ray of passes that look at little of their arrays: the code of a surface and the first two places of
# a list are read, two fields of the surface are written
_TOUCHED: Final = {"cross_boundaries": 4 * (1 + 2 + 2)}


def recorded(scene: Scene, width: int, wanted: int | str | None, settings: Settings) -> Recording:
    """The launches of a picture of that width, on a single core."""
    return record(scene, width, wanted, replace(settings, threads=1))


def cases(recording: Recording, scene: str, passes_too: bool = True) -> list[Case]:
    """Tracing of every kind of ray; the other passes on primary rays, or else where they first appear.

    `passes_too` = False leaves it at the tracing.
    """
    walks = {kind: walk(recording, kind) for kind in RAY_KINDS if kind in recording.rays}
    found: list[Case] = []
    seen: set[str] = set()
    for kernel, queue in recording.launches:
        if kernel in TRACING and queue in RAY_KINDS:
            made = case(recording, kernel, queue, scene)
            visits = walks[queue]
            found.append(
                replace(
                    made,
                    nbytes=made.nbytes + visits.nbytes(made.items),
                    flops=made.items * visits.flops,
                )
            )
        elif passes_too and kernel not in TRACING and kernel not in seen:
            seen.add(kernel)
            made = case(recording, kernel, queue, scene)
            nbytes = float(made.items * _TOUCHED[kernel]) if kernel in _TOUCHED else made.nbytes
            found.append(replace(made, nbytes=nbytes, flops=float(made.items * _FLOPS.get(kernel, 0))))
    return sorted(found, key=_order)


def walk(recording: Recording, kind: str) -> Walk:
    """Visits of a sample of the rays of a kind; a shadow feeler's walk is taken to its first blocker, too."""
    device, world = recording.device, recording.world
    buffer, n = recording.rays[kind][0]
    queue = Queue(CAMERA, n, buffer, None, None, None, None, device)
    hits = passes.closest(device, world, queue, crossing=False)
    t = device.read(hits.t, np.empty(n, np.float32))
    device.finish()
    origins, directions, _ = rays_on_host(device, buffer, n)
    chosen = np.random.default_rng(1).permutation(n)[:_SAMPLE]
    arrays = (array[chosen].astype(np.float64) for array in (origins, directions, t))
    return count_visits(read_nodes(device, world), *arrays)


def rays_of(recording: Recording, kind: str) -> np.ndarray:
    """All rays of a kind, of all tiles: (7, n) float32, origins, directions, t_max."""
    parts = [rays_on_host(recording.device, buffer, n) for buffer, n in recording.rays[kind]]
    return np.ascontiguousarray(np.concatenate([np.column_stack(part) for part in parts]).T)


def hits_of(recording: Recording, kind: str) -> np.ndarray:
    """What the rays of `rays_of` hit: primitive numbers, -1 on a miss, (n,) int32."""
    found = []
    for buffer, n in recording.rays[kind]:
        queue = Queue(CAMERA, n, buffer, None, None, None, None, recording.device)
        hits = passes.closest(recording.device, recording.world, queue, crossing=False)
        found.append(recording.device.read(hits.primitive, np.empty(n, np.int32)))
    recording.device.finish()
    return np.concatenate(found)


def _order(made: Case) -> tuple[Any, ...]:
    groups: Sequence[str] = ("tracing", "shading", "compaction")
    kinds = (*RAY_KINDS, made.queue)
    return groups.index(made.group), made.name if made.group != "shading" else "", kinds.index(made.queue)
