"""What observers of the loop are told: a record for each pass and queue."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from clrt.engine.queues import Queue


@dataclass(frozen=True)
class Stage:
    """What one pass did for the rays of one queue.

    name: of the pass: "generate" or "adopt", with a filter "weigh_samples", "closest", "shade", "feelers",
    "illuminate", "gather", "spawn", and once for a tile "geometry", "resolve", "develop". wrote: what it made
    or changed on the device (a Queue, Weights, QueueHits, Shaded, Feelers, Film), or arrays; who changes it
    in turn changes the picture. term: of local light, where a layer has the pass for that one alone.
    """

    name: str
    generation: int
    queue: Queue
    wrote: Any
    term: str = ""

    @property
    def kind(self) -> str:
        """Of the rays: "camera", "reflection", "transmission", "ambient"."""
        return self.queue.kind

    def values(self) -> dict[str, np.ndarray]:
        """What the pass wrote, read back now: by the time the next pass has run it may be something else.

        Arrays by name; the number of the ray (feeler, pixel) is their last axis.
        """
        return self.wrote if isinstance(self.wrote, dict) else self.wrote.decoded(self.queue)


Observer = Callable[[Stage], None]


def tell(
    observers: Sequence[Observer], name: str, generation: int, queue: Queue, wrote: Any, term: str = ""
) -> None:
    """Hand each of the observers the record of a pass that has just been launched."""
    for observe in observers:
        observe(Stage(name, generation, queue, wrote, term))
