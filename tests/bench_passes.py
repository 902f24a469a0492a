"""The passes' microbenchmarks for pytest-benchmark; by its name, no part of an ordinary run of the tests.

    python -m pytest tests/bench_passes.py --benchmark-autosave
    python -m pytest tests/bench_passes.py --benchmark-compare

The scenes are small; `clrt bench` measures on large ones, and knows the device's roof.
"""

from __future__ import annotations

import time
from typing import Any

import pytest

import clrt
from clrt.bench import kernels, scenes
from clrt.bench.machine import one_core
from clrt.bench.timing import Case

WIDTH = 128


def recorded() -> list[Case]:
    found = []
    for name in scenes.SCENES:
        recording = kernels.recorded(scenes.make(name, quick=True), WIDTH, None, clrt.Settings())
        found += kernels.cases(recording, name)
    return found


@pytest.mark.parametrize("case", recorded(), ids=lambda case: f"{case.scene}-{case.name}-{case.queue}")
@pytest.mark.benchmark(timer=time.process_time, warmup=True, warmup_iterations=1, min_rounds=9)
def test_pass(case: Case, benchmark: Any) -> None:
    benchmark.group = f"{case.group}: {case.name}"
    benchmark.extra_info |= {"items": case.items, "bytes": case.nbytes, "flops": case.flops}
    with one_core():
        if case.reset:
            benchmark.pedantic(case.run, setup=case.reset, rounds=9, warmup_rounds=1)
        else:
            benchmark(case.run)
