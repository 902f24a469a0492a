"""Where surfaces lie in pictures: for each primitive of a shape how its u and v follow from a point.

A row is four numbers: `row.xyz . p + row.w` of a point of the world (or of an outward normal). In object
space they are as docs/model.md has them ("Images"); transforms go in here, in float64, rounded once.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, Final

import numpy as np

from clrt import layout
from clrt.base.hints import Numbers
from clrt.flatten.mesh import fanned, mirrors, unit
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

Row = tuple[Sequence[float] | np.ndarray, float]
"""In object space: factors of x, y, z, and what is added."""
_AXES: Final = np.eye(3)


def mappings(scene: Scene, primitives: np.ndarray, pictured: np.ndarray) -> dict[str, np.ndarray]:
    """The sections `mappings`, `mapping_of` and `corner_uv`.

    primitives: records; pictured: of each material whether it shows a picture.
    """
    of = np.full(len(primitives), -1, np.int32)
    found: dict[bytes, int] = {}
    corners: list[np.ndarray] = [np.zeros((0, 2, 4), np.float32)]
    count = 0
    wanted = np.flatnonzero(pictured[primitives["material"]] & (primitives["shape"] < len(scene.shapes)))
    shapes, first = np.unique(primitives["shape"][wanted], return_index=True)
    for index, start in zip(shapes.tolist(), wanted[first].tolist(), strict=True):
        shape = scene.shapes[index]
        if isinstance(shape, Mesh):
            own = _corner_uv(shape)
            record = _record("MAP_MESH", _AXES)
            record["corners"] = count - int(primitives["index"][start])
            corners.append(own)
            count += len(own)
            of[start : start + len(own)] = found.setdefault(record.tobytes(), len(found))
            continue
        if type(shape) is Sphere and not shape.transform:  # of which there may be a million
            of[start] = found.setdefault(_UPRIGHT, len(found))
            continue
        make = _MAP[type(shape)]
        assert make is not None
        for place, record in enumerate(make(shape), start):
            of[place] = found.setdefault(record.tobytes(), len(found))
    records = np.frombuffer(b"".join(found), layout.dtype("Mapping")).copy()
    return {"mappings": records, "mapping_of": of, "corner_uv": np.concatenate(corners).reshape(-1, 4)}


def _corner_uv(shape: Mesh) -> np.ndarray:
    """(n, 2, 4) float32: u and v of the three corners of each triangle, and two numbers that are 0."""
    data, matrix = shape.data(), shape.matrix
    assert data.uv is not None, "the scene refuses pictures on a mesh without uv"
    triangles = fanned(data.faces)
    order = [0, 2, 1] if mirrors(matrix) else [0, 1, 2]
    out = np.zeros((len(triangles), 8), np.float32)
    out[:, :6] = data.uv[triangles[:, order]].reshape(-1, 6)
    return out.reshape(-1, 2, 4)


def _record(kind: str, matrix: np.ndarray, *rows: Row) -> np.ndarray:
    """A mapping whose rows are those of object space, seen through the shape's matrix."""
    out = np.zeros(1, layout.dtype("Mapping"))
    out["kind"] = layout.MAPPINGS[kind]
    inverse = np.linalg.inv(matrix)
    for name, (factors, rest) in zip(("row_u", "row_v", "row_w"), rows, strict=False):
        own = np.array([*factors, rest], np.float64)
        out[name] = own @ inverse if len(matrix) == 4 else own
    return out


def _from(origin: Any, way: np.ndarray, offset: float = 0.0) -> Row:
    """The row of way . (p - origin) + offset."""
    return way, offset - float(np.dot(way, np.asarray(origin, np.float64)))


def _by_normal(shape: Sphere | Quadric) -> list[np.ndarray]:
    # a plane's normal of object space is that of the world times the matrix, from the left
    columns = shape.matrix[:3, :3].T
    record = _record("MAP_NORMAL", _AXES, *((column, 0.0) for column in columns))
    record["quadric"] = type(shape) is Quadric
    return [record]


def _sphere(shape: Sphere) -> list[np.ndarray]:
    if shape.transform and not is_similarity(shape.matrix):
        return _round(shape, shape.center, (shape.radius,) * 3)
    return _by_normal(shape)


def _ellipsoid(shape: Ellipsoid) -> list[np.ndarray]:
    return _round(shape, shape.center, shape.radii)


