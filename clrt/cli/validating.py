"""What `clrt validate` shows while it runs and leaves, whoever is under test."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from clrt.base.resources import validation_module
from clrt.cli.terminal import console, marked


def say_json(result: Any) -> None:
    """Print what stands beside a report as JSON."""
    print(json.dumps(validation_module("suite.files").plain(result), indent=1, allow_nan=False))


def write(result: Any, report: Path, quiet: bool = False) -> None:
    """Write a report and what stands beside it, and say where."""
    page = validation_module("suite.report").write_report(result, report)
    xml, data = validation_module("suite.files").write_beside(result, report)
    if not quiet:
        print(f"report: {page}\nfor other programs: {xml.name} (JUnit), {data.name}")


@contextmanager
def progress_bar() -> Iterator[Callable[[int, int, str], None] | None]:
    """A bar on stderr, or a line every tenth where that is not a terminal."""
    if not sys.stderr.isatty():
        yield _report_tenths
        return
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn
    from rich.progress import TimeRemainingColumn as Remaining

    columns = (BarColumn(), MofNCompleteColumn(), TimeElapsedColumn(), Remaining(),
               TextColumn("{task.description}"))
    with Progress(*columns, console=console(stderr=True), transient=True) as bar:
        task = bar.add_task("starting", total=None)

        def report(done: int, total: int, name: str) -> None:
            bar.update(task, completed=done, total=total, description=marked(name))

        yield report


def _report_tenths(done: int, total: int, name: str) -> None:
    if done * 10 // total != (done - 1) * 10 // total:
        print(f"{done} of {total}: {name}", file=sys.stderr, flush=True)
