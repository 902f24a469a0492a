"""Measures which features each case shows, and keeps it (`ticks`).

    python -m validation.deletion_run [CASE ...]      these cases, or all whose scenes or features changed

Named cases are measured anew, in this process. The others go to the suite's processes, a fault or a case at a
time, and what comes of them is kept from run to run (`suite.kept`): broken off, it goes on where it was.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterable, Iterator, Mapping
from typing import Any, Final

from clrt.base.resources import validation_module

from .cases import matrix_cases
from .deletion_jobs import faults_of, noticed, shown
from .reliability import code
from .reliability.kept import ticks_of
from .suite.kept import Inputs, Kept
from .suite.run import Jobs, Plan, completed_once, versions
from .ticks import Row, fits, kept, row, write
from .types import Case

_WRONG: Final = "; WRONG: ticks.json"
_MODULE: Final = "validation.deletion_jobs"


def jobs_of(cases: Iterable[Case], device: int | str | None) -> tuple[Jobs, dict[str, Inputs | None]]:
    """What has to be done for these cases, and what it is made from."""
    cases, jobs, inputs = list(cases), Jobs(), dict[str, Inputs | None]()
    faults = {case.name: {f for feature in case.features for f in faults_of(feature)} for case in cases}
    for fault in sorted(set().union(*faults.values())):
        asked = tuple(name for name, of in faults.items() if fault in of)
        jobs[f"fault: {fault}"] = noticed, fault, asked, device
        inputs[f"fault: {fault}"] = Inputs(_MODULE, asked, (fault,))
    for case in cases:
        features = tuple(sorted(case.features))
        jobs[f"edits: {case.name}"] = shown, case.name, device
        inputs[f"edits: {case.name}"] = Inputs(_MODULE, (case.name,), said=features)
    return jobs, inputs


def measured(cases: Iterable[Case], found: Mapping[str, Any]) -> Iterator[tuple[Case, set[str]]]:
    """Each case and the features without which its picture is not the float64 oracle's any more, by what the
    jobs found."""
    for case in cases:
        faults = {feature: faults_of(feature) for feature in case.features}
        by_fault = {f for f, of in faults.items() if any(case.name in found[f"fault: {one}"] for one in of)}
        yield case, by_fault | set(found[f"edits: {case.name}"])


def otherwise(said: Row | None, found: Row) -> str:
    """What a kept row says otherwise than the one that was measured now; empty where they are equal."""
    if said is None or any(said[key] != found[key] for key in ("scene", "asked")):
        return f"{_WRONG} is of another case"
    if claimed := sorted(set(said["shows"]) - set(found["shows"])):
        return f"{_WRONG} claims {', '.join(claimed)}"
    more = sorted(set(found["shows"]) - set(said["shows"]))
    return f"; ticks.json does not claim {', '.join(more)}" if more else ""


def main(arguments: list[str] | None = None) -> int:
    """Measure the named cases, or all whose rows do not fit, and keep what was found; 2 for unknown names.

    With --check nothing is written, and 1 returned where a row is of another case or claims a feature that
    does not show. One that shows and is not claimed is only named: a picture at the edge of its gates passes
    them by one rounding and fails them by another, and a tick that is missing claims nothing.
    """
    parser = argparse.ArgumentParser(prog="python -m validation.deletion_run")
    parser.add_argument("case", nargs="*", help="only these; else those whose scenes or features changed")
    parser.add_argument("--all", action="store_true", help="every case of the matrix")
    parser.add_argument("--check", action="store_true", help="measure, and compare with what is kept")
    parser.add_argument("--fresh", action="store_true", help="all anew, also what an earlier run has kept")
    parser.add_argument("--device", help="as for clrt render")
    given = parser.parse_args(arguments)
    matrix, rows, wrong = matrix_cases(), dict(kept()), 0
    if unknown := sorted(set(given.case) - set(matrix)):
        print(f"no such case: {', '.join(unknown)}", file=sys.stderr)
        return 2
    wanted = given.case or [name for name, case in matrix.items() if given.all or not fits(case)]
    of = code.digest(*ticks_of())
    jobs, inputs = jobs_of(map(matrix.__getitem__, wanted), given.device)
    if given.case:
        found = {name: do(*arguments) for name, (do, *arguments) in jobs.items()}
    else:
        store = Kept(given.device, versions(), given.fresh)
        found, old = completed_once(jobs, inputs, given.device, Plan().processes, store, _tell)
        print(f"{len(old)} of {len(jobs)} results were kept{store.fault and f', none is: {store.fault}'}")
    for case, shows in measured(map(matrix.__getitem__, wanted), found):
        hollow = ", ".join(sorted(case.features - shows)) or "nothing"
        said = otherwise(rows.get(case.name), row(case, shows)) if given.check else ""
        wrong += said.startswith(_WRONG)
        print(f"{case.name}: without effect: {hollow}{said}", flush=True)
        rows[case.name] = row(case, shows, of)
    if not given.check:
        write(rows, matrix)
    return int(wrong > 0)


def _tell(done: int, total: int, name: str) -> None:
    print(f"{done} of {total} {name}", flush=True)


if __name__ == "__main__":
    sys.exit(validation_module("deletion_run").main())  # by the name that the suite's processes know
