"""Plants the faults that nobody chose (`generated`) and says who noticed each.

    python -m validation.mutants.generated_run [--count N] [--seed S] [--all]

A fault is live where in some case more than 0.1 % of the pixels outside the reference's mask move by more
than 1e-3; a live one has to be noticed. What came out is kept in generated.json with the digest of the file
with the fault in it, and stays until that changes.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import sys
from collections.abc import Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import Any, Final

import numpy as np

from clrt.base.atomic import write_text
from clrt.base.errors import ClrtError
from clrt.base.resources import PACKAGE, kernel_folder
from clrt.device.device import Device

from ..cases import matrix_cases
from ..coverage import fewest_cases
from ..oracles import our_picture
from ..types import OracleImage
from .generated import SEED, Place, drawn
from .plant import patched, pictures_by_child, small
from .run import MUTANTS, is_sound, judge_of, judged, reference

COUNT: Final = 300
FILE: Final = Path(__file__).with_name("generated.json")
LIVE_SHARE: Final = 0.001
LIVE_CHANGE: Final = 1e-3
_FIRST: Final = 4  # cases that are tried before all of the panel
_TOLD: Final = 3  # gates of those that failed
_SECONDS: Final = (120.0, 900.0)  # for pictures of the first ones, and of all others

Row = dict[str, Any]  # "text": digest of the file with the fault, "outcome", "by"


def outcome(place: Place, device: int | str | None = None) -> Row:
    """Plant a fault: "noticed", "no picture", "not live" or "survived", and by which case and gates."""
    live = ""
    with patched(place.file, place.edit) as root:
        for cases, seconds in zip(_cases(place.file), _SECONDS, strict=True):
            try:
                for name, ours in pictures_by_child(root, cases, device, seconds):
                    if (noticed := _noticed(place, name, ours, device)) is not None:
                        return {"outcome": "noticed", "by": noticed}
                    live = live or (name if _moves(name, ours, device) else "")
            except ClrtError as error:
                return {"outcome": "no picture", "by": str(error).splitlines()[-1][-200:]}
    return {"outcome": "survived", "by": live} if live else {"outcome": "not live", "by": ""}


def _noticed(place: Place, name: str, ours: OracleImage, device: int | str | None) -> str | None:
    """The case, the oracle and the gates that fail; None where all pass."""
    oracle = judge_of(place.file, name)
    comparison = judged(name, ours, oracle)
    if comparison.passed or not is_sound(name, device, oracle):
        return None
    failed = [gate.name for gate in comparison.gates if not gate.passed]
    return f"{name} ({oracle}): {', '.join(failed[:_TOLD])}"


def _moves(name: str, ours: OracleImage, device: int | str | None) -> bool:
    """Whether the fault is live here."""
    mask = reference(name)[1]
    change = np.abs(ours.pixels.astype(np.float64) - _sound(name, device))[~mask].max(axis=-1)
    return bool((change > LIVE_CHANGE).mean() > LIVE_SHARE)


@cache
def _sound(name: str, device: int | str | None) -> np.ndarray:
    return our_picture(small(name), _device(device)).pixels


@cache
def _device(device: int | str | None) -> Device:
    return Device(device)


@cache
def _cases(file: str) -> tuple[Sequence[str], Sequence[str]]:
    """A few cases on which faults of this file show, and the fewest others that show every feature."""
    near = (case for mutant in MUTANTS.values() if mutant.file == file for case in mutant.cases)
    panel = fewest_cases({name: case.shows for name, case in matrix_cases().items()})
    first = list(dict.fromkeys([*near, *panel]))[:_FIRST]
    return first, [name for name in panel if name not in first]


def kept() -> Mapping[str, Row]:
    """What came out before, by the fault's name."""
    return dict(json.loads(FILE.read_text("utf-8"))) if FILE.is_file() else {}


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
    parser.add_argument("--only", default="", help="those whose name has this in it")
    parser.add_argument("--device", help="as for clrt render")
    given = parser.parse_args(arguments)
    old, rows = kept(), dict[str, Row]()
    for place in drawn(given.count, given.seed):
        was, now = old.get(place.name), digest(place)
        fresh = was is None or was["text"] != now or given.all
        if given.only and given.only not in place.name:
            fresh = False
        if fresh:
            was = {"text": now, **outcome(place, given.device)}
            print(f"{place.name}: {was['outcome']}: {was['by']}", flush=True)
        if was is not None:
            rows[place.name] = was
        if fresh:
            _write(rows | {name: row for name, row in old.items() if name not in rows})
    _write(rows)
    counts = {kind: sum(row["outcome"] == kind for row in rows.values())
              for kind in ("noticed", "no picture", "not live", "survived")}  # fmt: skip
    print(", ".join(f"{count} {kind}" for kind, count in counts.items()))
    return int(counts["survived"] > 0)


def _write(rows: Mapping[str, Row]) -> None:
    lines = [f"{json.dumps(name)}: {json.dumps(row)}" for name, row in sorted(rows.items())]
    write_text(FILE, "{\n" + ",\n".join(lines) + "\n}\n")


if __name__ == "__main__":
    sys.exit(main())
