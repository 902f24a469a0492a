"""Pictures on surfaces, in float64 and in the shapes' own coordinates: u, v, texels and bent normals."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import OpenImageIO as oiio

from clrt.base.limits import Limits
from clrt.meshfiles.pictures import PictureFiles
from clrt.scene.scene import ImageTexture, NormalMap, Placement, Quadric, Scene

from .footprints import Seen, between, pyramid, reaches
from .palette import Palette
from .vectors import Array, Ints, dot, unit

COLORS = {"color": "color", "highlight": "highlight_color", "mirror": "reflection_color",
          "tint": "transmission_color", "emission": "emission"}  # fmt: skip

How = ImageTexture | Placement


@dataclass(frozen=True)
class Place:
    """Where n points of a shape lie in pictures, and how that grows there, in the shape's coordinates."""

    u: Array
    v: Array
    du: Array  # (n, 3): dp/du, of any length
    dv: Array


class Images:
    """The pictures of a scene's materials."""

    def __init__(self, scene: Scene, palette: Palette, shape_of: Ints) -> None:
        self.scene, self.palette = scene, palette
        self.first = np.searchsorted(shape_of, np.arange(len(scene.shapes)))
        self.shown = np.array([bool(scene.material_of(shape).pictures) for shape in scene.shapes], bool)
        self._read: dict[tuple[str, int | None], tuple[Array, int]] = {}
        self._levels: dict[Any, list[Array]] = {}

    def tone(self, name: str, plain: Array, shape: Ints, primitive: Ints, point: Array,
             outward: Array, seen: Seen | None = None) -> Array:  # fmt: skip
        """A colour (n, bands) at points: `plain`, or what pictures show there (not `seen`: of level 0)."""
        found = np.array(plain)
        for number in np.unique(shape[self.shown[shape]]):
            material = self.scene.material_of(self.scene.shapes[number])
            picture = getattr(material, COLORS[name])
            if not isinstance(picture, ImageTexture):
                continue
            rows = np.flatnonzero(shape == number)
            at = number, primitive[rows], point[rows], outward[rows]
            rgb = self._shown(picture, name, picture, at, seen and seen[rows])
            light = name == "emission"
            of = self.palette.light if light else self.palette.reflectance
            found[rows] = rgb @ np.stack([of(tuple(primary)) for primary in np.eye(3)])
        return found

    def places(self, shape: Ints, primitive: Ints, point: Array, outward: Array) -> Array:
        """u and v (n, 2) where shapes show pictures, 0 elsewhere."""
        found = np.zeros((len(shape), 2))
        for number in np.unique(shape[self.shown[shape]]):
            rows = np.flatnonzero(shape == number)
            place = self._place(number, primitive[rows], point[rows], outward[rows])
            found[rows] = np.stack([place.u, place.v], axis=1)
        return found

    def bent(self, ns: Array, n: Array, smooth: Array, shape: Ints, primitive: Ints, point: Array,
             outward: Array, seen: Seen) -> Array:  # fmt: skip
        """Shading normals `ns` on the rays' side as maps bend them; `smooth`: interpolated ones, outward."""
        found = np.array(ns)
        for number in np.unique(shape[self.shown[shape]]):
            one = self.scene.shapes[number]
            material = self.scene.material_of(one)
            if material.normal_map is None:
                continue
            rows = np.flatnonzero(shape == number)
            at = number, primitive[rows], point[rows], outward[rows]
            place = self._place(*at)
            like = material.color if isinstance(material.color, ImageTexture) else ImageTexture(file="-")
            how = material.normal_map.placement or like
            texel = np.maximum(self._shown(material.normal_map, "normals", how, at, seen[rows]), -1.0)
            x, y, z = texel.T * np.array([[material.normal_map.scale], [material.normal_map.scale], [1.0]])
            normal, matrix = smooth[rows], np.asarray(one.matrix, float)[:3, :3]
            du, dv = place.du @ matrix.T, place.dv @ matrix.T
            tangent = du - dot(du, normal)[:, None] * normal
            with np.errstate(all="ignore"):
                tangent = unit(tangent)
            lost = ~np.isfinite(tangent).all(axis=1) | (dot(du, du) == 0)
            tangent[lost] = _duff(normal[lost])[0]
            side = np.where(dot(np.cross(du, dv), normal) < 0, 1.0, -1.0)
            other = np.cross(normal, tangent) * side[:, None]
            with np.errstate(invalid="ignore"):  # of length 0: no way, and not towards the ray
                new = unit(x[:, None] * tangent + y[:, None] * other + z[:, None] * normal)
            new = np.where(dot(new, n[rows])[:, None] < 0, -new, new)
            stays = ~(dot(new, seen.direction[rows]) < 0) | ((x == 0) & (y == 0) & (z > 0))
            found[rows] = np.where(stays[:, None], ns[rows], new)
        return found

    def _place(self, number: int, primitive: Ints, point: Array, outward: Array) -> Place:
        shape: Any = self.scene.shapes[number]
        matrix = np.asarray(shape.matrix, float)
        own = (point - matrix[:3, 3]) @ np.linalg.inv(matrix[:3, :3]).T
        normal = unit(outward @ matrix[:3, :3])
        return _PLACES[type(shape).__name__](shape, primitive - self.first[number], own, normal)

    def _shown(self, picture: ImageTexture | NormalMap, name: str, how: How, at: tuple[Any, ...],
               seen: Seen | None) -> Array:  # fmt: skip
        """What a picture for the colour `name`, or for "normals", shows as `how` says."""
        levels = self._levels.get((picture, name, how.filter))
        if levels is None:
            whole = self._normals(picture) if isinstance(picture, NormalMap) else self._picture(picture, name)
            levels = self._levels[picture, name, how.filter] = pyramid(whole, how.filter == "mipmap")
        place = self._place(*at)
        if len(levels) == 1 or seen is None:
            return looked_up(levels[0], how, place.u, place.v)
        number, primitive, point, outward = at

        def moved(rest: Array) -> tuple[Array, Array]:
            own = self._place(number, primitive, point + rest, self._turned(number, point + rest, outward))
            return own.u, own.v

        reach = reaches(moved, outward, seen)
        size = np.array(levels[0].shape[1::-1]) * np.abs(how.scale)
        level, share = between(np.max(reach * size, axis=1), len(levels) - 1)
        found = np.zeros((len(level), 3))
        for k, texels in enumerate(levels):
            part = np.where(level == k, 1 - share, 0) + np.where(level == k - 1, share, 0)
            found += np.where(part[:, None] > 0, part[:, None] * looked_up(texels, how, place.u, place.v), 0)
        return found

    def _turned(self, number: int, point: Array, outward: Array) -> Array:
        """Outward directions at points beside those of `outward`, where u and v depend on them."""
        shape: Any = self.scene.shapes[number]
        if not isinstance(shape, Quadric):
            return outward
        matrix = np.asarray(shape.matrix, float)
        back = np.linalg.inv(matrix[:3, :3])
        x, y, z = ((point - matrix[:3, 3]) @ back.T).T
        a, b, c, d, e, f, g, h, i, _ = shape.coefficients
        rows = (a * x + d * y + f * z + g, d * x + b * y + e * z + h, f * x + e * y + c * z + i)
        slope = np.stack(rows, axis=1) @ back
        return np.where(dot(slope, outward)[:, None] < 0, -slope, slope)

    def _picture(self, picture: ImageTexture, name: str) -> Array:
        """Linear, (h, w, 3)."""
        values, depth = self._samples(picture)
        if picture.encoding == "srgb" or (picture.encoding is None and depth):
            values = np.where(values <= 0.04045, values / 12.92, (np.maximum(values, 0) + 0.055) / 1.055) ** (
                np.where(values <= 0.04045, 1.0, 2.4)
            )
        if picture.file.lower().endswith(".ply"):  # corners' colours, and what makes them linear between
            return np.asarray(values * picture.tint)
        return np.clip(values * picture.tint, 0.0, np.inf if name == "emission" else 1.0)

    def _normals(self, of: NormalMap) -> Array:
        values, depth = self._samples(of)
        if not depth:
            return 2 * values - 1
        middle = 2.0 ** (depth - 1)
        return np.asarray((values * (2**depth - 1) - middle) / (middle - 1))

    def _samples(self, picture: ImageTexture | NormalMap) -> tuple[Array, int]:
        """(h, w, 3) as they are in the file, whole numbers from 0 to 1; and their bits, 0 of floats."""
        file = picture.file, picture.part
        if file in self._read:
            return self._read[file]
        with PictureFiles(Limits()).file((self.scene.folder or Path()) / picture.file, picture.part) as path:
            apart = oiio.ImageSpec()
            apart.attribute("oiio:UnassociatedAlpha", 1)  # or colours come multiplied by it
            stored = oiio.ImageBuf(str(path), 0, 0, apart)
            kind = str(stored.spec().format)
            whole = stored.roi_full if stored.file_format_name == "openexr" else stored.roi
            upright = oiio.ImageBufAlgo.reorient(oiio.ImageBufAlgo.cut(stored, whole))
            assert not upright.has_error, upright.geterror()
            samples = np.asarray(upright.get_pixels(oiio.FLOAT), float)
        colors = samples[:, :, :3] if samples.shape[2] > 2 else samples[:, :, :1]
        bits = {"uint8": 8, "uint16": 16}.get(kind, 0)
        self._read[file] = np.broadcast_to(colors, (*colors.shape[:2], 3)), bits
        return self._read[file]


