"""The float32 twin's lists of media: where rays start, which boundaries they see, what is absorbed."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from clrt import layout
from clrt.flatten.flatten import FlatScene
from clrt.flatten.media import too_deep

from .edges import nearest_faces, touched
from .geometry import (
    BEFORE_ALL,
    KINDS,
    NO_PRIMITIVE,
    Hits,
    Rays,
    nearest_hit,
    primitives_of,
    quadric_clips,
    quadric_form,
    to_axes,
)
from .math import Array, dot, exponential, unit, xyz
from .queues import Queue
from .surface import Surface, bands, surface_at

_NONE = -1
_BESIDE = np.float32(layout.BESIDE)
_WAY = (0.5698, 0.3713, 0.7331)  # which edges and planes of no scene have


@dataclass(frozen=True)
class Crossed:
    """A queue after its way through all boundaries that it does not see, and its hits.

    before, after: (n,) int32, the materials whose indices meet at the hits; None where rays carry no lists.
    """

    queue: Queue
    hits: Hits
    before: Array | None = None
    after: Array | None = None

    def iors(
        self, flat: FlatScene, s: Surface, which: Array, band: Array | int | None = None
    ) -> tuple[Array, Array]:
        """On the rays' side and behind the surfaces `s` that the rays `which` hit, in a band of each."""
        around = flat.scene["medium_ior"][0]
        if self.before is None or self.after is None:
            metal = s.material["fresnel"] == layout.FRESNEL["CONDUCTOR"]
            enters = (s.material["thin"] != 0) | ~s.inside | metal
            own = s.material["ior"] if band is None else s.material["band_ior"][np.arange(len(which)), band]
            return np.where(enters, around, own), np.where(enters, own, around)
        before, after = self.before[which], self.after[which]
        if band is None:
            ior = np.append(flat.materials["ior"], around)  # _NONE is the last
            return ior[before], ior[after]
        index = np.append(flat.materials["band_ior"], np.full((1, flat.bands), around), axis=0)
        return index[before, band], index[after, band]


def immersed(flat: FlatScene, queue: Queue) -> Queue:
    """The queue with the media in which its rays' origins lie."""
    if flat.media is None:
        return queue
    return replace(queue, media=flat.media.lists(queue.rays.origin.T).T.copy())


def crossed(flat: FlatScene, queue: Queue, hits: Hits) -> Crossed:
    """Through boundaries that leave the top of a ray's list unchanged, to the first that does not."""
    if queue.media is None:
        return Crossed(queue, hits)
    lists, t, primitive = queue.media.copy(), hits.t.copy(), hits.primitive.copy()
    before = top(flat, lists)
    after = before.copy()
    going = np.flatnonzero(primitive != NO_PRIMITIVE)
    while len(going):
        rays = queue.rays[going]
        s = surface_at(flat, rays, Hits(t[going], primitive[going]))
        own = primitives_of(flat)["material"][primitive[going]].astype(np.int32)
        beside = (t[going] <= _BESIDE * s.offset) & _solids_are_listed(flat, lists[:, going], s, t[going])
        at, other = touched(flat, rays, lists[:, going], s, Hits(t[going], primitive[going]), beside)
        t[going[at]], primitive[going[at]] = other.t, other.primitive
        beside[at] = True
        lists[:, going], following = _next_lists(flat, lists[:, going], s, beside)
        old, new = top(flat, lists[:, going]), top(flat, following)
        solid = s.material["medium"] == _NONE
        metal = s.material["fresnel"] == layout.FRESNEL["CONDUCTOR"]
        behind = solid & s.inside & (s.material["thin"] == 0) & ~metal
        before[going] = np.where(behind, own, old)
        after[going] = np.where(behind, old, np.where(solid, own, new))
        unseen = ~solid & (old == new)
        lists[:, going[unseen]] = following[:, unseen]
        going = going[unseen]
        further = nearest_faces(flat, queue.rays[going], Hits(t[going], primitive[going]))
        t[going], primitive[going] = further.t, further.primitive
        going = going[further.primitive != NO_PRIMITIVE]
    weight = queue.weight * transmittance(flat, top(flat, lists), t)
    return Crossed(replace(queue, media=lists, weight=weight), Hits(t, primitive), before, after)


def first_seen(flat: FlatScene, queue: Queue) -> Hits:
    """The hits of rays of generation 0, past all boundaries that they do not see."""
    return crossed(flat, immersed(flat, queue), nearest_faces(flat, queue.rays)).hits


