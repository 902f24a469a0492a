"""How often a mesh winds around points, in float64.

The sum of its triangles' solid angles says so, in time of points times triangles. A closed mesh has one
number wherever none of its faces lies between: the sum is asked at one point, and on the way from there to
another the faces that are crossed change it by one each. Boxes of points are halved until few faces are
within. Where a way passes an edge or ends on a face to within rounding, the sum itself decides, as it does of
open meshes, whose number is a whole one nowhere.
"""

from __future__ import annotations

from typing import Final

import numpy as np

_PAIRS: Final = 1 << 20  # points times triangles whose angles are taken at once
_FEW: Final = 64  # points below which it is not asked whether a mesh is closed
_CROSSED: Final = 1 << 17  # points times triangles of which is asked at once who crosses whom
_ROUNDED: Final = 1e-12  # of a volume: thousands of roundings
_SHRINKS: Final = 0.25  # how far from a half's middle its start lies, of the way to one of the whole
_SEED: Final = 5


def winding_numbers(vertices: np.ndarray, triangles: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Of vertices (v, 3) and triangles (t, 3) of their numbers: (n,) float64 for finite points (n, 3)."""
    corners = vertices[triangles]
    if len(points) <= _FEW or not _closes(vertices, triangles):
        return _summed(corners, points)
    low, high = corners.min(axis=1), corners.max(axis=1)
    random, out = np.random.default_rng(_SEED), np.empty(len(points))
    # a start off all points: in their plane, or on their line, many ways could pass along edges
    size = max(float(np.ptp(points, axis=0).max()), float(np.ptp(vertices, axis=0).max()))
    start = points.mean(axis=0) + _SHRINKS * size * random.uniform(-1, 1, 3)
    number = float(_summed(corners, start[None])[0])
    waiting = [(np.arange(len(points)), np.arange(len(corners)), start, number)]
    while waiting:
        which, faces, start, number = waiting.pop()
        some = points[which]
        least, most = np.minimum(some.min(axis=0), start), np.maximum(some.max(axis=0), start)
        faces = faces[((low[faces] <= most) & (high[faces] >= least)).all(axis=1)]
        if len(which) * len(faces) <= _CROSSED or len(which) == 1:
            out[which] = number + _crossed(start, some, corners[faces])
            continue
        order = np.argsort(some[:, np.argmax(np.ptp(some, axis=0))])
        for half in np.array_split(order, 2):
            middle = some[half].mean(axis=0)
            there = middle + _SHRINKS * (random.uniform(least, most) - middle)
            value = number + _crossed(start, there[None], corners[faces])
            if np.isnan(value[0]):
                value = _summed(corners, there[None])
            waiting.append((which[half], faces, there, float(value[0])))
    unsure = np.isnan(out)
    out[unsure] = _summed(corners, points[unsure])
    return out


def _summed(corners: np.ndarray, points: np.ndarray) -> np.ndarray:
    """The sum of the solid angles of triangles (t, 3, 3), in turns, rounded: (n,)."""
    out, step = np.empty(len(points)), max(1, _PAIRS // max(len(corners), 1))
    for first in range(0, len(points), step):
        seen = corners[None] - points[first : first + step, None, None]
        out[first : first + step] = _solid_angles(*np.moveaxis(seen, 2, 0)).sum(axis=1) / (4 * np.pi)
    return np.round(out)


def _solid_angles(a: np.ndarray, b: np.ndarray, c: np.ndarray) -> np.ndarray:
    """Of triangles (..., 3) seen from the origin, positive from behind (van Oosterom, Strackee 1983)."""

    def dot(u: np.ndarray, v: np.ndarray) -> np.ndarray:
        return np.asarray(np.einsum("...i,...i->...", u, v))

    la, lb, lc = (np.sqrt(dot(v, v)) for v in (a, b, c))
    volume = dot(a, np.cross(b, c))
    return 2 * np.arctan2(volume, la * lb * lc + dot(a, b) * lc + dot(b, c) * la + dot(c, a) * lb)


def _crossed(start: np.ndarray, points: np.ndarray, corners: np.ndarray) -> np.ndarray:
    """By how much the number at the points (n, 3) exceeds that at `start`; NaN where rounding decides."""
    a, b, c = np.moveaxis(corners - start, 1, 0)
    ways = points - start
    far, reach = np.linalg.norm(ways, axis=1)[:, None], np.linalg.norm(corners - start, axis=2).max(axis=1)
    normal, edge = np.cross(b - a, c - a), np.maximum(np.abs(b - a), np.abs(c - a)).max(axis=1)
    ahead = np.einsum("ij,ij->i", normal, a)  # of the plane along its normal
    near = _ROUNDED * (3 * edge**2) * (reach + far)
    beyond = ways @ normal.T - ahead
    behind, before = beyond < -near, beyond > near
    begins_behind, begins_before = ahead > near, ahead < -near
    aside = _ROUNDED * far * reach**2
    sides = [ways @ np.cross(*pair).T for pair in ((a, b), (b, c), (c, a))]
    left = [side > aside for side in sides]
    right = [side < -aside for side in sides]
    misses = (left[0] | left[1] | left[2]) & (right[0] | right[1] | right[2])
    misses |= (behind & begins_behind) | (before & begins_before)
    within = (left[0] & left[1] & left[2]) | (right[0] & right[1] & right[2])
    leaves, enters = within & begins_behind & before, within & begins_before & behind
    change = enters.sum(axis=1, dtype=np.float64) - leaves.sum(axis=1)
    change[~(misses | leaves | enters).all(axis=1)] = np.nan
    return change


def _closes(vertices: np.ndarray, triangles: np.ndarray) -> bool:
    """Whether every edge has one that runs the other way, between the same places."""
    if _pairs_up(triangles):
        return True
    _, place = np.unique(vertices, axis=0, return_inverse=True)
    return _pairs_up(place.reshape(-1)[triangles])


def _pairs_up(triangles: np.ndarray) -> bool:
    first, second = triangles.astype(np.int64), np.roll(triangles, -1, axis=1).astype(np.int64)
    apart = first != second
    forth, back = np.sort((first << 32 | second)[apart]), np.sort((second << 32 | first)[apart])
    return bool((forth == back).all())
