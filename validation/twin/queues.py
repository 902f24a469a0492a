"""The float32 twin's queues of rays: camera rays, rays of the caller, and the merging of children."""

from __future__ import annotations

from dataclasses import dataclass, fields, replace

import numpy as np

from clrt import layout

from .geometry import Rays
from .math import (
    Array,
    combine,
    disk,
    dot,
    exponential,
    larger,
    mix_bits,
    unit,
    unit_interval,
    unit_of_any,
    vector,
)

FLAGS = np.uint32(layout.PATH["PATH_FLAGS"])


@dataclass(frozen=True)
class Streams:
    """What rays draw numbers from, (n,) uint32 each: a hash, and which stretch of its sequence is a ray's."""

    base: Array
    sample: Array

    def __getitem__(self, rows: Array) -> Streams:
        return Streams(self.base[rows], self.sample[rows])


@dataclass(frozen=True)
class Queue:
    """n rays of one kind and generation, those of a pixel next to each other; weight is (bands, n).

    media: (places, n) int32, numbers of materials, where rays carry lists of them. band: (n,) int32, the
    first band of each, where the rays are narrow. first: what rays of generation 0 draw from.
    """

    kind: str
    rays: Rays
    pixel_of: Array
    path: Array
    weight: Array
    media: Array | None = None
    band: Array | None = None
    first: Streams | None = None

    def __len__(self) -> int:
        return len(self.rays)

    @property
    def streams(self) -> Streams:
        """Of generation 0 those of the pixels; deeper each ray has its own."""
        return self.first or Streams(self.path & ~FLAGS, np.zeros_like(self.path))


