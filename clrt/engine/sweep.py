"""Scenes that differ in a few values: what many pictures are made of."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from itertools import product
from typing import Any, Final

import numpy as np

from clrt.base import arguments
from clrt.base.errors import ClrtError, fault
from clrt.scene.scene import Scene, edited

Values = dict[str, Any]
PICTURES: Final = 100_000  # of a sweep: all values are looked at before the first


def checked(scene: Scene, changes: object) -> dict[str, Sequence[Any]]:
    """The changes as lists, each value of which the scene takes by itself."""
    found: dict[str, Sequence[Any]] = {}
    for place, values in arguments.mapping("changes", changes).items():
        if isinstance(values, np.ndarray) and values.ndim and len(values) <= PICTURES:
            values = list(values)
        if not isinstance(values, (list, tuple, range)) or not values:
            right = "it must be a list of values, such as [20, 30]"
            raise ClrtError(fault("", f"changes[{place!r}]", values, right))
        found[place] = values
    pictures = math.prod(map(len, found.values()))
    if pictures > PICTURES:
        raise ClrtError(f"changes: {pictures} pictures are too many; one sweep has at most {PICTURES}")
    for place, values in found.items():
        others = {other: values[0] for other, values in found.items()}
        for value in values:
            edited(scene, {**others, place: value})
    return found


def combinations(changes: Mapping[str, Sequence[Any]]) -> Iterator[Values]:
    """Every combination of the values, the last place changing fastest."""
    for values in product(*changes.values()):
        yield dict(zip(changes, values, strict=True))
