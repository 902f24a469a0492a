"""A caller's rays, checked, of any leading shape; and how kernels are given them, in place if they can be."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import zip_longest
from typing import Any, Final

import numpy as np

from clrt.base.arguments import real_numbers
from clrt.base.errors import ClrtError, LimitError
from clrt.base.limits import written
from clrt.device.shared import Work

PATCH: Final = 4  # rays side by side of a patch, and at most so many rows (kernels/asked.clh)
_IN_PLACE: Final = 1 << 24  # rays of a launch that reads the caller's own arrays
_COPIED: Final = 1 << 17  # ... copies of them: these stay in the caches
_LOOKED_AT: Final = 1 << 16  # rays from which on a picture's rows are looked for
_LONGEST: Final = 1 << 13  # row that is looked for
_MOST: Final = 1 << 57  # rays: of more numpy makes no view, even of one number
_AXES: Final = 63  # an array has 64, and the last one is for x, y, z
_LEAP: Final = 8.0  # times the distance between neighbours: from the end of a row to the next one


@dataclass(frozen=True)
class Piece:
    """Rays `start` to `stop` of a batch as float32 arrays: of one ray where all have the same, or of each."""

    start: int
    stop: int
    origins: np.ndarray
    directions: np.ndarray
    t_min: np.ndarray
    t_max: np.ndarray
    width: int

    @property
    def n(self) -> int:
        return self.stop - self.start

    def arguments(self, work: Work) -> tuple[Any, ...]:
        """What ASKED_PARAMETERS take."""
        least, most = (None if len(bound) < 2 else bound for bound in (self.t_min, self.t_max))
        patches = self.n // (PATCH * self.width) * PATCH * self.width if self.width else 0
        return (
            work.given(self.origins),
            work.given(self.directions),
            work.given(least),
            work.given(most),
            np.float32(self.t_min[0]),
            np.float32(self.t_max[0]),
            np.uint32(3 if len(self.origins) > 1 else 0),
            np.uint32(3 if len(self.directions) > 1 else 0),
            np.uint32(self.n),
            np.uint32(self.width),
            np.uint32(patches),
        )


class Batch:
    """Rays: origins, directions (..., 3), t_min, t_max (...), broadcast against each other.

    shape: the leading shape of the rays, and so of what is answered. What is beyond float32 becomes infinite.
    ClrtError for shapes that do not go together, and for what are no real numbers.
    """

    def __init__(self, origins: object, directions: object, t_min: object, t_max: object) -> None:
        o, d = _vectors("origins", origins), _vectors("directions", directions)
        try:
            self.shape = _together(o.shape[:-1], d.shape[:-1])
        except ValueError:  # shapes that differ; too many axes together
            raise ClrtError(
                f"origins and directions: shapes {o.shape} and {d.shape} do not go together; "
                "there must be one for each ray, or one for all"
            ) from None
        bounds = [self._bound(*given) for given in (("t_min", t_min), ("t_max", t_max))]
        self.n = math.prod(self.shape)
        if self.n > _MOST:
            raise LimitError(f"rays: {written(self.n)} are more than any memory holds; ask of fewer")
        self._arrays = [_Given(array, self.shape, self.n) for array in (o, d)]
        self._bounds = [_Given(array[..., None], self.shape, self.n) for array in bounds]
        self.width = self._width()

    def _bound(self, name: str, value: object) -> np.ndarray:
        """A bound of the rays, of which there may be more for it."""
        bound = real_numbers(name, value, f"() or {self.shape}" if self.shape else "()")
        try:
            self.shape = _together(bound.shape, self.shape)
        except ValueError:
            text = f"shape {bound.shape} is neither a number nor {self.shape}, as the rays are"
            raise ClrtError(f"{name}: {text}") from None
        return bound

    def ranges(self, tile: int | None = None) -> Iterator[tuple[int, int]]:
        """Where each piece begins and ends: `tile` rays, or as many as suits the arrays."""
        whole = all(given.in_place for given in (*self._arrays, *self._bounds))
        step = tile or (_IN_PLACE if whole else _COPIED)
        if self.width:
            step = max(step // (PATCH * self.width), 1) * PATCH * self.width
        for start in range(0, self.n, step):
            yield start, min(start + step, self.n)

    def pieces(self, tile: int | None = None) -> Iterator[Piece]:
        """All rays, piece by piece."""
        for start, stop in self.ranges(tile):
            yield self.piece(start, stop)

    def piece(self, start: int, stop: int) -> Piece:
        """Some of the rays."""
        origins, directions = (given.part(start, stop) for given in self._arrays)
        t_min, t_max = (given.part(start, stop)[:, 0] for given in self._bounds)
        return Piece(start, stop, origins, directions, t_min, t_max, self.width)

    def flat(self) -> tuple[np.ndarray, np.ndarray]:
        """Origins and directions (n, 3) float32 of all rays."""
        origins, directions = (np.broadcast_to(g.part(0, self.n), (self.n, 3)) for g in self._arrays)
        return origins, directions

    def some(self, numbers: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Origins and directions (m, 3) float32 of the rays with these numbers."""
        origins, directions = (given.some(numbers) for given in self._arrays)
        return origins, directions

    def _width(self) -> int:
        """The length of a picture's rows, in rays; 0 where these are not known to be a picture's.

        Which rays are traced together changes no bit of any answer.
        """
        width = self.shape[-1] if len(self.shape) > 1 else 0
        if len(self.shape) == 1 and self.n >= _LOOKED_AT:
            origins, directions = (given.part(0, _LONGEST) for given in self._arrays)
            width = row_length(origins + directions)
        if width % PATCH or width > self.n // PATCH:
            return 0
        return width


