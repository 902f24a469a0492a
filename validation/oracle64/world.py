"""The scene as rays see it: the nearest hit, and how much of a light is seen."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from clrt.scene.scene import Scene

from .batch import Batch
from .images import Images
from .lights import with_surfaces
from .media import Media
from .palette import Palette
from .primitives import gather
from .surfaces import Surfaces
from .tree import LEAF, Node, build, walk
from .vectors import Array, Bools, Ints, across, dot

Hit = tuple[Array, Ints]  # distances and primitives (n,)
Lift = Callable[[Array], Array]  # how far (n,) from points (n, 3) of surfaces rays start that leave them


@dataclass(frozen=True)
class World:
    """Primitives of a scene in batches, each with its trees of boxes.

    lift: where rays start, if not as near to surfaces as float64 can.
    """

    scene: Scene
    batches: list[Batch]
    trees: list[list[Node]]
    shape_of: Ints  # (primitives,)
    palette: Palette
    surfaces: Surfaces  # one row a shape, and then one a visible light
    lamp: Ints  # (rows,): of each the light's number, -1 of shapes
    media: Media
    images: Images
    lift: Lift | None = None

    @classmethod
    def of(cls, scene: Scene, leaf: int = LEAF, lift: Lift | None = None) -> World:
        """The world of a scene; with `leaf` as large as the scene, brute force."""
        scene, lamp = with_surfaces(scene)
        batches, shape_of = gather(scene)
        trees = [build(batch, leaf) for batch in batches]
        palette = Palette.of(scene)
        surfaces = Surfaces.of(scene, palette, batches, shape_of)
        return cls(scene, batches, trees, shape_of, palette, surfaces, lamp, Media.of(scene, palette),
                   Images(scene, palette, shape_of), lift)  # fmt: skip

    @cached_property
    def shown(self) -> Ints:
        """The number (rows,) that a layer shows of each: lights are counted after all shapes."""
        return np.where(self.lamp < 0, np.arange(len(self.lamp)), np.count_nonzero(self.lamp < 0) + self.lamp)

    @cached_property
    def hides_backs(self) -> Bools:
        """Shapes (s,) that are invisible from behind."""
        opaque = (self.surfaces.kt == 0) & (self.lamp < 0)
        return opaque if self.scene.one_sided == "opaque" else np.zeros_like(opaque)

    def located(self, primitive: Ints) -> list[tuple[Batch, Ints, Ints]]:
        """Where primitives (m,) lie: (batch, places in `primitive`, rows of the batch)."""
        found = []
        for batch in self.batches:
            row = np.minimum(np.searchsorted(batch.ids, primitive), len(batch.ids) - 1)
            places = np.flatnonzero(batch.ids[row] == primitive)
            if places.size:
                found.append((batch, places, row[places]))
        return found


def visible_roots(world: World, batch: Batch, which: Ints, origin: Array, direction: Array) -> Array:
    """Distances (m, k) at which rays meet primitives; infinite where not in front or not visible."""
    with np.errstate(all="ignore"):
        roots = batch.roots(which, origin, direction)
        roots = np.where((roots > 0) & np.isfinite(roots), roots, np.inf)
        hides = world.hides_backs[world.shape_of[batch.ids[which]]]
        if hides.any():
            for k in range(roots.shape[1]):
                met = np.flatnonzero(np.isfinite(roots[:, k]) & hides)
                u = direction[met]
                outward = batch.outward(which[met], origin[met] + roots[met, k, None] * u, u)
                roots[met[dot(outward, u) > 0], k] = np.inf
    return np.asarray(roots)


def nearest_hit(world: World, origin: Array, direction: Array, after: Hit | None = None) -> Hit:
    """Distance and primitive (n,) of nearest hits: inf and -1 for a miss, the lowest number among equals.

    `after`: hits that, with all before them, are passed.
    """
    t, primitive = np.full(len(origin), np.inf), np.full(len(origin), -1)
    passed, last = (np.zeros(len(origin)), primitive.copy()) if after is None else after
    for batch, roots in zip(world.batches, world.trees, strict=True):

        def visit(rays: Ints, rows: Ints, batch: Batch = batch) -> None:
            ray, which = np.repeat(rays, len(rows)), np.tile(rows, len(rays))
            found = visible_roots(world, batch, which, origin[ray], direction[ray])
            if after is not None:
                number, beyond = batch.ids[which, None], passed[ray, None]
                # the same root may come out an ulp larger in other company
                own = (number == last[ray, None]) & (found <= beyond * (1 + 1e-12))
                later = (found > beyond) | ((found == beyond) & (number > last[ray, None]))
                found = np.where(later & ~own, found, np.inf)
            found = across(np.minimum, found).reshape(len(rays), len(rows))
            best = np.argmin(found, axis=1)  # the first of equals, which has the lowest number
            distance, number = found[np.arange(len(rays)), best], batch.ids[rows[best]]
            nearer = (distance < t[rays]) | ((distance == t[rays]) & (number < primitive[rays]))
            t[rays[nearer]], primitive[rays[nearer]] = distance[nearer], number[nearer]

        walk(roots, origin, direction, t, visit)
    return t, primitive


def visibility(world: World, origin: Array, direction: Array, length: Array, light: int) -> Array:
    """What of a light at distance `length` arrives (n, bands): 0 behind a blocker at t < length, else 1.

    Its own surface, that of light number `light`, does not count. With tinted shadows every transmissive
    surface crossed multiplies it by kt Tt.
    """
    seen = np.ones((len(origin), world.palette.bands))
    reach = length.copy()
    tinted = world.scene.shadow == "tinted"
    for batch, roots in zip(world.batches, world.trees, strict=True):

        def visit(rays: Ints, rows: Ints, batch: Batch = batch) -> None:
            ray, which = np.repeat(rays, len(rows)), np.tile(rows, len(rays))
            distance = visible_roots(world, batch, which, origin[ray], direction[ray])
            crossed = distance < length[ray, None]
            shape = world.shape_of[batch.ids[which]]
            crossed &= (world.lamp[shape] != light)[:, None]
            opaque = (world.surfaces.kt[shape] == 0) | (not tinted)
            blocked = ray[across(np.logical_or, crossed) & opaque]
            seen[blocked], reach[blocked] = 0.0, -np.inf  # no box is nearer: such a ray is done
            tints = world.surfaces.clear[shape] ** crossed.sum(axis=1)[:, None]
            for k in range(crossed.shape[1]):
                shown = np.flatnonzero(crossed[:, k] & world.images.shown[shape] & ~opaque)
                u = direction[ray[shown]]
                at = origin[ray[shown]] + distance[shown, k, None] * u
                outward = batch.outward(which[shown], at, u)
                number, one = batch.ids[which[shown]], shape[shown]
                # all of a picture's tint is in this one crossing: `clear` has any other
                plain = np.ones((len(shown), world.palette.bands))
                tints[shown] *= world.images.tone("tint", plain, one, number, at, outward)
            np.multiply.at(seen, ray[~opaque], tints[~opaque])

        walk(roots, origin, direction, reach, visit)
    return seen
