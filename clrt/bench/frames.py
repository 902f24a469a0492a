"""Whole pictures, with one thread and with two or more, and which pass takes what share of them."""

from __future__ import annotations

import time
from dataclasses import dataclass, field, replace
from statistics import median

from clrt.bench.recorder import TRACING
from clrt.bench.timing import Case, Measurement, Tell, measure
from clrt.scene import Scene
from clrt.settings import Settings
from clrt.tracer import Tracer


@dataclass
class Frame:
    """A scene, ready to be rendered at one size with a number of threads; remembers the passes' seconds."""

    name: str
    scene: Scene
    width: int
    threads: int
    wanted: int | str | None = None
    settings: Settings = field(default_factory=Settings)
    parts: list[dict[str, float]] = field(default_factory=list)
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
        self.parts.append(dict(image.stats["seconds"]))
        self.traced = int(image.stats["traced"])
        return spent

    def passes(self) -> dict[str, float]:
        """Seconds of each pass, medians over the renders."""
        names = set().union(*self.parts)
        return {name: median(part.get(name, 0.0) for part in self.parts) for name in sorted(names)}


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
            extra = {"rays": frame.traced, "passes": frame.passes()}
            found.append(replace(measurement, extra=extra))
    return found


def shares(measurement: Measurement) -> dict[str, float]:
    """A frame's time as shares: finding hits, all other passes, and the host between them."""
    passes: dict[str, float] = measurement.extra["passes"]
    tracing = sum(spent for name, spent in passes.items() if name.removesuffix("_tinted") in TRACING)
    rest = sum(passes.values()) - tracing
    whole = measurement.median
    return {"tracing": tracing / whole, "passes": rest / whole, "host": 1.0 - (tracing + rest) / whole}
