"""The observer that keeps what becomes of a pixel's rays, queue by queue."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Final

import numpy as np

from clrt import layout
from clrt.base.errors import LimitError
from clrt.device.device import Device
from clrt.engine.apart import Kept, LitBy, by_light, by_term
from clrt.engine.queues import AMBIENT, REFLECTION, TRANSMISSION, Queue, QueueHits
from clrt.engine.stage import Stage
from clrt.engine.world import World

MOST_RAYS: Final = 50_000  # of a pixel: a tree of more says nothing to a reader
_OF_A_RAY, _OF_A_SHARE = 40, 10  # numbers of a ray, and of what a light brings to it, beside those by band

_SPAWNS: Final = {
    REFLECTION: layout.SPAWN["SPAWN_REFLECTION"],
    TRANSMISSION: layout.SPAWN["SPAWN_TRANSMISSION"],
    AMBIENT: layout.SPAWN["SPAWN_AMBIENT"],
}


@dataclass(eq=False)
class Seen:
    """What was seen of a queue: arrays as `Stage.values` gives them, the number of the ray their last axis.

    parents: of each ray, the number of a queue of the generation before, and of a ray in it. emission,
    ambient, local: what needs no feeler, by term and in all. brings: with what the lights add; spawn: the
    words that say what each ray spawns.
    """

    generation: int
    queue: Queue
    rays: dict[str, np.ndarray]
    parents: list[tuple[int, int]]
    met: QueueHits | None = None
    hits: dict[str, np.ndarray] = field(default_factory=dict)
    emission: np.ndarray = field(default_factory=lambda: np.zeros((0, 0), np.float32))
    ambient: np.ndarray = field(default_factory=lambda: np.zeros((0, 0), np.float32))
    local: np.ndarray = field(default_factory=lambda: np.zeros((0, 0), np.float32))
    brings: np.ndarray = field(default_factory=lambda: np.zeros((0, 0), np.float32))
    spawn: np.ndarray = field(default_factory=lambda: np.zeros(0, np.uint32))
    lights: list[LitBy] = field(default_factory=list)


class Watcher:
    """An observer of a list of one pixel. `generations`: what it has seen of the queues of each."""

    def __init__(self, device: Device, world: World, depth: int) -> None:
        self._device, self._world, self._depth = device, world, depth
        self._alone = [world.lit_by(device, number) for number in range(len(world.flat.lights))]
        self._count, self._kept = 0, Kept()
        self.generations: list[list[Seen]] = []
        self.weights: list[float] = []  # of the samples, where there is a filter

    def __call__(self, stage: Stage) -> None:
        if stage.term:
            return
        if stage.name in ("generate", "spawn"):
            self._begin(stage)
            return
        if stage.name == "weigh_samples":
            self.weights = stage.values()["weights"].tolist()
            return
        seen = next((s for s in self.generations[stage.generation] if s.queue is stage.queue), None)
        if seen is None:
            return
        if isinstance(stage.wrote, QueueHits):
            seen.met, seen.hits = stage.wrote, stage.values()
        elif stage.name == "shade":
            values = stage.values()
            seen.local = values["local"]
            self._take_apart(seen, values["spawn"])
        elif stage.name == "illuminate":
            values = stage.values()
            seen.brings, seen.spawn = values["local"], values["spawn"]

    def _begin(self, stage: Stage) -> None:
        queue = stage.queue
        self._count += queue.n
        if self._count > MOST_RAYS:
            raise LimitError(
                f"explain: the pixel has more than {MOST_RAYS} rays; lower max_depth, spp or ambient_samples"
            )
        if len(self.generations) == stage.generation:
            self.generations.append([])
        parents: list[tuple[int, int]] = []
        if stage.generation:
            parents = parents_of(queue, self.generations[stage.generation - 1], self._world.ambient_samples)
        self.generations[stage.generation].append(Seen(stage.generation, queue, stage.values(), parents))

    def _take_apart(self, seen: Seen, spawn: np.ndarray) -> None:
        assert seen.met is not None
        where = self._device, self._world, seen.queue, seen.met, seen.generation == self._depth
        bands = len(seen.local)
        self._kept.check(seen.queue.n * (_OF_A_RAY + 8 * bands))
        seen.emission, seen.ambient = by_term(*where, "emission"), by_term(*where, "ambient")
        if (spawn & layout.SPAWN["SPAWN_FEELERS"]).any():
            self._kept.check(seen.queue.n * len(self._alone) * (_OF_A_SHARE + 3 * bands))
            for number, alone in enumerate(self._alone):
                seen.lights.append(by_light(where[0], alone, number, *where[2:], self._kept))


def parents_of(child: Queue, before: list[Seen], ambient_samples: int) -> list[tuple[int, int]]:
    """Of each ray of a pixel's new queue: numbers of a queue of the generation `before`, and of a ray in it.

    They stand by place of the film, those of one place queue by queue (`passes.spawn`); with a filter, each
    sample is a place of its own.
    """
    found: list[tuple[int, int]] = []
    for number, parent in enumerate(before):
        count = (parent.spawn & _SPAWNS[child.kind] != 0).astype(int)
        if child.kind == AMBIENT:
            count *= ambient_samples
        if parent.queue.narrow != child.narrow:  # rays of all bands make narrow ones by dispersion alone
            if parent.queue.narrow or child.kind != TRANSMISSION:
                continue
            count = (parent.spawn & layout.SPAWN["SPAWN_GROUPS"]) // layout.SPAWN["SPAWN_GROUP"]
        found += [(number, ray) for ray, times in enumerate(count.tolist()) for _ in range(times)]
    assert len(found) == child.n
    places = [seen.rays["pixel_of"].tolist() for seen in before]
    return sorted(found, key=lambda parent: places[parent[0]][parent[1]])  # a stable sort
