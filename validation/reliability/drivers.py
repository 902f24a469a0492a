"""Processor time on PoCL 3.0, which pip installs, and on PoCL 3.1: why `clrt doctor` prefers that."""

from __future__ import annotations

import time
from typing import Final

import clrt
from clrt.device.platforms import devices
from clrt.device.trial import verdict
from clrt.formats.shipped import load_scene

from .figures import Figure, Tell

_SCENES: Final = ("showcase", "sphereflake", "mesh", "whitted_1980")
_OLD, _NEW = "PoCL 3.0", "PoCL 3.1"
_WIDTH, _ROUNDS = 480, 5


def unable() -> str:
    """Why the two cannot be compared on this machine; "" where they can."""
    faults = []
    for name in (_OLD, _NEW):
        found = [verdict(info)[0] for info in devices() if name in info.label]
        if not found or all(found):
            faults.append(f"{name}: {found[0]}" if found else f"{name} is not here")
    return "; ".join(faults)


def run(count: int, tell: Tell) -> Figure:
    """Time `count` scenes on both, in turn; wrong are those that the older driver renders faster."""
    start = time.perf_counter()
    ratios: list[str] = []
    wrong = 0
    for number, name in enumerate(_SCENES[:count]):
        scene = load_scene(name)
        tracers = {driver: clrt.Tracer(scene, driver) for driver in (_OLD, _NEW)}
        best = dict.fromkeys(tracers, float("inf"))
        for round_ in range(_ROUNDS + 1):
            for driver, tracer in tracers.items():
                begun = time.process_time()
                tracer.render(width=_WIDTH)
                if round_:  # the first one compiles
                    best[driver] = min(best[driver], time.process_time() - begun)
        ratios.append(f"{name} {best[_OLD] / best[_NEW]:.2f}")
        wrong += best[_OLD] < best[_NEW]
        tell((number + 1) / count)
    detail = f"processor time on {_OLD} over that on {_NEW}: {', '.join(ratios)}"
    return Figure(len(ratios), wrong, detail, time.perf_counter() - start)
