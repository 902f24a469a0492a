"""Distances of hits against the analytic float64 oracle: is every one within the error band?

The band is a shift of the ray. Float32 cannot tell a ray from one BAND times the largest coordinate beside
it, so a hit is right where its distance lies between those that the oracle finds for the ray and for rays
beside it (and the same for a miss). BAND is twice what 10^5 rays a solid need (`needs`: 8 units of 2^-24, the
triangle 32). A triangle's corners are coordinates like those of the ray and its hit; where it is long
and thin, its plane may be off by as much as a ray that leaves it is moved (docs/design.md).
"""

from __future__ import annotations

import time
from typing import Any, Final

import numpy as np

import clrt

from ..oracle64 import trace64
from ..proofs import SOLIDS
from .figures import Figure, Tell, listed

BAND: Final = 64 * 2.0**-24
SCALES: Final = (1e-4, 1.0, 1e5)
DISTANCES: Final = (0.0, 10.0)
# Angles around a ray and shares of the band: where it may be as well. The first four settle nearly all rays;
# near an edge or an apex a hit of the band can lie between them.
_BESIDE: Final = [(np.pi / 2 * k, 1.0) for k in range(4)] + [
    (np.pi / 8 * k, share) for share in (1.0, 0.5, 0.25) for k in range(16)
]
_BATCH: Final = 1 << 18


def run(count: int, tell: Tell, device: int | str | None = None, band: float = BAND) -> Figure:
    """`count` rays over all solids, scales and distances from the origin."""
    start = time.perf_counter()
    places = [(name, scale, far) for name in SOLIDS for scale in SCALES for far in DISTANCES]
    share = -(-count // len(places))
    tried = wrong = 0
    where: list[str] = []
    for number, (name, scale, far) in enumerate(places):
        tracer, corners = clrt.Tracer(_scene(name, scale, far), device), _corners(name, scale, far)
        for first in range(0, share, _BATCH):
            n = min(_BATCH, share - first)
            rays = _rays(number + 1000 * first, n, scale, far)
            found = int(errors(tracer, *rays, band, *corners).sum())
            if found:
                where.append(f"{name}, scale {scale:g}, {far:g} away")
            wrong += found
            tried += n
            tell(tried / (share * len(places)))
    detail = f"band {band * 2**24:g} x 2^-24 of the largest coordinate{listed(where)}"
    return Figure(tried, wrong, detail, time.perf_counter() - start)


def errors(
    tracer: clrt.Tracer,
    origins: np.ndarray,
    directions: np.ndarray,
    band: float,
    largest: float = 0.0,
    moved: np.ndarray | None = None,
) -> np.ndarray:
    """Which of n rays have a hit that no ray within the band has, (n,) bool.

    largest, moved: as `_corners` has them.
    """
    t = tracer.intersect(origins, directions).t.astype(np.float64)
    o, d = origins.astype(np.float64), directions.astype(np.float64)
    d /= np.linalg.norm(d, axis=1, keepdims=True)
    low = trace64(tracer.scene, o, d).t
    high = low.copy()
    ends = o + d * np.where(np.isfinite(t), t, 0)[:, None]
    reach = band * np.maximum(np.abs(o).max(axis=1), np.abs(ends).max(axis=1)).clip(min=largest)
    off = reach
    if moved is not None:  # off along the normal is more along a ray that grazes
        with np.errstate(divide="ignore"):
            off = np.maximum(reach, moved @ moved / np.abs(d @ moved))
    doubtful = np.flatnonzero(_outside(t, low, high, off))
    if len(doubtful) == 0:
        return np.zeros(len(t), bool)
    across = np.cross(d, np.eye(3)[np.abs(d).argmin(axis=1)])
    across /= np.linalg.norm(across, axis=1, keepdims=True)
    for angle, share in _BESIDE:
        left = doubtful[_outside(t[doubtful], low[doubtful], high[doubtful], off[doubtful])]
        if len(left) == 0:
            break
        side = np.cos(angle) * across[left] + np.sin(angle) * np.cross(d[left], across[left])
        shifted = trace64(tracer.scene, o[left] + side * (share * reach[left, None]), d[left]).t
        low[left], high[left] = np.minimum(low[left], shifted), np.maximum(high[left], shifted)
    out = np.zeros(len(t), bool)
    out[doubtful] = _outside(t[doubtful], low[doubtful], high[doubtful], off[doubtful])
    return out


def _outside(t: np.ndarray, low: np.ndarray, high: np.ndarray, off: np.ndarray) -> np.ndarray:
    return ~((t >= low - off) & (t <= high + off))


def needs(count: int, device: int | str | None = None) -> dict[str, float]:
    """For every solid the least band, in units of 2^-24, within powers of 2, that leaves no ray outside."""
    found = {}
    for number, name in enumerate(SOLIDS):
        units = 0.5
        for scale in SCALES:
            for far in DISTANCES:
                tracer = clrt.Tracer(_scene(name, scale, far), device)
                rays = _rays(number, count, scale, far)
                corners = _corners(name, scale, far)
                while errors(tracer, *rays, units * 2.0**-24, *corners).any():
                    units *= 2
        found[name] = units
    return found


def _center(scale: float, far: float) -> np.ndarray:
    return np.array([0.48, 0.6, 0.64]) * far * scale


def _scene(name: str, scale: float, far: float) -> clrt.Scene:
    keys: dict[str, Any] = SOLIDS[name]
    center = _center(scale, far).tolist()
    if name == "plane":
        return clrt.load_dict({"shapes": [{**keys, "point": center}]})
    return clrt.load_dict({"shapes": [{**keys, "transform": [{"scale": scale}, {"translate": center}]}]})


def _corners(name: str, scale: float, far: float) -> tuple[float, np.ndarray | None]:
    """The largest coordinate of a triangle's corners where `_scene` has it, and how a ray that leaves it is
    moved for its being thin, along its normal (3,); 0 and None for other solids."""
    if "vertices" not in SOLIDS[name]:
        return 0.0, None
    corners = np.array(SOLIDS[name]["vertices"], float) * scale
    one, two = corners[1:] - corners[0]
    longest, across = np.abs([one, two]).max(), np.cross(one, two)
    width = np.abs(across).max() / longest
    normal = across / np.linalg.norm(across)
    moved = normal * min(2.0**-23 * longest**2 / width, width)
    return float(np.abs(corners + _center(scale, far)).max()), moved


def _rays(seed: int, n: int, scale: float, far: float) -> tuple[np.ndarray, np.ndarray]:
    """From about the shape and in it, towards it or past it."""
    draw = np.random.default_rng(seed)
    o = draw.normal(size=(n, 3)) * draw.choice([0.3, 1.0, 5.0], size=(n, 1))
    aim = draw.normal(size=(n, 3)) * 0.6
    return (o * scale + _center(scale, far)).astype(np.float32), ((aim - o) * scale).astype(np.float32)
