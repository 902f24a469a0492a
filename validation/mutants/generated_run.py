"""Plants the faults that nobody chose (`generated`) and says who noticed each.

    python -m validation.mutants.generated_run [--count N] [--seed S] [--all] [--only TEXT] [--jobs N]

A fault is live where in some case more than 0.1 % of the pixels outside the reference's mask move by more
than 1e-3; a live one has to be noticed. What came out is kept in docs/mutants.json, each row with the commit
that it was planted in and the digest of the file with the fault; it stays until that file changes. Broken
off, it goes on where it was.

It is cheap to do so: all faults in kernels are in one build, without optimising, for few formats of rays; and
a picture that has the bits of the sound one is not judged.
"""

from __future__ import annotations

import argparse
import dataclasses
import hashlib
import json
import queue
import sys
import threading
import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import closing
from pathlib import Path
from typing import Any, Final

import numpy as np

from clrt.base.atomic import write_text
from clrt.base.errors import ClrtError
from clrt.base.resources import PACKAGE, kernel_folder

from ..reliability import kept as pages
from ..types import OracleImage
from .generated import SEED, Place, drawn
from .panel import cases_for
from .plant import REFITTED, patched, pictures_by_child
from .run import is_sound, judge_of, judged, reference, sound
from .served import Lost, Served

COUNT: Final = 300
NAME: Final = "mutants.json"
OUTCOMES: Final = ("noticed", "no picture", "not built", "not live", "survived")
LIVE_SHARE: Final = 0.001
LIVE_CHANGE: Final = 1e-3
_NOTHING: Final = 1e-7  # of hits' distances, relative (their gate: 1e-5), and of radiance (1e-4)
_MOST: Final = 60  # cases on which a fault in kernels is looked for
_TOLD: Final = 3  # gates of those that failed
_SECONDS: Final = 1800.0  # for all pictures; each has a limit of processor time besides
_UNBUILT: Final = "do not build"

# "text": digest of the file with the fault, "commit", "outcome", "by", "case", "seconds"
Row = dict[str, Any]
_looking = threading.Lock()  # oracles and the device serve one at a time


def outcome(place: Place, device: int | str | None = None) -> Row:
    """Plant a fault: one of OUTCOMES, and by which case and gates, or on which case it lives."""
    with patched(place.file, place.edit) as root:
        try:
            with closing(pictures_by_child(root, cases_for(place.file), device, _SECONDS)) as pictures:
                return _judged(place, pictures, device)
        except ClrtError as error:
            kind = "not built" if _UNBUILT in str(error) else "no picture"
            return {"outcome": kind, "by": _last(error)}


def in_kernels(places: Sequence[Place], device: int | str | None = None) -> Iterator[tuple[Place, Row]]:
    """What `outcome` gives for each of these faults in kernels, by one build of all of them.

    Each is looked for on the cases whose pictures come by its place, which one without faults tells.
    """
    with Served(dict(enumerate(places, 1)), device) as served:
        reached: dict[str, frozenset[int]] = {}
        for case in dict.fromkeys(case for place in places for case in cases_for(place.file)):
            picture, reached[case] = served.sound(case)
            with _looking:
                if not _same(picture, sound(case, device)):
                    raise ClrtError(f"{case}: the places of faults change the picture where none is chosen")
        for number, place in enumerate(places, 1):
            start = time.perf_counter()
            cases = [case for case in cases_for(place.file) if number in reached.get(case, ())]
            if number in served.unable:
                row = outcome(place, device)
            else:
                row = _chosen(served, number, place, cases[:_MOST], device)
            if not cases:
                row["by"] = "no case comes by"
            yield place, {**row, "seconds": round(time.perf_counter() - start, 1)}


def _chosen(
    served: Served, number: int, place: Place, cases: Sequence[str], device: int | str | None
) -> Row:
    """What comes out of a fault in the kernels that are built. Where it may come from another one's traces
    in the process, or where the process is not the same after it, it is chosen in a new one."""
    row: Row = {}
    for _ in range(2):
        try:
            row = _judged(place, ((case, served.picture(number, case)) for case in cases), device)
            if row["outcome"] == "not live":
                return row
            with _looking:
                right = sound(row["case"], device)
            if _same(served.picture(0, row["case"]), right):
                return row
        except Lost as error:
            row = {"outcome": "no picture", "by": _last(error)}
            if not error.crashed:
                return row
        served.restart()
    return row


def _judged(
    place: Place, pictures: Iterable[tuple[str, OracleImage]], device: int | str | None
) -> Row:
    """What comes out of a fault's pictures, of which no more are asked for than it takes."""
    live = last = ""
    for name, ours in pictures:
        with _looking:
            if _same(ours, sound(name, device)):
                continue
            last = name
            if not name.startswith(REFITTED) and _near(ours, sound(name, device)):
                continue
            if (noticed := _noticed(place, name, ours, device)) is not None:
                return {"outcome": "noticed", "by": noticed, "case": name}
            live = live or (name if _moves(name, ours, device) else "")
    if live:
        return {"outcome": "survived", "by": live, "case": live}
    return {"outcome": "not live", "by": f"moves too little, in {last}" if last else "moves nothing"}


def _last(error: ClrtError) -> str:
    return str(error).splitlines()[-1][-200:]


def _same(ours: OracleImage, right: OracleImage) -> bool:
    """Whether all of two pictures, layers and shares of rays too, has the same bits."""
    mine, others = dict(_arrays(ours)), dict(_arrays(right))
    return mine.keys() == others.keys() and all(
        mine[name].dtype == others[name].dtype and mine[name].tobytes() == others[name].tobytes()
        for name in mine
    )


