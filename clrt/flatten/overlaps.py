"""Media that overlap though neither has the higher priority: found by points of their surfaces, and told."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import cache
from typing import Any, Final

import numpy as np

from clrt.base import notices
from clrt.flatten.inside import count_inside
from clrt.flatten.media import Media
from clrt.scene.mesh import Mesh
from clrt.scene.shapes import Box, Cone, Cylinder, Ellipsoid, Paraboloid, Shape, Sphere

_MOST_PAIRS: Final = 400  # looked at: this is a hint, and must not take long
_MOST_BOXES: Final = 1 << 22  # pairs of boxes compared to find them
_CHUNK: Final = 1 << 18  # of those at once
_MOST_FACES: Final = 1 << 23  # of meshes in the pairs looked at
_MOST_ANGLES: Final = 1 << 21  # points times faces of a mesh, likewise
_MARGIN: Final = 1e-5  # of the surface's size: what is nearer to the other's surface touches it
_ASIDE: Final = np.concatenate([np.zeros((1, 3)), np.eye(3), -np.eye(3)])


def warn_of_overlaps(media: Media, priority: np.ndarray) -> None:
    """Warn of the first two shapes of different media and one priority of which one pierces the other.

    priority: (n,), that of each of the shapes of `media`. Points of one surface that lie well inside the
    other shape and others well outside prove it; a small overlap may lie between the points.
    """
    faces = 0
    for a, b in _pairs(media, priority):
        one, other = media.bodies[a], media.bodies[b]
        faces += one.primitives + other.primitives
        if faces > _MOST_FACES:
            return
        if _passes_through(one, other) or _passes_through(other, one):
            first, second = sorted((int(media.shapes[a]), int(media.shapes[b])))
            text = (
                f"overlaps shapes[{second}], a medium of the same priority {priority[a]}: where both are, "
                "the one that a ray entered last counts; give one a higher priority"
            )
            notices.warn(media.source, f"shapes[{first}]", text)
            return


def _pairs(media: Media, priority: np.ndarray) -> Iterator[tuple[int, int]]:
    """Shapes of different media and one priority whose boxes meet, largest first; not all where many do."""
    if len(media.numbers) == 0 or (media.numbers == media.numbers[0]).all():
        return
    found = 0
    for a, b in candidates(media.low, media.high):
        meets = ((media.low[a] <= media.high[b]) & (media.high[a] >= media.low[b])).all(axis=1)
        meets &= (priority[a] == priority[b]) & (media.numbers[a] != media.numbers[b])
        for k in np.flatnonzero(meets)[: _MOST_PAIRS - found]:
            yield int(a[k]), int(b[k])
        found += int(np.count_nonzero(meets))
        if found >= _MOST_PAIRS:
            return


def candidates(low: np.ndarray, high: np.ndarray) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """Chunks of pairs a, b whose boxes meet along one axis, that on which fewest do; not all of very many.

    low, high: (n, 3).
    """
    n = len(low)
    sweeps = []
    for axis in range(3):
        order = np.argsort(low[:, axis], kind="stable")
        place = np.empty(n, np.int64)
        place[order] = np.arange(n)
        # the box that starts first sees the other
        behind = np.searchsorted(low[order, axis], high[:, axis], "right") - place - 1
        sweeps.append((np.maximum(behind, 0), place, order))
    behind, place, order = min(sweeps, key=lambda sweep: int(sweep[0].sum()))
    ends = np.minimum(np.cumsum(behind), _MOST_BOXES)
    for start in range(0, int(ends[-1]), _CHUNK):
        number = np.arange(start, min(start + _CHUNK, int(ends[-1])))
        a = np.searchsorted(ends, number, "right")
        yield a, order[place[a] + 1 + number - (ends[a - 1] * (a > 0))]


def _passes_through(surface: Shape, solid: Shape) -> bool:
    """Whether points of the surface lie well inside the solid and others well outside."""
    sample = POINTS.get(type(surface))
    if sample is None:
        return False
    matrix = surface.matrix
    points = np.asarray(sample(surface), np.float64) @ matrix[:3, :3].T + matrix[:3, 3]
    if isinstance(solid, Mesh):
        most = max(2, _MOST_ANGLES // (len(_ASIDE) * max(solid.primitives, 1)))
        points = points[:: -(-len(points) // most)]
    count = count_inside(solid, points)
    if count.all() or not count.any():  # most pairs
        return False
    aside = _MARGIN * np.ptp(points, axis=0).max() * _ASIDE
    count = count_inside(solid, (points[:, None] + aside).reshape(-1, 3)).reshape(len(points), -1)
    return bool((count > 0).all(axis=1).any() and (count == 0).all(axis=1).any())


@cache
def directions(n: int = 64) -> np.ndarray:
    """Spread over the unit sphere: (n, 3)."""
    z = (2 * np.arange(n) + 1) / n - 1
    angle = np.arange(n) * np.pi * (3 - np.sqrt(5))
    return np.column_stack([np.cos(angle) * np.sqrt(1 - z * z), np.sin(angle) * np.sqrt(1 - z * z), z])


def _of_box(shape: Box) -> np.ndarray:
    grid = np.stack(np.meshgrid(*[np.linspace(0, 1, 5)] * 3), axis=-1).reshape(-1, 3)
    grid = grid[((grid == 0) | (grid == 1)).any(axis=1)]
    return np.asarray(shape.min + grid * np.subtract(shape.max, shape.min))


def _of_cone(shape: Cone | Cylinder) -> np.ndarray:
    r0, r1 = (shape.r0, shape.r1) if isinstance(shape, Cone) else (shape.radius, shape.radius)
    along = np.array([0, 0, 0, 0.25, 0.5, 0.75, 1, 1, 1])
    radius = r0 + (r1 - r0) * along
    radius[[0, 8]], radius[[1, 7]] = 0, radius[[1, 7]] / 2
    return rings(shape.p0, np.subtract(shape.p1, shape.p0), along, radius)


def _of_paraboloid(shape: Paraboloid) -> np.ndarray:
    axis = np.asarray(shape.axis, np.float64) / np.linalg.norm(shape.axis)
    along = shape.height * np.array([0, 0.1, 0.3, 0.6, 1])
    return rings(shape.apex, axis, along, np.sqrt(4 * shape.focal * along))


def rings(
    start: Any, axis: np.ndarray, along: np.ndarray, radius: np.ndarray, around: int = 12
) -> np.ndarray:
    """Circles about start + along * axis, of so many points: one after the other, (n, 3)."""
    across = np.linalg.svd(axis[None])[2][1:]
    angle = np.arange(around) * 2 * np.pi / around
    circle = np.cos(angle)[:, None] * across[0] + np.sin(angle)[:, None] * across[1]
    return np.asarray(start + along[:, None, None] * axis + radius[:, None, None] * circle).reshape(-1, 3)


POINTS: Final[dict[type[Shape], Callable[[Any], np.ndarray]]] = {
    Sphere: lambda shape: shape.center + shape.radius * directions(),
    Ellipsoid: lambda shape: shape.center + np.multiply(shape.radii, directions()),
    Box: _of_box,
    Cone: _of_cone,
    Cylinder: _of_cone,
    Paraboloid: _of_paraboloid,
    Mesh: lambda shape: shape.data().vertices[:: 1 + len(shape.data().vertices) // 256],
}
