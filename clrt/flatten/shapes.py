"""Each shape of a scene as numbered primitives in world space, collected by kind.

One function a shape class turns it into what its primitives are made of (float64); the arrays of a kind are
then made for all its primitives at once. To add a shape: a function here, its entry in `_ADD`, and those in
the other tables of `clrt.flatten.entries`.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from clrt import layout
from clrt.base.errors import SceneError
from clrt.flatten import quadric
from clrt.flatten.mesh import (
    IDENTITY,
    fans,
    joined,
    mesh_triangles,
    mirrors,
    reversed_runs,
    starts,
    unit,
    world_normals,
    world_points,
)
from clrt.scene.scene import (
    Box,
    Cone,
    Cylinder,
    Disk,
    Ellipsoid,
    Mesh,
    Paraboloid,
    Plane,
    Polygon,
    Quadric,
    Scene,
    Shape,
    Sphere,
)
from clrt.scene.transforms import is_similarity

Point = Sequence[float] | np.ndarray
_MANY = 64  # primitives of a shape for which an array is faster than a list of rows

# corner i of a box is at its maximum on x, y, z where bit 0, 1, 2 of i is set; counter-clockwise from outside
_BOX_CORNERS = np.array([[i & 1, i >> 1 & 1, i >> 2] for i in range(8)])
_BOX_FACES = np.array([[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]])
_BOX_COUNTS = np.full(6, 4)


@dataclass
class Collected:
    """The primitives of a scene by kind, in the order of their numbers."""

    spheres: list[tuple[float, ...]] = field(default_factory=list)  # centre, radius
    planes: list[tuple[float, ...]] = field(default_factory=list)  # point, normal
    disks: list[tuple[float, ...]] = field(default_factory=list)  # centre, radius, normal
    triangles: list[np.ndarray] = field(default_factory=list)  # chunks of records
    corner_normals: list[np.ndarray] = field(default_factory=list)  # chunks (k, 4)
    normals: int = 0  # in `corner_normals`
    corners: list[np.ndarray] = field(default_factory=list)  # of polygons, chunks (k, 3)
    corner_counts: list[np.ndarray] = field(default_factory=list)  # chunks
    forms: list[quadric.Form] = field(default_factory=list)
    counts: dict[str, int] = field(default_factory=lambda: dict.fromkeys(layout.KINDS, 0))
    # (kind, index, shape, material), one a primitive; whole arrays of records for meshes
    rows: list[tuple[int, int, int, int]] = field(default_factory=list)
    chunks: list[np.ndarray] = field(default_factory=list)
    fanned: frozenset[int] = frozenset()  # numbers of meshes whose faces become triangles

    def number(self, kind: str, shape: int, material: int, count: int = 1) -> None:
        """Give the next `count` primitives, all of one kind, their numbers."""
        first = self.counts[kind]
        if count > _MANY:
            self._close_rows()
            chunk = np.zeros(count, layout.dtype("Primitive"))
            chunk["kind"], chunk["shape"], chunk["material"] = layout.KINDS[kind], shape, material
            chunk["index"] = np.arange(first, first + count)
            self.chunks.append(chunk)
            self.counts[kind] = first + count
            return
        self.counts[kind] = first + count
        self.rows += [(layout.KINDS[kind], index, shape, material) for index in range(first, first + count)]

    def number_all(self, kinds: np.ndarray, shape: int, material: int) -> None:
        """The same for a kind each."""
        self._close_rows()
        chunk = np.zeros(len(kinds), layout.dtype("Primitive"))
        chunk["kind"], chunk["shape"], chunk["material"] = kinds, shape, material
        found = np.bincount(kinds, minlength=len(layout.KINDS))
        for name, kind in layout.KINDS.items():
            count = int(found[kind])
            if count:
                chunk["index"][kinds == kind] = self.counts[name] + np.arange(count)
                self.counts[name] += count
        self.chunks.append(chunk)

    def primitives(self) -> np.ndarray:
        """All of them in the order of their numbers, dtype Primitive."""
        self._close_rows()
        return concatenated(self.chunks, np.zeros(0, layout.dtype("Primitive")))

    def _close_rows(self) -> None:
        if self.rows:
            self.chunks.append(np.array(self.rows, layout.dtype("Primitive")))
            self.rows.clear()


def concatenated(chunks: list[np.ndarray], empty: np.ndarray) -> np.ndarray:
    """The chunks in a row, `empty` if there are none; a single one is not copied."""
    return chunks[0] if len(chunks) == 1 else np.concatenate([empty, *chunks])


def pictured_meshes(scene: Scene) -> frozenset[int]:
    """The numbers of meshes with pictures and faces of more than three corners: these become triangles."""
    meshes = ((number, shape) for number, shape in enumerate(scene.shapes) if isinstance(shape, Mesh))
    shown = ((number, mesh) for number, mesh in meshes if scene.material_of(mesh).pictures)
    return frozenset(number for number, mesh in shown if isinstance(mesh.data().faces, tuple))


def collect(scene: Scene, materials: Sequence[int]) -> Collected:
    """All shapes of the scene, of materials of these numbers.

    Raises `SceneError` for a transform that leaves no primitive to be.
    """
    out = Collected(fanned=pictured_meshes(scene))
    for index, (shape, material) in enumerate(zip(scene.shapes, materials, strict=True)):
        _ADD[type(shape)](out, shape, index, material, _at(scene, index))
    return out


def _at(scene: Scene, index: int) -> str:
    return f"{scene.source}: shapes[{index}]" if scene.source else f"shapes[{index}]"


def _matrix(shape: Any) -> np.ndarray:
    return shape.matrix if shape.transform else IDENTITY


def _sphere(out: Collected, shape: Sphere, index: int, material: int, at: str) -> None:
    center, radius = shape.center, shape.radius
    if shape.transform:
        matrix = shape.matrix
        if not is_similarity(matrix):
            out.forms.append(quadric.ellipsoid(matrix, center, (radius, radius, radius)))
            out.number("QUADRIC", index, material)
            return
        center = tuple(matrix[:3, :3] @ center + matrix[:3, 3])
        radius *= _scale(matrix)
    out.spheres.append((*center, radius))
    out.number("SPHERE", index, material)


def _plane(out: Collected, shape: Plane, index: int, material: int, at: str) -> None:
    out.planes.append((*shape.point, *unit(shape.normal)))
    out.number("PLANE", index, material)


def _disk(out: Collected, shape: Disk, index: int, material: int, at: str) -> None:
    _add_disk(out, _matrix(shape), shape.center, shape.normal, shape.radius, index, material, at)


def _add_disk(
    out: Collected,
    matrix: np.ndarray,
    center: Point,
    normal: Point,
    radius: float,
    index: int,
    material: int,
    at: str,
) -> None:
    if matrix is not IDENTITY:
        if not is_similarity(matrix):
            raise SceneError(
                f"{at}.transform: would make a disk (or cap) an ellipse; use one scale for all axes"
            )
        center = matrix[:3, :3] @ center + matrix[:3, 3]
        normal = world_normals(np.array([unit(normal)]), matrix)[0]
        radius *= _scale(matrix)
    out.disks.append((*center, radius, *unit(normal)))
    out.number("DISK", index, material)


def _polygon(out: Collected, shape: Polygon, index: int, material: int, at: str) -> None:
    points = np.asarray(shape.points, np.float64)
    if shape.transform:
        matrix = shape.matrix
        points = world_points(points, matrix)
        if mirrors(matrix):
            points = points[[0, *range(len(points) - 1, 0, -1)]]
    out.corners.append(points)
    out.corner_counts.append(np.array([len(points)]))
    out.number("POLYGON", index, material)


def _box(out: Collected, shape: Box, index: int, material: int, at: str) -> None:
    matrix = _matrix(shape)
    # transformed once, so that faces share their corners to the bit
    corners = world_points(np.where(_BOX_CORNERS, shape.max, shape.min), matrix)
    faces = _BOX_FACES[:, [0, 3, 2, 1]] if mirrors(matrix) else _BOX_FACES
    out.corners.append(corners[faces].reshape(-1, 3).astype(np.float32))
    out.corner_counts.append(_BOX_COUNTS)
    out.number("POLYGON", index, material, 6)


def _mesh(out: Collected, shape: Mesh, index: int, material: int, at: str) -> None:
    data, matrix = shape.data(), _matrix(shape)
    indices, sizes = joined(data.faces)
    flat = data.normals is None and index not in out.fanned
    flat_polygons = (sizes > 3) if flat else np.zeros(len(sizes), bool)
    if isinstance(data.faces, np.ndarray) and data.faces.shape[1] == 3:
        triangles = data.faces
    elif flat:
        triangles = indices[starts(sizes)[~flat_polygons, None] + np.arange(3)]
    else:
        triangles = fans(indices, sizes)
    records, normals = mesh_triangles(data, matrix, triangles)
    if len(normals):
        records["normals"] += out.normals
        out.normals += len(normals)
    out.triangles.append(records)
    out.corner_normals.append(normals)
    if flat_polygons.any():
        corners = indices[np.repeat(flat_polygons, sizes)]
        counts = sizes[flat_polygons]
        if mirrors(matrix):
            corners = corners[reversed_runs(counts)]
        out.corners.append(world_points(data.vertices[corners], matrix))
        out.corner_counts.append(counts)
        kinds = np.where(flat_polygons, layout.KINDS["POLYGON"], layout.KINDS["TRIANGLE"])
        out.number_all(kinds, index, material)
    else:
        out.number("TRIANGLE", index, material, len(triangles))


def _quadric(out: Collected, shape: Quadric, index: int, material: int, at: str) -> None:
    out.forms.append(quadric.general(_matrix(shape), shape.coefficients, shape.clip))
    out.number("QUADRIC", index, material)


def _ellipsoid(out: Collected, shape: Ellipsoid, index: int, material: int, at: str) -> None:
    out.forms.append(quadric.ellipsoid(_matrix(shape), shape.center, shape.radii))
    out.number("QUADRIC", index, material)


def _paraboloid(out: Collected, shape: Paraboloid, index: int, material: int, at: str) -> None:
    form = quadric.paraboloid(_matrix(shape), shape.apex, shape.axis, shape.focal, shape.height)
    out.forms.append(form)
    out.number("QUADRIC", index, material)


def _cone(out: Collected, shape: Cone | Cylinder, index: int, material: int, at: str) -> None:
    matrix = _matrix(shape)
    r0, r1 = (shape.r0, shape.r1) if isinstance(shape, Cone) else (shape.radius, shape.radius)
    out.forms.append(quadric.cone(matrix, shape.p0, r0, shape.p1, r1))
    out.number("QUADRIC", index, material)
    if shape.caps:
        axis = np.subtract(shape.p1, shape.p0)
        for center, radius, normal in ((shape.p0, r0, -axis), (shape.p1, r1, axis)):
            if radius > 0:
                _add_disk(out, matrix, center, normal, radius, index, material, at)


def _scale(matrix: np.ndarray) -> float:
    """How much a similarity scales."""
    return float(np.cbrt(abs(np.linalg.det(matrix[:3, :3]))))


Adder = Callable[[Collected, Any, int, int, str], None]
_ADD: dict[type[Shape], Adder] = {
    Sphere: _sphere,
    Plane: _plane,
    Disk: _disk,
    Polygon: _polygon,
    Box: _box,
    Mesh: _mesh,
    Quadric: _quadric,
    Ellipsoid: _ellipsoid,
    Paraboloid: _paraboloid,
    Cylinder: _cone,
    Cone: _cone,
}
