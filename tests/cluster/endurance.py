"""The long run, `python -m tests.cluster.endurance [--out F.json]`: workers are killed and paused.

Each round renders a picture, a series of pictures, or runs some of validation's cases, in turns, while one
of the workers is killed (SIGKILL) or paused (SIGSTOP), of 1, of 2 and of 4 (`--workers`). Prints a line for
each; fails where bits differ. `docs/make_cluster.py faults` keeps what it found.
"""

from __future__ import annotations

import argparse
import json
import os
import random
import signal
import threading
import time
from collections.abc import Callable, Mapping
from contextlib import suppress
from typing import Any

import clrt
from clrt.base.resources import validation_module
from clrt.cluster import pictures
from clrt.cluster.calls import Told
from clrt.cluster.connect import connected
from clrt.cluster.farm import Report
from clrt.cluster.orders import Worker
from clrt.engine.campath import turntable
from clrt.engine.request import Request
from validation.reliability import kept

SIZE = {"width": 320, "height": 180, "spp": 4}
CASES = ("picture on a sphere", "picture and normals on a floor", "picture on a box and a cylinder")
Counts = dict[str, tuple[int, int]]  # by address: process, and orders that it has done


def pids(executor: Any) -> list[int]:
    """The processes of a dask executor's workers."""
    while True:
        try:
            return [*executor._client.run(os.getpid).values()]
        except OSError:  # one that is paused still: dask gives it up soon
            time.sleep(1)


def _orders() -> tuple[int, int]:
    """Asked of a worker."""
    import os

    from clrt.cluster import worker

    return os.getpid(), worker._bench().orders


def orders(executor: Any, of: list[str] | None = None) -> Counts:
    """What workers say, all or those at some addresses."""
    found: Counts = executor._client.run(_orders, workers=of)
    return found


def disturbed(
    executor: Any,
    settings: clrt.Settings,
    scene: clrt.Scene,
    after: int,
    what: Callable[[int], None],
    victim: int | None = None,
    **size: Any,
) -> tuple[clrt.Image, Report]:
    """A picture, and its report; once so many pieces are there, `what` is done to one of the workers."""
    (image,), report = series(executor, settings, [scene], after, what, victim, **size)
    return image, report


def series(
    executor: Any,
    settings: clrt.Settings,
    scenes: list[clrt.Scene],
    after: int,
    what: Callable[[int], None],
    victim: int | None = None,
    **size: Any,
) -> tuple[list[clrt.Image], Report]:
    """As `disturbed`, several pictures."""
    process = random.choice(pids(executor)) if victim is None else victim
    seen: list[int] = []

    def progress(done: int, total: int, rays: int) -> None:
        seen.append(done)
        if len(seen) == after:
            what(process)

    remote = pictures.Remote(executor, None, settings)
    sheets = (pictures.Sheet(*remote.plan(scene, Request(**size)), progress) for scene in scenes)
    images = [sheet.image() for sheet in remote.sheets(sheets, len(scenes))]
    return images, remote.farm.report


def validated(
    executor: Any, after: int, what: Callable[[int], None], victim: int, cases: tuple[str, ...] = CASES
) -> tuple[list[Any], Told]:
    """What validation's cases find, by the float64 oracle, and who found it; once so many are done one worker
    is disturbed."""

    def progress(done: int, total: int, name: str) -> None:
        if done == after:
            what(victim)

    suite, told = validation_module("suite.run"), Told()
    tasks = suite.tasks_of(suite.Plan(cases=cases, pictures=True))
    jobs = {task.name: (suite.run_case, task) for task in tasks}
    done = dict(validation_module("suite.shared").completed_by(executor, jobs, None, progress, told))
    rows = [
        (name, oracle, found.metrics, done[name].ours.pixels.tobytes())
        for name in jobs
        for oracle, (_, found) in done[name].results.items()
    ]
    rows += [(name, done[name].unproven) for name in jobs]
    return rows, told


def twice(executor: Any, before: Counts, victim: int, answers: Mapping[Worker, int]) -> int | None:
    """Orders that workers left alone have done beyond their answers that came; None where there are none."""
    others = [address for address, (process, _) in before.items() if process != victim]
    if not others:
        return None
    done = orders(executor, others)
    sure = sum(done[address][1] - before[address][1] for address in others)
    return sure - sum(count for worker, count in answers.items() if worker.address in others)


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
    """Wait until all workers are there: one that ends is started again, however often."""
    executor._client.wait_for_workers(workers, timeout=60)


def rounds(workers: int, kills: int, pauses: int, name: str) -> list[dict[str, Any]]:
    """What came of each round."""
    scene = clrt.load(name)
    assert scene.camera is not None
    scenes = [scene.replace({"camera": camera}) for camera in turntable(scene.camera, 4)]
    right = [clrt.render(one, **SIZE) for one in scenes]
    told: list[dict[str, Any]] = []
    with connected(f"local:{workers}", clrt.Settings(threads=1)) as (executor, settings):
        proven, _ = validated(executor, 99, kill, 0)
        for number in range(kills + pauses):
            settle(executor, workers)
            pids(executor)
            before = orders(executor)
            victim = random.choice([process for process, _ in before.values()])
            what = kill if number < kills else pause
            kind, start = ("picture", "series", "validation")[number % 3], time.monotonic()
            row: dict[str, Any] = {"what": what.__name__, "kind": kind}
            hit: list[int] = []

            def disturb(process: int, what: Callable[[int], None] = what, hit: list[int] = hit) -> None:
                hit.append(process)
                what(process)

            if kind == "validation":
                found, done = validated(executor, 1, disturb, victim)
                same = found == proven
                other = [pair for pair in zip(found, proven, strict=False) if pair[0] != pair[1]]
                for here, there in other:  # without the pixels
                    print("differs:", here[:3], there[:3], "pixels", here[3:] == there[3:])
            else:
                some = scenes[: 1 if kind == "picture" else 4]
                row["after"] = random.randrange(1, min(9, 4 * workers))  # a picture has four pieces a worker
                images, done = series(executor, settings, some, row["after"], disturb, victim, **SIZE)
                same = all(
                    (image.hash, image.stats["rays"]) == (wanted.hash, wanted.stats["rays"])
                    for image, wanted in zip(images, right[: len(some)], strict=True)
                )
            row |= {"answers": done.answers, "lost": done.lost}
            row["twice"] = twice(executor, before, victim, done.workers)
            told.append(row | {"same": same, "seconds": round(time.monotonic() - start, 2)})
            print(number, told[-1], flush=True)
            assert same and hit == [victim]
    return told


def main() -> None:
    """Kill, pause, compare."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--workers", type=int, nargs="+", default=[1, 2, 4], help="each of these counts")
    parser.add_argument("--kills", type=int, default=50)
    parser.add_argument("--pauses", type=int, default=20)
    parser.add_argument("--scene", default="showcase")
    parser.add_argument("--out", help="write all rounds as JSON")
    options = parser.parse_args()
    runs: list[dict[str, Any]] = []
    for workers in options.workers:
        stamp = kept.stamp(kept.FILES["cluster.json"])
        found = rounds(workers, options.kills, options.pauses, options.scene)
        runs.append({"workers": workers, "stamp": stamp, "rounds": found})
        if options.out:
            with open(options.out, "w", encoding="utf-8") as file:
                json.dump({"runs": runs}, file)


if __name__ == "__main__":
    main()
