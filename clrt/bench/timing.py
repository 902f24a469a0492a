"""How times are taken: warm-up, then rounds in which every case has its turn: a drift meets all alike.

A time is processor time of this process where the device is a processor (what other programs do then hardly
counts), else wall time. What is kept are the times of all rounds; the median stands for them, half the
distance between the quartiles for how far they scatter.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from statistics import median, quantiles
from typing import Any, Final

SHORTEST: Final = 4e-3  # seconds; what is faster is repeated within a measurement
CLOCKS: Final = {"cpu": time.process_time, "wall": time.perf_counter}
Tell = Callable[[str], None]


@dataclass(frozen=True, kw_only=True)
class Case:
    """Something to time: `run` does all `items` once and waits; `reset`, not timed, readies the next run.

    Where only a part of `run` counts, it returns the seconds of that part, and the clock is not asked.
    """

    group: str
    name: str
    run: Callable[[], float | None]
    scene: str = ""
    queue: str = ""
    threads: int = 1
    items: int = 1
    unit: str = ""
    clock: str = "cpu"
    reset: Callable[[], Any] | None = None
    nbytes: float = 0.0  # compulsory traffic of a run; 0: not known
    flops: float = 0.0  # floating-point operations of a run; 0: not known

    @property
    def key(self) -> tuple[str, str, str, str, int]:
        return (self.group, self.scene, self.name, self.queue, self.threads)


@dataclass(frozen=True, kw_only=True)
class Measurement:
    """The times of a case, seconds for all its items, one a round. As it stands in the JSON."""

    group: str
    scene: str
    name: str
    queue: str
    threads: int
    items: int
    unit: str
    clock: str
    nbytes: float
    flops: float
    seconds: tuple[float, ...]
    extra: dict[str, Any]

    @property
    def key(self) -> tuple[str, str, str, str, int]:
        return (self.group, self.scene, self.name, self.queue, self.threads)

    @property
    def median(self) -> float:
        return median(self.seconds)

    @property
    def spread(self) -> float:
        """Half the distance between the quartiles, as a share of the median."""
        if len(self.seconds) < 2:
            return math.nan
        low, _, high = quantiles(self.seconds, n=4, method="inclusive")
        return (high - low) / 2 / self.median

    @property
    def ns(self) -> float:
        """Nanoseconds an item."""
        return self.median / max(self.items, 1) * 1e9

    def to_dict(self) -> dict[str, Any]:
        return asdict(self)


def measure(cases: Sequence[Case], rounds: int, tell: Tell | None = None) -> list[Measurement]:
    """Time the cases, `rounds` times each and interleaved, after a run each to warm up."""
    repeats = []
    for case in cases:
        if tell:
            tell(f"warming up {' '.join(filter(None, (case.scene, case.name, case.queue)))}")
        case.run()
        once = _seconds(case, 1)
        repeats.append(1 if case.reset else max(1, math.ceil(SHORTEST / max(once, 1e-6))))
    times: list[list[float]] = [[] for _ in cases]
    for turn in range(rounds):
        if tell:
            tell(f"round {turn + 1} of {rounds}")
        for case, again, kept in zip(cases, repeats, times, strict=True):
            kept.append(_seconds(case, again))
    return [measured(case, seconds) for case, seconds in zip(cases, times, strict=True)]


def measured(case: Case, seconds: Sequence[float], **extra: Any) -> Measurement:
    """The record of times that were taken elsewhere."""
    return Measurement(
        group=case.group,
        scene=case.scene,
        name=case.name,
        queue=case.queue,
        threads=case.threads,
        items=case.items,
        unit=case.unit,
        clock=case.clock,
        nbytes=case.nbytes,
        flops=case.flops,
        seconds=tuple(seconds),
        extra=extra,
    )


def _seconds(case: Case, repeats: int) -> float:
    if case.reset:
        case.reset()
    clock = CLOCKS[case.clock]
    start = clock()
    own = [case.run() for _ in range(repeats)]
    spent = clock() - start
    counted = [seconds for seconds in own if seconds is not None]
    return (sum(counted) if counted else spent) / repeats
