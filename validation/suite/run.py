"""The whole of validation in one call: cases under their oracles, ray counts, mutants, coverage.

Cases go to a few processes, each with a device and a Mitsuba of its own. Quick: the float64 oracle on every
matrix case, and Mitsuba on as few of them as have all features. Least: only these few, and Mitsuba's own
plugins. Full: every oracle that can express a case, the scenes that ship and random scenes.
"""

from __future__ import annotations

import datetime
import os
import platform
import signal
import time
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import Future, ProcessPoolExecutor, as_completed
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from dataclasses import dataclass, field
from importlib.metadata import PackageNotFoundError, version
from multiprocessing import active_children, get_context
from pathlib import Path
from typing import Any, Final

from clrt.base import interrupts
from clrt.base.errors import ClrtError
from clrt.base.resources import validation_module
from clrt.device.device import Device
from clrt.device.platforms import choose
from clrt.scene.scene import Scene
from clrt.version import __version__

from ..cases import TABLES, case_named, matrix_cases, own_case, own_file, random_cases, shipped_cases
from ..compare.metrics import without_flip
from ..coverage import PROGRAM, coverage, fewest_cases
from ..mutants.run import MUTANTS, judged_by_mitsuba, run_mutant
from ..oracle_povray import client as povray
from ..oracles import ORACLE64, POVRAY, able, scene_of, why_not
from ..spd import KNOWN, PUBLISHED, check_folder
from ..types import CaseResult, SuiteResult
from .kept import Inputs, Kept
from .program import Program
from .worker import Task, count_known, count_published, run_case, run_twin

Progress = Callable[[int, int, str], None]
Jobs = dict[str, tuple[Any, ...]]  # by name: function and arguments
RANDOM_SEED: Final = 1
FULL_RANDOM: Final = 100  # scenes
_MOST_PROCESSES: Final = 4  # each has a Mitsuba, which takes memory
_PACKAGES: Final = ("numpy", "pyopencl", "scikit-image", "flip-evaluator", "mitsuba", "drjit",
                    "karellen-llvm-core")


@dataclass(frozen=True)
class Plan:
    """What a run consists of.

    least: no more cases than show every feature to two oracles. seed: of the random scenes. pictures: keep
    them for a report. executor: whose workers do it, in place of this machine's processes, and then nothing
    is kept. program: somebody else's, as a further oracle of every case. keep: results, for later runs;
    fresh: take none of an earlier one (`kept`).
    """

    quick: bool = True
    least: bool = False
    random: int = 0
    seed: int = RANDOM_SEED
    spd: Path | None = None
    mutants: bool = False
    cases: tuple[str, ...] = ()  # only these
    scenes: tuple[str, ...] = ()  # somebody's own, and no others
    device: int | str | None = None
    pictures: bool = False
    command: str = ""
    executor: Any = None
    program: Program | None = None
    keep: bool = False
    fresh: bool = False
    processes: int = field(default_factory=lambda: min(os.cpu_count() or 1, _MOST_PROCESSES))


def run(plan: Plan, progress: Progress | None = None) -> SuiteResult:
    """Run what the plan says. ClrtError, before anything runs, for a case or folder that is not there."""
    start, started = time.perf_counter(), datetime.datetime.now().astimezone().isoformat(timespec="seconds")
    tasks, mutants = tasks_of(plan), tuple(MUTANTS) if plan.mutants else ()
    jobs: Jobs = {}
    if plan.spd is not None:
        check_folder(plan.spd)
        jobs |= {f"published counts: {name}": (count_published, name, plan.spd,
                                               plan.device) for name in PUBLISHED}
    if not (plan.cases or plan.scenes):
        jobs |= {f"counts: {name}": (count_known, name, plan.device) for name in KNOWN}
    if not plan.quick:
        jobs["float32 twin"] = (run_twin, plan.device)
    counting = [name for name in jobs if "counts: " in name]
    # the longest first, so that no process is left alone with one of them
    jobs |= {task.name: (run_case, task) for task in sorted(tasks, key=lambda task: -task.rays)}
    jobs |= {f"mutant: {name}": (run_mutant, name, plan.device) for name in mutants}
    found, label, kept, said = _done(jobs, plan, progress)

    cases: list[CaseResult] = [found[task.name] for task in tasks]
    counts = [count for name in counting for count in found[name]]
    # a few cases are to prove no more than themselves
    table = {} if plan.cases or plan.scenes else coverage(cases, counts)
    return SuiteResult(
        cases,
        [found[f"mutant: {name}"] for name in mutants],
        counts,
        table,
        versions(),
        label,
        time.perf_counter() - start,
        plan.seed if plan.random else None,
        plan.command,
        started,
        (*notes(plan, cases), *said),
        (found["float32 twin"],) if "float32 twin" in found else (),
        0 if plan.scenes else len({*matrix_cases(), *shipped_cases(), *(task.name for task in tasks)}),
        kept=kept,
    )