def looked_up(picture: Array, how: How, u: Array, v: Array) -> Array:
    """What a picture shows (n, 3): the equations of "Images" as they stand."""
    rows, columns = picture.shape[:2]
    x = _coordinate(how, u * how.scale[0] + how.offset[0], columns)
    y = _coordinate(how, v * how.scale[1] + how.offset[1], rows)
    if how.filter == "nearest":
        return picture[_index(how, np.floor(y), rows), _index(how, np.floor(x), columns)]
    x, y = x - 0.5, y - 0.5
    fx, fy = (x - np.floor(x))[:, None], (y - np.floor(y))[:, None]
    left, right = (_index(how, np.floor(x) + i, columns) for i in (0, 1))
    top, bottom = (_index(how, np.floor(y) + i, rows) for i in (0, 1))
    upper = (1 - fx) * picture[top, left] + fx * picture[top, right]
    lower = (1 - fx) * picture[bottom, left] + fx * picture[bottom, right]
    return np.asarray((1 - fy) * upper + fy * lower)


def _coordinate(how: How, u: Array, count: int) -> Array:
    wrapped = {"repeat": np.mod(u, 1.0), "mirror": np.mod(u, 2.0), "clamp": np.clip(u, 0.0, 1.0)}
    return np.asarray(wrapped[how.wrap] * count)


