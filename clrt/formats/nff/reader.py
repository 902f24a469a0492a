"""Eric Haines' Neutral File Format, as the Standard Procedural Databases (1987) write it."""

from __future__ import annotations

import math
from array import array
from collections.abc import Iterable, Iterator
from itertools import chain
from pathlib import Path
from typing import Any

import numpy as np

from clrt.base.collector import no_collections
from clrt.base.errors import SceneError, located
from clrt.base.limits import Limits
from clrt.base.records import cross
from clrt.formats.tokens import Tokens, build
from clrt.meshfiles.planar import same_turn
from clrt.scene.scene import Scene

_AXES = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)
_LAST = (0.0, 0.0, 0.0, 1.0)  # row of a transform
_INWARD = (-1.0, -1.0, -1.0, *(0.0,) * 6)  # coefficients of a sphere seen from within, but for its radius
_LARGEST = 1e15  # radius of what is seen from within: its square stands in the scene
_RAYS = 513
"""The published ray counts are of 513 x 513 rays through the pixel corners of a 512 x 512 picture."""


def load(path: Path, limits: Limits, conformance: str = "none") -> Scene:
    """The scene in an NFF file.

    `conformance = "spd"` sets what the published ray counts of the SPD hold under: 513 x 513 rays, no
    pruning, opaque surfaces seen from outside only (a file with patches, `pp`, is seen from both sides).
    """
    if conformance not in ("none", "spd"):
        raise SceneError(
            located(path.name, "conformance", f"{conformance!r} is not allowed; it is 'none' or 'spd'")
        )
    reader = _Reader(path, limits)
    with no_collections():
        reader.read()
    return build(reader.table(conformance), reader.lines, reader.shape_lines, path, limits)


