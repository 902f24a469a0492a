"""Hostile inputs in processes that are watched: `python -m clrt_validation.hostile.run --count 100000`.

An input has failed where its process dies of a signal, does not answer, raises anything but a `ClrtError`,
gives a pixel that is not finite, or costs more than `gates` allow. The first try counts; nothing is repeated.
Among the inputs are command lines (`commands`). What failed is written to a folder, with what happened.
"""

from __future__ import annotations

import argparse
import datetime
import json
import os
import select
import shutil
import subprocess
import sys
import tempfile
import threading
import time
from collections import Counter
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import IO, Any, Final

from clrt.base.resources import PACKAGE

from . import commands, gates, process
from .mutate import make

PATIENCE: Final = 600.0  # seconds of wall time, then a process hangs; kernels of many bands take minutes
CEILING: Final = 9 << 30  # bytes at which a process is ended: more than any scene takes that `Limits` allow
TURNS: Final = 1000  # inputs a process; then a new one, so that no leak hides what an input costs
COMMANDS: Final = 200  # of so many tasks one is a command, which costs as much as many inputs
CORPUS: Final = Path(__file__).with_name("corpus")
FOUND: Final = Path("out/hostile")
_BOOT: Final = (
    "from clrt.base.resources import validation_module as find; find('hostile.worker').main({!r}, {!r})"
)
_LOOK: Final = 0.05  # seconds between looks at a process' memory


@dataclass
class Outcome:
    """Of all tasks: how many ended how, the worst of each cost, and those that failed."""

    counts: Counter[str] = field(default_factory=Counter)
    worst: gates.Worst = field(default_factory=gates.Worst)
    seconds: float = 0.0
    failures: list[dict[str, Any]] = field(default_factory=list)

    def add(self, answer: dict[str, Any]) -> None:
        self.worst.note(answer)
        status = gates.judged(answer)
        self.counts[status] += 1
        if status not in gates.GOOD:
            self.failures.append({**answer, "status": status})

    def told(self) -> str:
        """The counts and the worst costs in words."""
        how = ", ".join(f"{number:,} {status}" for status, number in sorted(self.counts.items()))
        return f"{how}; {self.worst.told()}; no task was repeated"


class Watched:
    """A worker process; a new one after TURNS inputs, and after one that died or hung."""

    def __init__(self, device: str | None) -> None:
        self._device = device
        self._process: subprocess.Popen[bytes] | None = None
        self._left = 0
        self._folder: tempfile.TemporaryDirectory[str] | None = None  # one that is killed leaves its own

    def ask(self, task: dict[str, Any]) -> dict[str, Any]:
        """What the process answers to a task, or {"status": "died" | "hangs", ...}."""
        process = self._ready()
        try:
            _in(process).write(json.dumps(task).encode() + b"\n")
            _in(process).flush()
            answer, grown = _answer(process, PATIENCE)
        except BrokenPipeError:
            answer, grown = b"", 0
        self._left -= 1
        if answer:
            return dict(json.loads(answer))
        self.close()
        code = process.returncode
        if grown > CEILING:
            return {**task, "status": "large", "text": f"ended at {grown >> 20} MiB"}
        if answer is None:
            return {**task, "status": "hangs", "text": f"no answer in {PATIENCE:g} s"}
        return {**task, "status": "died", "text": f"exit code {code}"}

    def close(self) -> None:
        if self._process:
            self._process.kill()
            self._process.communicate()
        if self._folder:
            self._folder.cleanup()
        self._process = self._folder = None

    def _ready(self) -> subprocess.Popen[bytes]:
        if self._process and self._left > 0:
            return self._process
        self.close()
        environment = {**os.environ, "PYTHONPATH": os.pathsep.join([str(PACKAGE.parent), *sys.path])}
        self._folder = tempfile.TemporaryDirectory(prefix="clrt-hostile-", ignore_cleanup_errors=True)
        command = [sys.executable, "-P", "-c", _BOOT.format(self._device, self._folder.name)]
        self._process = subprocess.Popen(
            command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, env=environment
        )
        if not _answer(self._process, 300.0)[0]:
            self.close()
            raise RuntimeError(f"{' '.join(command)} does not start; run it to see why")
        self._left = TURNS
        return self._process