def _index(how: How, i: Array, count: int) -> Ints:
    i = i.astype(int)
    if how.wrap == "clamp":
        return np.clip(i, 0, count - 1)
    if how.wrap == "repeat":
        return np.mod(i, count)
    j = np.mod(i, 2 * count)
    return np.where(j < count, j, 2 * count - 1 - j)


def _phi(x: Array, y: Array) -> Array:
    return np.mod(np.arctan2(y, x) / (2 * np.pi), 1.0)


def _duff(n: Array) -> tuple[Array, Array]:
    sign = np.where(n[..., 2] < 0, -1.0, 1.0)
    a = -1 / (sign + n[..., 2])
    b = n[..., 0] * n[..., 1] * a
    first = np.stack([1 + sign * n[..., 0] ** 2 * a, sign * b, -sign * n[..., 0]], axis=-1)
    return first, np.stack([b, sign + n[..., 1] ** 2 * a, -n[..., 1]], axis=-1)


def _flat_axes(normal: Array) -> tuple[Array, Array]:
    axis = np.eye(3)[np.argmin(np.abs(normal))]
    across = unit(axis - (axis @ normal) * normal)
    return across, np.cross(normal, across)


def _globe(way: Array, radii: Array) -> Place:
    """Of unit vectors seen from a centre, of a body with these radii."""
    x, y, z = way.T
    around = np.stack([-y, x, 0 * x], axis=1)
    rim = np.hypot(x, y)
    with np.errstate(all="ignore"):
        down = np.stack([x * z / rim, y * z / rim, -rim], axis=1)
    v = np.arccos(np.clip(z, -1, 1)) / np.pi
    return Place(_phi(x, y), v, around * radii, np.nan_to_num(down) * radii)


def _sphere(shape: Any, _: Ints, point: Array, normal: Array) -> Place:
    return _globe(unit(point - shape.center), np.ones(3))


def _ellipsoid(shape: Any, _: Ints, point: Array, normal: Array) -> Place:
    return _globe(unit((point - shape.center) / shape.radii), np.asarray(shape.radii, float))


def _quadric(shape: Any, _: Ints, point: Array, normal: Array) -> Place:
    return _globe(normal, np.ones(3))


def _wheel(point: Array, center: Any, across: Array, up: Array, radius: float) -> Place:
    offset = point - np.asarray(center, float)
    x, y = offset @ across / radius, offset @ up / radius
    outwards = x[:, None] * across + y[:, None] * up
    return Place(np.hypot(x, y), _phi(x, y), outwards, x[:, None] * up - y[:, None] * across)


def _disk(shape: Any, _: Ints, point: Array, normal: Array) -> Place:
    return _wheel(point, shape.center, *_flat_axes(unit(shape.normal)), shape.radius)


