"""Scenes that differ in a few values: what many pictures are made of."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from copy import deepcopy
from itertools import product
from typing import Any, Final

import numpy as np

from clrt.base import arguments
from clrt.base.errors import ClrtError, fault
from clrt.engine.foresight import FEW, Values
from clrt.scene.edit import places
from clrt.scene.scene import Scene, edited

PICTURES: Final = 100_000  # of a sweep: all values are looked at before the first
# argument for all pictures -> the place whose values it goes before
_INSTEAD: Final = {
    "width": ("camera", "width"), "height": ("camera", "height"), "spp": ("camera", "spp"),
    "max_depth": ("max_depth",), "camera": ("camera",),
}  # fmt: skip


def checked(scene: Scene, changes: object) -> dict[str, Sequence[Any]]:
    """The changes as lists, each value of which makes a scene; of few pictures each combination does.

    Whether these can be rendered, too, `foresight.check_series` tells.
    """
    found: dict[str, Sequence[Any]] = {}
    for place, values in arguments.mapping("changes", changes).items():
        if isinstance(values, np.ndarray) and values.ndim and len(values) <= PICTURES:
            values = list(values)
        if not isinstance(values, (list, tuple, range)) or not values:
            right = "it must be a list of values, such as [20, 30]"
            raise ClrtError(fault("", f"changes[{place!r}]", values, right))
        try:
            found[place] = deepcopy(values)  # the caller's may change before the last picture
        except Exception as error:  # whatever their classes raise
            right = f"it must be a list of values that can be copied ({type(error).__name__}: {error})"
            raise ClrtError(fault("", f"changes[{place!r}]", values, right)) from None
    _check_apart(scene, found)
    pictures = math.prod(map(len, found.values()))
    if pictures > PICTURES:
        raise ClrtError(f"changes: {pictures} pictures are too many; one sweep has at most {PICTURES}")
    firsts = {place: values[0] for place, values in found.items()}
    each = ({**firsts, place: value} for place, values in found.items() for value in values)
    for values in combinations(found) if pictures <= FEW else each:
        edited(scene, values)
    return found


def _check_apart(scene: Scene, changes: Iterable[str]) -> None:
    """ClrtError where a place holds one before it, of whose values nothing would be left."""
    within: dict[tuple[str | int, ...], str] = {}  # places so far, by their steps and all of their beginnings
    for place, steps in places(scene, changes).items():
        if steps in within:
            told = f"it stands in the place of changes[{within[steps]!r}], too; give one, or it first"
            raise ClrtError(f"changes[{place!r}]: {told}")
        within |= {steps[: k + 1]: place for k in range(len(steps))}


def check_once(
    scene: Scene,
    changes: Mapping[str, Sequence[Any]],
    given: Mapping[str, Any],
    said: Callable[[str, str], tuple[str, str]],
) -> None:
    """ClrtError where what is given for all pictures goes before values of these places.

    said: how the user has written an argument, and values for a place.
    """
    for place, steps in places(scene, changes).items():
        for name, instead in _INSTEAD.items():
            if given.get(name) is not None and _says(steps, changes[place], instead):
                argument, values = said(name, place)
                text = f"it would hold for all pictures, whatever {values} says; give one of the two"
                raise ClrtError(f"{argument}: {text}")


def _says(steps: tuple[str | int, ...], values: Sequence[Any], instead: tuple[str, ...]) -> bool:
    """Whether values for a place say various things of what is at `instead`."""
    if steps[: len(instead)] == instead:
        return True
    if steps != instead[:-1]:
        return False
    key = instead[-1]
    first, *others = (v.get(key) if isinstance(v, Mapping) else getattr(v, key, None) for v in values)
    return any(other != first for other in others)


def combinations(changes: Mapping[str, Sequence[Any]]) -> Iterator[Values]:
    """Every combination of the values, the last place changing fastest."""
    for values in product(*changes.values()):
        yield dict(zip(changes, values, strict=True))
