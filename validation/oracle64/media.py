"""What fills the space that rays go through: lists of media by ray, and which of them holds.

A medium is a material whose surfaces let light through and have an inside. A list is a row of numbers of
media in the order in which they were entered, -1 in unused places; tables of media have one row more, which
is what surrounds everything, so that medium -1 finds it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from clrt.scene.scene import Disk, Polygon, Scene

from .batch import Batch
from .curved import Quadrics, Spheres
from .flat import Disks, Planes, Polygons, Triangles, newell_normal
from .palette import Palette
from .tree import PAIRS
from .vectors import Array, Bools, Ints, apply, dot, unit


@dataclass(frozen=True)
class Media:
    """The m media of a scene and their surroundings."""

    number: Ints  # (shapes,): the medium that a shape bounds, -1 where it bounds none
    priority: Array  # (m + 1,)
    eta: Array  # (m + 1, groups): index of refraction
    curved: Bools  # (m + 1,): the index is a curve
    sigma: Array  # (m + 1, bands): absorption per unit length
    solid: Bools  # (shapes,): there is an inside that a ray can start in

    @classmethod
    def of(cls, scene: Scene, palette: Palette) -> Media:
        """Materials that are equal are one medium."""
        materials = [scene.material_of(shape) for shape in scene.shapes]
        lists = scene.conformance != "spd"  # these ray counts know none
        refracting = [m for m in materials if m.kt > 0 and not m.thin and lists]
        distinct = [m for i, m in enumerate(refracting) if m not in refracting[:i]]
        number = [distinct.index(m) if m in distinct else -1 for m in materials]
        around = np.full((1, palette.groups), scene.medium_ior)
        return cls(
            np.array(number, int),
            np.array([*(m.priority for m in distinct), -np.inf]),
            np.concatenate([*(palette.index(m.ior)[None] for m in distinct), around]),
            np.array([*(palette.is_curve(m.ior) for m in distinct), False]),
            np.array([*(palette.curve(m.absorption) for m in distinct), np.zeros(palette.bands)]),
            np.array([not isinstance(shape, (Polygon, Disk)) for shape in scene.shapes], bool),
        )

    def top(self, lists: Ints) -> Ints:
        """The medium (n,) that holds: of the highest priority, among equals the one entered last."""
        if not lists.shape[1]:
            return np.full(len(lists), -1)
        priority = np.where(lists >= 0, self.priority[lists], -np.inf)
        last = lists.shape[1] - 1 - np.argmax(priority[:, ::-1], axis=1)
        return np.asarray(lists[np.arange(len(lists)), last])

    def crossed(self, lists: Ints, shape: Ints, enters: Bools, beside: Bools) -> tuple[Ints, Ints]:
        """Lists before and after the surfaces of these shapes; those of no medium change nothing.

        A medium that is left without having been entered was there all the time, as what was entered last.
        Not so beside an edge: there the ray has just left it by the other side, or entered what it enters.
        """
        medium = self.number[shape]
        longer = np.column_stack([lists, medium])
        shorter = np.column_stack([lists, np.full(len(lists), -1)])
        listed = shorter == medium[:, None]
        known = listed.any(axis=1)
        latest = shorter.shape[1] - 1 - np.argmax(listed[:, ::-1], axis=1)
        removed = shorter.copy()
        removed[np.flatnonzero(known), latest[known]] = -1
        passed, exits = ((medium < 0) | beside)[:, None], ~enters[:, None]
        before = np.where(exits & ~known[:, None], longer, shorter)
        after = np.where(exits, removed, longer)
        return np.where(passed, shorter, before), np.where(passed, shorter, after)

    def as_listed(
        self, lists: Ints, shape: Ints, point: Array, batches: list[Batch], shape_of: Ints
    ) -> Bools:
        """Whether points are in as many solids of these shapes' media as the lists have of them."""
        turns = _turns(batches, shape_of, self, point)
        medium = self.number[shape][:, None]
        held = np.where(self.number[None] == medium, turns, 0).sum(axis=1)
        return np.asarray(held == (lists == medium).sum(axis=1))


