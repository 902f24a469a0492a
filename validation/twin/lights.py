"""The float32 twin's lights: the way from points to a light, or to one of its points (docs/model.md)."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np

from clrt import layout

from .math import (
    ONE,
    Array,
    arctan2,
    combine,
    cross,
    disk,
    dot,
    frame_about,
    larger,
    mix_bits,
    smaller,
    turn,
    unit_interval,
    vector,
)
from .queues import Streams

_ZERO = np.float32(0.0)
_STEPS = np.uint32(0xC13FA9A9), np.uint32(0x91E10DA5)


@dataclass(frozen=True)
class LightSample:
    """The way from n points to one light, and the factor (n,) by which its intensity arrives.

    Unit directions (3, n), 0 where it does not shine; distances (n,), infinite where it is directional.
    """

    direction: Array
    distance: Array
    factor: Array


def light_samples(lights: Array, start: Array, streams: Streams) -> Iterator[tuple[np.void, LightSample]]:
    """Each light, once for each of its points, and the way to it from n places (3, n)."""
    for number, light in enumerate(lights):
        kind = int(light["kind"])
        if kind in _SAMPLES:
            yield light, _SAMPLES[kind](light, start)
            continue
        h = combine(streams.base, np.full_like(streams.base, np.uint32(0x80000002 + number)))
        for i in range(int(light["samples"])):
            place = streams.sample * np.uint32(light["samples"]) + np.uint32(i)
            u1, u2 = (
                unit_interval(mix_bits(h + np.uint32(k + 1)) + place * step) for k, step in enumerate(_STEPS)
            )
            yield light, EXTENDED[kind](light, start, u1, u2)


def _point(light: np.void, start: Array) -> LightSample:
    way = _field(light, "place", start) - start
    distance = np.sqrt(dot(way, way))
    fades = light["falloff"] == layout.FALLOFF["INVERSE_SQUARE"]
    factor = ONE / (distance * distance) if fades else np.ones_like(distance)
    return LightSample(way * (ONE / distance), distance, factor)


def _directional(light: np.void, start: Array) -> LightSample:
    far = np.full(start.shape[1], np.inf, np.float32)
    return LightSample(_field(light, "place", start), far, np.ones_like(far))


def _spot(light: np.void, start: Array) -> LightSample:
    sample = _point(light, start)
    axis = _field(light, "axis", start)
    across = cross(axis, sample.direction)
    theta = arctan2(np.sqrt(dot(across, across)), -dot(axis, sample.direction))
    share = (light["angle"] - theta) / light["width"]
    clamped = smaller(larger(share, _ZERO), ONE)
    return LightSample(
        np.where(share > 0.0, sample.direction, _ZERO), sample.distance, sample.factor * clamped
    )


def _rectangle(light: np.void, start: Array, u1: Array, u2: Array) -> LightSample:
    along_u = _field(light, "u", start) * (2.0 * u1 - 1.0)
    along_v = _field(light, "v", start) * (2.0 * u2 - 1.0)
    return _flat(light, start, _field(light, "place", start) + along_u + along_v)


def _disk(light: np.void, start: Array, u1: Array, u2: Array) -> LightSample:
    x, y = disk(u1, u2)
    at = _field(light, "place", start) + _field(light, "u", start) * x + _field(light, "v", start) * y
    return _flat(light, start, at)


def _flat(light: np.void, start: Array, at: Array) -> LightSample:
    """A point of a flat light, by the cosine of its normal."""
    way = at - start
    distance = np.sqrt(dot(way, way))
    direction = way * (ONE / distance)
    cosine = -dot(_field(light, "axis", start), direction)
    if light["two_sided"]:
        cosine = np.abs(cosine)
    factor = light["share"] * cosine / (distance * distance)
    return LightSample(np.where(cosine > 0.0, direction, _ZERO), distance, factor)


def _sphere(light: np.void, start: Array, u1: Array, u2: Array) -> LightSample:
    """A point of the cap of a sphere that is seen, evenly by solid angle; from within all of it."""
    radius = light["radius"]
    way = _field(light, "place", start) - start
    d = np.sqrt(dot(way, way))
    power, ratio, outside = (d - radius) * (d + radius), radius / d, d > radius
    middle = vector(np.zeros_like(d), np.zeros_like(d), np.ones_like(d))
    to_center = np.where(d > 0.0, way * (ONE / d), middle)
    cap = np.where(outside, ratio * ratio / (1.0 + np.sqrt(power) / d), np.float32(2.0))
    q = u1 * cap
    cosine, sine = 1.0 - q, np.sqrt(q * (2.0 - q))
    beside, across = turn(u2)
    tangent, bitangent = frame_about(to_center)
    direction = tangent * (sine * across) + bitangent * (sine * beside) + to_center * cosine
    along = d * cosine
    chord = np.sqrt((1.0 - u1) * (2.0 - cap * (1.0 + u1)) / (2.0 - cap))
    distance = np.where(outside, power / (along + radius * chord), along + np.sqrt(along * along - power))
    shines = outside | bool(light["two_sided"])
    factor = 2.0 * cap / np.float32(light["samples"])
    return LightSample(np.where(shines, direction, _ZERO), distance, factor)


def _field(light: np.void, name: str, start: Array) -> Array:
    """A vector of the record, for every point."""
    return np.repeat(light[name][:3, None], start.shape[1], axis=1)


_SAMPLES: dict[int, Callable[[np.void, Array], LightSample]] = {
    layout.LIGHT_KINDS[kind]: sample
    for kind, sample in {"POINT": _point, "DIRECTIONAL": _directional, "SPOT": _spot}.items()
}
EXTENDED: dict[int, Callable[[np.void, Array, Array, Array], LightSample]] = {
    layout.EXTENDED_KINDS[kind]: sample
    for kind, sample in {"RECTANGLE": _rectangle, "DISK": _disk, "SPHERE": _sphere}.items()
}
