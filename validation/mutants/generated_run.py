"""Plants the faults that nobody chose (`generated`) and says who noticed each.

    python -m validation.mutants.generated_run [--count N] [--seed S] [--all] [--only TEXT]

A fault is live where in some case more than 0.1 % of the pixels outside the reference's mask move by more
than 1e-3; a live one has to be noticed. What came out is kept in docs/mutants.json, each row with the commit
and the digest of the code that it was planted in: kernels, and all modules that a picture or its judgement
may reach. A row of other code is planted again, and until then the file is stale. Broken off, it goes on
where it was. `python docs/make_mutants.py` writes the page from it.

It runs in a copy of the checkout, so that an edit meanwhile changes nothing; and it is cheap: all faults in
kernels are in one build, without optimising, for few formats of rays, all of the host in one process.
"""

from __future__ import annotations

import argparse
import json
import queue
import sys
import time
from collections.abc import Iterable, Iterator, Mapping
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any, Final

from clrt.base.atomic import write_text
from clrt.base.errors import ClrtError
from clrt.base.resources import PACKAGE

from ..reliability import code
from ..reliability import kept as pages
from . import snapshot
from .generated import SEED, Place, drawn
from .outcomes import OUTCOMES, SURVIVED, Row, in_one_copy

COUNT: Final = pages.FAULTS
NAME: Final = "mutants.json"
_JOBS: Final = 2  # faults in kernels, and of the host
_DIGITS: Final = 16  # of the hash of the code, in rows


def kept(docs: Path = pages.DOCS) -> Mapping[str, Row]:
    """What came out of each fault, by name; nothing where none is kept."""
    try:
        found: Mapping[str, Row] = json.loads((docs / NAME).read_text("utf-8"))["faults"]
    except FileNotFoundError:
        return {}
    return found


def main(arguments: list[str] | None = None) -> int:
    """Plant those that are new, and say what came out; 1 where a live fault was not noticed."""
    parser = argparse.ArgumentParser(prog="python -m validation.mutants.generated_run")
    parser.add_argument("--count", type=int, default=COUNT)
    parser.add_argument("--seed", type=int, default=SEED)
    parser.add_argument("--all", action="store_true", help="also those whose results are kept")
    parser.add_argument("--only", default="", help="those whose name or result has this in it")
    parser.add_argument("--device", help="as for clrt render")
    parser.add_argument("--docs", type=Path, default=pages.DOCS, help="the folder of mutants.json")
    parser.add_argument("--stamp", type=json.loads, help=argparse.SUPPRESS)  # in the copy: of the checkout
    given = parser.parse_args(arguments)
    if given.stamp is None:
        stamp = pages.stamp(pages.FILES[NAME])
        words = sys.argv[1:] if arguments is None else arguments
        return snapshot.run(__spec__.name, [*words, "--docs", str(given.docs.resolve())], stamp)
    stamp = dict(given.stamp)
    if code.digest(pages.FILES[NAME]) != stamp["code"] or PACKAGE.parent != code.ROOT:
        raise ClrtError(f"the code of {PACKAGE} is not that of the stamp")
    old = kept(given.docs)
    places = {place.name: place for place in drawn(given.count, given.seed)}
    rows = {name: old[name] for name in places if name in old}
    waiting = [name for name in places if given.all or not current(rows.get(name, {}), stamp)]
    if given.only:
        waiting = [name for name in places if given.only in f"{name}: {rows.get(name, {}).get('outcome')}"]
    start = time.perf_counter()
    dirty = {"dirty": True} if stamp["dirty"] else {}
    came_from = {"code": stamp["code"][:_DIGITS], "commit": stamp["commit"], **dirty}
    for number, (name, row) in enumerate(_planted([places[n] for n in waiting], given.device)):
        rows[name] = {**came_from, **row}
        said = f"{row['why']}, {row['by']}" if "why" in row else row["by"]
        print(f"[{number + 1}/{len(waiting)}] {name}: {row['outcome']}: {said}", flush=True)
        _write(given.docs, rows, places, stamp)
    _write(given.docs, rows, places, stamp)
    counts = {kind: sum(row["outcome"] == kind for row in rows.values()) for kind in OUTCOMES}
    said = ", ".join(f"{count} {kind}" for kind, count in counts.items())
    print(f"{said}; {len(waiting)} planted in {time.perf_counter() - start:.0f} s")
    return int(counts[SURVIVED] > 0)


def _planted(places: list[Place], device: str | None) -> Iterator[tuple[str, Row]]:
    """What comes out of each, as it does: those of the host beside those in kernels."""
    found: queue.Queue[tuple[str, Row] | BaseException] = queue.Queue()

    def all_of(some: list[Place]) -> None:
        try:
            for place, row in in_one_copy(some, device) if some else ():
                found.put((place.name, row))
        except BaseException as error:
            found.put(error)

    kernels = [place for place in places if place.file.startswith("kernels/")]
    with ThreadPoolExecutor(_JOBS) as pool:
        for some in (kernels, [place for place in places if place not in kernels]):
            pool.submit(all_of, some)
        for _ in places:
            answer = found.get()
            if isinstance(answer, BaseException):
                raise answer
            yield answer


def current(row: Row, stamp: Mapping[str, Any]) -> bool:
    """Whether a row is of the stamp's code. A dirty one is none of a clean stamp's: no commit holds it."""
    return row.get("code") == stamp["code"][:_DIGITS] and (stamp["dirty"] or not row.get("dirty"))


def _write(docs: Path, rows: Mapping[str, Row], places: Iterable[str], stamp: Mapping[str, Any]) -> None:
    """A line a fault, so that a change is seen as one. Dirty as long as one of the rows is; and no code's as
    long as some are of other code, or missing."""
    whole = {**stamp, "dirty": stamp["dirty"] or any(row.get("dirty") for row in rows.values())}
    if not all(rows.get(name, {}).get("code") == stamp["code"][:_DIGITS] for name in places):
        whole["code"] = ""
    lines = [f"{json.dumps(name)}: {json.dumps(row)}" for name, row in sorted(rows.items())]
    text = f'{{"stamp": {json.dumps(whole)},\n"faults": {{\n' + ",\n".join(lines) + "\n}}\n"
    write_text(docs / NAME, text)


if __name__ == "__main__":
    sys.exit(main())
