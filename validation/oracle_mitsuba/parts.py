"""The scene's shapes as what Mitsuba knows: unit spheres, cylinders, disks and rectangles under a matrix, and
meshes.

This reads the scene's own records and nothing that the renderer makes of them.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np

from . import endless, faces, forms, meshing
from .forms import Array, Form
from .meshing import Triangles
from .records import Scene
from .shapes import Box, Cone, Cylinder, Disk, Ellipsoid, Mesh, Paraboloid, Plane, Polygon, Quadric, Sphere

Kind = Literal["sphere", "cylinder", "disk", "rectangle", "mesh"]
CURVED_TRIANGLES = 1 << 20  # of all curved meshes of a scene together
CROWD, CROWD_SEGMENTS = 256, 12  # from how many spheres on they become meshes, and how coarse ones
ENCLOSING = 192  # segments of meshes around ellipsoids, cylinders and cones
APART = 1e-3  # of the radius: how far meshes around one surface lie from one another
TINY = 1e-3, 5e-3  # of the scene's size: coordinates are counted from what is so small, see `_ball`
NEAR = 20.0  # times the scene's size: where the middle part of a plane ends
GROWTH = 20.0  # of a plane's rings


@dataclass(frozen=True, eq=False)
class Part:
    """A shape of Mitsuba's that stands for the scene's shape number `owner`, or for a part of it.

    sphere: radius 1 about 0. cylinder: radius 1 about z from 0 to 1. disk: radius 1 in xy, rectangle: [-1,
    1]^2, both facing +z. All under `to_world` (4, 4) by whose inverse transpose normals go; `flip` turns them
    round. mesh: in world space; `smooth`: its normals are for shading, else they are the surface's own.
    `form`: the surface that a mesh or a rectangle approximates.
    """

    kind: Kind
    owner: int
    to_world: Array | None = None
    flip: bool = False
    mesh: Triangles | None = None
    smooth: bool = False
    form: Form | None = None

    def corners(self) -> Array:
        """Points (n, 3) around which the part lies."""
        if self.mesh is not None:
            return self.mesh.vertices
        assert self.to_world is not None
        z = {"sphere": (-1.0, 1.0), "cylinder": (0.0, 1.0)}.get(self.kind, (0.0,))
        box = np.array([(x, y, h, 1.0) for x in (-1, 1) for y in (-1, 1) for h in z])
        return np.asarray((box @ self.to_world.T)[:, :3])


@dataclass(frozen=True)
class Fineness:
    """How curved shapes are made: segments around, rows along a cone, cells along an axis of a quadric's
    grid.

    margin: how far meshes go beyond rims and clips. `forms`: whether hits are moved onto forms.
    """

    around: int
    rows: int
    cells: int
    margin: float
    forms: bool


POLISHED = Fineness(around=256, rows=1, cells=96, margin=0.02, forms=True)
"""For modes that move a hit from the mesh to the surface and drop what lies beyond its ends."""
EXACT = Fineness(around=768, rows=64, cells=192, margin=0.0, forms=False)
"""For modes that take the mesh as it is: within 1e-5 (quadrics: 2e-5) of the radius of curvature."""
SMALL = Fineness(around=256, rows=16, cells=96, margin=0.0, forms=False)
"""For files: within 8e-5."""


@dataclass(frozen=True, eq=False)
class Geometry:
    """A scene's parts, and the ball that holds all that is finite in it."""

    parts: tuple[Part, ...]
    center: Array  # that coordinates are counted from
    size: float  # the ball's radius
    fine: float  # how large what lies at `center` is


