"""How few samples the showcase needs for the error of 16 a pixel: by the model's rule, by others.

    python docs/measure_adaptive.py [WIDTH]

Each way of choosing pixels gets as many as it takes for the RMSE of 16 samples for all (to 256 for all), from
grids of 4, 16 and 64, all of which are traced. Printed: camera rays over those of 16 for all, and the time of
tracing just these pixels and grids, over that of 16 for all (processor time, in turns, the least of three).
"By the error" knows this very picture's, more than any rule; "by the expected error" the mean of three other
grids of 4 (no bound: a rule that sees this grid may do better); "by samples" compares single samples with
those beside them.
"""

from __future__ import annotations

import sys
import time
from typing import Final

import numpy as np

import clrt
import clrt.engine.job as jobs
from clrt.device.device import Device
from clrt.engine.adaptive import _Run, refined
from clrt.engine.job import Job
from clrt.engine.schedule import Work
from clrt.engine.wavefront import Tile
from clrt.engine.world import World

GRIDS: Final = (2, 4, 8)
COST: Final = np.array([4.0, 20.0, 84.0])  # camera rays up to each grid
ROUNDS: Final = 3
SETTLED: Final = 0.01  # of the model's rule: colours that differ by less after the second grid


class Chosen:
    """Adaptive sampling whose pixels are given: 0, 1 or 2, the last of its grids."""

    def __init__(self, last: np.ndarray) -> None:
        self._last = last

    def __call__(self, job: Job, device: Device, world: World, pixels: np.ndarray, observers: tuple[()] = (),
                 budget: int | None = None) -> Work[Tile]:  # fmt: skip
        run, last = _Run(device, world, observers, budget), self._last[pixels]
        found = yield from run.trace(job.even(GRIDS[0]), pixels)
        for number, grid in enumerate(GRIDS[1:], 1):
            if len(which := np.flatnonzero(last >= number)):
                finer = yield from run.trace(job.even(grid), pixels[which])
                found["image"][which] = finer["image"]
        return run.tile(found)


def error(picture: np.ndarray, right: np.ndarray) -> np.ndarray:
    """(n,) mean square over the channels of (h, w, 3)."""
    found: np.ndarray = ((picture.astype(np.float64) - right) ** 2).mean(axis=2).ravel()
    return found


def by_expectation(known: np.ndarray, truth: np.ndarray) -> np.ndarray:
    """The grids that cost least by errors `known` (3, n), until `truth` is small enough."""
    low, high = 1e-14, 1e3
    for _ in range(60):
        middle = float(np.sqrt(low * high))
        last = np.argmin(known + middle * COST[:, None], axis=0)
        small = np.take_along_axis(truth, last[None], 0).mean() <= truth[1].mean()
        low, high = (middle, high) if small else (low, middle)
    return np.argmin(known + low * COST[:, None], axis=0)


def by_score(score: np.ndarray, again: np.ndarray, truth: np.ndarray) -> np.ndarray:
    """As many pixels of the highest score as it takes; those in `again` get the third grid, too."""
    order = np.argsort(-score)
    gain = (np.where(again, truth[2], truth[1]) - truth[0])[order]
    count = np.flatnonzero(truth[0].sum() + np.cumsum(gain) <= truth[1].sum())[0] + 1
    last = np.zeros(len(score), np.intp)
    last[order[:count]] = 1
    return np.where(again, 2 * last, last)


def beside(samples: np.ndarray) -> np.ndarray:
    """(h w,) how much the samples (2 h, 2 w, 3) of a pixel differ from those beside them."""
    most = np.zeros(samples.shape[:2])
    for axis in (0, 1):
        change = (np.diff(samples, axis=axis) ** 2).max(axis=2)
        pad = [(0, 0), (0, 0)]
        for pad[axis] in ((0, 1), (1, 0)):
            most = np.maximum(most, np.pad(change, pad))
    height, width = most.shape
    return most.reshape(height // 2, 2, width // 2, 2).max(axis=(1, 3)).ravel()


def main() -> None:
    width = int(sys.argv[1]) if len(sys.argv) > 1 else 1280
    scene = clrt.load("showcase").replace({"camera.spp": 4})
    tracer = clrt.Tracer(scene)
    even = {spp: tracer.render(width=width, spp=spp).pixels for spp in (4, 16, 64, 256)}
    truth = np.stack([error(even[spp], even[256]) for spp in (4, 16, 64)])
    jitters = [clrt.render(scene.replace({"camera.jitter": seed}), width=width).pixels for seed in (1, 2, 3)]
    expected = np.mean([error(one, even[256]) for one in jitters], axis=0)
    seen = {spp: np.sqrt(np.clip(even[spp], 0, 1)) for spp in (4, 16)}
    again = ((seen[16] - seen[4]) ** 2 > SETTLED).any(axis=2)
    fine = clrt.render(scene, width=2 * width, spp=1).pixels
    ways = {
        "by the error": by_expectation(truth, truth),
        # where it falls by the cube of a grid's side, as it does at edges
        "by the expected error": by_expectation(np.stack([expected, expected / 8, expected / 64]), truth),
        "by samples": by_score(beside(fine), again.ravel(), truth),
    }
    adaptive = clrt.Tracer(scene.replace({"adaptive": {"spp": 64}}))
    least: dict[str, float] = {}
    for _ in range(ROUNDS):
        for name in ("16 for all", "by the model", *ways):
            jobs.refined = Chosen(ways[name]) if name in ways else refined  # type: ignore[assignment]
            whose, spp = (tracer, 16) if name == "16 for all" else (adaptive, 4)
            start = time.process_time()
            image = whose.render(width=width, spp=spp)
            least[name] = min(time.process_time() - start, least.get(name, np.inf))
            rays = image.stats["rays"]["camera"] / (16 * image.pixels[..., 0].size)
            rmse = np.sqrt(error(image.pixels, even[256]).mean() / truth[1].mean())
            spent = least[name] / least["16 for all"]
            print(f"{name:22s} rays {rays:.3f} time {spent:.3f} RMSE {rmse:.3f}", flush=True)


if __name__ == "__main__":
    main()
