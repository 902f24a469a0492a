"""The float32 twin's rays at edges and corners, where two faces of a solid are in one place."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from clrt.flatten.flatten import FlatScene

from .geometry import NO_PRIMITIVE, Hits, Rays, nearest_hit
from .math import Array, dot, smaller
from .surface import Surface, place_width, surface_at

_FACES = 8  # of one place
_PARALLEL = np.float32(0.999)  # cosine of the angle between faces that are no edge, but one upon the other
_NONE = -1


def nearest_faces(flat: FlatScene, rays: Rays, after: Hits | None = None) -> Hits:
    """Nearest hits; in the place of opaque inner sides at edges, the faces rays meet from outside there."""
    hits = nearest_hit(flat, rays) if after is None else nearest_hit(flat, rays, after)
    out = Hits(hits.t.copy(), hits.primitive.copy())
    which = np.flatnonzero(hits.primitive != NO_PRIMITIVE)
    met = Hits(hits.t[which], hits.primitive[which])
    s = surface_at(flat, rays[which], met)
    asked = s.inside & s.at_edge & (s.material["medium"] == _NONE)
    which, s, met = which[asked], s[asked], Hits(met.t[asked], met.primitive[asked])
    back, faces = [s.n], []  # normals of inner sides; rays, hits and normals of outer ones

    def visit(going: Array, other: Hits, there: Surface) -> Array:
        face = ~there.inside & there.at_edge
        faces.append((going[face], Hits(other.t[face], other.primitive[face]), there.outward[:, face]))
        back.append(np.zeros((3, len(which)), np.float32))
        back[-1][:, going[there.inside]] = there.outward[:, there.inside]
        return np.ones(len(going), bool)

    _visit_place(flat, rays[which], s.n, met, np.arange(len(which)), visit)
    for going, other, outward in reversed(faces):  # the first is what counts
        upon = [np.abs(dot(outward, normal[:, going])) >= _PARALLEL for normal in back]
        alone = ~np.any(upon, axis=0)
        at = which[going[alone]]
        out.t[at], out.primitive[at] = other.t[alone], other.primitive[alone]
    return out


def touched(
    flat: FlatScene, rays: Rays, lists: Array, s: Surface, hits: Hits, beside: Array
) -> tuple[Array, Hits]:
    """Rays that only touch an edge or corner, and the last hits of their medium there.

    They leave a solid of the medium and enter it at once, or the other way round.
    """
    medium, last = s.material["medium"], Hits(hits.t.copy(), hits.primitive.copy())
    listed = (lists == medium).any(axis=0)
    asked = np.where(s.inside, s.at_edge | ~listed, s.at_edge & ~listed)
    both = np.zeros(len(medium), bool)

    def visit(going: Array, other: Hits, there: Surface) -> Array:
        same = there.material["medium"] == medium[going]
        at = going[same]
        both[at] |= there.inside[same] != s.inside[at]
        last.t[at], last.primitive[at] = other.t[same], other.primitive[same]
        return same

    _visit_place(flat, rays, s.n, hits, np.flatnonzero(asked & (medium != _NONE) & ~beside), visit)
    which = np.flatnonzero(both)
    return which, Hits(last.t[which], last.primitive[which])


def _visit_place(
    flat: FlatScene,
    rays: Rays,
    normal: Array,
    hits: Hits,
    going: Array,
    visit: Callable[[Array, Hits, Surface], Array],
) -> None:
    """What rays `going` meet where their hits are, one after the other, as long as visit(rays, hits,
    surfaces) says so of each."""
    last = Hits(hits.t.copy(), hits.primitive.copy())
    near = place_width(rays, rays.origin + rays.direction * hits.t)
    slope = np.abs(dot(normal, rays.direction))
    for _ in range(_FACES):
        other = nearest_hit(flat, rays[going], Hits(last.t[going], last.primitive[going]))
        met = other.primitive != NO_PRIMITIVE
        going, other = going[met], Hits(other.t[met], other.primitive[met])
        if not len(going):
            return
        last.t[going], last.primitive[going] = other.t, other.primitive
        there = surface_at(flat, rays[going], other)
        flatter = smaller(slope[going], np.abs(dot(there.outward, rays[going].direction)))
        same = (other.t - hits.t[going]) * flatter <= near[going]
        going, other = going[same], Hits(other.t[same], other.primitive[same])
        going = going[visit(going, other, there[same])]