def _round(shape: Sphere | Ellipsoid, center: Any, radii: Numbers) -> list[np.ndarray]:
    rows = [_from(center, axis / radius) for axis, radius in zip(_AXES, radii, strict=True)]
    return [_record("MAP_SPHERE", shape.matrix, *rows)]


def in_plane(normal: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The axes of a flat pattern: U along the coordinate axis closest to the plane, V = n x U."""
    axis = _AXES[int(np.argmin(np.abs(normal)))]
    u = unit(axis - float(axis @ normal) * normal)
    return u, np.cross(normal, u)


def about(axis: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Duff's frame about a unit vector, as in kernels/frame.clh."""
    x, y, z = axis
    sign = -1.0 if z < 0 else 1.0
    a = -1.0 / (sign + z)
    b = x * y * a
    return np.array([1.0 + sign * x * x * a, sign * b, -sign * x]), np.array([b, sign + y * y * a, -y])


def _disk(shape: Disk) -> list[np.ndarray]:
    return [_polar(shape.matrix, shape.center, *in_plane(unit(shape.normal)), shape.radius)]


def _polar(matrix: np.ndarray, center: Any, u: np.ndarray, v: np.ndarray, radius: float) -> np.ndarray:
    return _record("MAP_POLAR", matrix, _from(center, u / radius), _from(center, v / radius))


def _cone(shape: Cylinder | Cone) -> list[np.ndarray]:
    r0, r1 = (shape.r0, shape.r1) if isinstance(shape, Cone) else (shape.radius, shape.radius)
    axis = np.subtract(shape.p1, shape.p0)
    tangent, bitangent = about(unit(axis))
    along = axis / (axis @ axis)
    rows = (_from(shape.p0, tangent), _from(shape.p0, bitangent), _from(shape.p0, along))
    out = [_record("MAP_AXIAL", shape.matrix, *rows)]
    if shape.caps:
        ends = ((shape.p0, r0), (shape.p1, r1))
        out += [_polar(shape.matrix, p, tangent, bitangent, r) for p, r in ends if r > 0]
    return out


def _paraboloid(shape: Paraboloid) -> list[np.ndarray]:
    axis = unit(shape.axis)
    tangent, bitangent = about(axis)
    ways = tangent, bitangent, axis / shape.height
    return [_record("MAP_AXIAL", shape.matrix, *(_from(shape.apex, way) for way in ways))]


def _plane(shape: Plane) -> list[np.ndarray]:
    u, v = in_plane(unit(shape.normal))
    return [_record("MAP_FLAT", shape.matrix, _from(shape.point, u), _from(shape.point, -v, 1.0))]


def _polygon(shape: Polygon) -> list[np.ndarray]:
    points = np.asarray(shape.points, np.float64)
    local = points - points[0]
    normal = unit(np.cross(local, np.roll(local, -1, axis=0)).sum(axis=0))
    u, v = in_plane(normal)
    (left, wide), (low, high) = ((float((local @ way).min()), float(np.ptp(local @ way))) for way in (u, v))
    across = _from(points[0], u / wide, -left / wide)
    down = _from(points[0], -v / high, 1.0 + low / high)
    return [_record("MAP_FLAT", shape.matrix, across, down)]


def _box(shape: Box) -> list[np.ndarray]:
    low, size = np.asarray(shape.min, np.float64), np.subtract(shape.max, shape.min)
    rows = {name: _from(low, axis / side) for name, axis, side in zip("xyz", _AXES, size, strict=True)}
    rows |= {name.upper(): (-np.asarray(way), 1.0 - rest) for name, (way, rest) in list(rows.items())}
    return [_record("MAP_FLAT", shape.matrix, rows[u], rows[v]) for u, v in _BOX_FACES]


_UPRIGHT: Final = _record("MAP_NORMAL", _AXES, *((axis, 0.0) for axis in _AXES)).tobytes()
# u and v of a box's faces, from -x to +z; capital letters run from 1 to 0
_BOX_FACES: Final = ("yz", "yZ", "zx", "XZ", "Yx", "yx")
# every shape that there is; None: by numbers of its own
_MAP: Final[dict[type[Shape], Callable[[Any], list[np.ndarray]] | None]] = {
    Sphere: _sphere,
    Plane: _plane,
    Disk: _disk,
    Polygon: _polygon,
    Box: _box,
    Quadric: _by_normal,
    Ellipsoid: _ellipsoid,
    Paraboloid: _paraboloid,
    Cylinder: _cone,
    Cone: _cone,
    Mesh: None,
}
