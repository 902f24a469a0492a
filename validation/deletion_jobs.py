"""Which features a case shows: measured by deleting them, a fault or a case at a time.

The pictures are half as large as the case's, and judged by its gates.
"""

from __future__ import annotations

import dataclasses
from functools import cache, partial

from clrt.device.device import Device

from .cases import case_named, quietly
from .deletions import DELETIONS, Faults
from .mutants.plant import small
from .mutants.run import MUTANTS, is_sound, judged, pictures_of
from .oracles import ORACLE64, our_picture


def faults_of(feature: str) -> Faults:
    """The faults that delete a feature; none where an edit of the scene does."""
    deletion = DELETIONS[feature]
    return () if callable(deletion) else deletion


def noticed(fault: str, cases: tuple[str, ...], device: int | str | None) -> list[str]:
    """Those of the cases whose pictures with a fault are not the float64 oracle's any more."""
    pictures = pictures_of(dataclasses.replace(MUTANTS[fault], cases=cases), device)
    return [name for name, ours in pictures if not judged(name, ours, ORACLE64).passed]


def shown(name: str, device: int | str | None) -> list[str]:
    """Those of a case's features that an edit of its scene deletes, and without which its picture is another.

    AssertionError where the renderer as it is does not pass the case's gates.
    """
    is_sound(name, device, ORACLE64)
    found = []
    for feature in sorted(case_named(name).features):
        deletion = DELETIONS[feature]
        if callable(deletion):
            ours = our_picture(quietly(partial(deletion, small(name))), _opened(device))
            if not judged(name, ours, ORACLE64).passed:
                found.append(feature)
    return found


@cache
def _opened(device: int | str | None) -> Device:
    return Device(device)
