"""What hits send back, taken apart: each term and each light alone, and what stands in a feeler's way.

By the same passes as the picture's, run again with one term, or in the same world with one light.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from clrt import layout
from clrt.device.device import Device
from clrt.engine import passes
from clrt.engine.queues import Feelers, Queue, QueueHits
from clrt.engine.world import World
from clrt.raytree.tree import Crossing

_DIRECT: Final = layout.TERMS["TERM_DIFFUSE"] | layout.TERMS["TERM_HIGHLIGHT"]


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


def by_term(device: Device, world: World, queue: Queue, hits: QueueHits, last: bool, name: str) -> np.ndarray:
    """What a term that needs no feeler brings, weighted: (bands, n) float32. Rays that miss have none."""
    lit = passes.shade(device, world, queue, hits, last, layout.TERMS[f"TERM_{name.upper()}"])
    return lit.decoded(queue)["local"]


def by_light(device: Device, alone: World, queue: Queue, hits: QueueHits, last: bool) -> LitBy:
    """What the only light of a world brings."""
    found = []
    feelers = None
    for term in (layout.TERMS["TERM_DIFFUSE"], layout.TERMS["TERM_HIGHLIGHT"], _DIRECT):
        lit = passes.shade(device, alone, queue, hits, last, term)
        feelers = passes.feelers(device, alone, queue, hits, lit)
        passes.illuminate(device, alone, queue, hits, lit, feelers, term)
        found.append(lit.decoded(queue)["local"])
    assert feelers is not None
    diffuse, highlight, brings = found
    if not feelers.n:
        return LitBy(diffuse, highlight, brings, None, [])
    met = _met(device, alone, replace(queue, n=feelers.n, rays=feelers.rays), feelers)
    return LitBy(diffuse, highlight, brings, feelers.decoded(queue), met)


def _met(device: Device, world: World, feelers: Queue, lit: Feelers) -> list[tuple[Crossing, ...]]:
    """What each of these rays meets up to its t_max: all, as far as light comes through, where shadows are
    tinted, else the first. The surface of the light that they go to is none."""
    shapes, materials = world.flat.primitives["shape"], world.flat.primitives["material"]
    opaque = world.flat.materials["kt"] == 0
    found: list[list[Crossing]] = [[] for _ in range(feelers.n)]
    hits = passes.closest(device, world, feelers, crossing=False)
    own = feelers.words(lit.own, np.int32) if lit.own is not None else np.full(feelers.n, -1, np.int32)
    going = np.ones(feelers.n, bool)
    while True:
        t, primitive = feelers.words(hits.t, np.float32), feelers.words(hits.primitive, np.int32)
        going &= primitive >= 0
        for number in np.flatnonzero(going & (primitive != own)).tolist():
            blocks = not world.tinted or bool(opaque[materials[primitive[number]]])
            found[number].append(Crossing(int(shapes[primitive[number]]), float(t[number]), blocks))
            going[number] = not blocks
        if not going.any():
            return [tuple(met) for met in found]
        passes.next_hit(device, world, feelers, hits)
