"""What is answered about rays: the nearest hit of each, and all that each crosses."""

from __future__ import annotations

from dataclasses import dataclass, fields
from functools import cached_property
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from clrt.base.errors import ClrtError, fault
from clrt.base.suggest import did_you_mean

# field -> type, and how many numbers
FIELDS: Final[dict[str, tuple[type[np.generic], int]]] = {
    "t": (np.float32, 1),
    "primitive": (np.int32, 1),
    "shape": (np.int32, 1),
    "normal": (np.float32, 3),
    "u": (np.float32, 1),
    "v": (np.float32, 1),
}


class NotAskedFor(ClrtError, AttributeError):
    """An answer lacks a field, since the call left it out."""


@dataclass(frozen=True, repr=False, eq=False)
class _Fields:
    t: np.ndarray
    primitive: np.ndarray
    shape: np.ndarray
    normal: np.ndarray
    u: np.ndarray
    v: np.ndarray

    if not TYPE_CHECKING:  # to whom each name that there is not would be one, of type Any

        def __getattr__(self, name: str) -> Any:
            """Reached for what is not there."""
            if name in FIELDS:
                raise NotAskedFor(f"{name}: was not asked for; add {name!r} to fields=")
            raise AttributeError(f"{type(self).__name__!r} object has no attribute {name!r}")

    def __repr__(self) -> str:
        kept = {field.name: getattr(self, field.name, None) for field in fields(self)}
        said = [f"{name}={values!r}" for name, values in kept.items() if values is not None]
        return f"{type(self).__name__}({', '.join(said)})"


class Hits(_Fields):
    """The nearest hits of rays of leading shape (...). A miss has primitive = shape = -1 and t = inf.

    t: (...) float32, distance. primitive, shape: (...) int32. normal: (..., 3) float32, the outward geometric
    unit normal (0 on a miss). u, v: (...) float32, barycentric weights of a triangle's second and third
    corner in the order of the mesh's `faces`, also where its transform mirrors; of a face of more corners
    that became triangles (docs/queries.md) those of the triangle; 0 on other primitives. What was not asked
    for is a ClrtError.
    """

    @classmethod
    def of(cls, found: dict[str, np.ndarray], lead: tuple[int, ...]) -> Hits:
        """From flat arrays, (n,) or (n, 3) each."""
        made = cls.__new__(cls)
        made.__dict__.update({name: array.reshape(lead + array.shape[1:]) for name, array in found.items()})
        return made


@dataclass(frozen=True, repr=False, eq=False)
class Crossings(_Fields):
    """All that n rays cross, ray after ray and along each ray; the rays of a leading shape in their order.

    Those of ray i are splits[i] to splits[i + 1], int64. t, primitive, shape, normal, u, v: as in `Hits`, but
    flat, one for each crossing. A ray that runs through a common edge of triangles crosses one of them, or
    as many as keep inside and outside apart (docs/queries.md). What was not asked for is a ClrtError.
    """

    splits: np.ndarray

    @classmethod
    def of(cls, found: dict[str, np.ndarray], splits: np.ndarray) -> Crossings:
        """From flat arrays, and where those of each ray begin."""
        made = cls.__new__(cls)
        made.__dict__.update(found, splits=splits)
        return made

    @property
    def counts(self) -> np.ndarray:
        """(n,) int64: how many crossings each ray has."""
        return np.diff(self.splits)

    @cached_property
    def rays(self) -> np.ndarray:
        """(m,) int64: the number of each crossing's ray."""
        return np.repeat(np.arange(len(self.splits) - 1), self.counts)

    def __len__(self) -> int:
        return int(self.splits[-1])


def check_fields(value: object) -> tuple[str, ...]:
    """Names of FIELDS, in their order; None: all. ClrtError names the nearest known one."""
    if value is None:
        return tuple(FIELDS)
    known = ", ".join(FIELDS)
    right = f"it must be a list of names: {known}"
    if isinstance(value, str) or not isinstance(value, (list, tuple, set, frozenset)) or not value:
        raise ClrtError(fault("", "fields", value, right))
    for name in value:
        if not isinstance(name, str):
            raise ClrtError(fault("", "fields", value, right))
        if name not in FIELDS:
            text = f"fields: {name[:99]!r} is none{did_you_mean(name, list(FIELDS))}; there are {known}"
            raise ClrtError(text)
    return tuple(name for name in FIELDS if name in value)