def _attempt(task: dict[str, Any]) -> dict[str, Any]:
    """What a command did; one that cannot be tried here is a failure, and not the end of a run of hours."""
    try:
        return process.attempt(task)
    except (OSError, ValueError) as error:
        return {**task, "status": "not tried", "text": f"{type(error).__name__}: {error}"[:2000]}


def _in(process: subprocess.Popen[bytes]) -> IO[bytes]:
    assert process.stdin
    return process.stdin


def _answer(process: subprocess.Popen[bytes], patience: float) -> tuple[bytes | None, int]:
    """The process' next line, b"" when it has ended, None when it does not come or the process has grown too
    large; and how many bytes it held when it was last looked at.
    """
    assert process.stdout
    end, grown = time.monotonic() + patience, 0
    while time.monotonic() < end and grown <= CEILING:
        if select.select([process.stdout], [], [], _LOOK)[0]:
            return process.stdout.readline(), 0
        grown = held(process.pid)
    return None, grown


def held(pid: int) -> int:
    """Bytes of memory that a process holds; 0 where it has ended or the system does not say."""
    try:
        return int(Path(f"/proc/{pid}/statm").read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE")
    except (OSError, IndexError, ValueError):
        return 0


def drawn(seed: int, count: int, start: int = 0) -> Iterator[dict[str, Any]]:
    """The tasks of `count` inputs that a seed draws; every COMMANDS-th is a command."""
    for index in range(start, start + count):
        yield {
            "seed": seed,
            "index": index,
            **({"command": True} if index % COMMANDS == COMMANDS - 1 else {}),
        }


def today() -> int:
    """A seed that changes every day."""
    return datetime.datetime.now(datetime.UTC).date().toordinal()


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
                answer = _attempt(task) if "command" in task else worker.ask(task)
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
    """Write inputs that failed, with what happened, each in a folder named by seed and index, or by file."""
    for failure in failures:
        name = f"{failure['seed']}_{failure['index']}" if "seed" in failure else failure["scene"]
        place = folder / f"{name}_{failure['status'].replace(' ', '_')}"
        shutil.rmtree(place, ignore_errors=True)  # of an earlier run
        place.mkdir(parents=True)
        (place / "what.json").write_text(json.dumps(failure, indent=1))
        if "command" in failure:
            commands.make(failure["seed"], failure["index"]).prepare(place / "run")
        elif "seed" in failure:
            for name, data in make(failure["seed"], failure["index"]).files.items():
                (place / name).write_bytes(data)


def main() -> int:
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--count", type=int, default=2000, metavar="N")
    parser.add_argument("--seed", type=int, default=today(), metavar="S", help="by default the date's")
    parser.add_argument("--start", type=int, default=0, metavar="I", help="the first index")
    parser.add_argument("--only", choices=("inputs", "commands"), help="by default both")
    parser.add_argument("--device", metavar="D")
    parser.add_argument("--workers", type=int, default=os.cpu_count() or 1, metavar="N")
    parser.add_argument("--out", type=Path, default=FOUND, metavar="FOLDER")
    options = parser.parse_args()
    columns = (BarColumn(), MofNCompleteColumn(), TimeRemainingColumn(), TextColumn("{task.description}"))
    with Progress(*columns) as bar:
        row = bar.add_task("", total=options.count)
        kept: list[dict[str, Any]] = []

        def tell(outcome: Outcome) -> None:
            said = ", ".join(f"{count} {status}" for status, count in sorted(outcome.counts.items()))
            bar.update(row, completed=outcome.counts.total(), description=said)
            keep(outcome.failures[len(kept) :], options.out)
            kept.extend(outcome.failures[len(kept) :])

        tasks = [*corpus(), *drawn(options.seed, options.count, options.start)]
        if options.only:
            tasks = [task for task in tasks if ("command" in task) == (options.only == "commands")]
        bar.update(row, total=len(tasks))
        outcome = run(tasks, options.device, options.workers, tell)
    print(f"seed {options.seed}: {outcome.told()}; {outcome.seconds:.0f} s")
    if outcome.failures:
        print(f"failures are in {options.out}")
    return bool(outcome.failures)


if __name__ == "__main__":
    sys.exit(main())
