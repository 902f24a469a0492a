"""Surfaces that lie on one that light passes: a ray that goes on from one of the two does not meet the other.

It begins a little behind the surface (docs/model.md, "Rays, hits, normals"), and so behind whatever lies
there, too: a floor under a block of glass that stands on it, the glass around a hollow that ends where the
glass ends. Flat pieces of both that lie on one another prove it, or points of one surface that lie on the
other, where both face one way; and it is told.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from itertools import islice
from typing import Any, Final

import numpy as np

from clrt.base import notices
from clrt.flatten.facets import PARALLEL, have_common_piece, is_flat, moved, place_of_flat, triangles_of
from clrt.flatten.inside import count_inside
from clrt.flatten.lightsurfaces import visible_lights
from clrt.flatten.overlaps import POINTS, directions, rings
from clrt.scene.arealights import DiskLight, RectangleLight
from clrt.scene.mesh import Mesh
from clrt.scene.scene import Scene
from clrt.scene.shapes import Cone, Cylinder, Disk, Paraboloid, Plane, Polygon, Quadric, Shape

Found = tuple[np.ndarray, np.ndarray]
_MOST_PAIRS: Final = 150  # looked at: this is a hint, and must not take long
_MOST_BOXES: Final = 1 << 22  # pairs of boxes compared to find them
_MOST_FACES: Final = 1 << 12  # of a mesh, or corners of a polygon, that is looked at
_MOST_TESTS: Final = 1 << 15  # of these in all the pairs, and of points with triangles about them at once
_TRIANGLES: Final = 64  # of a mesh, of which there are points
_WITHIN: Final = np.array([[1, 1, 1], [4, 1, 1], [1, 4, 1], [1, 1, 4]]) / [[3], [6], [6], [6]]
_ALONG: Final = (np.arange(40) + 0.5) / 40  # a cylinder or cone: heights of circles of points
_OFFSET: Final = 2e-6  # by which a ray starts behind a surface, of its coordinates; a little more
_ENOUGH: Final = 3  # points: bodies may touch in one


def warn_of_flush(scene: Scene, low: np.ndarray, high: np.ndarray, passes: np.ndarray) -> None:
    """Warn of the first two shapes that have a piece of surface in common, where light passes one of them.

    low, high: (n, 3) the shapes' boxes; passes: (n,) bool, of which of them it does.
    """
    faces = 0
    for a, b in islice(_pairs(low, high, passes), _MOST_PAIRS):
        one, other = scene.shapes[a], scene.shapes[b]
        if max(sizes := (_faces(one), _faces(other))) > _MOST_FACES:
            continue
        faces += sum(sizes)
        if faces > _MOST_TESTS:
            return
        if _meet(one, other, np.array([low[a], low[b]]), np.array([high[a], high[b]])):
            text = (
                f"lies with a piece of its surface on shapes[{b}]: a ray that passes one of the two does not "
                "meet the other; leave a gap of 0.0001 of their size, or let one reach as far into the other"
            )
            notices.warn(scene.source, f"shapes[{a}]", text)
            return


def warn_of_flush_lamps(scene: Scene, low: np.ndarray, high: np.ndarray) -> None:
    """Warn of the first flat lamp that is to be seen and lies in the surface of a shape, which may hide it.

    low, high: (n, 3) the shapes' boxes.
    """
    looked = 0
    for number, light in visible_lights(scene).items():
        if not isinstance(light, (RectangleLight, DiskLight)):
            continue
        points, normal = _points_of_lamp(light)
        reach = _OFFSET * np.abs(points).max(initial=0.0)
        near = ((points.min(axis=0) <= high + reach) & (points.max(axis=0) >= low - reach)).all(axis=1)
        for k in np.flatnonzero(near).tolist():
            looked += _faces(scene.shapes[k])
            if looked > _MOST_TESTS:
                return
            there, normals = _on(scene.shapes[k], points, reach)
            flush = there & (np.abs(normals @ normal) > PARALLEL)
            if flush.sum() >= _ENOUGH:
                text = (
                    f"lies in the surface of shapes[{k}], so either may be seen there; move it off by 0.001 "
                    "of its size, or let it be not visible"
                )
                notices.warn(scene.source, f"lights[{number}]", text)
                return


def _points_of_lamp(light: RectangleLight | DiskLight) -> Found:
    """Points (n, 3) of its surface, and its unit normal."""
    normal = np.asarray(light.normal, np.float64)
    normal = normal / np.linalg.norm(normal)
    if isinstance(light, RectangleLight):
        u, v = np.asarray(light.u, np.float64), np.asarray(light.v, np.float64)
    else:
        axis = np.eye(3)[np.argmin(np.abs(normal))]
        u = np.cross(normal, axis)
        u *= light.radius / np.linalg.norm(u)
        v = np.cross(normal, u)
    across = np.array([[0, 0], [0.6, 0.1], [-0.5, 0.4], [0.2, -0.6], [-0.3, -0.3], [0.1, 0.7]])
    return np.asarray(light.center, np.float64) + across @ np.stack([u, v]), normal


def _pairs(low: np.ndarray, high: np.ndarray, passes: np.ndarray) -> Iterator[tuple[int, int]]:
    """Two shapes whose boxes meet, the first of which light passes."""
    looked = 0
    for a in np.flatnonzero(passes).tolist():
        looked += len(low)
        if looked > _MOST_BOXES:
            return
        reach = _OFFSET * np.abs(np.where(np.isfinite(low[a]), low[a], 0.0)).max(initial=1.0)
        meets = ((low[a] <= high + reach) & (high[a] >= low - reach)).all(axis=1)
        for b in np.flatnonzero(meets).tolist():
            if b > a or (b < a and not passes[b]):
                yield a, b


def _faces(shape: Shape) -> int:
    """How many triangles a shape is looked at as; of one of very many at least that it is too many."""
    if isinstance(shape, Polygon):
        return len(shape.points)
    faces = shape.data().faces if isinstance(shape, Mesh) else ()
    return len(faces) if len(faces) > _MOST_FACES or isinstance(faces, np.ndarray) else sum(map(len, faces))


def _meet(one: Shape, other: Shape, low: np.ndarray, high: np.ndarray) -> bool:
    """Whether they have a piece of surface in common; low, high: (2, 3) their boxes.

    Of what is flat it is known; of what is curved points are asked.
    """
    both = low.max(axis=0), high.min(axis=0)
    reach = _OFFSET * np.abs(both).max()
    if np.isfinite(reach):
        if have_common_piece(one, other, *both, float(reach)):
            return True
        if is_flat(one) and is_flat(other):
            return False
    return _lies_on(one, other, low[1], high[1]) or _lies_on(other, one, low[0], high[0])


def _lies_on(surface: Shape, other: Shape, low: np.ndarray, high: np.ndarray) -> bool:
    """Whether several points of the surface lie on the other, which has that box and is parallel there."""
    points = _points_of(surface)
    reach = _OFFSET * np.abs(points).max(initial=0.0)
    points = points[((points >= low - reach) & (points <= high + reach)).all(axis=1)]
    if len(points) < _ENOUGH:
        return False
    here, normals = _on(surface, points, reach)
    there, others = _on(other, points, reach)
    cosine = np.abs(np.einsum("ij,ij->i", normals, others))
    return bool((here & there & (cosine > PARALLEL)).sum() >= _ENOUGH)


def _points_of(shape: Shape) -> np.ndarray:
    """Points of a surface, in the world."""
    if isinstance(shape, Mesh):
        corners = triangles_of(shape)[0]
        return np.asarray(_WITHIN @ corners[:: 1 + len(corners) // _TRIANGLES]).reshape(-1, 3)
    sample = POINTS.get(type(shape))
    if sample is None:
        return np.zeros((0, 3))
    points = np.asarray(sample(shape), np.float64)
    if isinstance(shape, (Cone, Cylinder)):  # of which a part of the length may lie on another's
        r0, r1 = (shape.r0, shape.r1) if isinstance(shape, Cone) else (shape.radius, shape.radius)
        side = rings(shape.p0, np.subtract(shape.p1, shape.p0), _ALONG, r0 + (r1 - r0) * _ALONG)
        points = np.concatenate([points, side])
    return moved(shape, points)


def _on(shape: Shape, points: np.ndarray, reach: float) -> Found:
    """Which points lie on its surface to within `reach`, and its normals there, of length 1 or 0."""
    return _ON.get(type(shape), _on_body)(shape, points, reach)


def _on_body(shape: Shape, points: np.ndarray, reach: float) -> Found:
    """By what is inside of it about each point: half of all where the surface is smooth.

    Where an open one has no cap it faces along an axis of its own.
    """
    around = directions()
    inside = count_inside(shape, (points[:, None] + reach * around).reshape(-1, 3)) > 0
    share = inside.reshape(len(points), -1)
    normals = np.where(share, -1.0, 1.0) @ around
    lengths = np.linalg.norm(normals, axis=1, keepdims=True)
    normals /= np.where(lengths > 0, lengths, 1.0)
    on = np.abs(share.mean(axis=1) - 0.5) < 0.2
    for axis in _axes(shape) if shape.is_open else ():
        on &= np.abs(normals @ axis) < PARALLEL
    return on, normals


def _axes(shape: Any) -> np.ndarray:
    """The normals of the planes in which an open shape ends, in the world, of length 1."""
    if isinstance(shape, Quadric):
        ends = np.eye(3)
    else:
        ends = np.array([shape.axis if isinstance(shape, Paraboloid) else np.subtract(shape.p1, shape.p0)])
    found = ends @ np.linalg.inv(shape.matrix[:3, :3])
    return np.asarray(found / np.linalg.norm(found, axis=1, keepdims=True))


def _on_plane(shape: Plane, points: np.ndarray, reach: float) -> Found:
    return _on_flat(shape, shape.point, shape.normal, points, reach)


def _on_disk(shape: Disk, points: np.ndarray, reach: float) -> Found:
    on, normals = _on_flat(shape, shape.center, shape.normal, points, reach)
    local = (points - shape.matrix[:3, 3]) @ np.linalg.inv(shape.matrix[:3, :3]).T
    return on & (np.linalg.norm(local - shape.center, axis=1) <= shape.radius), normals


def _on_flat(shape: Shape, corner: Any, normal: Any, points: np.ndarray, reach: float) -> Found:
    """As if it had no end."""
    place, across = place_of_flat(shape, corner, normal)
    return np.abs((points - place) @ across) <= reach, np.broadcast_to(across, points.shape)


def _on_faces(shape: Mesh | Polygon, points: np.ndarray, reach: float) -> Found:
    return _on_triangles(triangles_of(shape)[0], points, reach)


def _on_triangles(corners: np.ndarray, points: np.ndarray, reach: float) -> Found:
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    lengths = np.linalg.norm(normals, axis=1, keepdims=True)
    corners, normals = corners[lengths[:, 0] > 0], normals[lengths[:, 0] > 0]
    normals = normals / lengths[lengths > 0, None]
    away = normals @ points.T - np.einsum("ij,ij->i", normals, corners[:, 0])[:, None]
    near = np.abs(away) <= reach
    for axis in range(3):  # first, for faces of one plane are near to each point of it
        low, high = corners[:, :, axis].min(axis=1) - reach, corners[:, :, axis].max(axis=1) + reach
        near &= (points[:, axis] >= low[:, None]) & (points[:, axis] <= high[:, None])
    which, at = (found[:_MOST_TESTS] for found in np.nonzero(near))
    normal, within = normals[which], np.ones(len(which), bool)
    for k in range(3):
        start, end = corners[which, k], corners[which, (k + 1) % 3]
        turn = np.einsum("ij,ij->i", np.cross(end - start, points[at] - start), normal)
        within &= turn >= -reach * np.linalg.norm(end - start, axis=1)
    on, found = np.zeros(len(points), bool), np.zeros_like(points)
    on[at[within]], found[at[within]] = True, normal[within]
    return on, found


_ON: Final[dict[type[Shape], Callable[[Any, np.ndarray, float], Found]]] = {
    Plane: _on_plane, Disk: _on_disk, Polygon: _on_faces, Mesh: _on_faces,
}  # fmt: skip
