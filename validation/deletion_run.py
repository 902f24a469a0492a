"""Measures which features each case shows, and keeps it (`ticks`).

    python -m validation.deletion_run [CASE ...]      these cases, or all whose scenes or features changed
"""

from __future__ import annotations

import argparse
import dataclasses
import sys
from collections.abc import Iterable, Iterator, Mapping
from functools import partial
from typing import Final

from clrt.device.device import Device

from .cases import matrix_cases, quietly
from .deletions import DELETIONS, Faults
from .mutants.plant import small
from .mutants.run import MUTANTS, is_sound, judged, pictures_of
from .oracles import ORACLE64, our_picture
from .ticks import Row, fits, kept, row, write
from .types import Case

_WRONG: Final = "; WRONG: ticks.json"


def measured(cases: Iterable[Case], device: int | str | None = None) -> Iterator[tuple[Case, set[str]]]:
    """Each case and the features without which its picture is not the float64 oracle's any more.

    The pictures are half as large as the case's, and judged by its gates. AssertionError where the renderer
    as it is does not pass them.
    """
    cases, opened = list(cases), Device(device)
    noticed: dict[str, set[str]] = {}  # fault -> cases
    for fault in sorted({fault for case in cases for feature in case.features for fault in _faults(feature)}):
        asked = tuple(c.name for c in cases if any(fault in _faults(feature) for feature in c.features))
        pictures = pictures_of(dataclasses.replace(MUTANTS[fault], cases=asked), device)
        noticed[fault] = {name for name, ours in pictures if not judged(name, ours, ORACLE64).passed}
    for case in cases:
        is_sound(case.name, device, ORACLE64)
        yield case, {feature for feature in case.features if _shows(case.name, feature, noticed, opened)}


def otherwise(said: Row | None, found: Row) -> str:
    """What a kept row says otherwise than the one that was measured now; empty where they are equal."""
    if said is None or any(said[key] != found[key] for key in ("scene", "asked")):
        return f"{_WRONG} is of another case"
    if claimed := sorted(set(said["shows"]) - set(found["shows"])):
        return f"{_WRONG} claims {', '.join(claimed)}"
    more = sorted(set(found["shows"]) - set(said["shows"]))
    return f"; ticks.json does not claim {', '.join(more)}" if more else ""


def _shows(name: str, feature: str, noticed: Mapping[str, set[str]], opened: Device) -> bool:
    deletion = DELETIONS[feature]
    if not callable(deletion):
        return any(name in noticed[fault] for fault in deletion)
    return not judged(name, our_picture(quietly(partial(deletion, small(name))), opened), ORACLE64).passed


def _faults(feature: str) -> Faults:
    deletion = DELETIONS[feature]
    return () if callable(deletion) else deletion


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
    parser.add_argument("--device", help="as for clrt render")
    given = parser.parse_args(arguments)
    matrix, rows, wrong = matrix_cases(), dict(kept()), 0
    if unknown := sorted(set(given.case) - set(matrix)):
        print(f"no such case: {', '.join(unknown)}", file=sys.stderr)
        return 2
    wanted = given.case or [name for name, case in matrix.items() if given.all or not fits(case)]
    for number, (case, shows) in enumerate(measured(map(matrix.__getitem__, wanted), given.device), 1):
        hollow = ", ".join(sorted(case.features - shows)) or "nothing"
        said = otherwise(rows.get(case.name), row(case, shows)) if given.check else ""
        wrong += said.startswith(_WRONG)
        print(f"{number} of {len(wanted)} {case.name}: without effect: {hollow}{said}", flush=True)
        if not given.check:
            rows[case.name] = row(case, shows)
            write(rows, matrix)
    return int(wrong > 0)


if __name__ == "__main__":
    sys.exit(main())
