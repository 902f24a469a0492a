"""The float32 twin's rough mirrors: facets drawn from those that a ray sees (docs/model.md, Gloss)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .math import (
    ONE,
    Array,
    combine,
    cross,
    disk,
    dot,
    frame_about,
    larger,
    mix_bits,
    unit,
    unit_interval,
    vector,
)
from .queues import Streams

_ZERO = np.float32(0.0)


@dataclass(frozen=True)
class Facet:
    """Directions (3, n) mirrored at facets, cosines (n,) of incidence there, and what share goes on."""

    direction: Array
    cosine: Array
    passed: Array


def facet_at(n: Array, ns: Array, u: Array, alpha: Array, streams: Streams) -> Facet:
    """About the shading normals ns, or where that leads below the surface about the true ones n."""
    h = combine(streams.base, np.full_like(streams.base, 0x80000001))
    u1 = unit_interval(mix_bits(h + np.uint32(1)) + streams.sample * np.uint32(0xC13FA9A9))
    u2 = unit_interval(mix_bits(h + np.uint32(2)) + streams.sample * np.uint32(0x91E10DA5))
    point = disk(u1, u2)
    shaded, true = (_about(normal, u, alpha, *point) for normal in (ns, n))
    below = (shaded.passed > 0.0) & ~(dot(shaded.direction, n) > 0.0)
    return Facet(
        *(np.where(below, b, a) for a, b in zip(vars(shaded).values(), vars(true).values(), strict=True))
    )


def _about(n: Array, u: Array, alpha: Array, a: Array, b: Array) -> Facet:
    tangent, bitangent = frame_about(n)
    v = vector(-dot(u, tangent), -dot(u, bitangent), -dot(u, n))
    stretched = unit(vector(alpha * v[0], alpha * v[1], v[2]))
    across = np.sqrt(stretched[0] * stretched[0] + stretched[1] * stretched[1])
    flat = across == 0.0
    first = vector(
        np.where(flat, ONE, -stretched[1] / across), np.where(flat, _ZERO, stretched[0] / across), _ZERO
    )
    second = cross(stretched, first)
    part = np.float32(0.5) * (1.0 + stretched[2])
    b = (1.0 - part) * np.sqrt(larger(1.0 - a * a, _ZERO)) + part * b
    along = np.sqrt(larger(1.0 - a * a - b * b, _ZERO))
    facet = first * a + second * b + stretched * along
    h = unit(vector(alpha * facet[0], alpha * facet[1], larger(facet[2], _ZERO)))
    cosine = dot(v, h)
    r = h * (2.0 * cosine) - v
    slope = (r[0] * r[0] + r[1] * r[1]) / (r[2] * r[2])
    passed = np.where(r[2] > 0.0, 2.0 / (1.0 + np.sqrt(1.0 + alpha * alpha * slope)), _ZERO)
    return Facet(unit(tangent * r[0] + bitangent * r[1] + n * r[2]), cosine, passed)
