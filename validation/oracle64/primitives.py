"""The shapes of a scene as numbered primitives.

A shape becomes batches whose `ids` count from 0 within the shape; `gather` renumbers them in scene order
and joins those of a kind. Numbering: one primitive for a sphere, plane, polygon, quadric, ellipsoid,
paraboloid or disk; a cylinder or cone is its side, then with caps the disks at p0 and p1 (none where the
radius is 0); a box is 6 quadrilaterals in the order -x +x -y +y -z +z; a mesh is its faces in order, a smooth
mesh each face's fan of triangles.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from clrt.scene import scene as clrt_scene

from .batch import Batch, merge
from .curved import Quadrics, Spheres
from .flat import Disks, Planes, Polygons, Triangles, newell_normal
from .vectors import Array, Ints, box_corners, perpendicular_axes, transform_normals, transform_points, unit

INFINITE = np.full(3, np.inf)
# corners of the sides -x +x -y +y -z +z, numbered as `box_corners` does, counter-clockwise from outside
BOX_SIDES = ((0, 4, 6, 2), (1, 3, 7, 5), (0, 1, 5, 4), (2, 6, 7, 3), (0, 2, 3, 1), (4, 5, 7, 6))


def gather(scene: clrt_scene.Scene) -> tuple[list[Batch], Ints]:
    """All primitives in batches of a kind, and the shape number of each primitive (p,)."""
    kinds: dict[Any, tuple[list[Batch], list[Ints]]] = {}
    counts: list[int] = []
    for shape in scene.shapes:
        batches = primitives_of(shape, bool(scene.material_of(shape).pictures))
        first = sum(counts)
        for batch in batches:
            key = (type(batch), batch.corners.shape[1] if isinstance(batch, Polygons) else 0)
            batch_list, id_list = kinds.setdefault(key, ([], []))
            batch_list.append(batch)
            id_list.append(first + batch.ids)
        counts.append(sum(len(batch.ids) for batch in batches))
    return [merge(*lists) for lists in kinds.values()], np.repeat(np.arange(len(counts)), counts)


def primitives_of(shape: Any, pictured: bool = False) -> list[Batch]:
    """The primitives of one shape, in world space; `pictured` meshes are triangles."""
    if pictured and isinstance(shape, clrt_scene.Mesh):
        return _mesh(shape, np.asarray(shape.matrix, float), True)
    return _BUILDERS[type(shape).__name__](shape, np.asarray(shape.matrix, float))


def _numbered(*batches: Batch) -> list[Batch]:
    """Batches of one primitive each, numbered in this order."""
    return [type(b)(**{**vars(b), "ids": np.array([i])}) for i, b in enumerate(batches)]


def _rows(*values: Any) -> list[Array]:
    """Each value as an array with one row."""
    return [np.asarray(value, float)[None] for value in values]


def _sphere(shape: Any, matrix: Array) -> list[Batch]:
    """A sphere; a quadric where its transform does more than move, turn and scale alike on all axes."""
    gram = matrix[:3, :3].T @ matrix[:3, :3]
    scale = np.sqrt(np.trace(gram) / 3)
    if np.max(np.abs(gram - scale**2 * np.eye(3))) > 1e-9 * scale**2:
        return [_stretched_sphere(shape.center, [shape.radius] * 3, matrix)]
    center, radius = transform_points(matrix, shape.center), shape.radius * scale
    return [Spheres(np.array([0]), *_rows(center - radius, center + radius, center, radius))]


def _ellipsoid(shape: Any, matrix: Array) -> list[Batch]:
    return [_stretched_sphere(shape.center, shape.radii, matrix)]


def _stretched_sphere(center: Any, radii: Any, matrix: Array) -> Quadrics:
    frame = matrix[:3, :3] @ np.diag(np.asarray(radii, float))
    position = transform_points(matrix, center)
    return _quadric_in(frame, position, np.eye(3), np.zeros(3), -1.0, -INFINITE, INFINITE, 1.0)


def _quadric_in(
    frame: Array, position: Array, form: Array, gradient: Array, constant: float,
    low: Array, high: Array, radius: float,
) -> Quadrics:  # fmt: skip
    """A quadric given in the frame with these axes (columns) and origin, within +-`radius` on each axis."""
    box_low, box_high = np.maximum(low, -radius), np.minimum(high, radius)
    box = [-INFINITE, INFINITE]
    if np.isfinite([box_low, box_high]).all():
        corners = position + box_corners(box_low, box_high) @ frame.T
        box = [corners.min(axis=0), corners.max(axis=0)]
    return Quadrics(
        np.array([0]), *_rows(*box, np.linalg.inv(frame), position, form, gradient, constant, low, high)
    )


def _quadric(shape: Any, matrix: Array) -> list[Batch]:
    """The general form, moved to its centre: there its terms are of the size of the surface."""
    a, b, c, d, e, f, g, h, i, constant = (float(x) for x in shape.coefficients)
    form = np.array([[a, d, f], [d, b, e], [f, e, c]])
    gradient = np.array([g, h, i])
    low, high = (-INFINITE, INFINITE) if shape.clip is None else np.asarray(shape.clip, float)
    center = -np.linalg.pinv(form, rcond=1e-9, hermitian=True) @ gradient
    moved_gradient = form @ center + gradient
    moved_constant = center @ (moved_gradient + gradient) + constant
    position = transform_points(matrix, center)
    args = (form, moved_gradient, moved_constant, low - center, high - center, np.inf)
    return [_quadric_in(matrix[:3, :3], position, *args)]


def _revolution(
    matrix: Array, origin: Any, axis: Array, height: float, a: float, b: float, c: float
) -> Quadrics:
    """The surface r^2 = a + b h + c h^2, 0 <= h <= height, round the unit vector `axis` from `origin`."""
    frame = matrix[:3, :3] @ perpendicular_axes(axis)
    form, gradient = np.diag([1.0, 1.0, -c]), np.array([0.0, 0.0, -b / 2])
    ends = [a, a + height * (b + c * height)]  # r^2 has its largest value at an end: c >= 0
    low, high = np.array([-np.inf, -np.inf, 0.0]), np.array([np.inf, np.inf, height])
    radius = max(*np.sqrt(np.maximum(ends, 0.0)), height)
    return _quadric_in(frame, transform_points(matrix, origin), form, gradient, -a, low, high, radius)


def _cone(shape: Any, matrix: Array) -> list[Batch]:
    p0, p1 = np.asarray(shape.p0, float), np.asarray(shape.p1, float)
    r0, r1 = (shape.r0, shape.r1) if hasattr(shape, "r0") else (shape.radius, shape.radius)
    height = float(np.linalg.norm(p1 - p0))
    axis, slope = (p1 - p0) / height, abs(r1 - r0) / height
    # h counts from the narrow end, so that an apex is the frame's origin: rays through it have a double root,
    # which rounding would split or lose anywhere else
    narrow, r, up = (p0, r0, axis) if r0 <= r1 else (p1, r1, -axis)
    parts: list[Batch] = [_revolution(matrix, narrow, up, height, r * r, 2 * r * slope, slope * slope)]
    if shape.caps:
        parts += [_disk_in(matrix, p, n, r) for p, n, r in ((p0, -axis, r0), (p1, axis, r1)) if r > 0]
    return _numbered(*parts)


def _paraboloid(shape: Any, matrix: Array) -> list[Batch]:
    return [_revolution(matrix, shape.apex, unit(shape.axis), shape.height, 0.0, 4.0 * shape.focal, 0.0)]


def _disk(shape: Any, matrix: Array) -> list[Batch]:
    return [_disk_in(matrix, shape.center, unit(shape.normal), shape.radius)]


def _disk_in(matrix: Array, center: Any, normal: Array, radius: float) -> Disks:
    frame = matrix[:3, :3] * radius
    position = transform_points(matrix, center)
    corners = position + box_corners(-np.ones(3), np.ones(3)) @ frame.T
    world_normal = transform_normals(matrix, normal)
    box = (corners.min(axis=0), corners.max(axis=0))
    return Disks(np.array([0]), *_rows(*box, position, world_normal, np.linalg.inv(frame)))


def _plane(shape: Any, matrix: Array) -> list[Batch]:
    return [Planes(np.array([0]), *_rows(-INFINITE, INFINITE, shape.point, unit(shape.normal)))]


def _polygon(shape: Any, matrix: Array) -> list[Batch]:
    return [_polygons(np.asarray([shape.points], float), np.array([0]), matrix)]


def _box(shape: Any, matrix: Array) -> list[Batch]:
    corners = box_corners(np.asarray(shape.min, float), np.asarray(shape.max, float))
    return [_polygons(corners[np.array(BOX_SIDES)], np.arange(6), matrix)]


def _polygons(corners: Array, ids: Ints, matrix: Array) -> Polygons:
    """Polygons given in the frame of their shape (n, k, 3); Newell's normal there is the outer side."""
    normal = transform_normals(matrix, newell_normal(corners))
    corners = transform_points(matrix, corners)
    return Polygons(ids, corners.min(axis=1), corners.max(axis=1), corners[:, 0], normal, corners)


