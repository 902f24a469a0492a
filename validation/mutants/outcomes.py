"""What comes out of a fault that nobody chose: who notices it, or why nobody can.

A picture that has the bits of the sound one is not judged; of those that hardly move the few that change most
are; and where there is none, the code without the fault has to give it in the same place.
"""

from __future__ import annotations

import dataclasses
import threading
import time
from collections.abc import Iterable, Iterator, Sequence
from contextlib import closing
from functools import cache
from typing import Any, Final

import numpy as np

from clrt.base.errors import ClrtError

from ..types import OracleImage
from .generated import Place
from .panel import cases_for
from .plant import REFITTED, Lost, patched, pictures_by_child
from .run import is_sound, judge_of, judged, reference, sound
from .served import Served

NOTICED: Final = "noticed"
NO_PICTURE: Final = "no picture"
NOT_BUILT: Final = "not built"
NOT_LIVE: Final = "not live"
SURVIVED: Final = "survived"
OUTCOMES: Final = (NOTICED, NO_PICTURE, NOT_BUILT, NOT_LIVE, SURVIVED)
NEVER: Final = "no case comes by"
SAME: Final = "changes no bit"
LITTLE: Final = "moves too little"
REASONS: Final = {
    NEVER: "no picture of the cases comes by the place",
    SAME: "pictures come by the place, and no bit of them, of their layers and of counts of rays changes",
    LITTLE: "something changes, but in no case do more than 0.1 % of the pixels move by more than 1e-3",
}
"""Why a fault is not live, as its row's "why" has it, and what that means."""
LIVE_SHARE: Final = 0.001
LIVE_CHANGE: Final = 1e-3
_NOTHING: Final = 1e-7  # of hits' distances, relative (their gate: 1e-5), and of radiance (1e-4)
_CHANGED: Final = 1e-5  # relative: layers that differ by more are counted
_ASIDE: Final = 6  # pictures that hardly move and are judged nevertheless
_TOLD: Final = 3  # gates of those that failed
_SECONDS: Final = 1800.0  # for all pictures; each has a limit of processor time besides
_UNBUILT: Final = "do not build"

# "outcome", "by", "case", "seconds"; of those that are not live "why"
Row = dict[str, Any]
_looking = threading.Lock()  # oracles and the device serve one at a time


def outcome(place: Place, device: int | str | None = None) -> Row:
    """Plant a fault in a copy of its own: one of OUTCOMES, by which case and gates or why, and the case."""
    cases = cases_for(place.file)
    asked: list[str] = []  # of the pictures that came

    def noted(pictures: Iterable[tuple[str, OracleImage]]) -> Iterator[tuple[str, OracleImage]]:
        for case, picture in pictures:
            asked.append(case)
            yield case, picture

    with patched(place.file, place.edit) as root:
        try:
            with closing(pictures_by_child(root, cases, device, _SECONDS)) as pictures:
                return judged_pictures(place, noted(pictures), device)
        except Lost as error:
            case = cases[len(asked)]
            _prove(place.file, case, device)
            return {"outcome": NOT_BUILT if _UNBUILT in error.said else NO_PICTURE, "by": error.word,
                    "case": case}  # fmt: skip


def in_one_copy(places: Sequence[Place], device: int | str | None = None) -> Iterator[tuple[Place, Row]]:
    """What `outcome` gives for each of these faults, all in kernels or all of the host, by one copy of all.

    Each is looked for on the cases whose pictures come by its place, which one without faults tells.
    """
    with Served(dict(enumerate(places, 1)), device) as served:
        reached: dict[str, frozenset[int]] = {}
        for case in dict.fromkeys(case for place in places for case in cases_for(place.file)):
            picture, reached[case] = served.sound(case)
            if not _is_sound_one(picture, case, device):
                raise ClrtError(f"{case}: the places of faults change the picture where none is chosen")
        for number, place in enumerate(places, 1):
            start = time.perf_counter()
            every = cases_for(place.file)
            cases = [case for case in every if number in reached[case]]
            if number in served.unable:
                row = outcome(place, device)
            elif not cases:
                row = _not_live(NEVER, f"none of {len(every)} pictures")
            else:
                row = _chosen(served, number, place, cases, device)
            yield place, {**row, "seconds": round(time.perf_counter() - start, 1)}


def _chosen(
    served: Served, number: int, place: Place, cases: Sequence[str], device: int | str | None
) -> Row:
    """What comes out of a fault that can be chosen. Where it may come from another one's traces in the
    process, or where the process is not the same after it, it is chosen in a new one.

    ClrtError where the process gives no right picture without the fault, either: then it says nothing.
    """
    row: Row = {}
    for _ in range(2):
        crashed, asked = False, list[str]()
        try:
            row = judged_pictures(place, _pictures(served, number, cases, asked), device)
            if row["outcome"] == NOT_LIVE:
                return row
        except Lost as error:
            row, crashed = {"outcome": NO_PICTURE, "by": error.word, "case": asked[-1]}, error.crashed
        if _serves(served, row["case"], device):
            if not crashed:
                return row
        else:
            served.restart()
            if not _serves(served, row["case"], device):
                raise ClrtError(f"{row['case']}: no right picture without {place.name}, too: {row['by']}")
        cases = [row["case"], *(case for case in cases if case != row["case"])]
    return row


def _pictures(
    served: Served, number: int, cases: Sequence[str], asked: list[str]
) -> Iterator[tuple[str, OracleImage]]:
    """The pictures of a fault, and in `asked` the cases that they were asked of."""
    for case in cases:
        asked.append(case)
        yield case, served.picture(number, case)


