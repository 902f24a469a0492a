"""Times that nobody took."""

from __future__ import annotations

from dataclasses import replace

from clrt.bench import timing
from clrt.bench.timing import Case, Measurement


def measurement(seconds: tuple[float, ...], name: str = "closest", items: int = 10) -> Measurement:
    made = Case(group="tracing", scene="flake", name=name, queue="primary", run=lambda: None, items=items)
    return timing.measured(replace(made, nbytes=200.0, flops=3000.0), seconds)