def _round_about(point: Array, origin: Any, axis: Array, height: float, widens: float | None) -> Place:
    """Of a body about an axis, by how much its radius grows on the way; None: as the root of the height."""
    tangent, bitangent = _duff(axis)
    offset = point - np.asarray(origin, float)
    x, y, v = offset @ tangent, offset @ bitangent, offset @ axis / height
    around = x[:, None] * bitangent - y[:, None] * tangent
    radius = np.hypot(x, y)
    with np.errstate(all="ignore"):
        outwards = np.nan_to_num((radius / (2 * v) if widens is None else widens) / radius)
    radial = x[:, None] * tangent + y[:, None] * bitangent
    return Place(_phi(x, y), v, around, height * axis + outwards[:, None] * radial)


def _cone(shape: Any, primitive: Ints, point: Array, normal: Array) -> Place:
    p0, p1 = np.asarray(shape.p0, float), np.asarray(shape.p1, float)
    radii = (shape.r0, shape.r1) if hasattr(shape, "r0") else (shape.radius, shape.radius)
    height = float(np.linalg.norm(p1 - p0))
    axis = (p1 - p0) / height
    tangent, bitangent = _duff(axis)
    places = [_round_about(point, p0, axis, height, radii[1] - radii[0])]
    caps = zip((p0, p1), radii, strict=True)
    places += [_wheel(point, p, tangent, bitangent, r) for p, r in caps if r > 0]
    return _chosen(places, primitive)


def _chosen(places: list[Place], number: Ints) -> Place:
    """Of each point the place that its primitive's number names."""
    rows = np.arange(len(number))
    found = [np.stack([getattr(p, name) for p in places])[number, rows] for name in ("u", "v", "du", "dv")]
    return Place(*found)


def _paraboloid(shape: Any, _: Ints, point: Array, normal: Array) -> Place:
    return _round_about(point, shape.apex, unit(shape.axis), shape.height, None)


def _sheet(u: Array, v: Array, du: Array, dv: Array) -> Place:
    return Place(u, v, np.broadcast_to(du, (len(u), 3)), np.broadcast_to(dv, (len(u), 3)))


def _plane(shape: Any, _: Ints, point: Array, normal: Array) -> Place:
    across, up = _flat_axes(unit(shape.normal))
    offset = point - np.asarray(shape.point, float)
    return _sheet(offset @ across, 1 - offset @ up, across, -up)


def _polygon(shape: Any, _: Ints, point: Array, normal: Array) -> Place:
    points = np.asarray(shape.points, float)
    local = points - points[0]
    own = unit(np.cross(local, np.roll(local, -1, axis=0)).sum(axis=0))
    across, up = _flat_axes(own)
    low, high = [(points @ way).min() for way in (across, up)], [(points @ way).max() for way in (across, up)]
    u = (point @ across - low[0]) / (high[0] - low[0])
    return _sheet(u, 1 - (point @ up - low[1]) / (high[1] - low[1]), across, -up)


def _box(shape: Any, primitive: Ints, point: Array, normal: Array) -> Place:
    low, size = np.asarray(shape.min, float), np.subtract(shape.max, shape.min)
    x, y, z = ((point - low) / size).T
    ex, ey, ez = np.eye(3)
    faces = [(y, z, ey, ez), (y, 1 - z, ey, -ez), (z, x, ez, ex), (1 - x, 1 - z, -ex, -ez),
             (1 - y, x, -ey, ex), (y, x, ey, ex)]  # fmt: skip
    return _chosen([_sheet(*face) for face in faces], primitive)


def _mesh(shape: Any, primitive: Ints, point: Array, normal: Array) -> Place:
    data = shape.data()
    faces = [face[[0, k, k + 1]] for face in map(np.asarray, data.faces) for k in range(1, len(face) - 1)]
    index = np.array(faces, int)[primitive]
    a, b, c = (np.asarray(data.vertices, float)[index[:, i]] for i in range(3))
    ua, ub, uc = (np.asarray(data.uv, float)[index[:, i]] for i in range(3))
    sides = np.stack([b - a, c - a], axis=2)
    weight = np.einsum("nij,nj->ni", np.linalg.pinv(sides), point - a)[:, :, None]
    uv = ua + weight[:, :1, 0] * (ub - ua) + weight[:, 1:, 0] * (uc - ua)
    # dp/du, dp/dv: the sides are what they become under the differences of u and v
    both = sides @ np.linalg.pinv(np.stack([ub - ua, uc - ua], axis=2))
    return Place(uv[:, 0], uv[:, 1], both[:, :, 0], both[:, :, 1])


_PLACES: dict[str, Callable[[Any, Ints, Array, Array], Place]] = {
    "Sphere": _sphere, "Ellipsoid": _ellipsoid, "Quadric": _quadric, "Disk": _disk, "Cylinder": _cone,
    "Cone": _cone, "Paraboloid": _paraboloid, "Plane": _plane, "Polygon": _polygon, "Box": _box,
    "Mesh": _mesh,
}  # fmt: skip
