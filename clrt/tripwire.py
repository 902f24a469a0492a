"""The tripwire of `--check`: the first number that is not finite, and where it arose.

NaN and infinity travel: found in a picture, they say nothing about their origin. So what each pass wrote is
read back and looked through, in the order of the passes. Infinite on purpose are only how far a ray may go,
and the distance of a miss.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np

from clrt import layout
from clrt.device import Device
from clrt.errors import ClrtError
from clrt.queues import Feelers, Hits, Lit, Queue
from clrt.world import World

if TYPE_CHECKING:
    from clrt.film import Film

Parents = list[tuple[Queue, Hits, Lit]]
_DIRECTED = layout.RAY_FIELDS.index("T_MAX")  # fields of a ray before it: origin and direction


class Tripwire:
    """Watches the rays of one tile: `pixels` are the numbers of its pixels in a picture `width` wide.

    With `width` 0 they are numbers of a caller's rays. All methods raise ClrtError.
    """

    def __init__(self, device: Device, world: World, pixels: np.ndarray, width: int = 0) -> None:
        self.device, self.world, self.pixels, self.width = device, world, pixels, width

    def rays(self, name: str, generation: int, queue: Queue, hits: Hits, parents: Parents) -> None:
        """What the pass `name` wrote, and then what its rays meet."""
        fields = self._blocks(queue.rays, queue.n, len(layout.RAY_FIELDS))[:, :_DIRECTED]
        if generation == 0 and not self.width:
            fields[:] = 0  # a caller's rays need not be finite: such rays miss
        for what, values in (("ray", fields), ("weight", self._bands(queue.weight, queue.n))):
            self._look(name, what, values, generation, queue, lambda row: self._left(parents, queue, row))
        hit = self._words(hits.code, queue.n, np.int32) >= 0
        distance = np.where(hit, self._words(hits.t, queue.n, np.float32), 0)[:, None]
        surfaces = self._blocks(hits.surfaces, queue.n, layout.surface_fields(self.device.media))
        surfaces = np.where(hit[:, None], surfaces[:, : len(layout.SURFACE_FIELDS)], 0)
        for name, values in (("closest", distance), ("surface", surfaces)):
            self._look(name, "hit", values, generation, queue, lambda row: self._shape(hits, queue, row))

    def light(
        self, generation: int, queue: Queue, hits: Hits, lit: Lit, name: str = "light", what: str = "local"
    ) -> None:
        """What a queue's hits send back, after the pass `name`: `what` light."""
        bright = self._words(lit.spawn, queue.n) & layout.SPAWN["SPAWN_LOCAL"] != 0
        local = np.where(bright[:, None], self._bands(lit.local, queue.n), 0)
        self._look(name, f"{what} light", local, generation, queue, lambda row: self._shape(hits, queue, row))

    def illumination(
        self, generation: int, queue: Queue, hits: Hits, lit: Lit, feelers: Feelers, film: Film
    ) -> None:
        """A queue's feelers, what its hits send back with the lights, and the film after that was added."""

        def shape(row: int) -> str:
            return self._shape(hits, queue, row)

        if feelers.n:
            rays = self._blocks(feelers.rays, feelers.n, len(layout.RAY_FIELDS))[:, :_DIRECTED]
            owner = self._words(feelers.owner, feelers.n)
            self._look("feelers", "feeler", rays, generation, queue, shape, owner)
        self.light(generation, queue, hits, lit, "illuminate", "direct")
        size = (len(film.planes), film.pixels, self.device.bands)
        sums = self.device.read(film.sums, np.empty(size, np.float32))
        sums = sums[:, self._words(queue.pixel_of, queue.n)].transpose(1, 0, 2).reshape(queue.n, -1)
        self._look("gather", "sum of the film", sums, generation, queue, shape)

    def _look(
        self,
        name: str,
        what: str,
        values: np.ndarray,
        generation: int,
        queue: Queue,
        shape: Callable[[int], str],
        owner: np.ndarray | None = None,
    ) -> None:
        """Raise for the first row of `values` that is not all finite; `owner`: its place in `queue`."""
        wrong = ~np.isfinite(values)
        if not wrong.any():
            return
        row = int(np.argmax(wrong.any(axis=1)))
        value = float(values[row][wrong[row]][0])
        row = row if owner is None else int(owner[row])
        number = int(self.pixels[self._words(queue.pixel_of, queue.n)[row]])
        where = f"pixel ({number % self.width}, {number // self.width})" if self.width else f"ray {number}"
        raise ClrtError(
            f"check: {what} is {value} after the pass {name}, at {where}, generation {generation}, "
            f"{queue.kind} ray, {shape(row)}"
        )

    def _shape(self, hits: Hits, queue: Queue, row: int) -> str:
        primitive = int(self._words(hits.primitive, queue.n, np.int32)[row])
        if primitive < 0:
            return "which meets nothing"
        shape = int(self.world.flat.primitives["shape"][primitive])
        return f"which meets shapes[{shape}] (primitive {primitive})"

    def _left(self, parents: Parents, child: Queue, row: int) -> str:
        """The surfaces that a ray of this pixel may have left."""
        place = self._words(child.pixel_of, child.n)[row]
        left: dict[int, None] = {}
        for queue, hits, _ in parents:
            primitives = self._words(hits.primitive, queue.n, np.int32)
            here = primitives[self._words(queue.pixel_of, queue.n) == place]
            left |= dict.fromkeys(self.world.flat.primitives["shape"][here[here >= 0]].tolist())
        return "which left " + (" or ".join(f"shapes[{shape}]" for shape in left) or "the camera")

    def _words(self, buffer: Any, n: int, kind: type[np.generic] = np.uint32) -> np.ndarray:
        return self.device.read(buffer, np.empty(n, kind))

    def _bands(self, buffer: Any, n: int) -> np.ndarray:
        return self._blocks(buffer, n, self.device.bands)

    def _blocks(self, buffer: Any, n: int, fields: int) -> np.ndarray:
        """(n, fields) of a buffer of blocks."""
        lanes = self.device.settings.lanes
        blocks = self.device.read(buffer, np.empty((-(-n // lanes), fields, lanes), np.float32))
        return blocks.transpose(0, 2, 1).reshape(-1, fields)[:n]
