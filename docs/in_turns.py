"""Processor times of tracers that render the same picture in turns: what `docs/measure_*_cost.py` compare."""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence

import numpy as np

from clrt import Tracer


def ratios(tracers: Sequence[Tracer], base: int, rounds: int, width: int) -> Iterator[tuple[float, str]]:
    """Of each tracer but number `base`: the median of its time over that one's of the same round, and a text
    of it with the quartiles. Each round begins with another tracer."""
    spent = np.empty((rounds, len(tracers)))
    for number in range(rounds):
        for which in np.roll(np.arange(len(tracers)), number):
            start = time.process_time()
            tracers[which].render(width=width)
            spent[number, which] = time.process_time() - start
    for times in np.delete(spent, base, axis=1).T:
        low, middle, high = np.quantile(times / spent[:, base], [0.25, 0.5, 0.75])
        yield float(middle), f"{middle:.3f} ({low:.3f} to {high:.3f})"