def _serves(served: Served, case: str, device: int | str | None) -> bool:
    """Whether without any fault the case has its picture."""
    try:
        return _is_sound_one(served.picture(0, case), case, device)
    except Lost:
        return False


@cache
def _prove(file: str, case: str, device: int | str | None) -> None:
    """AssertionError unless a copy in which nothing is changed gives the case's picture."""
    with (
        patched(file, lambda text: text) as root,
        closing(pictures_by_child(root, [case], device, _SECONDS)) as pictures,
    ):
        _, picture = next(pictures)
    assert _is_sound_one(picture, case, device), f"{case}: a copy without any fault has another picture"


def judged_pictures(
    place: Place, pictures: Iterable[tuple[str, OracleImage]], device: int | str | None
) -> Row:
    """What comes out of a fault's pictures, of which no more are asked for than it takes."""
    live, count = "", 0
    most = -1.0, 0.0, ""  # the largest move, the share of pixels that move, where
    aside: list[tuple[float, str, OracleImage]] = []
    for name, ours in pictures:
        count += 1
        with _looking:
            right = sound(name, device)
            if same(ours, right):
                continue
            move, share = moved(name, ours, right)
        most = max(most, (move, share, name))
        if name.startswith(REFITTED):
            return {"outcome": NOTICED, "by": f"{name} (a new tracer): other bits", "case": name}
        if share <= LIVE_SHARE:
            if not _near(ours, right):
                aside.append((_changed(ours, right), name, ours))
            continue
        if (noticed := _noticed(place, name, ours, device)) is not None:
            return {"outcome": NOTICED, "by": noticed, "case": name}
        live = live or name
    aside.sort(key=lambda one: -one[0])
    for _, name, ours in aside if live else aside[:_ASIDE]:
        if (noticed := _noticed(place, name, ours, device)) is not None:
            return {"outcome": NOTICED, "by": noticed, "case": name}
    if live:
        return {"outcome": SURVIVED, "by": live, "case": live}
    move, share, name = most
    if not name:
        return _not_live(SAME, f"{count} pictures")
    pixels = f"{share:.2%} of the pixels move by more than 1e-3, the most by {move:.1e}"
    return {**_not_live(LITTLE, pixels if move else "layers change, and no pixel"), "case": name}


def _not_live(why: str, measured: str) -> Row:
    return {"outcome": NOT_LIVE, "why": why, "by": measured}


def _noticed(place: Place, name: str, ours: OracleImage, device: int | str | None) -> str | None:
    """The case, the oracle and the gates that fail; None where all pass."""
    oracle = judge_of(place.file, name)
    comparison = judged(name, ours, oracle)
    if comparison.passed or not is_sound(name, device, oracle):
        return None
    failed = [gate.name for gate in comparison.gates if not gate.passed]
    return f"{name} ({oracle}): {', '.join(failed[:_TOLD])}"


def _is_sound_one(picture: OracleImage, case: str, device: int | str | None) -> bool:
    with _looking:
        return same(picture, sound(case, device))


def same(ours: OracleImage, right: OracleImage) -> bool:
    """Whether all of two pictures, layers and shares of rays too, has the same bits."""
    mine, others = dict(_arrays(ours)), dict(_arrays(right))
    return mine.keys() == others.keys() and all(
        mine[name].dtype == others[name].dtype and mine[name].tobytes() == others[name].tobytes()
        for name in mine
    )


def _near(ours: OracleImage, right: OracleImage) -> bool:
    """Whether nothing differs by more than a hundredth of what gates forgive, so that none can fail by it."""
    return all(_apart(mine, other, _NOTHING) == 0 for mine, other in _pairs(ours, right))


def _changed(ours: OracleImage, right: OracleImage) -> float:
    """How much of a picture and of its layers differs: the sum of their shares."""
    return sum(_apart(mine, other, _CHANGED) for mine, other in _pairs(ours, right))


def _pairs(ours: OracleImage, right: OracleImage) -> Iterator[tuple[Any, Any]]:
    mine, others = dict(_arrays(ours)), dict(_arrays(right))
    for name in mine.keys() | others.keys():
        yield mine.get(name), others.get(name)


def _apart(mine: np.ndarray | None, other: np.ndarray | None, tolerance: float) -> float:
    """The share of two arrays that differs; 1 where their shapes do."""
    if mine is None or other is None or mine.shape != other.shape:
        return 1.0
    if not mine.size:
        return 0.0
    return 1.0 - float(np.isclose(mine, other, rtol=tolerance, atol=tolerance, equal_nan=True).mean())


def _arrays(image: OracleImage) -> Iterator[tuple[str, np.ndarray]]:
    for field in dataclasses.fields(image):
        value = getattr(image, field.name)
        for name, array in value.items() if isinstance(value, dict) else [("", value)]:
            if isinstance(array, np.ndarray):
                yield f"{field.name} {name}", array


def moved(name: str, ours: OracleImage, right: OracleImage) -> tuple[float, float]:
    """How far a pixel outside the mask of edges moves at most, and the share of those that move by more than
    LIVE_CHANGE. A fault is live where that is above LIVE_SHARE."""
    if ours.pixels.shape != right.pixels.shape:
        return float("inf"), 1.0
    inside = ~reference(name)[1]
    if not inside.any():
        return 0.0, 0.0
    change = np.abs(ours.pixels.astype(np.float64) - right.pixels)[inside].max(axis=-1)
    # what is no number any more has moved
    change = np.where(np.isnan(change), np.inf, change)
    return float(change.max()), float((change > LIVE_CHANGE).mean())