def _mesh(shape: Any, matrix: Array, pictured: bool = False) -> list[Batch]:
    mesh = shape.data()
    faces = [np.asarray(face, int) for face in mesh.faces]
    if mesh.normals is not None or pictured:
        faces = [face[[0, k, k + 1]] for face in faces for k in range(1, len(face) - 1)]
    batches: list[Batch] = []
    sizes = np.array([len(face) for face in faces], int)
    for size in np.unique(sizes):
        ids = np.flatnonzero(sizes == size)
        index = np.stack([faces[i] for i in ids])
        polygons = _polygons(np.asarray(mesh.vertices, float)[index], ids, matrix)
        batches.append(_triangles(polygons, index, mesh.normals, matrix) if size == 3 else polygons)
    return batches


def _triangles(flat: Polygons, index: Ints, normals: Any, matrix: Array) -> Triangles:
    corner_normals = np.zeros((*index.shape, 3))
    if normals is not None:
        corner_normals = transform_normals(matrix, np.asarray(normals, float)[index])
    smooth = np.full(len(index), normals is not None)
    return Triangles(**vars(flat), corner_normals=corner_normals, smooth=smooth)


_BUILDERS = {
    "Sphere": _sphere, "Plane": _plane, "Polygon": _polygon, "Mesh": _mesh, "Quadric": _quadric,
    "Ellipsoid": _ellipsoid, "Cylinder": _cone, "Cone": _cone, "Paraboloid": _paraboloid, "Disk": _disk,
    "Box": _box,
}  # fmt: skip
