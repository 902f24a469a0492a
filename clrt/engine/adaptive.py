"""Adaptive sampling: grid after grid where neighbours differ (Whitted 1980, 2.3, on grids of whole pixels).

A pixel's value is that of its last grid alone, so it has the bits of the even picture of as many samples.
Whether it gets the second grid depends on its neighbours on the first one: these are traced, too, where a
list of pixels lacks them. So any list has the bits of the whole picture, wherever it is done.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Final

import numpy as np

from clrt.device.device import Device
from clrt.engine.schedule import TooLarge, Work
from clrt.engine.stage import Observer
from clrt.engine.wavefront import RayCounts, Tile
from clrt.engine.world import World

if TYPE_CHECKING:
    from clrt.engine.job import Job

_SURFACE: Final = ("shape", "normal")  # layers by which neighbours are compared
_BENT: Final = np.float32(0.9)  # cosine between normals of neighbours below which there is an edge

Found = dict[str, np.ndarray]


def refined(
    job: Job,
    device: Device,
    world: World,
    pixels: np.ndarray,
    observers: Sequence[Observer] = (),
    budget: int | None = None,
) -> Work[Tile]:
    """`Job.trace` for a job that says how far to refine. Rays of neighbours that are no part of the list are
    not counted, so that counts do not depend on how a picture is cut."""
    assert job.adaptive is not None and job.camera is not None
    grid, (finest, threshold) = job.grid, job.adaptive
    size = int(job.camera["width"][0]), int(job.camera["height"][0])
    run = _Run(device, world, observers, budget)
    found = yield from run.trace(job.even(grid, (*job.layers, *_SURFACE)), pixels)
    beside = around(pixels, *size)
    seen = found
    if len(beside):
        uncounted = _Run(device, world, observers, budget)
        theirs = yield from uncounted.trace(job.even(grid, _SURFACE), beside)
        seen = {name: np.concatenate([found[name], theirs[name]]) for name in ("image", *_SURFACE)}
    chosen = np.flatnonzero(edges(np.concatenate([pixels, beside]), len(pixels), seen, *size, threshold))
    while len(chosen) and grid < finest:
        grid *= 2
        finer = yield from run.trace(job.even(grid, job.layers), pixels[chosen])
        changed = apart(found["image"][chosen], finer["image"], threshold)
        for name, values in finer.items():
            found[name][chosen] = values
        chosen = chosen[changed]
    return run.tile({name: found[name] for name in ("image", *job.layers)})


class _Run:
    """Traces lists of pixels, in parts that suit the device, and adds up what they cost."""

    def __init__(
        self, device: Device, world: World, observers: Sequence[Observer], budget: int | None
    ) -> None:
        self._device, self._world, self._observers, self._budget = device, world, observers, budget
        self._rays, self._local_size = RayCounts(), 0

    def trace(self, job: Job, pixels: np.ndarray) -> Work[Found]:
        """Picture and layers of the pixels, in their order."""
        step = max(1, job.tile_rays // job.samples)
        waiting = [np.arange(start, min(start + step, len(pixels))) for start in range(0, len(pixels), step)]
        found: Found = {}
        while waiting:
            part = waiting.pop()
            try:
                work = job.trace(self._device, self._world, pixels[part], self._observers, self._budget)
                tile = yield from work
            except TooLarge:
                if len(part) < 2:
                    raise  # whoever cuts lists of pixels knows what to say
                waiting += [part[len(part) // 2 :], part[: len(part) // 2]]
                continue
            for name, values in tile.layers.items():
                if name not in found:
                    found[name] = np.empty((len(pixels), *values.shape[1:]), values.dtype)
                found[name][part] = values
            self._rays.merge(tile.rays)
            self._local_size = tile.local_size
        return found

    def tile(self, layers: Found) -> Tile:
        return Tile(self._rays, layers, self._local_size)


def around(pixels: np.ndarray, width: int, height: int) -> np.ndarray:
    """The neighbours of pixels, to the four sides within the picture, that are not among them: uint32."""
    first, own = _in_rows(pixels, width)
    beside = np.zeros((int(own.max()) // width + 3) * width, bool)  # a row above and one below them
    for inside, step in _sides(pixels, width, height):
        beside[own[inside] + (width + step)] = True
    beside[own + width] = False
    return (np.flatnonzero(beside) + (first - width)).astype(np.uint32)


def edges(
    pixels: np.ndarray, n: int, seen: Found, width: int, height: int, threshold: float
) -> np.ndarray:
    """(n,) bool: which of the first n pixels differ from a neighbour, all of which are among the pixels.

    seen: their `image` (m, 3), `shape` (m,) and `normal` (m, 3).
    """
    _, own = _in_rows(pixels, width)
    place = np.empty(int(own.max()) + 1, np.int32)
    place[own] = np.arange(len(pixels), dtype=np.int32)
    chosen = np.zeros(n, bool)
    for inside, step in _sides(pixels[:n], width, height):
        here = np.flatnonzero(inside)
        chosen[here] |= _differ(seen, here, place[own[here] + step], threshold)
    return chosen


def _in_rows(pixels: np.ndarray, width: int) -> tuple[int, np.ndarray]:
    """The first number of the first of the picture's rows that has any, and the pixels counted from there."""
    first = int(pixels.min()) // width * width
    return first, pixels.astype(np.int64) - first


def _sides(pixels: np.ndarray, width: int, height: int) -> list[tuple[np.ndarray, int]]:
    """Of each side which pixels have a neighbour there, and by how much its number is larger."""
    x, y = pixels % width, pixels // width
    return [(x > 0, -1), (x < width - 1, 1), (y > 0, -width), (y < height - 1, width)]


def _differ(seen: Found, here: np.ndarray, there: np.ndarray, threshold: float) -> np.ndarray:
    shape, normal = seen["shape"], seen["normal"]
    one, other = normal[here], normal[there]
    cosine = one[:, 0] * other[:, 0] + one[:, 1] * other[:, 1] + one[:, 2] * other[:, 2]
    bent = (shape[here] >= 0) & (cosine < _BENT)
    outlines = (shape[here] != shape[there]) | bent
    return outlines | apart(seen["image"][here], seen["image"][there], threshold)


def apart(one: np.ndarray, other: np.ndarray, threshold: float) -> np.ndarray:
    """(n,) bool: do colours (n, 3) differ, on a scale that is even to the eye, in a channel?"""
    difference = np.sqrt(np.clip(one, 0, 1)) - np.sqrt(np.clip(other, 0, 1))
    return np.asarray((difference * difference > np.float32(threshold)).any(axis=1))