def _done(
    jobs: Jobs, plan: Plan, progress: Progress | None
) -> tuple[dict[str, Any], str, tuple[str, ...], list[str]]:
    """What the jobs found, the devices that they ran on, which results were kept, and notes on that."""
    if plan.executor is not None:
        from .shared import Told, completed_by

        told = Told()
        found = dict(completed_by(plan.executor, jobs, plan.device, progress, told))
        return found, ", ".join(sorted(told.devices)), (), []
    label = choose(plan.device)[0].label
    kept = Kept(plan.device, versions(), plan.fresh) if plan.keep else None
    inputs = {name: _inputs(job) for name, job in jobs.items()}
    found, names = completed_once(jobs, inputs, plan.device, plan.processes, kept, progress)
    said = [f"results are not kept: {kept.fault}"] if kept and kept.fault else []
    if names:
        said.append(f"{len(names)} of {len(jobs)} results are of earlier runs of the same code and inputs; "
                    "--fresh runs all anew")  # fmt: skip
    return found, label, names, said


def _inputs(job: tuple[Any, ...]) -> Inputs | None:
    """What a job is made from; None where somebody else's program, of which nothing is known, has a part."""
    function, first = job[0], job[1]
    module = f"validation.{function.__module__.partition('.')[2]}"
    if function is run_case:
        more = {"cases": (first.name,), "said": first.oracles, "pictures": first.pictures}
        return None if first.program else Inputs(module, **more)
    if function is run_mutant:
        return Inputs(module, faults=(first,))
    if function is count_published:
        return Inputs(module, files=(job[2] / f"{first}.nff",))
    return Inputs(module)


def completed_once(
    jobs: Jobs, inputs: Mapping[str, Inputs | None], device: int | str | None, processes: int,
    kept: Kept | None, progress: Progress | None,
) -> tuple[dict[str, Any], tuple[str, ...]]:  # fmt: skip
    """What jobs found, in an earlier run that kept it or now; and the names of those of earlier runs."""
    found = kept.read(inputs) if kept else {}
    names, left = tuple(found), {name: job for name, job in jobs.items() if name not in found}
    if left:
        Device(device).kernels.program  # noqa: B018 - compiled once, then all processes find it in the driver's cache

    def tell(done: int, total: int, name: str) -> None:
        if progress:
            progress(len(names) + done, len(names) + total, name)

    for name, result in completed(left, processes, tell):
        found[name] = result
        if kept:
            kept.keep(name, inputs[name], result)
    return found, names


def case_rows() -> Iterator[tuple[str, str]]:
    """Name and features of each case that `--case` takes, but for random ones."""
    for name in (*matrix_cases(), *shipped_cases()):
        yield name, ", ".join(sorted(case_named(name).shows or case_named(name).features))


def tasks_of(plan: Plan) -> list[Task]:
    """The cases to run, and for each the oracles that can express it."""
    matrix = matrix_cases()
    some = fewest_cases({name: c.shows for name, c in matrix.items() if "mitsuba-table" in c.oracles})
    if not plan.least:
        some = list(dict.fromkeys([*some, *judged_by_mitsuba()]))
    if plan.cases or plan.scenes:
        names = [*(name for name in plan.cases if case_named(name)), *map(own_case, plan.scenes)]
    elif plan.least:
        names = [*some, *(name for name, case in matrix.items() if "mitsuba-table" not in case.oracles)]
    else:
        names = [*matrix, *([] if plan.quick else shipped_cases()), *random_cases(plan.random, plan.seed)]
    tasks = []
    for name in names:
        case = case_named(name)
        oracles = list(case.oracles)
        chosen = plan.cases or plan.scenes
        if plan.quick and not chosen and name not in some:
            oracles = [oracle for oracle in oracles if oracle == ORACLE64 or oracle.startswith("stock")]
        if plan.quick and not chosen:
            oracles = [oracle for oracle in oracles if oracle != "mitsuba-bsdf"]
        able_ones = tuple(o for o in oracles if able(o, case) and not (o == POVRAY and povray.missing()))
        tasks.append(Task(name, able_ones, plan.device, plan.pictures, rays_of(scene_of(case)), plan.program))
    return tasks


def rays_of(scene: Scene) -> int:
    """About how many rays a scene's picture takes, as far as its size and samples tell."""
    assert scene.camera is not None
    bands = scene.spectrum.bands if scene.spectrum is not None else 3
    samples = scene.camera.width * scene.camera.height * scene.camera.spp
    return samples * (1 + scene.ambient_samples) * bands


