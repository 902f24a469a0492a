"""The suite on an executor's workers: each of its jobs is a pure task, with the files that it reads."""

from __future__ import annotations

import dataclasses
import os
import warnings
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

from clrt.base.errors import ClrtWarning
from clrt.base.inputs import noted, watched
from clrt.base.resources import shipped_scenes
from clrt.cluster.calls import Call, Told, answers
from clrt.cluster.pool import pool_of
from clrt.flatten.flatten import flatten

from ..cases import case_named, loaded, name_of_own, own_file
from ..types import CaseResult
from .worker import Task, count_published, run_case

Progress = Callable[[int, int, str], None]


def completed_by(
    executor: object,
    jobs: dict[str, tuple[Any, ...]],
    device: int | str | None,
    progress: Progress | None,
    told: Told,
) -> Iterator[tuple[str, Any]]:
    """Names and results of jobs (function, arguments), as workers have done them."""
    calls = {name: call_of(job, device) for name, job in jobs.items()}
    for name, result in answers(pool_of(executor), calls, told):
        if progress:
            progress(told.answers, len(jobs), name)
        if isinstance(result, CaseResult):  # its files may have lain elsewhere there
            result = dataclasses.replace(result, case=case_named(jobs[name][1].name))
        yield name, result


def call_of(job: tuple[Any, ...], device: int | str | None) -> Call:
    """A job as workers are told of it."""
    function, *arguments = job
    module = function.__module__.partition(".")[2]
    if function is run_case:
        (task,) = arguments
        file = own_file(task.name)
        if file is not None:
            shipped = {path.resolve(): name for name, path in shipped_scenes().items()}
            if file in shipped:  # a worker has its own
                return Call(__name__.partition(".")[2], "run_shipped", (shipped[file], task), device)
            return Call(__name__.partition(".")[2], "run_own", (file, task), device, files_of(file))
    if function is count_published:
        name, folder, wanted = arguments
        folder = Path(os.path.abspath(folder))
        nff = folder / f"{name}.nff"
        return Call(module, "count_published", (name, folder, wanted), device, {str(nff): nff.read_bytes()})
    return Call(module, function.__name__, tuple(arguments), device)


def files_of(scene: dict[str, Any] | Path) -> dict[str, bytes]:
    """All that a scene reads, its own file too, by absolute path; not what loaders write for a moment (a
    mesh's colours, as a picture).
    """
    with watched(), warnings.catch_warnings():
        warnings.simplefilter("ignore", ClrtWarning)  # who renders it is told
        flatten(loaded(scene))
        names = {os.path.abspath(name) for name in noted().values()}
    return {name: Path(name).read_bytes() for name in sorted(names) if os.path.isfile(name)}


def run_own(file: Path, task: Task) -> CaseResult:
    """A case of somebody's own scene, which is in this file here."""
    return run_case(dataclasses.replace(task, name=name_of_own(file)))


def run_shipped(name: str, task: Task) -> CaseResult:
    """A case of a scene that ships, of this installation."""
    return run_own(shipped_scenes()[name], task)
