"""The long run, `python -m tests.cluster.endurance [--out F.json]`: workers are killed and paused.

Each round renders a picture, a series of pictures, or runs some of validation's cases, in turns, while one
of the workers is killed (SIGKILL) or paused (SIGSTOP), of 1, of 2 and of 4 (`--workers`): one that has work,
at a time drawn from what such a round takes. Prints a line for each; fails where bits are not those of one
process, or where a worker that was left alone did more than its answers. `docs/make_cluster.py faults` keeps
what it found.
"""

from __future__ import annotations

import argparse
import faulthandler
import json
import os
import random
import signal
import statistics
import sys
import threading
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, nullcontext, suppress
from dataclasses import replace
from typing import Any

import clrt
from clrt.base.resources import validation_module
from clrt.cluster import connect, pictures
from clrt.cluster.calls import Told
from clrt.cluster.connect import connected
from clrt.cluster.farm import Report
from clrt.cluster.orders import Worker
from clrt.engine.campath import turntable
from clrt.engine.request import Request
from tests.farm_samples import Here
from validation.oracles import ORACLE64
from validation.reliability import kept

SIZE = {"width": 320, "height": 180, "spp": 4}
CASES = ("picture on a sphere", "picture and normals on a floor", "picture on a box and a cylinder")
MORE = (*CASES, "light behind", "shifted camera")  # more than there are workers, none of more than a second
KINDS = ("picture", "series", "validation")
TTL = "2 s"  # of silence; dask makes 5 of it, and looks each 2: what is waited for, of `connect` up to 20
STUCK = 300.0  # seconds of a round, after which the run says where it hangs, and ends
PAUSES = (1.0, 12.0)  # seconds, drawn: some workers go on before they are given up, most do not
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
    executor: Any,
    after: int,
    what: Callable[[int], None],
    victim: int,
    cases: tuple[str, ...] = CASES,
    only: str = "",
) -> tuple[list[Any], Told]:
    """What validation's cases find, by their oracles or that one, and who found it; once so many are done one
    worker is disturbed."""

    def progress(done: int, total: int, name: str) -> None:
        if done == after:
            what(victim)

    suite, told = validation_module("suite.run"), Told()
    tasks = suite.tasks_of(suite.Plan(cases=cases, pictures=True))
    tasks = [replace(task, oracles=(only,)) if only else task for task in tasks]
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


class Fault:
    """One worker killed or paused, a while after the beginning, once the scheduler says that it has work.

    victim: its process, 0 where all was done before. pieces: how many tasks it had.
    """

    def __init__(self, executor: Any, before: Counts, what: str, delay: float) -> None:
        self.client, self.before, self.what, self.delay = executor._client, before, what, delay
        self.victim, self.pieces, self.pause = 0, 0, 0.0
        self._over = threading.Event()

    @contextmanager
    def coming(self) -> Iterator[None]:
        """What is done here is disturbed; who is paused still at its end goes on."""
        thread = threading.Thread(target=self._strike)
        thread.start()
        try:
            yield
        finally:
            self._over.set()
            thread.join()
            if self.pause:
                with suppress(ProcessLookupError):  # it was given up
                    os.kill(self.victim, signal.SIGCONT)

    def _strike(self) -> None:
        self._over.wait(self.delay)
        while not self._over.is_set():
            busy = {name: len(keys) for name, keys in self.client.processing().items() if keys}
            if known := sorted(busy.keys() & self.before.keys()):
                address = random.choice(known)
                self.pieces, (self.victim, _) = busy[address], self.before[address]
                if self.what == "kill":
                    kill(self.victim)
                else:
                    self.pause = random.uniform(*PAUSES)
                    pause(self.victim, self.pause)
                return
            self._over.wait(0.01)


def proven(executor: Any) -> tuple[list[Any], Told]:
    """Some cases by the float64 oracle: Mitsuba takes each new worker five seconds to start."""
    return validated(executor, 99, kill, 0, MORE, ORACLE64)


def found(
    kind: str, executor: Any, settings: clrt.Settings, scenes: list[clrt.Scene]
) -> tuple[list[Any], Any]:
    """The bits of a round, and its report."""
    if kind == "validation":
        return proven(executor)
    images, report = series(
        executor, settings, scenes[: 1 if kind == "picture" else 4], 10**6, kill, 0, **SIZE
    )
    return [(image.hash, image.stats["rays"]) for image in images], report