def row_length(points: np.ndarray) -> int:
    """After how many of these points (n, 3) the first leap comes, from a row's end to the next; else 0."""
    steps = np.square(np.diff(points, axis=0)).sum(axis=1)
    usual = np.median(steps[:64])
    leaps = np.flatnonzero((steps > _LEAP**2 * usual) & (usual > 0))
    return int(leaps[0]) + 1 if len(leaps) else 0


class _Given:
    """An array of shape (..., k), which is broadcast to the rays' leading shape."""

    def __init__(self, array: np.ndarray, shape: tuple[int, ...], n: int) -> None:
        self._all = array.size == array.shape[-1]  # one for all rays
        native = array.dtype == np.float32 and array.dtype.isnative and array.flags.aligned
        if self._all:
            self._rows = np.ascontiguousarray(array.reshape(1, -1), np.float32)
        elif array.shape[:-1] == shape and (array.ndim == 2 or array.flags.c_contiguous):
            self._rows = array.reshape(n, array.shape[-1])
        else:
            self._rows = np.broadcast_to(array, (*shape, array.shape[-1]))
        self.in_place = self._all or bool(native and self._rows.ndim == 2 and self._rows.flags.c_contiguous)

    def part(self, start: int, stop: int) -> np.ndarray:
        """(m, k) float32 of some rays, C-contiguous; (1, k) where they are alike."""
        if self._all:
            return self._rows
        if self._rows.ndim == 2:
            return np.ascontiguousarray(self._rows[start:stop], np.float32)
        return self.some(np.arange(start, stop))

    def some(self, numbers: np.ndarray) -> np.ndarray:
        """(m, k) float32 of the rays with these numbers."""
        if self._all:
            return self._rows
        if self._rows.ndim == 2:
            return np.ascontiguousarray(self._rows[numbers], np.float32)
        places = np.unravel_index(numbers, self._rows.shape[:-1])
        return np.ascontiguousarray(self._rows[places], np.float32)


def _together(one: tuple[int, ...], other: tuple[int, ...]) -> tuple[int, ...]:
    """Two shapes, broadcast; ValueError where they do not go together.

    Not by numpy, which takes a tenth of the whole call of one ray, and says no, too, where there are many.
    """
    if one in ((), other):
        return other
    sides = [*zip_longest(reversed(one), reversed(other), fillvalue=1)]
    if len(sides) > _AXES or any(a != b and 1 not in (a, b) for a, b in sides):
        raise ValueError
    return tuple(b if a == 1 else a for a, b in reversed(sides))


def _vectors(name: str, value: object) -> np.ndarray:
    found = real_numbers(name, value, "(..., 3)")
    if found.ndim < 1 or found.shape[-1] != 3:
        raise ClrtError(f"{name}: shape {found.shape} is not (..., 3)")
    return found
