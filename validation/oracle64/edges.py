"""Rays at edges and corners, where two faces of a solid are in one place: what they meet first there."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from .vectors import Array, Bools, Ints, dot
from .world import Hit, World, nearest_hit

# Rays leave a surface at this times the largest |coordinate| of the hit, the primitive and the ray's origin.
# A hit moved back onto its primitive is off it by about 1e-15 of these, so a ray finds its own surface behind
# it; what the offset hides is far below what float32 resolves.
OFFSET = 1e-10
PARALLEL = 0.999  # cosine of the angle between faces that are no edge, but one upon the other


def outward_of(world: World, point: Array, u: Array, primitive: Ints) -> tuple[Array, Array]:
    """Outward normals, and how far primitives reach."""
    outward, extent = np.empty_like(point), np.empty(len(point))
    for batch, here, rows in world.located(primitive):
        outward[here] = batch.outward(rows, batch.project(rows, point[here]), u[here])
        extent[here] = batch.extent(rows)
    return outward, extent


def at_edge(world: World, origin: Array, u: Array, hits: Hit, extent: Array) -> Bools:
    """Whether hits are at an edge of a flat primitive that reaches so far."""
    found = np.zeros(len(u), bool)
    point = origin + hits[0][:, None] * u
    near = OFFSET * np.maximum(extent, hits[0])
    for batch, here, rows in world.located(hits[1]):
        found[here] = batch.at_edge(rows, point[here], near[here])
    return found


def nearest_faces(world: World, origin: Array, u: Array, after: Hit | None = None) -> Hit:
    """Nearest hits; in the place of opaque inner sides at edges, the faces rays meet from outside there."""
    t, primitive = nearest_hit(world, origin, u, after)
    rows = np.flatnonzero(primitive >= 0)
    rows = rows[world.media.number[world.shape_of[primitive[rows]]] < 0]
    outward, extent = outward_of(world, origin[rows] + t[rows, None] * u[rows], u[rows], primitive[rows])
    rear = dot(outward, u[rows]) > 0
    rows, outward, extent = rows[rear], outward[rear], extent[rear]
    edge = at_edge(world, origin[rows], u[rows], (t[rows], primitive[rows]), extent)
    rows, outward, extent = rows[edge], outward[edge], extent[edge]
    at, number = t[rows], primitive[rows]

    back, faces = [outward], []  # normals of inner sides; rays, hits and normals of outer ones

    def visit(asked: Ints, distance: Array, other: Ints, normal: Array) -> Bools:
        rear = dot(normal, u[rows[asked]]) > 0
        hits, reach = (distance, other), np.maximum(extent[asked], distance)
        face = ~rear & at_edge(world, origin[rows[asked]], u[rows[asked]], hits, reach)
        faces.append((asked[face], distance[face], other[face], normal[face]))
        back.append(np.zeros_like(outward))
        back[-1][asked[rear]] = normal[rear]
        return np.ones(len(asked), bool)

    _visit_place(world, origin[rows], u[rows], (at, number), OFFSET * np.maximum(extent, at), visit)
    for asked, distance, other, normal in reversed(faces):  # the first is what counts
        upon = [np.abs(dot(normal, side[asked])) >= PARALLEL for side in back]
        alone = ~np.any(upon, axis=0)
        t[rows[asked[alone]]], primitive[rows[asked[alone]]] = distance[alone], other[alone]
    return t, primitive


def touched(
    world: World, origin: Array, u: Array, hits: Hit, near: Array, enters: Bools
) -> tuple[Bools, Hit]:
    """Rays that only touch an edge or corner, and the last hits of their medium there.

    They leave a solid of the medium and enter it at once, or the other way round.
    """
    number = world.media.number[world.shape_of]
    t, primitive, both = hits[0].copy(), hits[1].copy(), np.zeros(len(u), bool)

    def visit(asked: Ints, distance: Array, other: Ints, normal: Array) -> Bools:
        same = np.asarray(number[other] == number[hits[1][asked]])
        asked, distance, other, normal = asked[same], distance[same], other[same], normal[same]
        both[asked] |= (dot(normal, u[asked]) <= 0) != enters[asked]
        t[asked], primitive[asked] = distance, other
        return same

    _visit_place(world, origin, u, hits, near, visit)
    return both, (t[both], primitive[both])


def _visit_place(
    world: World,
    origin: Array,
    u: Array,
    hits: Hit,
    near: Array,
    visit: Callable[[Ints, Array, Ints, Array], Bools],
) -> None:
    """What rays meet no farther than `near` behind their hits, one after the other, as long as
    visit(rays, t, primitive, outward) says so of each."""
    rows = np.arange(len(u))
    t, primitive = hits[0].copy(), hits[1].copy()
    while rows.size:
        at, other = nearest_hit(world, origin[rows], u[rows], (t[rows], primitive[rows]))
        there = (other >= 0) & (at <= hits[0][rows] + near[rows])
        rows, at, other = rows[there], at[there], other[there]
        if not rows.size:
            return
        t[rows], primitive[rows] = at, other
        outward = outward_of(world, origin[rows] + at[:, None] * u[rows], u[rows], other)[0]
        rows = rows[visit(rows, at, other, outward)]