def notes(plan: Plan, cases: list[CaseResult]) -> Iterator[str]:
    """What a reader should know: what was left out, and why."""
    unproven = [(result.case.name, oracle, why) for result in cases for oracle,
                why in result.unproven.items()]
    for why in dict.fromkeys(why for _, _, why in unproven):
        names = [f"{name} ({oracle})" for name, oracle, reason in unproven if reason == why]
        shown = ", ".join(names[:4]) + (f" and {len(names) - 4} more" if len(names) > 4 else "")
        yield f"NOT PROVEN, {len(names)} comparisons: {shown}: {why}"
    if missing := without_flip():
        yield missing
    if absent := povray.missing():
        yield f"no picture was compared with POV-Ray's: {absent}"
    for result in cases if plan.scenes else ():
        for oracle in result.case.oracles:
            if oracle not in result.results and oracle not in result.unproven:
                why = why_not(oracle, result.case) or povray.DARK  # nothing else is found out later
                yield f"{result.case.name}: {oracle} cannot express it: {why}"
    for result in cases if plan.scenes else ():
        own, mitsubas = own_file(result.case.name), [o for o in result.results if o.startswith("mitsuba")]
        if own is not None and own.suffix not in TABLES and mitsubas:
            why = f"only clrt reads {own.suffix}"
            yield f"{result.case.name}: Mitsuba's side got what clrt had read of it: {why}"
    for result in cases if plan.program else ():
        assert plan.program is not None
        if PROGRAM + plan.program.name not in {*result.results, *result.unproven}:
            why = plan.program.unable(scene_of(result.case), own_file(result.case.name))
            yield f"{result.case.name}: {plan.program.scene_suffix} has no words for it: {why}"
    if plan.cases or plan.scenes:
        yield f"only the {'scenes' if plan.scenes else 'cases'} asked for; no ray counts"
    elif plan.least:
        yield "least: no more cases than show every feature; the rest is left to a run without it"
    elif plan.quick:
        yield "quick: Mitsuba on a selection of the cases; stock plugins, scenes that ship left to --full"
    if plan.spd is None and not (plan.cases or plan.scenes):
        yield "published ray counts were not compared: --spd FOLDER"
    if not plan.mutants and not plan.scenes:
        yield "no mutants: --mutants"


def versions() -> dict[str, str]:
    """Of everything that a figure may depend on."""
    found = {"clrt": __version__, "python": platform.python_version()}
    for package in _PACKAGES:
        try:
            found[package] = version(package)
        except PackageNotFoundError:
            found[package] = "not installed"
    return found | {"povray": povray.version()}


def completed(jobs: Jobs, processes: int,
               progress: Progress | None) -> Iterator[tuple[str, Any]]:  # fmt: skip
    """Names and results of jobs (function, arguments), as they are done.

    Where a process dies, the jobs that may have ended it run once more, each alone: a faulty kernel may have
    harmed one that came after it. ClrtError names a job that dies again.
    """
    left = dict(jobs)

    def taken(name: str, result: Any) -> tuple[str, Any]:
        del left[name]
        if progress:
            progress(len(jobs) - len(left), len(jobs), name)
        return name, result

    while left:
        try:
            for name, result in _parallel(left, processes):
                yield taken(name, result)
        except BrokenProcessPool:
            for name in list(left)[:processes]:  # jobs start in order, so these were running
                try:
                    ((_, result),) = _parallel({name: left[name]}, 1)
                except BrokenProcessPool:
                    raise ClrtError(f"validation: {name}: ended the process that ran it, twice") from None
                yield taken(name, result)


def _parallel(jobs: Jobs, processes: int) -> Iterator[tuple[str, Any]]:
    # the initializer makes this package known under its own name, also in a checkout
    pool = ProcessPoolExecutor(processes, get_context("spawn"), validation_module, ("suite.worker",))
    before, whole = set(active_children()), False
    try:
        with _deaf():
            waiting: dict[Future[Any], str] = {pool.submit(*job): name for name, job in jobs.items()}
        for future in as_completed(waiting):
            yield waiting[future], future.result()
        whole = True
    finally:
        if not whole:  # nobody wants what they are at; else it would be waited for
            for process in set(active_children()) - before:
                process.kill()
        pool.shutdown(cancel_futures=True)


@contextmanager
def _deaf() -> Iterator[None]:
    """Processes that are started within never hear Ctrl-C: theirs to answer is who started them.

    They would print where they were interrupted. Here it is heard once the block ends, by whichever thread.
    """
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        with interrupts.holding():
            yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)
