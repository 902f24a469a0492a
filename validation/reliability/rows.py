"""The table of promises: what is tried, how often, and who tries it."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

from clrt.device.device import Device

from .. import proofs
from ..hostile import gates
from ..hostile import run as hostile
from ..twin import check as twin_check
from . import accuracy, beginnings, code, coldstarts, drivers, faults, intel, interrupts, kills, sameness
from .figures import Figure, Tell


def _always() -> str:
    return ""


@dataclass(frozen=True)
class Row:
    """A promise: `count` of its `unit` must be tried. Void when a file changes that `modules` depend on.

    unable: says why this machine cannot run it, "" where it can.
    """

    name: str
    promise: str
    count: int
    unit: str
    run: Callable[[int, Tell], Figure]
    modules: tuple[str, ...]
    unable: Callable[[], str] = _always

    @property
    def code(self) -> str:
        """What a figure of this row holds for."""
        return code.digest(self.modules)


def _hostile(count: int, tell: Tell) -> Figure:
    seed = hostile.today()
    tasks = [*hostile.corpus(), *hostile.drawn(seed, count)]
    kept = 0

    def progress(found: hostile.Outcome) -> None:
        nonlocal kept
        hostile.keep(found.failures[kept:], hostile.FOUND)  # at once: the run takes an hour, and may be ended
        kept = len(found.failures)
        tell(found.counts.total() / len(tasks))

    outcome = hostile.run(tasks, progress=progress)
    return Figure(len(tasks), len(outcome.failures), f"seed {seed}: {outcome.told()}", outcome.seconds)


def _twin(count: int, tell: Tell) -> Figure:
    found = twin_check.twin_check(Device(), count)
    return Figure(count, int(not found.passed), found.detail, found.seconds)


def _leaks(count: int, tell: Tell) -> Figure:
    proof = proofs.leaks(proofs.Prover(), count, lambda _, done: tell(done / count))
    return Figure(proof.rays, proof.failed, f"scales {_scales(proofs.SCALES)}", proof.seconds)


def _self_hits(count: int, tell: Tell) -> Figure:
    proof = proofs.self_hits(proofs.Prover(), count, lambda _, done: tell(done / count))
    return Figure(proof.rays, proof.failed, f"scales {_scales(proofs.SCALES)}", proof.seconds)


def _scales(scales: tuple[float, ...]) -> str:
    return ", ".join(f"{scale:g}" for scale in scales)


def _accuracy(count: int, tell: Tell) -> Figure:
    return accuracy.run(count, tell)


def _here(name: str) -> tuple[str, ...]:
    return (f"validation.reliability.{name}",)


ROWS: Final = (
    Row("hostile", "hostile inputs, command lines and surroundings that end in anything but a picture or one "
        f"`ClrtError`, or, until read or refused, take above {gates.SECONDS:g} s + 1 s a MB or "
        f"{gates.MEMORY >> 20} MiB + {gates.MEMORY_PER_BYTE} bytes a byte of file", 200_000, "inputs",
        _hostile, ("validation.hostile.run", "validation.hostile.worker", *code.program())),
    Row("accuracy", "hits outside the error band of an analytic float64 oracle", 10**8, "rays", _accuracy,
        _here("accuracy")),
    Row("twin", "bits that differ from the float32 reference in numpy", 10**7, "rays", _twin,
        ("validation.twin.check",)),
    Row("leaks", "leaks through shared edges and corners of closed meshes", 10**9, "rays", _leaks,
        ("validation.proofs", *code.UNREAD)),
    Row("self-hits", "rays that meet the surface they leave", 10**8, "rays", _self_hits,
        ("validation.proofs", *code.UNREAD)),
    Row("sameness", "pictures that differ between tiles, work-groups, lanes, threads, processes and drivers",
        48, "configurations of every scene", sameness.run, _here("sameness")),
    Row("intel", "checks of `clrt selftest`, 31 small pictures among them, that fail on Intel's runtime", 20,
        "checks", intel.run, (*_here("intel"), "validation.selftest", *code.program("selftest")),
        intel.unable),
    Row("faults", "calls of the driver or the disk that, failing once, give a wrong error, leave a buffer or "
        "a file, or spoil the next render", 500, "calls", faults.run, _here("faults")),
    Row("kills", "output files that are neither the old nor the complete new one after SIGKILL or SIGINT",
        1000, "kills", kills.run, _here("kills")),
    Row("interrupts", f"renders that Ctrl-C does not end within {interrupts.SOON:g} s, with exit code 130, "
         "one line and no file", 100, "renders", interrupts.run,
         (*_here("interrupts"), *code.program("render"))),
    Row("beginnings", "commands that Ctrl-C, at a random time after clrt's first line, ends in anything but "
        "exit code 130, one line and no file", 2000, "commands", beginnings.run,
        (*_here("beginnings"), *code.program(*(words[0] for words in beginnings.COMMANDS)))),
    Row("coldstarts", f"processes that fail where {coldstarts.TOGETHER} start at once on a cold kernel cache",
        100 * coldstarts.TOGETHER, "processes", coldstarts.run,
        (*_here("coldstarts"), *code.program("hash"))),
    Row("drivers", "scenes that PoCL 3.0 renders faster than PoCL 3.1", 4, "scenes", drivers.run,
        _here("drivers"), drivers.unable),
)  # fmt: skip
"""In the order of the page."""


def timed(row: Row, tell: Tell) -> Figure:
    """The row's figure, with the wall time of all of it."""
    start = time.perf_counter()
    found = row.run(row.count, tell)
    return Figure(found.tried, found.wrong, found.detail, time.perf_counter() - start)