def right(scenes: list[clrt.Scene]) -> dict[str, list[Any]]:
    """The bits of each kind of round, by this process alone."""
    images = [clrt.render(scene, **SIZE) for scene in scenes]
    told = [(image.hash, image.stats["rays"]) for image in images]
    return {"picture": told[:1], "series": told, "validation": proven(Here())[0]}


def rounds(
    workers: int, kills: int, pauses: int, scenes: list[clrt.Scene], wanted: dict[str, list[Any]]
) -> list[dict[str, Any]]:
    """What came of each round; the first ones are in peace, and one that ended too soon is repeated."""
    told: list[dict[str, Any]] = []
    with connected(f"local:{workers}", clrt.Settings(threads=1)) as (executor, settings):
        took = {kind: [] for kind in KINDS}

        def played(kind: str, what: str, part: float = 1.0) -> bool:
            """Add a row; whether it was disturbed, if asked for: in this part of what such rounds took."""
            faulthandler.dump_traceback_later(STUCK, exit=True)
            begun = time.monotonic()
            settle(executor, workers)
            pids(executor)
            before, start = orders(executor), time.monotonic()
            fault = Fault(
                executor, before, what, random.uniform(0, part * statistics.median(took[kind] or [0]))
            )
            with fault.coming() if what else nullcontext():
                bits, done = found(kind, executor, settings, scenes)
                seconds = time.monotonic() - start
            if what != "pause":
                took[kind].append(seconds)
            row = {"what": what, "kind": kind, "pieces": fault.pieces, "answers": done.answers}
            row |= {"lost": done.lost, "same": bits == wanted[kind]}
            row["twice"] = twice(executor, before, fault.victim, done.workers)
            times = {"ready": start - begun, "after": fault.delay, "pause": fault.pause, "seconds": seconds}
            told.append(row | {name: round(time, 2) for name, time in times.items()})
            faulthandler.cancel_dump_traceback_later()
            print(len(told), told[-1], flush=True)
            return bool(fault.victim) or not what

        for kind in KINDS:
            played(kind, "")
        for number in range(kills + pauses):
            what = "kill" if number < kills else "pause"
            any(played(KINDS[number % 3], what, 0.9 / 2**tried) for tried in range(5))
    return told


def wrong(rows: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Rounds with other bits, and those in which workers that were left alone did more than was answered.

    dask may ask for the victim's last answer again, as long as it does not know that the client has it. That
    has not been seen, and would be work done twice: it is not let through.
    """
    return [row for row in rows if not row["same"] or row["twice"]]


def main() -> None:
    """Kill, pause, compare."""
    parser = argparse.ArgumentParser()
    parser.add_argument(
        "--workers", type=int, nargs="+", default=[*kept.WORKERS], help="each of these counts"
    )
    parser.add_argument("--kills", type=int, default=kept.DISTURBED["kill"])
    parser.add_argument("--pauses", type=int, default=kept.DISTURBED["pause"])
    parser.add_argument("--scene", default="showcase")
    parser.add_argument(
        "--ttl", default=TTL, help="after which dask gives up a worker (default: %(default)s)"
    )
    parser.add_argument("--out", help="write all rounds as JSON")
    options = parser.parse_args()
    connect._CONFIG["distributed.scheduler.worker-ttl"] = options.ttl
    scene = clrt.load(options.scene)
    assert scene.camera is not None
    scenes = [scene.replace({"camera": camera}) for camera in turntable(scene.camera, 4)]
    wanted, runs, begun = right(scenes), [], time.monotonic()
    for workers in options.workers:
        stamp = kept.stamp(kept.FILES["cluster.json"])
        rows = rounds(workers, options.kills, options.pauses, scenes, wanted)
        runs.append({"workers": workers, "stamp": stamp, "rounds": rows})
        if options.out:
            with open(options.out, "w", encoding="utf-8") as file:
                json.dump({"runs": runs}, file)
        print(f"{workers} workers: {(time.monotonic() - begun) / 60:.1f} minutes so far", flush=True)
    bad = [row for run in runs for row in wrong(run["rounds"])]
    if bad:
        sys.exit(f"{len(bad)} rounds are wrong: {bad}")


if __name__ == "__main__":
    main()
