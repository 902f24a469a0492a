"""What a ray meets that it can see: the surface there, and the media on both of its sides."""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np

from .edges import OFFSET, at_edge, nearest_faces, outward_of, touched
from .film import Rays
from .footprints import Seen
from .media import tidy
from .vectors import Array, Bools, Ints, across, dot
from .world import World

BESIDE = 64 * OFFSET  # nearer to its start a ray may have crossed an edge by its other side


@dataclass(frozen=True)
class Met:
    """The nearest visible hits of n rays; a miss has t = inf and primitive = -1."""

    t: Array
    primitive: Ints
    before: Ints  # (n, k): the media on the ray's side
    after: Ints  # (n, k): and beyond

    def __getitem__(self, index: Ints | Bools) -> Met:
        return Met(*(getattr(self, f.name)[index] for f in fields(self)))


@dataclass(frozen=True)
class Spot:
    """Where rays hit, one row a ray."""

    point: Array  # on the primitive
    outward: Array
    n: Array  # geometric normal on the ray's side
    ns: Array  # shading normal on the ray's side
    enters: Bools  # the ray comes from outside
    offset: Array
    back: Array  # (n, 3): from there, back along the rays
    shape: Ints
    color: Array  # F
    before: Ints  # media on the ray's side
    after: Ints  # and beyond
    highlight: Array  # H
    mirror: Array  # M
    tint: Array  # Tt
    emission: Array  # e
    cone: Array  # (n, 2): as in Rays, from the hit on

    def take(self, rows: Ints) -> Spot:
        return Spot(*(getattr(self, f.name)[rows] for f in fields(self)))

    @property
    def start_before(self) -> Array:
        """Origins of rays that stay on the side from which the rays came."""
        return np.asarray(self.point + self.offset[:, None] * self.n - self.back)

    @property
    def start_behind(self) -> Array:
        """Origins of rays that go on behind the surface."""
        return np.asarray(self.point - self.offset[:, None] * self.n)


def visible_hit(world: World, rays: Rays) -> Met:
    """Nearest hits, but not those of boundaries that leave the medium on top as it is: these are crossed."""
    origin, u, media = rays.origin, rays.direction, world.media
    t, primitive = nearest_faces(world, origin, u)
    before = after = rays.media
    if (media.number < 0).all():
        return Met(t, primitive, before, after)
    todo = np.flatnonzero(primitive >= 0)
    while todo.size:
        shape = world.shape_of[primitive[todo]]
        point = origin[todo] + t[todo, None] * u[todo]
        outward, extent = outward_of(world, point, u[todo], primitive[todo])
        beside = t[todo] <= BESIDE * np.maximum(across(np.maximum, np.abs(origin[todo])), extent)
        enters = dot(outward, u[todo]) <= 0
        beside &= media.number[shape] >= 0
        if beside.any():
            inner = point - OFFSET * extent[:, None] * outward
            beside[beside] = media.as_listed(
                before[todo][beside], shape[beside], inner[beside], world.batches, world.shape_of
            )
        listed = (before[todo] == media.number[shape][:, None]).any(axis=1)
        beside &= listed == enters
        edge = at_edge(world, origin[todo], u[todo], (t[todo], primitive[todo]), extent)
        may_touch = np.where(enters, edge & ~listed, edge | ~listed)
        asked = np.flatnonzero((media.number[shape] >= 0) & may_touch & ~beside)
        if asked.size:
            rows, near = todo[asked], OFFSET * np.maximum(extent[asked], t[todo[asked]])
            only, at = touched(world, origin[rows], u[rows], (t[rows], primitive[rows]), near, enters[asked])
            t[rows[only]], primitive[rows[only]] = at
            beside[asked[only]] = True
        old, new = media.crossed(before[todo], shape, enters, beside)
        hidden = (media.number[shape] >= 0) & (media.top(old) == media.top(new))
        before = _put(before, todo, np.where(hidden[:, None], new, old))
        after = _put(after, todo, new)
        todo = todo[hidden]
        t[todo], primitive[todo] = nearest_faces(world, origin[todo], u[todo], (t[todo], primitive[todo]))
        todo = todo[primitive[todo] >= 0]
    return Met(t, primitive, tidy(before), tidy(after))


def _put(lists: Ints, rows: Ints, values: Ints) -> Ints:
    """Lists (n, k) with those of some rows replaced by values (m, j)."""
    missing = max(values.shape[1] - lists.shape[1], 0)
    grown = np.pad(lists, ((0, 0), (0, missing)), constant_values=-1)
    grown[rows] = np.pad(values, ((0, 0), (0, grown.shape[1] - values.shape[1])), constant_values=-1)
    return tidy(grown)


def spot_at(world: World, rays: Rays, met: Met) -> Spot:
    """The surface where rays hit something (no misses)."""
    u = rays.direction
    point = rays.origin + met.t[:, None] * u
    outward, ns, extent = np.empty_like(point), np.empty_like(point), np.empty_like(met.t)
    for batch, here, rows in world.located(met.primitive):
        point[here] = batch.project(rows, point[here])
        outward[here] = batch.outward(rows, point[here], u[here])
        ns[here] = batch.shading_normal(rows, point[here], outward[here])
        extent[here] = batch.extent(rows)
    enters = dot(outward, u) <= 0
    n = np.where(enters[:, None], outward, -outward)
    smooth = ns
    ns = np.where(dot(ns, n)[:, None] < 0, -ns, ns)
    ns = np.where(dot(ns, u)[:, None] >= 0, n, ns)
    largest = [across(np.maximum, np.abs(rays.origin)), across(np.maximum, np.abs(point)), extent]
    offset = OFFSET * np.max(largest, axis=0) if world.lift is None else world.lift(point)
    back = np.minimum(offset, met.t)[:, None] * u if world.lift is None else np.zeros_like(u)
    shape = world.shape_of[met.primitive]
    of = world.surfaces
    cone = np.stack([rays.cone[:, 0] + rays.cone[:, 1] * met.t, rays.cone[:, 1]], axis=1)
    at = (shape, met.primitive, point, outward, Seen(u, cone[:, 0]))
    color = world.images.tone("color", of.reflectance(shape, point, outward), *at)
    names = ("highlight", "mirror", "tint", "emission")
    tones = {name: world.images.tone(name, getattr(of, name)[shape], *at) for name in names}
    ns = world.images.bent(ns, n, smooth, *at)
    return Spot(
        point, outward, n, ns, enters, offset, back, shape, color, met.before, met.after, cone=cone, **tones
    )