def _near(ours: OracleImage, right: OracleImage) -> bool:
    """Whether nothing differs by more than a hundredth of what gates forgive, so that none can fail by it."""
    mine, others = dict(_arrays(ours)), dict(_arrays(right))
    return all(
        mine[name].shape == others[name].shape
        and np.allclose(mine[name], others[name], rtol=_NOTHING, atol=_NOTHING, equal_nan=True)
        for name in mine
    )


def _arrays(image: OracleImage) -> Iterator[tuple[str, np.ndarray]]:
    for field in dataclasses.fields(image):
        value = getattr(image, field.name)
        for name, array in value.items() if isinstance(value, dict) else [("", value)]:
            if isinstance(array, np.ndarray):
                yield f"{field.name} {name}", array


def _noticed(place: Place, name: str, ours: OracleImage, device: int | str | None) -> str | None:
    """The case, the oracle and the gates that fail; None where all pass."""
    if name.startswith(REFITTED):
        return f"{name} (a new tracer): other bits"
    oracle = judge_of(place.file, name)
    comparison = judged(name, ours, oracle)
    if comparison.passed or not is_sound(name, device, oracle):
        return None
    failed = [gate.name for gate in comparison.gates if not gate.passed]
    return f"{name} ({oracle}): {', '.join(failed[:_TOLD])}"


def _moves(name: str, ours: OracleImage, device: int | str | None) -> bool:
    """Whether the fault is live here."""
    mask, right = reference(name)[1], sound(name, device).pixels
    if ours.pixels.shape != right.shape:
        return True
    change = np.abs(ours.pixels.astype(np.float64) - right)[~mask].max(axis=-1)
    return bool((change > LIVE_CHANGE).mean() > LIVE_SHARE)


def kept(docs: Path = pages.DOCS) -> Mapping[str, Row]:
    """What came out before, by the fault's name."""
    file = docs / NAME
    return dict(json.loads(file.read_text("utf-8"))["faults"]) if file.is_file() else {}


def digest(place: Place) -> str:
    """What identifies the file with the fault in it."""
    root = kernel_folder().parent if place.file.startswith("kernels/") else PACKAGE.parent
    return hashlib.sha256(place.edit((root / place.file).read_text("utf-8")).encode()).hexdigest()[:16]


def main(arguments: list[str] | None = None) -> int:
    """Plant those that are new, and say what came out; 1 where a live fault was not noticed."""
    parser = argparse.ArgumentParser(prog="python -m validation.mutants.generated_run")
    parser.add_argument("--count", type=int, default=COUNT)
    parser.add_argument("--seed", type=int, default=SEED)
    parser.add_argument("--all", action="store_true", help="also those whose results are kept")
    parser.add_argument("--only", default="", help="those whose name or result has this in it")
    parser.add_argument("--jobs", type=int, default=2, help="faults that are planted at the same time")
    parser.add_argument("--device", help="as for clrt render")
    given = parser.parse_args(arguments)
    old = kept()
    places = {place.name: place for place in drawn(given.count, given.seed)}
    now = {name: digest(place) for name, place in places.items()}
    rows = {name: old[name] for name in places if name in old and old[name]["text"] == now[name]}
    waiting = [name for name in places if given.all or name not in rows]
    if given.only:
        waiting = [name for name in places if given.only in f"{name}: {rows.get(name, {}).get('outcome')}"]
    stamp = pages.stamp(pages.FILES[NAME])
    for number, (name, row) in enumerate(_planted([places[n] for n in waiting], given.jobs, given.device)):
        rows[name] = {"text": now[name], "commit": stamp["commit"], **row}
        print(f"[{number + 1}/{len(waiting)}] {name}: {row['outcome']}: {row['by']}", flush=True)
        _write(rows, stamp)
    _write(rows, stamp)
    counts = {kind: sum(row["outcome"] == kind for row in rows.values()) for kind in OUTCOMES}
    print(", ".join(f"{count} {kind}" for kind, count in counts.items()))
    return int(counts["survived"] > 0)


def _planted(places: list[Place], jobs: int, device: str | None) -> Iterator[tuple[str, Row]]:
    """What comes out of each, as it does: of the host one by one, of kernels in one build, side by side."""
    found: queue.Queue[tuple[str, Row] | BaseException] = queue.Queue()
    kernels = [place for place in places if place.file.startswith("kernels/")]

    def of_host() -> None:
        for place in places:
            if place not in kernels:
                start = time.perf_counter()
                row = outcome(place, device)
                found.put((place.name, {**row, "seconds": round(time.perf_counter() - start, 1)}))

    def of_kernels() -> None:
        for place, row in in_kernels(kernels, device) if kernels else ():
            found.put((place.name, row))

    def told(work: Callable[[], None]) -> None:
        try:
            work()
        except BaseException as error:
            found.put(error)

    with ThreadPoolExecutor(jobs) as pool:
        for work in (of_kernels, of_host):
            pool.submit(told, work)
        for _ in places:
            answer = found.get()
            if isinstance(answer, BaseException):
                raise answer
            yield answer


def _write(rows: Mapping[str, Row], stamp: Mapping[str, Any]) -> None:
    """A line a fault, so that a change is seen as one."""
    lines = [f"{json.dumps(name)}: {json.dumps(row)}" for name, row in sorted(rows.items())]
    text = f'{{"stamp": {json.dumps(stamp)},\n"faults": {{\n' + ",\n".join(lines) + "\n}}\n"
    write_text(pages.DOCS / NAME, text)


if __name__ == "__main__":
    sys.exit(main())
