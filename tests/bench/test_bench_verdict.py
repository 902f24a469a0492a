"""The verdict on two reports: an unchanged run is not flagged, a slowdown of ten percent is."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

import clrt
from clrt.bench import report, roof, timing, verdict
from clrt.bench.machine import one_core
from clrt.device.device import Device
from tests.bench_samples import measurement


def run_of(rng: np.random.Generator, cases: int, scatter: float, slower: float = 1.0) -> report.Report:
    """A report of cases whose times scatter with a long tail, by 1 % between runs; the first is slower."""
    rows = []
    for k in range(cases):
        middle = (slower if k == 0 else 1.0) * (1 + k) * np.exp(rng.normal(0, 0.01))
        times = middle * np.exp(scatter * (rng.normal(size=9) + rng.exponential(size=9)))
        rows.append(measurement(tuple(times), name=f"case {k}"))
    return report.Report({}, tuple(rows))


@pytest.mark.parametrize("scatter", [0.002, 0.01, 0.02])
def test_an_unchanged_run_is_not_flagged(scatter: float):
    rng = np.random.default_rng(1)
    words = [
        v.word
        for _ in range(100)
        for v in verdict.compare(run_of(rng, 30, scatter), run_of(rng, 30, scatter))
    ]
    flagged = words.count(verdict.SLOWER) + words.count(verdict.FASTER)
    assert len(words) == 3000 and flagged <= 3
    assert words.count(verdict.UNCLEAR) <= 3000 * (0.02 if scatter < 0.02 else 0.25)


@pytest.mark.parametrize(("scatter", "least"), [(0.002, 95), (0.01, 90)])
def test_a_slowdown_of_ten_percent_is_flagged(scatter: float, least: int):
    rng = np.random.default_rng(2)
    words = []
    for _ in range(100):
        found = verdict.compare(run_of(rng, 30, scatter), run_of(rng, 30, scatter, slower=1.1))
        words.append(found[0].word)
    assert words.count(verdict.SLOWER) >= least and verdict.FASTER not in words


def test_what_scatters_too_much_is_unclear_and_too_few_times_too():
    rng = np.random.default_rng(3)
    noisy = [measurement(tuple(1 + 0.3 * rng.random(9))) for _ in range(2)]
    assert verdict.judge(*noisy).word == verdict.UNCLEAR
    assert verdict.judge(measurement((1.0, 1.0)), measurement((1.1, 1.1))).word == verdict.UNCLEAR
    exact = measurement((1.0,) * 9)
    assert verdict.judge(exact, measurement((1.2,) * 9)).word == verdict.SLOWER
    assert verdict.judge(exact, measurement((0.8,) * 9)).word == verdict.FASTER
    assert verdict.judge(exact, measurement((1.04,) * 9)).word == verdict.SAME
    assert verdict.judge(exact, measurement((1.04,) * 9, items=20)).word == verdict.FASTER  # an item counts


def test_a_real_kernel_made_ten_percent_slower_is_flagged():
    """The arithmetic kernel with a tenth more steps, beside itself unchanged, in interleaved runs.

    On a machine with other work a run may be unclear, and is repeated with twice as many rounds, up to some
    ten seconds: what it says may not be wrong.
    """
    with one_core():
        device = Device(settings=clrt.Settings(threads=1))
        cases = [roof.arithmetic_case(device, steps) for steps in (8000, 8000, 8800)]
        for doubled in range(7):
            a, b, c = timing.measure(cases, rounds=15 << doubled)
            unchanged, slower = verdict.judge(a, b), verdict.judge(a, replace(c, items=a.items))
            assert unchanged.word in (verdict.SAME, verdict.UNCLEAR)
            assert slower.word in (verdict.SLOWER, verdict.UNCLEAR)
            if verdict.UNCLEAR not in (unchanged.word, slower.word):
                break
    assert (unchanged.word, slower.word) == (verdict.SAME, verdict.SLOWER)
    # the error that the verdict itself allows for: the bound that its words are made of
    assert abs(math.log(slower.ratio / 1.1)) < verdict.SURE * slower.error + verdict.FLOOR, slower
