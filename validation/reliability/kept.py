"""The figures of the other pages: files of raw values, each with a stamp of what it was measured with.

A file is stale where its stamp is of other code than there is now, or it has none.
"""

from __future__ import annotations

import datetime
import json
from pathlib import Path
from typing import Any, Final

from clrt.bench.machine import processor_name
from clrt.device.platforms import choose
from clrt.version import __version__

from . import code

DOCS: Final = code.ROOT / "docs"
STALE: Final = "older than the code that it is about"
TICKS: Final = "../validation/ticks.json"  # it has a digest a row
CLUSTER: Final = "cluster.json"
PROCESSORS: Final = "performance/processors.json"  # it has a stamp a kind of processor
WORKERS, DISTURBED = (1, 2, 4), {"kill": 50, "pause": 20}  # what its runs are of, at least
FAULTS: Final = 300  # that were drawn for mutants.json, at least
_OWN: Final = ("clrt.formats.native", *code.UNREAD)  # scenes that ship, and others that are made
FILES: Final[dict[str, tuple[str, ...]]] = {
    "performance/bench.json": ("clrt.bench.suite", *_OWN),
    "performance/bench_lanes8.json": ("clrt.bench.suite", *_OWN),
    "performance/bench_avx2.json": ("clrt.bench.suite", *_OWN),
    "performance/bench_other.json": ("clrt.bench.suite", *_OWN),
    PROCESSORS: ("clrt.bench.suite", *_OWN),
    "performance/scaling.json": ("clrt.bench.scaling", *_OWN),
    "performance/queries.json": ("clrt.bench.suite", *_OWN),
    "performance/large.json": ("clrt.bench.scenes", *code.program("render")),
    "performance/povray.json": ("clrt.bench.frames", *_OWN),
    "performance/thesis.json": (*code.program("render"), "clrt.formats.thesis", *_OWN),
    "performance/turns.json": (
        "clrt.bench.suite", *code.program("render", "bench"), "clrt.formats.thesis", *_OWN,
    ),
    CLUSTER: ("clrt.cluster.pictures", "clrt.cluster.connect", "clrt.cluster.calls"),
    "validation.json": ("validation.suite.run",),
    "mutants.json": ("validation.mutants.generated_run",),
    TICKS: ("validation.deletion_jobs",),
}
"""Files below docs, and the modules that each depends on."""


def stamp(modules: tuple[str, ...]) -> dict[str, Any]:
    """Commit, whether files have changed since, the code's hash, date, version, machine and driver; now."""
    commit, dirty = code.commit()
    return {
        "commit": commit, "dirty": dirty, "code": code.digest(modules), "version": __version__,
        "date": datetime.date.today().isoformat(), "processor": processor_name(), "device": choose()[0].label,
    }  # fmt: skip


def stale(name: str, docs: Path = DOCS) -> str:
    """What is wrong with a file of `FILES`; "" where its figures are of this code."""
    try:
        held = json.loads((docs / name).read_text("utf-8"))
    except FileNotFoundError:
        return "not measured"
    if name == TICKS:
        now = code.digest(*ticks_of())
        old = sum(not row.get("code") or not now.startswith(row["code"]) for row in held.values())
        return f"{old} of {len(held)} rows {STALE}" if old else ""
    found = held.get("stamp")
    if name == PROCESSORS:  # no machine has all kinds
        stamps = [kind["stamp"] for kind in held.values() if "stamp" in kind]
        found = next((s for s in stamps if s["code"] == code.digest(FILES[name])), next(iter(stamps), None))
    if not found:
        return "without a stamp of its code"
    if found["code"] != code.digest(FILES[name]):
        return STALE
    return "measured with changes that no commit holds" if found["dirty"] else _lacking(name, held)


def _lacking(name: str, held: dict[str, Any]) -> str:
    """What a file that is of this code does not prove."""
    if name == "validation.json":
        runs = held["runs"]
        if not all(run["passed"] for run in runs):
            return "not all of it passed"
        whole = any(run["coverage"] and run["mutants"] and run["checks"] for run in runs)
        return "" if whole else "of a part of the cases: no run is with --full"
    if name == "mutants.json":
        rows = held["faults"].values()
        if survived := sum(row["outcome"] == "survived" for row in rows):
            return f"{survived} faults survived"
        return "" if len(rows) >= FAULTS else f"of {len(rows)} faults, not {FAULTS}"
    if name == CLUSTER:
        told = {run["workers"]: run["rounds"] for run in held["faults"]}
        for count in WORKERS:
            rows = told.get(count, [])
            if other := sum(not row.get("same") for row in rows):
                return f"{other} rounds with {count} workers gave other bits"
            if again := sum(row.get("twice") or 0 for row in rows):  # None of one worker alone
                return f"{again} tasks were done twice with {count} workers"
            hit = [row["what"] for row in rows if row.get("pieces")]  # a worker that had something to do
            if any(hit.count(what) < least for what, least in DISTURBED.items()):
                return f"too few kills or pauses with {count} workers"
    return ""


def ticks_of() -> tuple[tuple[str, ...], tuple[str, ...]]:
    """What ticks are measured by, and what of it a row counts itself: for `code.digest`."""
    return FILES[TICKS], code.STATED


def checkout() -> bool:
    """Whether this is a checkout, whose commit can be told, and no installed copy."""
    return (code.ROOT / ".git").exists()
