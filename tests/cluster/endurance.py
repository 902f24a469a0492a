"""The long run, `python -m tests.cluster.endurance`: pictures while workers are killed and paused.

Prints a line for each picture and, at the end, JSON. It fails where a picture differs, or was rendered twice
by more than what was lost.
"""

from __future__ import annotations

import argparse
import json
import os
import random
import signal
import threading
import time
from collections.abc import Callable
from contextlib import suppress
from typing import Any

import clrt
from clrt.cluster import pictures
from clrt.cluster.connect import connected
from clrt.cluster.farm import Report
from clrt.engine.request import Request


def pids(executor: Any) -> list[int]:
    """The processes of a dask executor's workers."""
    while True:
        try:
            return [*executor._client.run(os.getpid).values()]
        except OSError:  # one that is paused still: dask gives it up soon
            time.sleep(1)


def disturbed(
    executor: Any,
    settings: clrt.Settings,
    scene: clrt.Scene,
    after: int,
    what: Callable[[int], None],
    **size: Any,
) -> tuple[clrt.Image, Report]:
    """A picture, and its report; once so many pieces are there, `what` is done to one of the workers."""
    victim = random.choice(pids(executor))
    seen: list[int] = []

    def progress(done: int, total: int, rays: int) -> None:
        seen.append(done)
        if len(seen) == after:
            what(victim)

    remote = pictures.Remote(executor, None, settings)
    sheet = pictures.Sheet(*remote.plan(scene, Request(**size)), progress)
    (done,) = remote.sheets(iter([sheet]), 1)
    return done.image(), remote.farm.report


def kill(pid: int) -> None:
    """End a process at once."""
    os.kill(pid, signal.SIGKILL)


def pause(pid: int, seconds: float = 25.0) -> None:
    """Stop a process; it may go on after longer than a scheduler waits for it."""
    os.kill(pid, signal.SIGSTOP)

    def resume() -> None:
        with suppress(ProcessLookupError):  # it was given up
            os.kill(pid, signal.SIGCONT)

    timer = threading.Timer(seconds, resume)
    timer.daemon = True
    timer.start()


def settle(executor: Any, workers: int) -> None:
    """Wait until all workers are there; for one that dask does not start again, a new one is."""
    import distributed

    try:
        executor._client.wait_for_workers(workers, timeout=30)
    except distributed.TimeoutError:
        executor._client.cluster.scale(workers + 1)
        executor._client.wait_for_workers(workers, timeout=60)


def main() -> None:
    """Kill, pause, compare."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--kills", type=int, default=50)
    parser.add_argument("--pauses", type=int, default=20)
    parser.add_argument("--scene", default="showcase")
    options = parser.parse_args()
    scene, size = clrt.load(options.scene), {"width": 320, "height": 180, "spp": 4}
    right = clrt.render(scene, **size)
    told: list[dict[str, Any]] = []
    with connected(f"local:{options.workers}", clrt.Settings()) as (executor, settings):
        for number in range(options.kills + options.pauses):
            what = kill if number < options.kills else pause
            settle(executor, options.workers)
            start = time.monotonic()
            after = random.randrange(1, 7)
            image, report = disturbed(executor, settings, scene, after, what, **size)
            row = {
                "what": what.__name__, "after": after, "seconds": round(time.monotonic() - start, 2),
                "same": image.hash == right.hash and image.stats["rays"] == right.stats["rays"],
                "answers": report.answers, "lost": report.lost, "sent": report.sent,
            }  # fmt: skip
            print(number, row, flush=True)
            told.append(row)
            assert row["same"]
    print(json.dumps(told))


if __name__ == "__main__":
    main()
