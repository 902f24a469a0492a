"""The algorithm: generations of queues of rays, one kernel pass after another (thesis 1.3, in breadth)."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Final

import numpy as np

from clrt import layout
from clrt.base.errors import LimitError
from clrt.device.device import Device
from clrt.engine import passes
from clrt.engine.film import Film
from clrt.engine.queues import (
    AMBIENT,
    CAMERA,
    REFLECTION,
    TRANSMISSION,
    Queue,
    QueueHits,
    Shaded,
    feeler_bytes,
    queue_bytes,
)
from clrt.engine.schedule import TooLarge, Work
from clrt.engine.stage import Observer, tell
from clrt.engine.world import World
from clrt.flatten.media import too_deep

_NARROW_RAYS: Final = 1 << 17  # that dispersion makes of a tile at a time: as many as a tile in RGB has


KINDS: Final = (
    "camera", "camera_hits", "reflection", "transmission", "ambient", "total_internal_reflection", "feelers",
    "hits",
)  # fmt: skip


@dataclass
class RayCounts:
    """Rays by generation and kind, as `Image.stats` gives them."""

    generations: list[Counter[str]] = field(default_factory=list)

    def add(self, generation: int, queue: Queue, shaded: Shaded) -> None:
        while len(self.generations) <= generation:
            self.generations.append(Counter())
        self.generations[generation] += Counter(
            {
                queue.kind: queue.n,
                "hits": shaded.totals["HIT"],
                f"{queue.kind}_hits": shaded.totals["HIT"] if queue.kind == CAMERA else 0,
                "total_internal_reflection": shaded.totals["TOTAL_INTERNAL"],
                "feelers": shaded.totals["FEELERS"],
            }
        )

    def merge(self, other: RayCounts) -> None:
        for generation, counts in enumerate(other.generations):
            while len(self.generations) <= generation:
                self.generations.append(Counter())
            self.generations[generation] += counts

    def table(self) -> dict[str, dict[str, int] | list[dict[str, int]]]:
        """{"rays": totals by kind, "generations": the same for each generation}."""
        rows = [{kind: counts[kind] for kind in KINDS} for counts in self.generations]
        return {"rays": {kind: sum(row[kind] for row in rows) for kind in KINDS}, "generations": rows}

    @property
    def traced(self) -> int:
        """All rays: those of every queue, and the shadow feelers."""
        return sum(
            sum(counts[kind] for kind in ("camera", REFLECTION, TRANSMISSION, AMBIENT, "feelers"))
            for counts in self.generations
        )


@dataclass(frozen=True)
class Tile:
    """What was found for a piece: counts, the picture ("image") and layers, the work-group size of pixels."""

    rays: RayCounts
    layers: dict[str, np.ndarray]
    local_size: int = 0


def trace(
    device: Device,
    world: World,
    queue: Queue,
    hits: QueueHits,
    film: Film,
    max_depth: int,
    budget: int | None = None,
    observers: Sequence[Observer] = (),
) -> Work[RayCounts]:
    """Trace a queue of generation 0, whose hits are known, and all its descendants onto the film.

    `budget` bounds the bytes of queues alive at a time: TooLarge before more is allocated, and before
    dispersion makes more rays of several pixels than caches are good for. `observers` are told of each pass.
    """
    counts, first = RayCounts(), queue
    divisible = queue.n > max(1, int(queue.pixels.samples))  # there are more pixels, or rays, than one
    film.add_terms(world, queue, hits, last=max_depth == 0, observers=observers)
    queues = [(queue, hits)]
    for generation in range(max_depth + 1):
        parents: list[tuple[Queue, QueueHits, Shaded]] = []
        for queue, hits in queues:
            shaded = passes.shade(device, world, queue, hits, last=generation == max_depth)
            parents.append((queue, hits, shaded))
            tell(observers, "shade", generation, queue, shaded)
        yield parents[-1][2].counted
        if budget is not None:
            _check_size(device, world, parents, divisible, budget)
        for queue, hits, shaded in parents:
            feelers = passes.feelers(device, world, queue, hits, shaded)
            tell(observers, "feelers", generation, queue, feelers)
            passes.illuminate(device, world, queue, hits, shaded, feelers)
            tell(observers, "illuminate", generation, queue, shaded)
            film.add(queue, shaded, generation)
            tell(observers, "gather", generation, queue, film)
            counts.add(generation, queue, shaded)
        queues = []
        for kind, narrow in spawned_kinds(device):
            child = passes.spawn(device, world, kind, generation, parents, narrow)
            if child:
                tell(observers, "spawn", generation + 1, child, child)
                queues.append((child, passes.closest(device, world, child)))
                tell(observers, "closest", generation + 1, *queues[-1])
        if not queues:
            break
    if world.flat.media is not None or world.tinted:
        overflow = device.ask(first.overflow, np.empty(1, np.uint32))
        yield overflow
        if what := int(overflow.wait()[0]):
            raise _refused(world, what)
    return counts


def _refused(world: World, what: int) -> LimitError:
    """The error for a value of layout.OVERFLOW."""
    if world.flat.media is not None and what == layout.OVERFLOW["MANY_MEDIA"]:
        return too_deep(world.flat.media.source)
    return LimitError(
        f"shadow: a feeler crosses more than {layout.PANES:,} surfaces that let light through; use fewer "
        'of them in a row, or shadow = "opaque"'
    )


def _check_size(
    device: Device, world: World, parents: list[tuple[Queue, QueueHits, Shaded]], divisible: bool, budget: int
) -> None:
    lanes = device.settings.lanes
    need = most_feelers = narrow = 0
    for queue, _, shaded in parents:
        ray_format = queue.device.ray_format
        children = sum(shaded.totals[stream] for stream in ("REFLECTION", "TRANSMISSION", "AMBIENT"))
        need += queue_bytes(queue.n, ray_format, lanes) + queue_bytes(children, ray_format, lanes)
        if shaded.totals.get("GROUPS"):
            narrow += shaded.totals["GROUPS"]
            need += queue_bytes(shaded.totals["GROUPS"], device.for_queue(True).ray_format, lanes)
        feelers = feeler_bytes(shaded.totals["FEELERS"], ray_format, lanes, world.tinted, world.surfaces)
        most_feelers = max(most_feelers, feelers)
    if need + most_feelers > budget or (narrow > _NARROW_RAYS and divisible):
        raise TooLarge


def spawned_kinds(device: Device) -> list[tuple[str, bool]]:
    """The queues of a generation, in their order: kind, and whether its rays carry one dispersion group."""
    kinds = (REFLECTION, TRANSMISSION, AMBIENT)
    widths = (False, True) if device.ray_format.group else (False,)
    return [(kind, narrow) for narrow in widths for kind in kinds]