class _Reader:
    """The state while reading: the material that holds, and what was found so far."""

    def __init__(self, path: Path, limits: Limits) -> None:
        self.tokens = Tokens(path, limits)
        self.lines: dict[str, int] = {}
        self.background: list[float] = [0.0, 0.0, 0.0]
        self.view: dict[str, Any] | None = None
        self.lights: list[dict[str, Any]] = []
        self.materials: dict[str, dict[str, Any]] = {}
        self.names: dict[tuple[float, ...], str] = {}  # of the materials, by their numbers
        self.material: str | None = None
        self.shapes: list[dict[str, Any]] = []
        self.shape_lines = array("Q")
        self.patches = False

    def read(self) -> None:
        entities = {
            "b": self._background,
            "v": self._view,
            "l": self._light,
            "f": self._fill,
            "s": self._sphere,
            "c": self._cone,
            "p": self._polygon,
            "pp": self._patch,
        }
        while self.tokens.peek() is not None:
            entities[self.tokens.expect(*entities)]()

    def table(self, conformance: str) -> dict[str, Any]:
        count = len(self.lights)
        level = math.sqrt(count) / (2 * count) if count else 0.0
        spd = conformance == "spd"
        table: dict[str, Any] = {
            "max_depth": 4,
            "conformance": conformance,
            "one_sided": "opaque" if spd and not self.patches else "none",
            "background": self.background,
            "ambient": level,
            "materials": self.materials,
            "lights": [{"intensity": level, **light} for light in self.lights],
            "shapes": _Tables(map(_joined, self.shapes)),
        }
        if self.view is not None:
            table["camera"] = self._camera(self.view, spd)
        return table

    def _camera(self, view: dict[str, Any], spd: bool) -> dict[str, Any]:
        """The angle spans the rows' centres, top to bottom; ours spans their outer edges."""
        width, height = (_RAYS, _RAYS) if spd else view["resolution"]
        gaps = _RAYS - 2 if spd else max(height - 1, 1)
        tangent = math.tan(math.radians(view["angle"] / 2)) * height / gaps
        return {
            "origin": view["from"],
            "target": view["at"],
            "up": view["up"],
            "fov": math.degrees(2 * math.atan(tangent)),
            "fov_axis": "vertical",
            "width": width,
            "height": height,
        }

    def _background(self) -> None:
        self.background = self.tokens.numbers(3, "the background colour")

    def _view(self) -> None:
        self.lines["camera"] = self.tokens.line
        view: dict[str, Any] = {}
        while len(view) < 6:
            wanted = [key for key in ("from", "at", "up", "angle", "hither", "resolution") if key not in view]
            key = self.tokens.expect(*wanted)
            if key in ("from", "at", "up"):
                view[key] = self.tokens.numbers(3, key)
            elif key == "resolution":
                view[key] = [self.tokens.side(key), self.tokens.side(key)]
            else:
                view[key] = self.tokens.number(key)
        if not 0 < view["angle"] < 180:
            raise self.tokens.error(
                f"angle {view['angle']:g} is not allowed; it must be between 0 and 180 degrees"
            )
        self.view = view

    def _light(self) -> None:
        self.lines[f"lights[{len(self.lights)}]"] = self.tokens.line
        light: dict[str, Any] = {"type": "point", "position": self.tokens.numbers(3, "a light's position")}
        if self.tokens.peek_same_line() is not None:
            light["intensity"] = self.tokens.numbers(3, "a light's colour")
        self.lights.append(light)

    def _fill(self) -> None:
        line = self.tokens.line
        *color, kd, ks, shine, transmission, ior = self.tokens.numbers(8, "a fill: r g b Kd Ks shine T ior")
        material = {
            "color": color,
            "diffuse": kd,
            "specular": ks,
            "reflection": ks,
            "shininess": shine,
            "transmission": transmission,
            "ior": ior or 1.0,
        }
        self.material = self.names.setdefault(
            (*color, kd, ks, shine, transmission, ior or 1.0), f"fill_{len(self.names) + 1}"
        )
        self.lines.setdefault(f"materials.{self.material}", line)
        self.materials[self.material] = material

    def _add(self, line: int, **shape: Any) -> None:
        self.shape_lines.append(line)
        self.shapes.append(shape | ({"material": self.material} if self.material else {}))

    def _add_inward(self, line: int, numbers: tuple[float, ...]) -> None:
        self.shape_lines.append(line)
        run = self._run("inward")
        if run is None or run[0] != len(numbers):
            run = array("d", [len(numbers)])
            self.shapes.append({"inward": run} | ({"material": self.material} if self.material else {}))
        run.extend(numbers)

    def _sphere(self) -> None:
        line = self.tokens.line
        *center, radius = self.tokens.numbers(4, "a sphere: x y z r")
        self._check_inward(radius)
        if radius < 0:  # its inside is the visible side, where our quadric's form is positive
            self._add_inward(line, (*center, radius * radius))
        else:
            self._add(line, type="sphere", center=center, radius=radius)

    def _cone(self) -> None:
        line = self.tokens.line
        *p0, r0 = self.tokens.numbers(4, "a cone's base: x y z r")
        *p1, r1 = self.tokens.numbers(4, "a cone's apex: x y z r")
        self._check_inward(min(r0, r1))
        if (r0 < 0 or r1 < 0) and r0 <= 0 and r1 <= 0 and p0 != p1:
            if math.isinf(math.dist(p0, p1)):
                raise self.tokens.error("its ends are too far apart: more than 1.8e308")
            self._add_inward(line, _cone_axes(p0, -r0, p1, -r1))
        elif r0 == r1:
            self._add(line, type="cylinder", p0=p0, p1=p1, radius=r0)
        else:
            self._add(line, type="cone", p0=p0, r0=r0, p1=p1, r1=r1)

    def _check_inward(self, radius: float) -> None:
        if radius < -_LARGEST:
            raise self.tokens.error(f"{radius:g} is not allowed; a radius must be from {-_LARGEST:g} on")

    def _polygon(self) -> None:
        line, count = self._corners()
        points = [self.tokens.numbers(3, "a polygon's point") for _ in range(count)]
        if not same_turn(points):
            points.reverse()
        run = self._run("polygons")
        if run is None:
            self._add(line, type="mesh", polygons=[points])
        else:
            run.append(points)

    def _patch(self) -> None:
        self.patches = True
        line, count = self._corners()
        corners = [self.tokens.numbers(6, "a patch's point and normal") for _ in range(count)]
        run = self._run("patches")
        if run is None:
            self._add(line, type="mesh", patches=[corners])
        else:
            run.append(corners)

    def _corners(self) -> tuple[int, int]:
        line, count = self.tokens.line, self.tokens.integer("the number of points")
        if count < 3:
            raise self.tokens.error(f"{count} points are not allowed; a polygon has 3 or more")
        return line, count

    def _run(self, kind: str) -> Any:
        """What is said of the shape before this one, if it is of the same kind and material."""
        last = self.shapes[-1] if self.shapes else {}
        return last.get(kind) if last.get("material") == self.material else None


