"""Whole pictures, with one thread and with two or more, and which pass takes what share of them."""

from __future__ import annotations

import time
from dataclasses import dataclass, field, replace

from clrt.bench.recorder import ARRANGING, TRACING
from clrt.bench.timing import Case, Measurement, Tell, measure
from clrt.device.settings import Settings
from clrt.engine.tracer import Tracer
from clrt.scene.scene import Scene


@dataclass
class Frame:
    """A scene, ready to be rendered at one size with a number of threads; remembers the passes' seconds."""

    name: str
    scene: Scene
    width: int
    threads: int
    wanted: int | str | None = None
    settings: Settings = field(default_factory=Settings)
    runs: list[tuple[float, dict[str, float]]] = field(default_factory=list)  # seconds, the passes'
    traced: int = 0

    def __post_init__(self) -> None:
        self.tracer = Tracer(self.scene, self.wanted, replace(self.settings, threads=self.threads))

    def case(self, pixels: int) -> Case:
        """Rendering as something to time, by wall time."""
        return Case(
            group="frame",
            scene=self.name,
            name="picture",
            run=self.run,
            threads=self.threads,
            items=pixels,
            unit="pixels",
            clock="wall",
        )

    def run(self) -> float:
        """Render once; the seconds it took."""
        start = time.perf_counter()
        image = self.tracer.render(width=self.width)
        spent = time.perf_counter() - start
        self.runs.append((spent, dict(image.stats["seconds"])))
        self.traced = int(image.stats["traced"])
        return spent

    def middle(self) -> tuple[float, dict[str, float]]:
        """Seconds of the run that took the median time, and of its passes.

        Of one run, since medians of parts need not add up to the median of the whole. The first run, which
        compiles, is left out.
        """
        return sorted(self.runs[1:], key=lambda run: run[0])[(len(self.runs) - 2) // 2]


def frame_times(
    scenes: dict[str, tuple[Scene, int]],
    threads: tuple[int, ...],
    rounds: int,
    wanted: int | str | None,
    settings: Settings,
    tell: Tell | None = None,
) -> list[Measurement]:
    """Pictures `scenes` (name -> scene, width) with each number of threads, interleaved."""
    found = []
    for name, (scene, width) in scenes.items():
        frames = [Frame(name, scene, width, n, wanted, settings) for n in threads]
        assert scene.camera is not None
        pixels = width * max(1, round(scene.camera.height * width / scene.camera.width))
        times = measure([frame.case(pixels) for frame in frames], rounds, tell)
        for frame, measurement in zip(frames, times, strict=True):
            whole, passes = frame.middle()
            extra = {"rays": frame.traced, "passes": passes, "of_seconds": whole}
            found.append(replace(measurement, extra=extra))
    return found


def shares(measurement: Measurement) -> dict[str, float]:
    """A frame's time as shares: finding hits, all other passes, and the host between them."""
    passes: dict[str, float] = measurement.extra["passes"]
    finding = (*TRACING, ARRANGING)
    tracing = sum(spent for name, spent in passes.items() if name.removesuffix("_tinted") in finding)
    rest = sum(passes.values()) - tracing
    whole = max(measurement.extra.get("of_seconds", measurement.median), tracing + rest)
    return {"tracing": tracing / whole, "passes": rest / whole, "host": 1.0 - (tracing + rest) / whole}