def generate(camera: Array, pixels: Array, bands: int = layout.BANDS) -> Queue:
    """Camera rays (docs/model.md, Camera and pixels): all samples of each of the pixel numbers."""
    c = camera[0]
    grid, width, height = (np.uint32(c[name]) for name in ("grid", "width", "height"))
    sample = np.tile(np.arange(grid * grid, dtype=np.uint32), len(pixels))
    place = np.repeat(np.arange(len(pixels), dtype=np.uint32), grid * grid)
    pixel = pixels.astype(np.uint32)[place]
    key = combine(combine(np.full_like(pixel, c["seed"]), pixel), sample)
    part_x, part_y = in_grid(c, key, sample)
    if c["filter"]:
        part_x, part_y = (np.float32(0.5) + off_middle(c, part) for part in (part_x, part_y))
    x = (pixel % width).astype(np.float32) + c["shift_x"] + part_x
    y = (pixel // width).astype(np.float32) + c["shift_y"] + part_y
    across = (2.0 * x / np.float32(width) - 1.0) * c["half_width"]
    above = (1.0 - 2.0 * y / np.float32(height)) * c["half_height"]
    origin, forward, right, up = (c[name][:3, None] for name in ("origin", "forward", "right", "up"))
    in_view = right * across + up * above
    if c["aperture"] > 0.0:
        lens = _on_lens(c, pixel, sample)
        ahead = np.repeat(forward, len(pixel), axis=1) if c["orthographic"] else forward + in_view
        if c["orthographic"]:
            origin = origin + in_view
        direction = unit(ahead - lens * (np.float32(1.0) / c["focus"]))
        origin = origin + lens + direction * (c["near"] / dot(direction, forward))
    elif c["orthographic"]:
        origin = origin + in_view + forward * c["near"]
        direction = np.repeat(forward, len(pixel), axis=1)
    else:
        direction = unit(forward + in_view)
        origin = origin + direction * (c["near"] / dot(direction, forward))
    if c["filter"]:
        place = np.arange(len(place), dtype=np.uint32)
    sides = 2.0 * c["half_width"] / np.float32(width), 2.0 * c["half_height"] / np.float32(height)
    side = np.float32(larger(*sides)) / np.float32(grid)
    spread = np.float32(0.0) if c["orthographic"] else side * dot(direction, forward)
    cone = vector(side if c["orthographic"] else side * c["near"], spread, np.zeros(len(place)))[:2]
    queue = new_queue(
        "camera", origin, direction, place, key & ~FLAGS, ones(bands, len(place)), cone=cone
    )
    return replace(queue, first=Streams(combine(np.full_like(pixel, c["seed"]), pixel), sample))


def in_grid(c: np.void, key: Array, sample: Array) -> tuple[Array, Array]:
    """Where samples of these hashes lie in the square that they fill, x and y from 0 to 1."""
    sub_x = sub_y = np.full(len(sample), 0.5, np.float32)
    if c["jitter"] and not (c["filter"] and c["grid"] == 1):
        sub_x, sub_y = (unit_interval(mix_bits(key + np.uint32(i))) for i in (1, 2))
    cells = sample % np.uint32(c["grid"]), sample // np.uint32(c["grid"])
    x, y = (
        (cell.astype(np.float32) + sub) / np.float32(c["grid"])
        for cell, sub in zip(cells, (sub_x, sub_y), strict=True)
    )
    return x, y


def off_middle(c: np.void, part: Array) -> Array:
    """How far from its pixel's middle a sample is, along an axis, in pixels."""
    return np.asarray(c["reach"] * (np.float32(2.0) * part - np.float32(1.0)))


def weights(camera: Array, pixels: Array) -> Array | None:
    """What each sample of these pixels counts for in its own, float32 (pixels, samples); None: as much."""
    c = camera[0]
    if not c["filter"]:
        return None
    samples = int(c["grid"]) ** 2
    sample = np.tile(np.arange(samples, dtype=np.uint32), len(pixels))
    pixel = np.repeat(pixels.astype(np.uint32), samples)
    key = combine(combine(np.full_like(pixel, c["seed"]), pixel), sample)
    x, y = (_filter(int(c["filter"]), off_middle(c, part)) for part in in_grid(c, key, sample))
    return (x * y).reshape(len(pixels), samples)


def _filter(kind: int, off: Array) -> Array:
    """A filter's weight along one axis."""
    a, f = np.abs(off), np.float32
    if kind == layout.FILTERS["TENT"]:
        return np.maximum(f(0.0), f(1.0) - a)
    if kind == layout.FILTERS["GAUSSIAN"]:
        return np.maximum(f(0.0), exponential(f(-2.0) * (a * a)) - f(0.000335462628))
    inner = ((f(7.0) * a - f(12.0)) * (a * a) + f(5.33333333)) / f(6.0)
    outer = (((f(-2.33333333) * a + f(12.0)) * a - f(20.0)) * a + f(10.6666667)) / f(6.0)
    return np.where(a < f(1.0), inner, outer)


def _on_lens(c: np.void, pixel: Array, sample: Array) -> Array:
    """Where on the lens rays start, (3, n) from its middle."""
    h = combine(combine(np.full_like(pixel, c["seed"]), pixel), np.uint32(0x80000000))
    u1 = unit_interval(mix_bits(h + np.uint32(1)) + sample * np.uint32(0x9E3779B9))
    u2 = unit_interval(mix_bits(h + np.uint32(2)) + sample * np.uint32(0x6A09E667))
    x, y = disk(u1, u2)
    return np.asarray((c["right"][:3, None] * x + c["up"][:3, None] * y) * c["aperture"])


def adopt(
    origins: Array, directions: Array, t_max: Array, numbers: Array, bands: int = layout.BANDS
) -> Queue:
    """A queue of the caller's rays: (n, 3), (n, 3) of any length, (n,) float32; their numbers (n,) uint32."""
    none = np.zeros_like(numbers)
    first = Streams(combine(none, numbers), none)
    path = combine(first.base, none) & ~FLAGS
    place = np.arange(len(numbers), dtype=np.uint32)
    weight = ones(bands, len(numbers))
    queue = new_queue("camera", origins.T, unit_of_any(directions.T), place, path, weight, t_max)
    return replace(queue, first=first)


def ones(bands: int, n: int) -> Array:
    """The weights of rays that start."""
    return np.ones((bands, n), np.float32)


def new_queue(
    kind: str,
    origin: Array,
    direction: Array,
    pixel_of: Array,
    path: Array,
    weight: Array,
    t_max: Array | None = None,
    media: Array | None = None,
    band: Array | None = None,
    cone: Array | None = None,
) -> Queue:
    """t_max defaults to infinity, `cone` to 0; `origin` may be one for all."""
    n = len(pixel_of)
    rays = Rays(
        np.ascontiguousarray(np.broadcast_to(origin, (3, n))),
        np.ascontiguousarray(direction),
        np.full(n, np.inf, np.float32) if t_max is None else t_max,
        np.zeros((2, n), np.float32) if cone is None else cone,
    )
    return Queue(kind, rays, pixel_of, path, weight, media, band)


def merged(queues: list[Queue]) -> Queue:
    """One queue, by pixel; rays of a pixel in the order of the queues."""
    order = np.argsort(np.concatenate([queue.pixel_of for queue in queues]), kind="stable")

    def join(parts: list[Array]) -> Array:
        return np.concatenate(parts, axis=-1)[..., order]

    rays = Rays(
        *(join([getattr(queue.rays, field.name) for queue in queues]) for field in fields(Rays))
    )
    lists = [queue.media for queue in queues if queue.media is not None]
    band = [queue.band for queue in queues if queue.band is not None]
    pixel_of, path, weight = (
        join([getattr(queue, name) for queue in queues]) for name in ("pixel_of", "path", "weight")
    )
    of_narrow = join(band) if band else None
    return Queue(queues[0].kind, rays, pixel_of, path, weight, join(lists) if lists else None, of_narrow)