def _joined(shape: dict[str, Any]) -> dict[str, Any]:
    """A run of polygons or patches as one mesh (one polygon stays one), any other shape as it is.

    Takes the run out of `shape`.
    """
    polygons, patches = shape.pop("polygons", None), shape.pop("patches", None)
    if polygons is not None and len(polygons) == 1:
        return shape | {"type": "polygon", "points": polygons[0]}
    outlines = polygons or patches
    if outlines is None:
        return shape
    lengths = [len(outline) for outline in outlines]
    corners = np.array([corner for outline in outlines for corner in outline])
    starts = np.concatenate(([0], np.cumsum(lengths)))
    shape["faces"] = [range(a, b) for a, b in zip(starts[:-1].tolist(), starts[1:].tolist(), strict=True)]
    shape["faces"] = [list(face) for face in shape["faces"]]
    shape["vertices"] = corners[:, :3]
    if patches is not None:
        shape["normals"] = corners[:, 3:]
    return shape


class _Tables(list[dict[str, Any]]):
    """Tables of shapes. What is seen from within is kept as runs of numbers, of which tables are made each
    time that they are asked for: all of them at once would take more memory than the file may."""

    def __iter__(self) -> Iterator[dict[str, Any]]:
        return chain.from_iterable(map(_apart, super().__iter__()))


def _apart(shape: dict[str, Any]) -> Iterable[dict[str, Any]]:
    """The quadrics of a run of spheres, or of open cones or cylinders, that have their outer sides within."""
    if "inward" not in shape:
        return (shape,)
    numbers, named = iter(shape["inward"]), {"material": shape["material"]} if "material" in shape else {}
    width = int(next(numbers))
    form = _inward_sphere if width == 4 else _inward_cone
    return ({"type": "quadric", **form(*row), **named} for row in zip(*[numbers] * width, strict=True))


def _inward_sphere(x: float, y: float, z: float, square: float) -> dict[str, Any]:
    return {"coefficients": (*_INWARD, square), "transform": [{"translate": (x, y, z)}]}


def _inward_cone(slope: float, r0: float, reach: float, height: float, *rows: float) -> dict[str, Any]:
    """-(x^2 + y^2 - (r0 + k z)^2) = 0, 0 <= z <= h."""
    low = -reach
    return {
        "coefficients": (-1.0, -1.0, slope**2, 0.0, 0.0, 0.0, 0.0, 0.0, slope * r0, r0**2),
        "clip": ((low, low, 0.0), (reach, reach, height)),
        "transform": (rows[:4], rows[4:8], rows[8:], _LAST),
    }


def _cone_axes(p0: list[float], r0: float, p1: list[float], r1: float) -> tuple[float, ...]:
    """Slope k, r0, what it reaches across, h and the rows of its axes: r0 + k z wide, 0 <= z <= h.

    There may be many: for three numbers numpy takes longer than Python.
    """
    height = math.dist(p0, p1)
    z = [(end - start) / height for start, end in zip(p0, p1, strict=True)]
    x = cross(z, _AXES[min(range(3), key=lambda axis: abs(z[axis]))])
    length = math.hypot(*x)
    x = x[0] / length, x[1] / length, x[2] / length
    rows = zip(x, cross(z, x), z, p0, strict=True)
    return (r1 - r0) / height, r0, 1.01 * max(r0, r1), height, *chain.from_iterable(rows)
