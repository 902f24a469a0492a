"""What all kinds of primitives have in common."""

from __future__ import annotations

import dataclasses
from abc import ABC, abstractmethod
from typing import TypeVar

import numpy as np

from .vectors import Array, Bools, Ints

B = TypeVar("B", bound="Batch")


@dataclasses.dataclass(frozen=True)
class Batch(ABC):
    """n primitives of one kind; field arrays have one row a primitive.

    The methods take pairs of a primitive and a ray or point: `which` (m,) are rows of the batch, the others
    (m, 3) or (m,). Directions are unit vectors and distances are along them.
    """

    ids: Ints  # primitive numbers in the scene
    low: Array  # world box (n, 3); infinite where the primitive is
    high: Array

    @abstractmethod
    def roots(self, which: Ints, origin: Array, direction: Array) -> Array:
        """Distances (m, k), in any order, behind the origin too; NaN or infinite where there is none."""

    @abstractmethod
    def outward(self, which: Ints, point: Array, direction: Array) -> Array:
        """Outward unit normals (m, 3); `direction` is of use only where a surface has no normal."""

    @abstractmethod
    def project(self, which: Ints, point: Array) -> Array:
        """The points, nearly on their primitives, moved onto them."""

    def shading_normal(self, which: Ints, point: Array, outward: Array) -> Array:
        """Interpolated normals (m, 3); those of the surface unless the primitive has its own."""
        return outward

    def at_edge(self, which: Ints, point: Array, near: Array) -> Bools:
        """Whether points lie nearer than `near` (m,) to an edge of a flat primitive."""
        return np.zeros(len(which), bool)

    def extent(self, which: Ints) -> Array:
        """Largest finite |coordinate| (m,) of the primitives' boxes."""
        corners = np.stack([self.low[which], self.high[which]])
        return np.asarray(np.max(np.abs(np.where(np.isfinite(corners), corners, 0.0)), axis=(0, 2)))


def merge(batches: list[B], ids: list[Ints]) -> B:
    """One batch of several of a kind, with new primitive numbers, in the order of these numbers."""
    numbers = np.concatenate(ids)
    order = np.argsort(numbers)
    fields = [field.name for field in dataclasses.fields(batches[0]) if field.name != "ids"]
    joined = {name: np.concatenate([getattr(batch, name) for batch in batches])[order] for name in fields}
    return type(batches[0])(ids=numbers[order], **joined)
