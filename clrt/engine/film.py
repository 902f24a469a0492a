"""The film of a tile: the picture and its layers as planes of sums on the device."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any, TypeVar

import numpy as np

from clrt import layout
from clrt.base.layers import Paths, Term, comes_from, find
from clrt.device.device import Device
from clrt.device.tracks import Answer
from clrt.engine import passes
from clrt.engine.queues import Queue, QueueHits, Shaded, Weights
from clrt.engine.stage import Observer, tell
from clrt.engine.world import World

Kind = TypeVar("Kind", Paths, Term)


class Film:
    """Planes of (pixels, bands) sums on the device: the picture, then a plane a layer of radiance.

    weights: what each of the samples counts for; their sums are then kept apart, and `pixels` is how many of
    these there are until the film is developed.
    """

    def __init__(
        self, device: Device, pixels: int, names: tuple[str, ...], weights: Weights | None = None
    ) -> None:
        self.device = device
        self.pixels = pixels * (weights.samples if weights else 1)
        self.weights = weights
        self.planes = ("image", *(name for name in names if comes_from(name, Paths, Term)))
        self.sources = ((Paths(),), *(find(name).sources for name in self.planes[1:]))
        self.nbytes = 4 * len(self.planes) * self.pixels * device.bands
        self.sums: Any = device.buffer(self.nbytes, "float")
        device.fill(self.sums, self.nbytes)

    def add(self, queue: Queue, shaded: Shaded, generation: int) -> None:
        """Add what a queue brings to its pixels, to the picture and to every layer it belongs to."""
        for plane, source in self._sources(Paths):
            if source.generation in (None, generation):
                mask = layout.PATH.get(source.mask, 0)
                value = mask if source.value is None else source.value
                passes.gather(self.device, queue, shaded, self.sums, plane, self.pixels, mask, value)

    def add_terms(
        self, world: World, queue: Queue, hits: QueueHits, last: bool, observers: Sequence[Observer] = ()
    ) -> None:
        """For layers of one term of generation 0: the passes of local light again, with that term only."""
        for plane, source in self._sources(Term):
            term, name = layout.TERMS[source.name], self.planes[plane]
            shaded = passes.shade(self.device, world, queue, hits, last, term)
            tell(observers, "shade", 0, queue, shaded, name)
            feelers = passes.feelers(self.device, world, queue, hits, shaded)
            tell(observers, "feelers", 0, queue, feelers, name)
            passes.illuminate(self.device, world, queue, hits, shaded, feelers, term)
            tell(observers, "illuminate", 0, queue, shaded, name)
            passes.gather(self.device, queue, shaded, self.sums, plane, self.pixels)
            tell(observers, "gather", 0, queue, self, name)

    def _sources(self, kind: type[Kind]) -> Iterator[tuple[int, Kind]]:
        """Of each plane that has such a source, the number and the source."""
        for plane, sources in enumerate(self.sources):
            yield from ((plane, source) for source in sources if isinstance(source, kind))

    def decoded(self, queue: Queue) -> dict[str, np.ndarray]:
        """`sums`, (planes, bands, pixels); means once it is developed."""
        size = len(self.planes), self.pixels, self.device.bands
        sums = self.device.read(self.sums, np.empty(size, np.float32))
        return {"sums": np.ascontiguousarray(sums.transpose(0, 2, 1))}

    def developing(self, samples: int, response: np.ndarray | None = None) -> Answer:
        """Turn the sums into means over the samples of each pixel, once; what `reading` gives of them."""
        values = len(self.planes) * self.pixels * self.device.bands
        if self.weights is None:
            self.device.launch("resolve", values, np.uint32(values), np.float32(samples), self.sums)
            return self.reading(response)
        self.pixels //= samples
        values //= samples
        means = self.device.buffer(4 * values, "float")
        light = self.sums, self.weights.buffer, np.uint32(self.pixels), np.uint32(samples)
        self.device.launch("weighted_means", values, np.uint32(values), *light, means)
        self.sums = means
        return self.reading(response)

    def reading(self, response: np.ndarray | None = None, planes: int | None = None) -> Answer:
        """The first `planes` planes (None: all), float32 (planes, pixels, rows of `response`).

        `response` (rows, bands) float32 is applied on the device, so that the host sees few values a pixel
        however many bands there are; without it the rows are the bands.
        """
        planes = len(self.planes) if planes is None else planes
        source, rows, n = self.sums, self.device.bands, planes * self.pixels
        if response is not None:
            rows, source = len(response), passes.develop(self.device, self.sums, n, response)
        return self.device.ask(source, np.empty((planes, self.pixels, rows), np.float32))
