"""The tripwire of `--check`: the first number that is not finite, and where it arose.

NaN and infinity travel: found in a picture, they say nothing about their origin. So what each pass wrote is
read back and looked through, in the order of the passes. Infinite on purpose are only how far a ray may go,
and the distance of a miss.
"""

from __future__ import annotations

from typing import Final

import numpy as np

from clrt.base.errors import ClrtError
from clrt.engine.queues import Queue, QueueHits
from clrt.engine.stage import Stage
from clrt.engine.world import World

# by stage: the pass that wrote them, what they are, the values
_LINES: Final = ("ray", ("origin", "direction"))
_LOOKED_AT: Final[dict[str, tuple[tuple[str, str, tuple[str, ...]], ...]]] = {
    "generate": (("generate", *_LINES), ("generate", "weight", ("weight",))),
    "adopt": (("adopt", "weight", ("weight",)),),  # a caller's rays need not be finite: such rays miss
    "spawn": (("spawn {kind}", *_LINES), ("spawn {kind}", "weight", ("weight",))),
    "closest": (
        ("closest", "hit", ("t",)),
        ("surface", "hit", ("point", "n", "ns", "offset")),
        ("cross_boundaries", "weight", ("weight",)),
    ),
    "shade": (("shade", "local light", ("local",)),),
    "feelers": (("feelers", "feeler", ("origin", "direction")),),
    "illuminate": (("illuminate", "direct light", ("local",)),),
    "gather": (("gather", "sum of the film", ("sums",)),),
}


class NotFinite(ClrtError):
    """A number that is not finite where none is meant to be."""


class Tripwire:
    """Watches the rays of one tile: `pixels` are the numbers of its pixels in a picture `width` wide.

    With `width` 0 they are numbers of a caller's rays. An observer, which raises NotFinite.
    """

    def __init__(self, world: World, pixels: np.ndarray, width: int = 0) -> None:
        self._shapes, self._pixels, self._width = world.flat.primitives["shape"], pixels, width
        # what the queues of a generation and the last one hit
        self._met: list[tuple[int, Queue, QueueHits]] = []

    def __call__(self, stage: Stage) -> None:
        if stage.name not in _LOOKED_AT:
            return
        values = stage.values()
        if isinstance(stage.wrote, QueueHits):
            self._met = [met for met in self._met if met[0] >= stage.generation - 1]
            self._met.append((stage.generation, stage.queue, stage.wrote))
            values["t"] = np.where(values["primitive"] < 0, 0, values["t"])
        ray = values.get("owner", np.arange(stage.queue.n))
        if stage.name == "gather":
            values["sums"] = values["sums"][..., stage.queue.words(stage.queue.pixel_of)]
        for name, what, parts in _LOOKED_AT[stage.name] if len(ray) else ():
            rows = [values[part].reshape(-1, len(ray)) for part in parts if part in values]
            if rows:
                self._look(stage, name.format(kind=stage.kind), what, np.concatenate(rows), ray)

    def _look(self, stage: Stage, name: str, what: str, values: np.ndarray, ray: np.ndarray) -> None:
        """Raise for the first item of `values` (numbers, items) that is not all finite, with its `ray`."""
        wrong = ~np.isfinite(values)
        if not wrong.any():
            return
        item = int(np.argmax(wrong.any(axis=0)))
        place = int(stage.queue.words(stage.queue.pixel_of)[ray[item]])
        number, width = int(self._pixels[place]), self._width
        where = f"pixel ({number % width}, {number // width})" if width else f"ray {number}"
        made, layer = stage.wrote is stage.queue, f" of the layer {stage.term}" if stage.term else ""
        raise NotFinite(
            f"check: {what}{layer} is {float(values[wrong[:, item], item][0])} after the pass {name}, "
            f"at {where}, generation {stage.generation}, {stage.kind} ray, "
            + (self._left(stage, place) if made else self._shape(stage, int(ray[item])))
        )

    def _shape(self, stage: Stage, ray: int) -> str:
        hits = next(hits for _, queue, hits in self._met if queue is stage.queue)
        primitive = int(stage.queue.words(hits.primitive, np.int32)[ray])
        if primitive < 0:
            return "which meets nothing"
        return f"which meets shapes[{int(self._shapes[primitive])}] (primitive {primitive})"

    def _left(self, stage: Stage, place: int) -> str:
        """The surfaces that a ray of the pixel at this place of the tile may have left."""
        left: dict[int, None] = {}
        for generation, queue, hits in self._met:
            if generation == stage.generation - 1:
                here = queue.words(hits.primitive, np.int32)[queue.words(queue.pixel_of) == place]
                left |= dict.fromkeys(self._shapes[here[here >= 0]].tolist())
        return "which left " + (" or ".join(f"shapes[{shape}]" for shape in left) or "the camera")
