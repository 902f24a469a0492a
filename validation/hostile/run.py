"""Hostile inputs in processes that are watched: `python -m clrt_validation.hostile.run --count 100000`.

An input has failed where its process dies of a signal, does not answer, raises anything but a `ClrtError`,
gives a pixel that is not finite, takes longer than SECONDS of processor time, or brings its process above
MEMORY bytes. Failed inputs are written to a folder, whole, with what happened.
"""

from __future__ import annotations

import argparse
import json
import os
import select
import subprocess
import sys
import threading
import time
from collections import Counter
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import IO, Any, Final

from clrt.resources import PACKAGE

from .mutate import make

SECONDS: Final = 2.0  # of processor time, an input
MEMORY: Final = 512 << 20  # bytes at the peak, a process
PATIENCE: Final = 120.0  # seconds of wall time after which a process counts as hanging
TURNS: Final = 200  # inputs a process; then a new one, so that no leak hides what an input costs
CORPUS: Final = Path(__file__).with_name("corpus")
_BOOT: Final = "from clrt.resources import validation_module as find; find('hostile.worker').main({!r})"


@dataclass
class Outcome:
    """Of all inputs: how many ended how, the worst of each cost, and those that failed."""

    counts: Counter[str] = field(default_factory=Counter)
    slowest: float = 0.0
    largest: int = 0
    seconds: float = 0.0
    failures: list[dict[str, Any]] = field(default_factory=list)

    def add(self, answer: dict[str, Any]) -> None:
        status = answer["status"]
        self.slowest = max(self.slowest, answer.get("cpu", 0.0))
        self.largest = max(self.largest, answer.get("peak", 0))
        if status in ("rendered", "refused"):
            if answer["cpu"] > SECONDS:
                status = "slow"
            elif answer["peak"] > MEMORY:
                status = "large"
        self.counts[status] += 1
        if status not in ("rendered", "refused"):
            self.failures.append({**answer, "status": status})


class Watched:
    """A worker process; a new one after TURNS inputs, and after one that died or hung."""

    def __init__(self, device: str | None) -> None:
        self._device = device
        self._process: subprocess.Popen[bytes] | None = None
        self._left = 0

    def ask(self, task: dict[str, Any]) -> dict[str, Any]:
        """What the process answers to a task, or {"status": "died" | "hangs", ...}."""
        process = self._ready()
        try:
            _in(process).write(json.dumps(task).encode() + b"\n")
            _in(process).flush()
            answer = _answer(process, PATIENCE)
        except BrokenPipeError:
            answer = b""
        self._left -= 1
        if answer:
            return dict(json.loads(answer))
        self.close()
        code = process.returncode
        if answer is None:
            return {**task, "status": "hangs", "text": f"no answer in {PATIENCE:g} s"}
        return {**task, "status": "died", "text": f"exit code {code}"}

    def close(self) -> None:
        if self._process:
            self._process.kill()
            self._process.communicate()
        self._process = None

    def _ready(self) -> subprocess.Popen[bytes]:
        if self._process and self._left > 0:
            return self._process
        self.close()
        environment = {**os.environ, "PYTHONPATH": os.pathsep.join([str(PACKAGE.parent), *sys.path])}
        command = [sys.executable, "-P", "-c", _BOOT.format(self._device)]
        self._process = subprocess.Popen(
            command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, env=environment
        )
        if not _answer(self._process, 300.0):
            self.close()
            raise RuntimeError(f"{' '.join(command)} does not start; run it to see why")
        self._left = TURNS
        return self._process


def _in(process: subprocess.Popen[bytes]) -> IO[bytes]:
    assert process.stdin
    return process.stdin


def _answer(process: subprocess.Popen[bytes], patience: float) -> bytes | None:
    """The process' next line, b"" when it has ended, None when it does not come."""
    assert process.stdout
    if not select.select([process.stdout], [], [], patience)[0]:
        return None
    return process.stdout.readline()


def drawn(seed: int, count: int, start: int = 0) -> Iterator[dict[str, Any]]:
    """The tasks of `count` inputs that a seed draws."""
    for index in range(start, start + count):
        yield {"seed": seed, "index": index}


def corpus(folder: Path = CORPUS) -> Iterator[dict[str, Any]]:
    """The tasks of the files that are kept; a file `part_...` belongs to another one."""
    for path in sorted(folder.iterdir()):
        if path.is_file() and not path.name.startswith("part_") and path.suffix != ".md":
            yield {"folder": str(folder), "scene": path.name}


def run(
    tasks: Iterable[dict[str, Any]],
    device: str | None = None,
    workers: int = 2,
    progress: Callable[[Outcome], None] | None = None,
) -> Outcome:
    """Try all tasks on `workers` processes side by side."""
    outcome, waiting, lock = Outcome(), iter(tasks), threading.Lock()
    start = time.perf_counter()
    broken: list[BaseException] = []

    def work() -> None:
        worker = Watched(device)
        try:
            while not broken:
                with lock:
                    task = next(waiting, None)
                if task is None:
                    return
                answer = worker.ask(task)
                with lock:
                    outcome.add(answer)
                    if progress:
                        progress(outcome)
        except BaseException as error:
            broken.append(error)
        finally:
            worker.close()

    threads = [threading.Thread(target=work, daemon=True) for _ in range(workers)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    if broken:
        raise broken[0]
    outcome.seconds = time.perf_counter() - start
    return outcome


def keep(failures: Iterable[dict[str, Any]], folder: Path) -> None:
    """Write the inputs that failed, each in a folder of its own, with what happened."""
    for number, failure in enumerate(failures):
        place = folder / f"{number:04}_{failure['status'].replace(' ', '_')}"
        place.mkdir(parents=True, exist_ok=True)
        (place / "what.json").write_text(json.dumps(failure, indent=1))
        if "seed" in failure:
            for name, data in make(failure["seed"], failure["index"]).files.items():
                (place / name).write_bytes(data)


def main() -> int:
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--count", type=int, default=2000, metavar="N")
    parser.add_argument("--seed", type=int, default=1, metavar="S")
    parser.add_argument("--device", metavar="D")
    parser.add_argument("--workers", type=int, default=os.cpu_count() or 1, metavar="N")
    parser.add_argument("--out", type=Path, default=Path("out/hostile"), metavar="FOLDER")
    options = parser.parse_args()
    columns = (BarColumn(), MofNCompleteColumn(), TimeRemainingColumn(), TextColumn("{task.description}"))
    with Progress(*columns) as bar:
        row = bar.add_task("", total=options.count)

        def tell(outcome: Outcome) -> None:
            said = ", ".join(f"{count} {status}" for status, count in sorted(outcome.counts.items()))
            bar.update(row, completed=outcome.counts.total(), description=said)

        tasks = [*corpus(), *drawn(options.seed, options.count)]
        bar.update(row, total=len(tasks))
        outcome = run(tasks, options.device, options.workers, tell)
    keep(outcome.failures, options.out)
    print(f"{dict(outcome.counts)}; slowest {outcome.slowest:.2f} s of processor time, "
          f"peak {outcome.largest >> 20} MiB, {outcome.seconds:.0f} s")  # fmt: skip
    if outcome.failures:
        print(f"failures are in {options.out}")
    return bool(outcome.failures)


if __name__ == "__main__":
    sys.exit(main())
