"""What bands cost: the sphereflake with more and more of them, and a ball of glass that disperses.

A dispersed picture of 64 bands stands against 64 pictures of one wavelength each, which show the same. Where
bands are bent in groups it is faster, and not the same any more.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Final

import numpy as np

from clrt.bench import scenes
from clrt.bench.timing import Case, Measurement, Tell, measure
from clrt.device.settings import Settings
from clrt.engine.tracer import Tracer
from clrt.scene.scene import Scene

BANDS: Final = (None, 8, 24, 64)  # None: RGB
MOST: Final = 64
ONE: Final = "one wavelength"
ALIKE, DISPERSED = (f"{MOST} bands, {kind}" for kind in ("one index", "dispersed"))
GROUPS: Final = {f"{DISPERSED} by {group}": group for group in (4, 8, 16)}
APART: Final = 1e-3  # of a band's maximum: what counts as another value


def pictures(quick: bool) -> Iterator[tuple[str, str, Scene]]:
    """(what it shows, how, scene) of each picture."""
    levels = 2 if quick else 4
    for bands in BANDS:
        name = f"{bands} bands" if bands else "RGB"
        yield "flake", name, scenes.flake_frame(levels=levels, bands=bands)
    index = scenes.GLASS_INDEX
    yield "glass ball", ONE, scenes.glass_ball(index, None)
    yield "glass ball", ALIKE, scenes.glass_ball(index, MOST)
    yield "glass ball", DISPERSED, scenes.glass_ball(scenes.GLASS, MOST)
    for name, group in GROUPS.items():
        yield "glass ball", name, scenes.glass_ball(scenes.GLASS, MOST, group)


def times(
    rounds: int, wanted: int | str | None, settings: Settings, quick: bool = False, tell: Tell | None = None
) -> list[Measurement]:
    """Processor time of the pictures, in turns, and the device memory that each holds (`device_bytes`).

    Of groups also `apart`: the share of the picture's values that differ from the dispersed one's by more
    than APART of the band's maximum.
    """
    cases: list[Case] = []
    tracers: list[Tracer] = []
    for shown, how, scene in pictures(quick):
        tracer = Tracer(scene, wanted, settings)
        width = _width(shown, quick)

        def run(tracer: Tracer = tracer, width: int = width) -> None:
            tracer.render(width=width)

        clock = "cpu" if tracer.device.info.kind == "CPU" else "wall"
        frame = Case(
            group="bands", scene=shown, name=how, run=run, items=width**2, unit="pixels", clock=clock
        )
        cases.append(frame)
        tracers.append(tracer)
    found = measure(cases, rounds, tell)
    by_name = {case.name: tracer for case, tracer in zip(cases, tracers, strict=True)}
    extra: dict[str, dict[str, float]] = {
        name: {"device_bytes": tracer.device.held_bytes} for name, tracer in by_name.items()
    }
    exact = _in_bands(by_name[DISPERSED], quick)
    for name in GROUPS:
        off = np.abs(_in_bands(by_name[name], quick) - exact) > APART * exact.max(axis=(0, 1))
        extra[name]["apart"] = float(off.mean())
    return [replace(m, extra=extra[m.name]) for m in found]


def _in_bands(tracer: Tracer, quick: bool) -> np.ndarray:
    return tracer.render(width=_width("glass ball", quick), layers=["bands"]).layers["bands"]


def _width(shown: str, quick: bool) -> int:
    return 64 if quick else 1024 if shown == "flake" else 512


def ratio(made: list[Measurement], shown: str, how: str) -> float:
    """What a picture costs against the same in RGB; a dispersed one against one wavelength."""
    median = {m.name: m.median for m in made if m.scene == shown}
    return median[how] / median["RGB" if shown == "flake" else ONE]
