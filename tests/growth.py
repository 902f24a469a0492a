"""How much longer four times as much takes."""

from __future__ import annotations

import gc
import itertools
import time
import warnings
from collections.abc import Callable
from pathlib import Path

import pytest

import clrt

MOST = 6.0
"""How much longer four times as much may take: 4 where the time is linear, 16 where it is its square."""


LEAST = 1e-2
"""Seconds below which pages of memory that are new, or not, decide: what is quadratic takes far longer."""


def seconds(work: Callable[[], object]) -> float:
    """Processor time, the least of two runs."""
    times = []
    for _ in range(2):
        gc.collect()
        gc.disable()
        try:
            start = time.process_time()
            work()
            times.append(time.process_time() - start)
        finally:
            gc.enable()
    return min(times)


def check_growth(make: Callable[[int], Callable[[], object]], n: int) -> None:
    """`make(n)` prepares a work of size n. The least times count: a busy machine only ever adds to them.

    Where the small one fits into a cache and the large one does not, both are doubled: only the square stays.
    Python's collector rests meanwhile: now and then it walks through all that this process holds beside.
    """
    ratios = []
    for scale in (1, 2):
        small, large = make(scale * n), make(4 * scale * n)
        least = [float("inf")] * 2
        for _ in range(6):
            least = [min(known, seconds(work)) for known, work in zip(least, (small, large), strict=True)]
            if least[1] <= MOST * max(least[0], LEAST):
                return
        ratios.append(round(least[1] / least[0], 1))
    pytest.fail(f"four times as much takes {ratios} times as long")


def names(count: int) -> list[str]:
    letters = itertools.product("abcdefghijklmnopqrstuvwxyz", repeat=4)
    return ["".join(name) for name in itertools.islice(letters, count)]


def loading(path: Path, load: Callable[[Path], object] = clrt.load) -> Callable[[], None]:
    """What reads a file, or has it refused."""

    def work() -> None:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            try:
                load(path)
            except clrt.ClrtError as error:
                assert len(str(error)) < 3000

    return work
