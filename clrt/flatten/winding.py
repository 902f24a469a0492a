"""How often a mesh winds around points, in float64.

The sum of its triangles' solid angles says so, in time of points times triangles. A closed mesh has one
number wherever none of its faces lies between: the sum is asked at one point, and on the way from there to
another the faces that are crossed change it by one each. Boxes of points are halved until few faces are
within. Where a way passes an edge or ends on a face to within rounding, the sum itself decides.

An open mesh is closed: places at its rim that are nearer to each other than the kernels' numbers tell are
one (the seam of a grid of angles, sin(2 pi) beside 0), and a fan about a point fills what is left. The solid
angles of the fan are then taken away again: of points times edges of the rim, which are few.
"""

from __future__ import annotations

import itertools
from typing import Final

import numpy as np

_PAIRS: Final = 1 << 20  # points times triangles whose angles are taken at once
_FEW: Final = 64  # points below which it is not asked whether a mesh is closed
_CROSSED: Final = 1 << 17  # points times triangles of which is asked at once who crosses whom
_ROUNDED: Final = 1e-12  # of a volume: thousands of roundings
_SHRINKS: Final = 0.25  # how far from a half's middle its start lies, of the way to one of the whole
_NEAR: Final = 2.0**-22  # of a mesh's size: as float32 has it; nearer places at its rim are one
_SEED: Final = 5


def winding_numbers(vertices: np.ndarray, triangles: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Of vertices (v, 3), triangles (t, 3) of their numbers: (n,) whole float64 of finite points (n, 3)."""
    corners = vertices[triangles]
    if len(points) <= _FEW:
        return _summed(corners, points)
    whole, fan = _closed(vertices, triangles)
    if 2 * len(fan) > len(corners):
        return _summed(corners, points)
    out = _of_closed(whole, points)
    if len(fan):
        out = np.round(out - _angles(fan, points))
    unsure = np.isnan(out)
    out[unsure] = _summed(corners, points[unsure])
    return out


def is_open(vertices: np.ndarray, triangles: np.ndarray) -> bool:
    """Whether an edge of a mesh has none that runs the other way; places that are one to float32 are one."""
    return len(_closed(vertices, triangles)[1]) > 0


def _closed(vertices: np.ndarray, triangles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """A mesh closed by a fan, and the fan: triangles (t + k, 3, 3) and (k, 3, 3); of a closed one none."""
    rim = _rim(triangles)
    if len(rim):
        vertices, place = np.unique(vertices, axis=0, return_inverse=True)
        triangles = place.reshape(-1)[triangles]
        rim = _rim(triangles)
    if len(rim):
        at, near = np.unique(rim), np.ptp(vertices, axis=0).max() * _NEAR
        for shift in itertools.product((0.0, 0.5), repeat=3):  # some grid has any two near ones in one cell
            cells = np.floor(vertices[at] / near + shift)
            _, first, cell = np.unique(cells, axis=0, return_index=True, return_inverse=True)
            vertices[at] = vertices[at[first[cell.reshape(-1)]]]
        vertices, place = np.unique(vertices, axis=0, return_inverse=True)
        triangles = place.reshape(-1)[triangles]
        rim = _rim(triangles)
    corners = vertices[triangles]
    fan = np.empty((len(rim), 3, 3))
    if len(rim):
        fan[:, 0], fan[:, 1] = vertices[rim[:, 1]], vertices[rim[:, 0]]
        fan[:, 2] = vertices[np.unique(rim)].mean(axis=0)
    return np.concatenate([corners, fan]), fan


def _rim(triangles: np.ndarray) -> np.ndarray:
    """Edges (k, 2) that no other runs along the other way, as often as there are more of them."""
    first, second = triangles.astype(np.int64), np.roll(triangles, -1, axis=1).astype(np.int64)
    apart = first != second
    first, second = first[apart], second[apart]
    edges, which = np.unique(np.minimum(first, second) << 32 | np.maximum(first, second), return_inverse=True)
    more = np.bincount(which, np.where(first < second, 1, -1), len(edges)).astype(np.int64)
    ends = np.repeat(np.stack([edges >> 32, edges & 0xFFFFFFFF], axis=1), np.abs(more), axis=0)
    back = np.repeat(more, np.abs(more)) < 0
    return np.where(back[:, None], ends[:, ::-1], ends)


def _of_closed(corners: np.ndarray, points: np.ndarray) -> np.ndarray:
    """`winding_numbers` of triangles (t, 3, 3) each of whose edges another runs along the other way.

    NaN where rounding decides.
    """
    low, high = corners.min(axis=1), corners.max(axis=1)
    random, out = np.random.default_rng(_SEED), np.empty(len(points))
    # a start off all points: in their plane, or on their line, many ways could pass along edges
    size = max(float(np.ptp(points, axis=0).max()), float((high.max(axis=0) - low.min(axis=0)).max()))
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
    return out


def _summed(corners: np.ndarray, points: np.ndarray) -> np.ndarray:
    """The sum of the solid angles of triangles (t, 3, 3), in turns, rounded: (n,)."""
    return np.round(_angles(corners, points))


def _angles(corners: np.ndarray, points: np.ndarray) -> np.ndarray:
    """The sum of the solid angles of triangles (t, 3, 3), in turns: (n,)."""
    out, step = np.empty(len(points)), max(1, _PAIRS // max(len(corners), 1))
    for first in range(0, len(points), step):
        seen = corners[None] - points[first : first + step, None, None]
        out[first : first + step] = _solid_angles(*np.moveaxis(seen, 2, 0)).sum(axis=1) / (4 * np.pi)
    return out


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