def top(flat: FlatScene, lists: Array) -> Array:
    """Of lists (places, n), the material of the highest priority, the last one among equals; (n,) int32."""
    priority = np.append(flat.materials["priority"], np.int32(-(2**31)))[lists]
    last = len(lists) - 1 - priority[::-1].argmax(axis=0)
    return np.where(lists[0] == _NONE, _NONE, lists[last, np.arange(lists.shape[1])]).astype(np.int32)


def transmittance(flat: FlatScene, medium: Array, t: Array) -> Array:
    """exp(-sigma t) in each medium, 1 where nothing absorbs: (bands, n)."""
    absorption = bands(flat.materials["absorption"])[:, medium]
    absorbs = (medium != _NONE) & (absorption > 0.0)
    return np.where(absorbs, exponential(-absorption * t), np.float32(1.0))


def _solids_are_listed(flat: FlatScene, lists: Array, s: Surface, t: Array) -> Array:
    """Whether so many solids of a surface's medium hold the point on its inner side as the list has of it."""
    medium = s.material["medium"]
    times, found = (lists == medium).sum(axis=0), np.zeros(len(t), np.int64)
    asked = np.flatnonzero((medium != _NONE) & ((times > 0) != s.inside) & (t <= _BESIDE * s.offset))
    off = s.n * s.offset
    origin = np.where(s.inside, s.point + off, s.point - off)
    way = unit(np.array(_WAY, np.float32)[:, None])
    primitives, endless = primitives_of(flat), flat.unbounded[: flat.scene["unbounded"][0]]
    for number in endless:
        same = flat.materials["medium"][primitives["material"][number]] == medium[asked]
        found[asked] += same & _holds(flat, number, origin[:, asked])
    going, after = asked, Hits(np.zeros(len(asked), np.float32), np.full(len(asked), BEFORE_ALL))
    while len(going):
        far = np.full(len(going), np.inf, np.float32)
        rays = Rays(origin[:, going], np.repeat(way, len(going), axis=1), far)
        hits = nearest_hit(flat, rays, after)
        met = hits.primitive != NO_PRIMITIVE
        going, after = going[met], Hits(hits.t[met], hits.primitive[met])
        if len(going):
            there = surface_at(flat, rays[met], after)
            same = (there.material["medium"] == medium[going]) & ~np.isin(after.primitive, endless)
            found[going] += np.where(same, np.where(there.inside, 1, -1), 0)
    out = np.zeros(len(t), bool)
    out[asked] = found[asked] == times[asked]
    return out


def _holds(flat: FlatScene, number: int, point: Array) -> Array:
    """Whether a plane or endless quadric has points on its inner side."""
    primitive = primitives_of(flat)[number : number + 1]
    if primitive["kind"][0] == KINDS["PLANE"]:
        plane = flat.planes[primitive["index"]]
        return np.asarray(dot(xyz(plane["normal"]), point - xyz(plane["point"])) < 0.0)
    q = flat.quadrics[primitive["index"]]
    axes, form, g, constant = quadric_form(q)
    local = point - xyz(q["center"])
    x = to_axes(axes, local)
    return np.asarray((dot(x, (form * x + g) + g) + constant < 0.0) & quadric_clips(q, local))


def _next_lists(
    flat: FlatScene, lists: Array, s: Surface, beside: Array | bool = False
) -> tuple[Array, Array]:
    """The lists on this side of surfaces and those behind them.

    beside: where rays may have crossed an edge by its other side.
    """
    medium = s.material["medium"]
    is_medium = medium != _NONE
    listed = ((lists == medium) & is_medium).any(axis=0)
    is_medium &= ~np.asarray(beside)
    here = _entered(flat, lists, medium, is_medium & s.inside & ~listed)
    behind = _entered(flat, here, medium, is_medium & ~s.inside)
    return here, _left(behind, medium, is_medium & s.inside)


def handed_on(flat: FlatScene, lists: Array, s: Surface) -> Array:
    """The lists of rays that go on behind the surfaces."""
    return _next_lists(flat, lists, s)[1]


def _entered(flat: FlatScene, lists: Array, medium: Array, where: Array) -> Array:
    out = lists.copy()
    size = (lists != _NONE).sum(axis=0)
    if (size[where] == layout.MEDIA).any():
        assert flat.media is not None
        raise too_deep(flat.media.source)
    (ray,) = np.nonzero(where)
    out[size[ray], ray] = medium[ray]
    return out


def _left(lists: Array, medium: Array, where: Array) -> Array:
    out = lists.copy()
    for ray in np.flatnonzero(where):
        at = np.flatnonzero(lists[:, ray] == medium[ray])[-1]
        out[:, ray] = np.append(np.delete(lists[:, ray], at), _NONE)
    return out