def tidy(lists: Ints) -> Ints:
    """The same lists without unused places between and after all of them."""
    order = np.argsort(lists < 0, axis=1, kind="stable")
    packed = np.take_along_axis(lists, order, axis=1)
    return np.asarray(packed[:, : int((packed >= 0).sum(axis=1).max(initial=0))])


def around(batches: list[Batch], shape_of: Ints, media: Media, points: Array) -> Ints:
    """The lists (n, k) of rays that start at points: the media they are inside of, the largest one first."""
    bounded = [number for number in np.argsort(-_extent(batches, shape_of, media), kind="stable")
               if media.number[number] >= 0 and media.solid[number]]  # fmt: skip
    if not bounded:
        return np.full((len(points), 0), -1)
    distinct, back = np.unique(points, axis=0, return_inverse=True)
    turns = _turns(batches, shape_of, media, distinct)[:, bounded]
    most = max(int(turns.max(initial=0)), 1)
    columns = [np.where(turns > turn, media.number[bounded], -1) for turn in range(most)]
    lists = np.stack(columns, axis=2).reshape(len(distinct), -1)  # each shape's turns side by side
    return tidy(lists[back.ravel()])


def _extent(batches: list[Batch], shape_of: Ints, media: Media) -> Array:
    """The volume (shapes,) of each shape's box."""
    low, high = np.full((2, len(media.number), 3), np.inf) * [[[1]], [[-1]]]
    for batch in batches:
        np.minimum.at(low, shape_of[batch.ids], batch.low)
        np.maximum.at(high, shape_of[batch.ids], batch.high)
    return np.asarray(np.prod(high - low, axis=1))


def _turns(batches: list[Batch], shape_of: Ints, media: Media, points: Array) -> Ints:
    """How often (n, shapes) points are inside of shapes that bound media."""
    count = np.zeros((len(points), len(media.number)))
    for batch in batches:
        rows = np.flatnonzero(media.number[shape_of[batch.ids]] >= 0)
        shape = shape_of[batch.ids[rows]]
        for some in np.array_split(np.arange(len(points)), -(-len(points) * len(rows) // PAIRS) or 1):
            pairs = np.repeat(some, len(rows)), np.tile(shape, len(some))
            np.add.at(count, pairs, _inside(batch, np.tile(rows, len(some)), points[pairs[0]]))
    return np.round(count).astype(int)


def _inside(batch: Batch, rows: Ints, point: Array) -> Array:
    """What primitives (m,) say of whether a point (m, 3) is inside; it is summed over a shape's primitives.

    A curved one or a plane knows by itself. A face tells which part of all directions leaves there.
    """
    if isinstance(batch, Spheres):
        offset = point - batch.center[rows]
        return (dot(offset, offset) < batch.radius[rows] ** 2).astype(float)
    if type(batch) is Planes:
        return (dot(point - batch.point[rows], batch.normal[rows]) < 0).astype(float)
    if isinstance(batch, Quadrics):
        x = apply(batch.inverse[rows], point - batch.position[rows])
        form = dot(x, apply(batch.form[rows], x) + 2 * batch.gradient[rows]) + batch.constant[rows]
        clipped = np.all((x >= batch.clip_low[rows]) & (x <= batch.clip_high[rows]), axis=1)
        return ((form < 0) & clipped).astype(float)
    if type(batch) is Disks:
        return np.zeros(len(rows))  # a cap: the side knows
    assert isinstance(batch, (Polygons, Triangles))
    corners = batch.corners[rows]
    turned = np.sign(dot(newell_normal(corners), batch.normal[rows]))
    a, b, c = (unit(corner - point[:, None]) for corner in (corners[:, :1], corners[:, 1:-1], corners[:, 2:]))
    halves = np.arctan2(dot(a, np.cross(b, c)), 1 + dot(a, b) + dot(b, c) + dot(c, a))  # of solid angles
    return np.nan_to_num(turned * halves.sum(axis=1) / (2 * np.pi))  # at a corner it is 0 / 0
