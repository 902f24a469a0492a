"""The shapes a scene is made of (which side of each is outside: docs, "Rays, hits, normals")."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any

import numpy as np
from msgspec import Meta

from clrt.base.hints import Numbers, Rows
from clrt.base.places import At
from clrt.base.records import Record, Vector, float32, is_zero, single_of
from clrt.meshfiles.planar import FLATNESS, flaws, is_sound
from clrt.scene import transforms
from clrt.scene.materials import Material

Radius = Annotated[float, Meta(gt=0, description="a radius must be > 0")]
EndRadius = Annotated[float, Meta(ge=0, description="must be a radius >= 0")]
Length = Annotated[float, Meta(gt=0, description="must be a length > 0")]
if TYPE_CHECKING:
    Named = str | Material | Any
    Outline = Rows
    Clip = Rows
    Radii = Numbers
    Coefficients = Numbers
else:
    Named = Annotated[
        str | Material, Meta(description="must be the name of a material or a table of its keys")
    ]
    Outline = Annotated[
        tuple[Vector, ...], Meta(min_length=3, description="points must be 3 or more points")
    ]
    Clip = Annotated[tuple[Vector, Vector], Meta(description="clip must be 2 corners of 3 numbers")]
    Radii = Annotated[tuple[Radius, Radius, Radius], Meta(description="radii must be 3 numbers > 0")]
    Coefficients = Annotated[
        tuple[float, float, float, float, float, float, float, float, float, float],
        Meta(description="coefficients must be 10 numbers, A to J"),
    ]


class Shape(Record, frozen=True, kw_only=True, tag_field="type"):
    """What all shapes have. `material` is a name, a material, or None for the default material."""

    material: Named | None = None
    name: str | None = None

    @property
    def matrix(self) -> np.ndarray:
        """Object to world space, (4, 4) float64 for column vectors."""
        return np.eye(4)

    @property
    def primitives(self) -> int:
        """How many primitive numbers the shape takes."""
        return 1

    @property
    def is_open(self) -> bool:
        """Whether the shape is a finite surface that encloses nothing."""
        return False

    def check(self, at: At) -> None:
        if isinstance(self.material, Material):
            self.material.check(at.key("material"))


class FiniteShape(Shape, frozen=True, kw_only=True):
    transform: transforms.Transform | None = None

    @property
    def matrix(self) -> np.ndarray:
        return transforms.matrix_of(self.transform)

    def check(self, at: At) -> None:
        Shape.check(self, at)
        if self.transform is not None:
            transforms.check(self.transform, at.key("transform"))


class Sphere(FiniteShape, frozen=True, kw_only=True, tag="sphere"):
    center: Vector
    radius: Radius


class Plane(Shape, frozen=True, kw_only=True, tag="plane"):
    """The infinite plane through `point`; `normal` (any length but 0) points to its outside."""

    point: Vector
    normal: Vector

    def check(self, at: At) -> None:
        Shape.check(self, at)
        _direction(self.normal, at.key("normal"), "normal")


class Polygon(FiniteShape, frozen=True, kw_only=True, tag="polygon"):
    """A plane polygon of 3 or more points, concave or crossing itself (even-odd) as may be."""

    points: Outline

    @property
    def is_open(self) -> bool:
        return True

    def check(self, at: At) -> None:
        FiniteShape.check(self, at)
        if is_sound(self.points):
            return
        collinear, bent = flaws(float32(self.points)[None])
        if collinear[0]:
            raise at.key("points").error(
                self.points, "the points of a polygon must span an area, not lie on a line"
            )
        if bent[0]:
            raise at.key("points").error(
                self.points, f"the points of a polygon must lie in one plane, to {FLATNESS:g} of its size"
            )


class Quadric(FiniteShape, frozen=True, kw_only=True, tag="quadric"):
    """Ax^2 + By^2 + Cz^2 + 2Dxy + 2Eyz + 2Fxz + 2Gx + 2Hy + 2Iz + J = 0, outside where the form is positive.

    `clip` keeps what lies in the box between two corners, in the quadric's own coordinates.
    """

    coefficients: Coefficients
    clip: Clip | None = None

    @property
    def is_open(self) -> bool:
        return self.clip is not None

    def check(self, at: At) -> None:
        FiniteShape.check(self, at)
        if is_zero(self.coefficients[:9]):
            raise at.key("coefficients").error(
                self.coefficients, "one of the coefficients A to I must not be 0"
            )
        if self.clip is not None:
            low, high = self.clip
            _box(low, high, at.key("clip"))


class Ellipsoid(FiniteShape, frozen=True, kw_only=True, tag="ellipsoid"):
    center: Vector
    radii: Radii


class Cylinder(FiniteShape, frozen=True, kw_only=True, tag="cylinder"):
    """From `p0` to `p1`, closed by disks if `caps`."""

    p0: Vector
    p1: Vector
    radius: Radius
    caps: bool = False

    @property
    def primitives(self) -> int:
        return 3 if self.caps else 1

    @property
    def is_open(self) -> bool:
        return not self.caps

    def check(self, at: At) -> None:
        FiniteShape.check(self, at)
        _apart(self.p0, self.p1, at.key("p1"))


class Cone(FiniteShape, frozen=True, kw_only=True, tag="cone"):
    """A truncated cone, radius `r0` at `p0` and `r1` at `p1` (one may be 0), closed by disks if `caps`."""

    p0: Vector
    r0: EndRadius
    p1: Vector
    r1: EndRadius
    caps: bool = False

    @property
    def primitives(self) -> int:
        return 1 + ((self.r0 > 0) + (self.r1 > 0) if self.caps else 0)

    @property
    def is_open(self) -> bool:
        return not self.caps

    def check(self, at: At) -> None:
        FiniteShape.check(self, at)
        _apart(self.p0, self.p1, at.key("p1"))
        if is_zero((self.r0, self.r1)):
            raise at.key("r1").error(self.r1, "one of the radii r0 and r1 must be > 0")


class Paraboloid(FiniteShape, frozen=True, kw_only=True, tag="paraboloid"):
    """r^2 = 4 `focal` h for 0 <= h <= `height` along `axis` from `apex`; outside is away from the axis."""

    apex: Vector
    axis: Vector
    focal: Length
    height: Length

    @property
    def is_open(self) -> bool:
        return True

    def check(self, at: At) -> None:
        FiniteShape.check(self, at)
        _direction(self.axis, at.key("axis"), "axis")


class Disk(FiniteShape, frozen=True, kw_only=True, tag="disk"):
    center: Vector
    normal: Vector
    radius: Radius

    @property
    def is_open(self) -> bool:
        return True

    def check(self, at: At) -> None:
        FiniteShape.check(self, at)
        _direction(self.normal, at.key("normal"), "normal")


class Box(FiniteShape, frozen=True, kw_only=True, tag="box"):
    """The axis-parallel box between the corners `min` and `max`."""

    min: Vector
    max: Vector

    @property
    def primitives(self) -> int:
        return 6

    def check(self, at: At) -> None:
        FiniteShape.check(self, at)
        _box(self.min, self.max, at.key("max"))


def _direction(vector: Vector, at: At, noun: str) -> None:
    if is_zero(vector):
        raise at.error(vector, f"{noun} must not be zero")


def _apart(p0: Vector, p1: Vector, at: At) -> None:
    if all(single_of(a) == single_of(b) for a, b in zip(p0, p1, strict=True)):
        raise at.error(p1, "p1 must not be at p0")


def _box(low: Vector, high: Vector, at: At) -> None:
    for axis, least, most in zip("xyz", low, high, strict=True):
        if not single_of(least) < single_of(most):
            raise at.error(high, f"the second corner must be above the first on every axis; {axis} is not")
