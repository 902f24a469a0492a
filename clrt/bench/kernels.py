"""Every pass alone, on the queues that a real picture gives it, on one core."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any, Final

import numpy as np

from clrt.bench.recorder import ADDING, ARRANGING, CLASSES, TRACING, Recording, case, record
from clrt.bench.timing import Case
from clrt.bench.walk import Walk, count_visits, read_nodes
from clrt.device.settings import Settings
from clrt.engine import passes
from clrt.scene.scene import Scene

RAY_KINDS: Final = ("primary", "shadow", *CLASSES.values())
_SAMPLE: Final = 512  # rays that are walked on the host

# Floating-point operations a ray, counted in the source for one light and one material, good to about a
# third: where a pass stands between the two roofs. Most move more than they compute.
_FLOPS: Final = {
    "generate": 40, "surface": 60, "cross_boundaries": 60, "shade": 80, "feelers": 40, "illuminate": 90,
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
        if kernel in (ARRANGING, ADDING):  # each with what needs it
            continue
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
    device, queue = recording.device, recording.rays[kind][0]
    hits = passes.closest(device, recording.world, queue, crossing=False)
    lines = {name: values.T.astype(np.float64) for name, values in queue.lines(queue.rays).items()}
    chosen = np.random.default_rng(1).permutation(queue.n)[:_SAMPLE]
    arrays = (lines["origin"], lines["direction"], queue.words(hits.t, np.float32).astype(np.float64))
    return count_visits(read_nodes(device, recording.world), *(array[chosen] for array in arrays))


def rays_of(recording: Recording, kind: str) -> np.ndarray:
    """All rays of a kind, of all tiles: (7, n) float32, origins, directions, t_max."""
    parts = [np.vstack(list(queue.lines(queue.rays).values())) for queue in recording.rays[kind]]
    return np.concatenate(parts, axis=1)


def hits_of(recording: Recording, kind: str) -> np.ndarray:
    """What the rays of `rays_of` hit: primitive numbers, -1 on a miss, (n,) int32."""
    found = []
    for queue in recording.rays[kind]:
        hits = passes.closest(recording.device, recording.world, queue, crossing=False)
        found.append(queue.words(hits.primitive, np.int32))
    recording.device.finish()
    return np.concatenate(found)


def _order(made: Case) -> tuple[Any, ...]:
    groups: Sequence[str] = ("tracing", "shading", "compaction")
    kinds = (*RAY_KINDS, made.queue)
    return groups.index(made.group), made.name if made.group != "shading" else "", kinds.index(made.queue)
