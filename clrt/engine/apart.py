"""What hits send back, taken apart: each term and each light alone, and what stands in a feeler's way.

By the same passes as the picture's, run again with one term, or in the same world with one light.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Final

import numpy as np

from clrt import layout
from clrt.base.errors import LimitError
from clrt.device.device import Device
from clrt.engine import passes
from clrt.engine.batch import Batch
from clrt.engine.queries import all_hits, count_hits
from clrt.engine.queues import Queue, QueueHits
from clrt.engine.world import World
from clrt.raytree.tree import Crossing

MOST_FEELERS: Final = 100_000  # of a pixel: a tree of more says nothing to a reader
MOST_NUMBERS: Final = 10_000_000  # that a pixel's tree may keep: of 40 bytes each, as measured
_OF_A_FEELER, _OF_A_CROSSING = 20, 4  # numbers, beside those by band
_DIRECT: Final = layout.TERMS["TERM_DIFFUSE"] | layout.TERMS["TERM_HIGHLIGHT"]


@dataclass
class Kept:
    """What a pixel's tree keeps so far."""

    feelers: int = 0
    numbers: int = 0

    def check(self, more: int) -> None:
        """So many numbers come; LimitError beyond MOST_NUMBERS, or with more than MOST_FEELERS."""
        self.numbers += more
        what = f"more than {MOST_FEELERS} shadow feelers" if self.feelers > MOST_FEELERS else (
            f"rays, lights and surfaces between them of more than {MOST_NUMBERS} numbers")  # fmt: skip
        if self.feelers > MOST_FEELERS or self.numbers > MOST_NUMBERS:
            advice = "lower samples of lights, ambient_samples, spp or max_depth"
            raise LimitError(f"explain: the pixel has {what}; {advice}")


@dataclass(frozen=True)
class LitBy:
    """What one light brings to the n rays of a queue, (bands, n) float32, weighted; and its feelers.

    feelers: as `Feelers.decoded` gives them. met: what each of them meets. None: it sends none.
    """

    diffuse: np.ndarray
    highlight: np.ndarray
    brings: np.ndarray
    feelers: dict[str, np.ndarray] | None
    met: list[tuple[Crossing, ...]]

    def of(self, ray: int) -> list[int]:
        """The numbers of a ray's feelers."""
        return self._owned.get(ray, [])

    @cached_property
    def _owned(self) -> dict[int, list[int]]:
        owned: dict[int, list[int]] = {}
        for number, owner in enumerate([] if self.feelers is None else self.feelers["owner"].tolist()):
            owned.setdefault(owner, []).append(number)
        return owned


def by_term(device: Device, world: World, queue: Queue, hits: QueueHits, last: bool, name: str) -> np.ndarray:
    """What a term that needs no feeler brings, weighted: (bands, n) float32. Rays that miss have none."""
    lit = passes.shade(device, world, queue, hits, last, layout.TERMS[f"TERM_{name.upper()}"])
    return lit.decoded(queue)["local"]


def by_light(
    device: Device, alone: World, number: int, queue: Queue, hits: QueueHits, last: bool, kept: Kept
) -> LitBy:
    """What the light of this number brings, in a world where it is alone. LimitError as of `Kept`."""
    found = []
    feelers = None
    for term in (layout.TERMS["TERM_DIFFUSE"], layout.TERMS["TERM_HIGHLIGHT"], _DIRECT):
        lit = passes.shade(device, alone, queue, hits, last, term)
        feelers = passes.feelers(device, alone, queue, hits, lit)
        passes.illuminate(device, alone, queue, hits, lit, feelers, term)
        found.append(lit.decoded(queue)["local"])
    assert feelers is not None
    diffuse, highlight, brings = found
    kept.feelers += feelers.n
    kept.check(feelers.n * (_OF_A_FEELER + len(diffuse)))
    if not feelers.n:
        return LitBy(diffuse, highlight, brings, None, [])
    words = feelers.decoded(queue)
    return LitBy(diffuse, highlight, brings, words, _met(device, alone, number, words, kept))


def _met(
    device: Device, world: World, light: int, feelers: dict[str, np.ndarray], kept: Kept
) -> list[tuple[Crossing, ...]]:
    """What stands in each feeler's way: all that light comes through, up to what blocks it.

    Where shadows are opaque, the first surface does. The light's own surface is in nobody's way.
    """
    batch = Batch(feelers["origin"].T, feelers["direction"].T, 0.0, feelers["t_max"])
    kept.check(_OF_A_CROSSING * int(count_hits(device, world, batch).sum(dtype=np.int64)))
    crossed = all_hits(device, world, batch, ("t", "primitive", "shape"), None)
    materials, opaque = world.flat.primitives["material"], world.flat.materials["kt"] == 0
    found = []
    for ray, seen in enumerate(feelers["seen"].tolist()):
        met: list[Crossing] = []
        for k in range(int(crossed.splits[ray]), int(crossed.splits[ray + 1])):
            shape, primitive = int(crossed.shape[k]), int(crossed.primitive[k])
            if shape == world.flat.n_shapes + light:
                continue
            blocks = not seen and (not world.tinted or bool(opaque[materials[primitive]]))
            if seen and not world.tinted:
                break
            met.append(Crossing(shape, float(crossed.t[k]), blocks))
            if blocks:
                break
        found.append(tuple(met))
    return found
