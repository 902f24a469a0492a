"""A progress bar on stderr with rays per second and the time left; silent where stderr is not a terminal.

While the driver compiles, or another process does, it says so in place of the rate.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from clrt.cli.terminal import console, marked

Report = Callable[[int, int, int], None]


@contextmanager
def progress(name: str, quiet: bool) -> Iterator[Report | None]:
    """Give a function to call with (done pixels, all pixels, rays so far), or None for silence."""
    if quiet or not sys.stderr.isatty():
        yield None
        return
    from rich.progress import BarColumn, Progress, TaskProgressColumn, TextColumn, TimeRemainingColumn

    from clrt.device import cachelock

    columns = (
        TextColumn("{task.description}"),
        BarColumn(),
        TaskProgressColumn(),
        TextColumn("{task.fields[doing]}"),
        TimeRemainingColumn(),
    )
    with Progress(*columns, console=console(stderr=True), transient=True) as bar:
        task = bar.add_task(marked(name), total=None, doing="")
        start = time.perf_counter()

        def report(done: int, total: int, rays: int) -> None:
            elapsed = max(time.perf_counter() - start, 1e-6)
            bar.update(task, completed=done, total=total, doing=f"{rays / elapsed / 1e6:6.2f} Mrays/s")

        def waits(what: str) -> None:
            bar.update(task, doing=what)
            bar.refresh()

        cachelock.watchers.append(waits)
        try:
            yield report
        finally:
            cachelock.watchers.remove(waits)
