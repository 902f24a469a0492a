"""The float32 twin's dispersion: groups of bands that are bent alike, and narrow rays of one group each.

A narrow ray's arrays have a row for every band of the scene, as all rays' have here; those outside its group
are zeros. What a device keeps of it is `carried`.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from clrt.flatten.flatten import FlatScene

from .math import Array
from .media import Crossed
from .shading import Bounce, bounce_at
from .surface import Surface


@dataclass(frozen=True)
class Groups:
    """The bounces (groups,) of rays of all bands, by each group's first band, and where they part (n,)."""

    first: list[int]
    bounces: list[Bounce]
    dispersing: Array


def bounces(flat: FlatScene, at: Crossed, s: Surface, which: Array) -> tuple[Bounce, Groups]:
    """What becomes of rays `which` at surfaces `s`: by band, and by group where rays are of all bands."""
    u, narrow, streams = at.queue.rays.direction[:, which], at.queue.band, at.queue.streams[which]
    nowhere = Groups([], [], np.zeros(len(which), bool))
    if flat.group == 0:
        return bounce_at(s, u, *at.iors(flat, s, which), streams), nowhere
    if narrow is not None:
        return bounce_at(s, u, *at.iors(flat, s, which, narrow[which]), streams), nowhere
    first = list(range(0, flat.bands, flat.group))
    parts = [bounce_at(s, u, *at.iors(flat, s, which, band), streams) for band in first]
    rows = [slice(band, band + flat.group) for band in first]
    whole = Bounce(
        parts[0].reflected,
        parts[0].transmitted,
        np.concatenate([part.reflect[row] for part, row in zip(parts, rows, strict=True)]),
        np.concatenate([part.transmit[row] for part, row in zip(parts, rows, strict=True)]),
        np.any([part.total_internal for part in parts], axis=0),
    )
    return whole, Groups(first, parts, _dispersing(flat, at, s, which))


def _dispersing(flat: FlatScene, at: Crossed, s: Surface, which: Array) -> Array:
    """Is the index on either side a curve: (n,) bool."""
    if at.before is None or at.after is None:
        return np.asarray(s.material["dispersive"] != 0)
    curved = np.append(flat.materials["dispersive"] != 0, False)  # -1, no medium, is the last
    return np.asarray(curved[at.before[which]] | curved[at.after[which]])


def own_bands(flat: FlatScene, band: Array) -> Array:
    """(bands, n): those of narrow rays whose first bands these are."""
    row = np.arange(flat.bands)[:, None]
    return np.asarray((row >= band) & (row < band + flat.group))


def carried(flat: FlatScene, values: Array, band: Array | None, beyond: bool = False) -> Array:
    """What a device keeps of values (bands, n): for narrow rays (group + 1, n), last the first band.

    In an incomplete group zeros stand for the bands that there are not; with `beyond` the last band does.
    """
    if band is None:
        return values
    row = band + np.arange(flat.group)[:, None]
    inside = row < flat.bands
    kept = np.take_along_axis(values, np.minimum(row, flat.bands - 1), axis=0)
    kept = np.where(inside | beyond, kept, np.float32(0.0))
    return np.concatenate([kept, band.astype(np.int32).view(np.float32)[None]])
