"""Flat pieces of surfaces, as convex polygons in the world, and whether two shapes have one in common."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from itertools import islice
from typing import Any, Final

import numpy as np

from clrt.flatten.overlaps import candidates, rings
from clrt.scene.mesh import Mesh
from clrt.scene.shapes import Box, Cone, Cylinder, Disk, Plane, Polygon, Shape

PARALLEL: Final = 0.99
"""Cosine between two normals, from which on surfaces that meet are parallel."""
_CHUNKS: Final = 2  # of pairs whose boxes meet along an axis: this is a hint, and must not take long
_FEW_PAIRS: Final = 64  # for which it takes longer to look at the boxes
_MOST_PAIRS: Final = 1 << 14  # of polygons whose boxes meet, likewise
_AROUND: Final = 36  # corners of a circle
_SQUARE: Final = np.array([[0, 0], [1, 0], [1, 1], [0, 1]])
_SIDES: Final = np.array([np.insert(_SQUARE, axis, end, axis=1) for axis in range(3) for end in (0, 1)])
_SHARE: Final = 0.02  # of the narrower piece's width
_NONE: Final = np.zeros((0, 3, 3))


def have_common_piece(one: Shape, other: Shape, low: np.ndarray, high: np.ndarray, reach: float) -> bool:
    """Whether flat pieces of both lie in one plane to within `reach`, and one on the other.

    low, high: the box that both of their boxes have in common. Two pieces lie on one another where no edge
    of either has the other beyond it; what does not reach in by 0.02 of the narrower one's width only
    touches, as what keeps the gap of the warning's advice. Pieces that have 0.05 of the smaller one's area in
    common reach in by 0.025 of its width: of convex figures the area is between half of width times
    diameter and all of it.
    """
    a, b = (_near(pieces(shape, low, high), low - reach, high + reach) for shape in (one, other))
    if not len(a) or not len(b):
        return False
    return any(_lie_on(a[first], b[second], reach).any() for first, second in _pairs(a, b, reach))


def _pairs(a: np.ndarray, b: np.ndarray, reach: float) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """Numbers of polygons of a and b whose boxes meet, together; of very many those of the largest boxes."""
    if len(a) * len(b) <= _FEW_PAIRS:
        first, second = np.indices((len(a), len(b))).reshape(2, -1)
        yield first, second
        return
    low = np.concatenate([a.min(axis=1), b.min(axis=1)]) - reach
    high = np.concatenate([a.max(axis=1), b.max(axis=1)]) + reach
    order = np.argsort(-np.linalg.norm(high - low, axis=1))
    looked = 0
    for found in islice(candidates(low[order], high[order]), _CHUNKS):
        mine, theirs = order[found[0]], order[found[1]]
        first, second = np.minimum(mine, theirs), np.maximum(mine, theirs)
        pair = (first < len(a)) & (second >= len(a))
        first, second = first[pair], second[pair]
        meets = np.flatnonzero(((low[first] <= high[second]) & (high[first] >= low[second])).all(axis=1))
        meets = meets[: _MOST_PAIRS - looked]
        looked += len(meets)
        yield first[meets], second[meets] - len(a)


def pieces(shape: Shape, low: np.ndarray, high: np.ndarray) -> np.ndarray:
    """(n, k, 3) the flat pieces of the shape; of a plane what is about the box low, high, if that ends."""
    if isinstance(shape, Plane):
        return _of_plane(shape, low, high)
    if isinstance(shape, (Mesh, Polygon)):
        corners, exact = triangles_of(shape)
        return corners if exact else _NONE
    make = _PIECES.get(type(shape))
    return _NONE if make is None else moved(shape, make(shape))


def is_flat(shape: Shape) -> bool:
    """Whether its flat pieces are all of the shape."""
    if isinstance(shape, (Mesh, Polygon)):
        return triangles_of(shape)[1]
    return isinstance(shape, (Box, Disk, Plane))


def triangles_of(shape: Mesh | Polygon) -> tuple[np.ndarray, bool]:
    """(n, 3, 3) the corners of its triangles in the world, and whether these cover its faces and no more."""
    faces: tuple[np.ndarray, ...] | np.ndarray
    if isinstance(shape, Mesh):
        vertices, faces = shape.data().vertices, shape.data().faces
    else:
        vertices = np.array(shape.points, np.float64)
        faces = (np.arange(len(vertices)),)
    if isinstance(faces, np.ndarray):
        return moved(shape, vertices)[faces], True
    from clrt.meshfiles.outlines import Outlines

    outlines = Outlines()
    cut = outlines.triangles(vertices, faces)
    return moved(shape, vertices)[cut], not outlines.left_over


def moved(shape: Shape, points: np.ndarray) -> np.ndarray:
    """Points (..., 3) of the shape in the world."""
    matrix = shape.matrix
    return np.asarray(points @ matrix[:3, :3].T + matrix[:3, 3])


def place_of_flat(shape: Shape, point: Any, normal: Any) -> tuple[np.ndarray, np.ndarray]:
    """A point of a plane or disk, and its unit normal, in the world."""
    across = np.linalg.inv(shape.matrix[:3, :3]).T @ np.asarray(normal, np.float64)
    return moved(shape, np.asarray(point, np.float64)), across / np.linalg.norm(across)


def _of_plane(shape: Plane, low: np.ndarray, high: np.ndarray) -> np.ndarray:
    place, normal = place_of_flat(shape, shape.point, shape.normal)
    middle, size = (low + high) / 2, np.linalg.norm(high - low)
    if not np.isfinite(size):
        return _NONE
    middle = middle - ((middle - place) @ normal) * normal
    return np.asarray(middle + size * (2 * _SQUARE - 1) @ np.linalg.svd(normal[None])[2][1:])[None]


def _of_disk(shape: Disk) -> np.ndarray:
    axis = np.asarray(shape.normal, np.float64)
    return rings(shape.center, axis, np.zeros(1), np.array([shape.radius]), _AROUND)[None]


def _of_cone(shape: Cone | Cylinder) -> np.ndarray:
    """Its caps."""
    r0, r1 = (shape.r0, shape.r1) if isinstance(shape, Cone) else (shape.radius, shape.radius)
    ends = np.flatnonzero([r0, r1]) if shape.caps else np.zeros(0, int)
    axis = np.subtract(shape.p1, shape.p0)
    return rings(shape.p0, axis, ends, np.array([r0, r1])[ends], _AROUND).reshape(-1, _AROUND, 3)


def _near(corners: np.ndarray, low: np.ndarray, high: np.ndarray) -> np.ndarray:
    """Those that span an area, and may reach into the box."""
    near = ((corners.min(axis=1) <= high) & (corners.max(axis=1) >= low)).all(axis=1)
    corners = corners[near]
    return corners[np.linalg.norm(_across(corners), axis=1) > 0]


def _across(corners: np.ndarray) -> np.ndarray:
    """Normals (m, 3) of convex polygons (m, k, 3), by a third of the way around and two."""
    third = corners.shape[1] // 3
    return np.cross(corners[:, third] - corners[:, 0], corners[:, 2 * third] - corners[:, 0])


def _lie_on(a: np.ndarray, b: np.ndarray, reach: float) -> np.ndarray:
    """Which of the convex polygons a (m, k, 3) lie on those of b (m, n, 3)."""
    normal_a, normal_b = (found / np.linalg.norm(found, axis=1)[:, None] for found in map(_across, (a, b)))
    flush = np.minimum(_away(a, b, normal_b), _away(b, a, normal_a)) <= reach
    flush &= np.abs(np.einsum("ij,ij->i", normal_a, normal_b)) > PARALLEL
    if not flush.any():  # most pairs
        return flush
    a, b, normal_a, normal_b = a[flush], b[flush], normal_a[flush], normal_b[flush]
    width = np.minimum(_within(a, a, normal_a), _within(b, b, normal_b))
    depth = np.minimum(_within(a, b, normal_a), _within(b, a, normal_b))
    return np.asarray(depth > np.maximum(_SHARE * width, 2 * reach))


def _away(a: np.ndarray, b: np.ndarray, normal: np.ndarray) -> np.ndarray:
    """How far corners of a lie off the planes of b, at most."""
    return np.asarray(np.abs(np.einsum("mkj,mj->mk", a - b[:, :1], normal)).max(axis=1))


def _within(a: np.ndarray, b: np.ndarray, normal: np.ndarray) -> np.ndarray:
    """How far b reaches inwards from the edges of a, at least: 0 or less where it only touches.

    a, b: (m, k, 3), (m, n, 3); normal: (m, 3) of a. Of a itself: its width.
    """
    inwards = np.cross(normal[:, None], np.roll(a, -1, axis=1) - a)
    inwards /= np.linalg.norm(inwards, axis=2)[:, :, None]
    from_edge = np.einsum("mkj,mnj->mkn", inwards, b) - np.einsum("mkj,mkj->mk", inwards, a)[:, :, None]
    return np.asarray(from_edge.max(axis=2).min(axis=1))


_PIECES: Final[dict[type[Shape], Callable[[Any], np.ndarray]]] = {
    Box: lambda shape: shape.min + _SIDES * np.subtract(shape.max, shape.min),
    Disk: _of_disk, Cone: _of_cone, Cylinder: _of_cone,
}  # fmt: skip