def geometry(scene: Scene, fineness: Fineness) -> Geometry:
    """The parts of a scene."""
    curved = sum(isinstance(shape, (Cone, Paraboloid, Quadric)) for shape in scene.shapes)
    if curved:
        most = int(np.sqrt(CURVED_TRIANGLES / curved))
        fineness = replace(
            fineness,
            around=min(fineness.around, max(48, most)),
            cells=min(fineness.cells, max(24, most // 4)),
        )
    finite = [part for number, shape in enumerate(scene.shapes) for part in _finite(number, shape, fineness)]
    finite = [part for part in finite if len(part.corners())]  # a mesh may have no faces
    center, size, fine = _ball(scene, finite)
    finite = list(_apart(finite))
    without_end: list[Part] = []
    for number, shape in enumerate(scene.shapes):
        if isinstance(shape, Plane):
            without_end += _plane(number, shape, center, size)
        elif isinstance(shape, Quadric) and is_endless(shape):
            without_end += _endless_quadric(number, shape, center, size)
    if fineness.forms and sum(_is_round(part) for part in finite) >= CROWD:
        finite = [_in_crowd(part) if _is_round(part) else part for part in finite]
    parts = sorted([*finite, *without_end], key=lambda part: part.owner)
    return Geometry(tuple(parts), center, size, fine)


def _apart(parts: list[Part]) -> Iterator[Part]:
    """The parts, of which no two meshes coincide: of two hits at once Mitsuba tells one, and one is lost.

    Meshes of cylinders in one another's extension would, for they go on beyond their ends.
    """
    before: Counter[bytes] = Counter()
    for part in parts:
        if part.form is None or part.mesh is None:
            yield part
            continue
        surface = (np.round(part.form.q / np.linalg.norm(part.form.q), 7) + 0.0).tobytes()  # no -0
        wider = 1 + APART * before[surface]
        before[surface] += 1
        to_world = np.linalg.inv(part.form.to_object)
        placed = to_world @ np.diag([wider, wider, 1.0, 1.0]) @ part.form.to_object
        yield part if wider == 1 else replace(part, mesh=faces.moved(part.mesh, placed))


def _ball(scene: Scene, parts: list[Part]) -> tuple[Array, float, float]:
    """Where coordinates are counted from, the ball's radius, and the size of what lies there.

    That is the ball's middle, but for scenes that have something tiny in them: float32 is coarse far from
    where it counts from, and a drop that is seen against a lamp 400 away would be as coarse as the lamp.
    Something smaller still is not what a picture shows, and all else would be the coarser for it: of the case
    "next to the camera" 0.1 % of the pixels would be wrong.
    """
    points = [part.corners() for part in parts]
    points += [np.array([shape.point]) for shape in scene.shapes if isinstance(shape, Plane)]
    if scene.camera is not None:
        points.append(np.array([scene.camera.origin, scene.camera.target]))
    if not points:
        return np.zeros(3), 1.0, 1.0
    center, size = _middle(np.concatenate(points))
    size = max(size, 1e-6)
    alone = parts if len(parts) < CROWD else []
    for at, extent in sorted((_middle(part.corners()) for part in alone), key=lambda found: found[1]):
        if TINY[0] < extent / size < TINY[1]:
            return at, size, extent
    return center, size, size


def _middle(points: Array) -> tuple[Array, float]:
    """Of points (n, 3) the middle of their box, and half its diagonal."""
    low, high = points.min(axis=0), points.max(axis=0)
    return (low + high) / 2, float(np.linalg.norm(high - low)) / 2


def _finite(number: int, shape: Any, fineness: Fineness) -> Iterator[Part]:
    """The parts of a shape; none of a plane, an endless quadric or a quadric without points."""
    matrix = shape.matrix
    if isinstance(shape, (Sphere, Ellipsoid)):
        radii = shape.radii if isinstance(shape, Ellipsoid) else (shape.radius,) * 3
        placed = np.diag([*radii, 1.0])
        placed[:3, 3] = shape.center
        yield _sphere(number, matrix @ placed, fineness)
    elif isinstance(shape, Disk):
        yield _disk(number, matrix, shape.center, shape.normal, shape.radius)
    elif isinstance(shape, Cylinder):
        axis = np.subtract(shape.p1, shape.p0)
        scale = np.diag([shape.radius, shape.radius, np.linalg.norm(axis), 1.0])
        to_world = matrix @ _frame(shape.p0, axis) @ scale
        yield _cylinder(number, to_world, fineness)
        yield from _caps(number, shape, shape.radius, shape.radius)
    elif isinstance(shape, Cone):
        axis = np.subtract(shape.p1, shape.p0)
        to_world = matrix @ _frame(shape.p0, axis) @ np.diag([1.0, 1.0, np.linalg.norm(axis), 1.0])
        yield _cone(number, shape.r0, shape.r1, to_world, fineness)
        yield from _caps(number, shape, shape.r0, shape.r1)
    elif isinstance(shape, Paraboloid):
        width = np.sqrt(4 * shape.focal * shape.height)
        to_world = matrix @ _frame(shape.apex, shape.axis) @ np.diag([width, width, shape.height, 1.0])
        mesh = meshing.paraboloid(fineness.around, fineness.margin)
        yield _curved(number, mesh, to_world, forms.paraboloid(to_world))
    elif isinstance(shape, Quadric):
        yield from _bounded_quadric(number, shape, fineness)
    elif isinstance(shape, (Polygon, Box, Mesh)):
        mesh, smooth = faces.triangles(shape)
        yield Part("mesh", number, mesh=mesh, smooth=smooth)


def _frame(origin: Any, axis: Any) -> Array:
    """A rotation that takes z to `axis` (any length), then a translation to `origin`."""
    z = np.asarray(axis, float) / np.linalg.norm(axis)
    x = np.eye(3)[np.argmin(np.abs(z))]
    x = np.cross(x, z)
    x /= np.linalg.norm(x)
    frame = np.eye(4)
    frame[:3, 0], frame[:3, 1], frame[:3, 2], frame[:3, 3] = x, np.cross(z, x), z, origin
    return frame


def _sphere(number: int, to_world: Array, fineness: Fineness, flip: bool = False) -> Part:
    """A round sphere is left to Mitsuba; an ellipsoid is a mesh, around it if hits are moved onto forms."""
    if _are_alike(to_world[:3, :3].T):
        return Part("sphere", number, to_world, flip=flip)
    segments = ENCLOSING if fineness.forms else fineness.around
    mesh = faces.moved(meshing.sphere(segments, around=fineness.forms), to_world)
    if flip:
        mesh = Triangles(mesh.vertices, mesh.faces[:, ::-1], -mesh.normals)
    return Part("mesh", number, mesh=mesh, form=forms.sphere(to_world, flip))


def _is_round(part: Part) -> bool:
    return part.kind == "sphere" and part.form is None and not part.flip


def _in_crowd(part: Part) -> Part:
    """A sphere as a coarse mesh: Mitsuba is slow with thousands of sphere plugins."""
    assert part.to_world is not None
    mesh = faces.moved(meshing.sphere(CROWD_SEGMENTS, around=True), part.to_world)
    return Part("mesh", part.owner, mesh=mesh, form=forms.sphere(part.to_world))


def _cylinder(number: int, to_world: Array, fineness: Fineness) -> Part:
    """A round cylinder is left to Mitsuba where hits are not moved onto forms."""
    x, y, z = to_world[:3, :3].T
    upright = max(abs(x @ z), abs(y @ z)) <= 1e-6 * np.linalg.norm(z) * np.linalg.norm(x)
    if not fineness.forms and upright and _are_alike(np.stack([x, y])):
        return Part("cylinder", number, to_world)
    return _cone(number, 1.0, 1.0, to_world, fineness)


def _cone(number: int, r0: float, r1: float, to_world: Array, fineness: Fineness) -> Part:
    segments = ENCLOSING if fineness.forms else 2 * fineness.around
    mesh = meshing.cone(r0, r1, segments, fineness.rows, fineness.margin)
    return _curved(number, mesh, to_world, forms.cone(r0, r1, to_world))


def _are_alike(vectors: Array) -> bool:
    """Whether vectors (k, 3) have one length and right angles between them."""
    product = vectors @ vectors.T
    square = np.trace(product) / len(product)
    return bool(np.abs(product - square * np.eye(len(product))).max() <= 1e-6 * square)


def _disk(number: int, matrix: Array, center: Any, normal: Any, radius: float) -> Part:
    return Part("disk", number, matrix @ _frame(center, normal) @ np.diag([radius, radius, 1.0, 1.0]))


def _caps(number: int, shape: Any, r0: float, r1: float) -> Iterator[Part]:
    axis = np.subtract(shape.p1, shape.p0)
    for center, normal, radius in ((shape.p0, -axis, r0), (shape.p1, axis, r1)):
        if shape.caps and radius > 0:
            yield _disk(number, shape.matrix, center, normal, radius)


def _curved(number: int, mesh: Triangles, to_world: Array, form: Form) -> Part:
    return Part("mesh", number, mesh=faces.moved(mesh, to_world), form=form)


def _plane(number: int, shape: Plane, center: Array, size: float) -> Iterator[Part]:
    """A rectangle about the scene, and rings of four around it, each GROWTH times as large.

    On a large one Mitsuba's float32 is coarse: a tilted one is hit by rays that pass 1e-5 of its size beside
    it, and such as reached from the scene to the horizon were hit by rays that start in it.
    """
    normal = np.asarray(shape.normal, float) / np.linalg.norm(shape.normal)
    foot = center - ((center - np.asarray(shape.point)) @ normal) * normal
    form = forms.plane(shape.point, shape.normal)
    near, end = NEAR * size, endless.FAR * size
    rectangles = [(0.0, 0.0, near, near)]
    while near < end:
        far = min(GROWTH * near, end)
        width, middle = (far - 0.99 * near) / 2, (far + 0.99 * near) / 2
        for side in (-1, 1):
            rectangles += [(side * middle, 0.0, width, far), (0.0, side * middle, near, width)]
        near = far
    for x, y, half_width, half_height in rectangles:
        placed = np.diag([half_width, half_height, 1.0, 1.0])
        placed[:2, 3] = x, y
        yield Part("rectangle", number, _frame(foot, normal) @ placed, form=form)


def is_endless(shape: Quadric) -> bool:
    """Whether a quadric has neither a clip nor an end of its own."""
    return shape.clip is None and forms.ellipsoid_frame(shape.coefficients) is None


def _bounded_quadric(number: int, shape: Quadric, fineness: Fineness) -> Iterator[Part]:
    frame = forms.ellipsoid_frame(shape.coefficients)
    if shape.clip is None:
        if frame is not None and frame[0].any():
            yield _sphere(number, shape.matrix @ frame[0], fineness, frame[1])
        return
    low, high = (np.asarray(corner, float) for corner in shape.clip)
    extra = fineness.margin * (high - low)
    axes = [np.linspace(a, b, fineness.cells + 1) for a, b in zip(low - extra, high + extra, strict=True)]
    form = forms.quadric(shape.coefficients, shape.clip, shape.matrix)
    mesh = meshing.quadric(forms.matrix(shape.coefficients), (axes[0], axes[1], axes[2]))
    if mesh is not None:
        yield _curved(number, mesh, shape.matrix, form)


def _endless_quadric(number: int, shape: Quadric, center: Array, size: float) -> Iterator[Part]:
    to_object = np.linalg.inv(shape.matrix)
    middle = to_object[:3, :3] @ center + to_object[:3, 3]
    extent = size * float(np.linalg.norm(to_object[:3, :3], 2))
    mesh = endless.surface(forms.matrix(shape.coefficients), middle, extent)
    if mesh is not None:
        yield _curved(number, mesh, shape.matrix, forms.quadric(shape.coefficients, None, shape.matrix))
