"""What fills the space that rays go through: lists of media by ray, and which of them holds.

A medium is a material whose surfaces let light through and have an inside. A list is a row of numbers of
media in the order in which they were entered, -1 in unused places; tables of media have one row more, which
is what surrounds everything, so that medium -1 finds it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from clrt.scene import Plane, Quadric, Scene

from .batch import Batch
from .palette import Palette
from .vectors import Array, Bools, Ints, dot, unit

_SOMEWHERE = unit([0.5377, 0.6142, -0.5776])  # along no edge of anything that a person would build


@dataclass(frozen=True)
class Media:
    """The m media of a scene and their surroundings."""

    number: Ints  # (shapes,): the medium that a shape bounds, -1 where it bounds none
    priority: Array  # (m + 1,)
    eta: Array  # (m + 1, groups): index of refraction
    curved: Bools  # (m + 1,): the index is a curve
    sigma: Array  # (m + 1, bands): absorption per unit length

    @classmethod
    def of(cls, scene: Scene, palette: Palette) -> Media:
        """Materials that are equal are one medium."""
        materials = [scene.material_of(shape) for shape in scene.shapes]
        refracting = [m for m in materials if m.kt > 0 and not m.thin]
        distinct = [m for i, m in enumerate(refracting) if m not in refracting[:i]]
        number = [distinct.index(m) if m in distinct else -1 for m in materials]
        around = np.full((1, palette.groups), scene.medium_ior)
        return cls(
            np.array(number, int),
            np.array([*(getattr(m, "priority", 0) for m in distinct), -np.inf]),
            np.concatenate([*(palette.index(m.ior)[None] for m in distinct), around]),
            np.array([*(palette.is_curve(m.ior) for m in distinct), False]),
            np.array([*(palette.curve(getattr(m, "absorption", 0.0)) for m in distinct), np.zeros(palette.bands)]),
        )

    def top(self, lists: Ints) -> Ints:
        """The medium (n,) that holds: of the highest priority, among equals the one entered last."""
        if not lists.shape[1]:
            return np.full(len(lists), -1)
        priority = np.where(lists >= 0, self.priority[lists], -np.inf)
        last = lists.shape[1] - 1 - np.argmax(priority[:, ::-1], axis=1)
        return np.asarray(lists[np.arange(len(lists)), last])

    def crossed(self, lists: Ints, shape: Ints, enters: Bools) -> tuple[Ints, Ints]:
        """Lists before and after the surfaces of these shapes; those of no medium change nothing.

        A medium that is left without having been entered was there all the time, as what was entered last.
        """
        medium = self.number[shape]
        longer = np.column_stack([lists, medium])
        shorter = np.column_stack([lists, np.full(len(lists), -1)])
        listed = shorter == medium[:, None]
        known = listed.any(axis=1)
        latest = shorter.shape[1] - 1 - np.argmax(listed[:, ::-1], axis=1)
        removed = shorter.copy()
        removed[np.flatnonzero(known), latest[known]] = -1
        of_none, leaves = (medium < 0)[:, None], ~enters[:, None]
        before = np.where(leaves & ~known[:, None], longer, shorter)
        after = np.where(leaves, removed, longer)
        return np.where(of_none, shorter, before), np.where(of_none, shorter, after)


def tidy(lists: Ints) -> Ints:
    """The same lists without unused places between and after all of them."""
    order = np.argsort(lists < 0, axis=1, kind="stable")
    packed = np.take_along_axis(lists, order, axis=1)
    return np.asarray(packed[:, : int((packed >= 0).sum(axis=1).max(initial=0))])


def around(scene: Scene, batches: list[Batch], shape_of: Ints, media: Media, points: Array) -> Ints:
    """The lists (n, k) of rays that start at points: the media they are inside of, in scene order."""
    lists = np.full((len(points), 0), -1)
    if (media.number < 0).all():
        return lists
    distinct, back = np.unique(points, axis=0, return_inverse=True)
    turns = _turns(batches, shape_of, media, distinct)
    for number, shape in enumerate(scene.shapes):
        if media.number[number] < 0 or shape.is_open:
            continue
        inside = turns[:, number] > 0
        if isinstance(shape, Plane):
            inside = dot(distinct - np.asarray(shape.point), unit(shape.normal)[None]) < 0
        elif isinstance(shape, Quadric):
            inside = _form(shape, distinct) < 0
        lists = np.column_stack([lists, np.where(inside, media.number[number], -1)[back.ravel()]])
    return tidy(lists)


def _turns(batches: list[Batch], shape_of: Ints, media: Media, points: Array) -> Ints:
    """How often (n, shapes) a ray from a point leaves a shape less how often it enters it."""
    count = np.zeros((len(points), len(media.number)), int)
    for batch in batches:
        rows = np.flatnonzero(media.number[shape_of[batch.ids]] >= 0)
        shape = shape_of[batch.ids[rows]]
        for number, point in enumerate(points if rows.size else []):
            origin, u = np.broadcast_to(point, (len(rows), 3)), np.broadcast_to(_SOMEWHERE, (len(rows), 3))
            for t in batch.roots(rows, origin, u).T:
                met = np.isfinite(t) & (t > 0)
                outward = batch.outward(rows, origin + np.where(met, t, 0.0)[:, None] * u, u)
                side = np.where(met, np.sign(dot(outward, u)), 0).astype(int)
                np.add.at(count[number], shape, side)
    return count


def _form(shape: Quadric, points: Array) -> Array:
    """The value of a quadric's form, > 0 outside."""
    a, b, c, d, e, f, g, h, i, j = shape.coefficients
    x, y, z = np.linalg.solve(shape.matrix, np.c_[points, np.ones(len(points))].T)[:3]
    squares, products = a * x * x + b * y * y + c * z * z, d * x * y + e * y * z + f * x * z
    return np.asarray(squares + 2 * (products + g * x + h * y + i * z) + j)
