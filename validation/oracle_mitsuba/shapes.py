"""The shapes of a scene as Mitsuba's side reads them, with the defaults of docs/scene-files.md."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from . import meshfile, steps

Array = np.ndarray


@dataclass(frozen=True, eq=False)
class Shape:
    material: Any = None
    transform: Any = None

    @cached_property
    def matrix(self) -> Array:
        """Object to world (4, 4)."""
        return steps.matrix(self.transform)


@dataclass(frozen=True, eq=False)
class Sphere(Shape):
    center: Any = None
    radius: Any = None


@dataclass(frozen=True, eq=False)
class Plane(Shape):
    point: Any = None
    normal: Any = None


@dataclass(frozen=True, eq=False)
class Polygon(Shape):
    points: Any = None


@dataclass(frozen=True, eq=False)
class Quadric(Shape):
    coefficients: Any = None
    clip: Any = None


@dataclass(frozen=True, eq=False)
class Ellipsoid(Shape):
    center: Any = None
    radii: Any = None


@dataclass(frozen=True, eq=False)
class Cylinder(Shape):
    p0: Any = None
    p1: Any = None
    radius: Any = None
    caps: bool = False


@dataclass(frozen=True, eq=False)
class Cone(Shape):
    p0: Any = None
    r0: Any = None
    p1: Any = None
    r1: Any = None
    caps: bool = False


@dataclass(frozen=True, eq=False)
class Paraboloid(Shape):
    apex: Any = None
    axis: Any = None
    focal: Any = None
    height: Any = None


@dataclass(frozen=True, eq=False)
class Disk(Shape):
    center: Any = None
    normal: Any = None
    radius: Any = None


@dataclass(frozen=True, eq=False)
class Box(Shape):
    min: Any = None
    max: Any = None


@dataclass(frozen=True, eq=False)
class Mesh(Shape):
    vertices: Any = None
    faces: Any = None
    normals: Any = None
    uv: Any = None
    file: str | None = None
    smooth: bool | None = None
    folder: str | None = None
    part: int | None = None  # of its file

    def data(self) -> meshfile.Surface:
        return self._data

    @cached_property
    def _data(self) -> meshfile.Surface:
        if self.file is not None:
            return meshfile.read(Path(self.folder or ".") / self.file, self.smooth, self.part)
        return meshfile.given(self.vertices, self.faces, self.normals, self.smooth, self.uv)


SHAPES: dict[str, type[Shape]] = {
    "sphere": Sphere, "plane": Plane, "polygon": Polygon, "quadric": Quadric, "ellipsoid": Ellipsoid,
    "cylinder": Cylinder, "cone": Cone, "paraboloid": Paraboloid, "disk": Disk, "box": Box, "mesh": Mesh,
}  # fmt: skip
