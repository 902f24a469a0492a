"""The float32 twin's surfaces: the point, the normals and the colour at a hit."""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np

from clrt import layout
from clrt.flatten.flatten import FlatScene

from .geometry import (
    KINDS,
    Hits,
    Rays,
    frame_of,
    from_axes,
    primitives_of,
    quadric_form,
    to_axes,
    triangle_hit,
    triangle_normal,
)
from .images import place_pictures
from .math import (
    ONE,
    Array,
    arccos,
    arctan2,
    cross,
    dot,
    larger,
    largest_coordinate,
    smaller,
    unit,
    unit_of_any,
    vector,
    xyz,
)

_OFFSET = np.float32(layout.OFFSET)
_ALONG, _FROM_EDGE = np.float32(layout.ALONG), np.float32(layout.FROM_EDGE)
_ULP = np.float32(2.0**-23)
_EDGES = 64  # of polygons with more none is looked for


@dataclass
class Surface:
    """What n rays hit; vectors are (3, n).

    point: the hit, moved back onto its primitive. outward: geometric unit normal; n: the same, turned to the
    side the ray came from; ns: the shading normal, on that side too, from `smooth`, which is 0 but on smooth
    meshes. center: the surface's own origin (for the checker). uv: barycentric weights (2, n). offset: how
    far spawned rays start off the surface; back: from there, back along the rays. material: records.
    """

    point: Array
    outward: Array
    smooth: Array
    center: Array
    uv: Array
    offset: Array
    back: Array
    material: Array
    n: Array
    ns: Array
    inside: Array
    at_edge: Array  # whether the hit is an edge of a flat primitive, to within rounding
    place: Array  # (2, n): where in pictures
    footprint: Array  # (3, n): how far it reaches in u and in v, and how wide the cone is there

    @property
    def relative(self) -> Array:
        return self.point - self.center

    @property
    def before(self) -> Array:
        """Where rays start that stay on the side from which the rays came."""
        return self.point + self.n * self.offset - self.back

    @property
    def behind(self) -> Array:
        """Where rays start that go on behind the surface."""
        return self.point - self.n * self.offset

    def __getitem__(self, index: Array) -> Surface:
        return Surface(*(getattr(self, field.name)[..., index] for field in fields(self)))


def surface_at(flat: FlatScene, rays: Rays, hits: Hits) -> Surface:
    """The surfaces that n rays hit; all of them must hit."""
    records = primitives_of(flat)[hits.primitive]
    zero = np.zeros((3, len(records)), np.float32)
    s = Surface(
        point=rays.origin + rays.direction * hits.t,
        outward=zero.copy(),
        smooth=zero.copy(),
        center=zero.copy(),
        uv=zero[:2].copy(),
        offset=zero[0].copy(),
        back=zero,
        material=flat.materials[records["material"]],
        n=zero,
        ns=zero,
        inside=zero[0],
        at_edge=np.zeros(len(records), bool),
        place=zero[:2].copy(),
        footprint=zero.copy(),
    )
    for kind, place in _PLACE.items():
        which = np.flatnonzero(records["kind"] == KINDS[kind])
        if len(which):
            place(flat, records["index"][which], rays[which], s, which)
    along = s.offset + _ALONG * hits.t
    s.back = rays.direction * smaller(np.where(s.at_edge, _FROM_EDGE * along, along), hits.t)
    s.inside = dot(s.outward, rays.direction) > 0.0
    s.n = np.where(s.inside, -s.outward, s.outward)
    s.ns = np.where(dot(s.smooth, s.n) < 0.0, -s.smooth, s.smooth)
    # also where the mesh is flat (0) or its normals cancelled (NaN)
    s.ns = np.where(dot(s.ns, rays.direction) < 0.0, s.ns, s.n)
    s.footprint[2] = rays.width(hits.t)
    place_pictures(flat, s, hits.primitive, rays.direction)
    return s


# Each of these fills in surface entries `at` of one kind, of rays that hit primitives `index` of that kind.


def _on_sphere(flat: FlatScene, index: Array, rays: Rays, s: Surface, at: Array) -> None:
    center, radius = xyz(flat.spheres["center_radius"][index]), flat.spheres["center_radius"][index, 3]
    way = s.point[:, at] - center
    with np.errstate(all="ignore"):
        outward = np.where(largest_coordinate(way) > 0, unit_of_any(way), -rays.direction)
    s.outward[:, at] = outward
    s.point[:, at] = center + outward * radius
    s.offset[at] = _OFFSET * (largest_coordinate(center) + radius)


def _on_plane(flat: FlatScene, index: Array, rays: Rays, s: Surface, at: Array) -> None:
    _flat_surface(s, at, xyz(flat.planes["point"][index]), xyz(flat.planes["normal"][index]))


def _on_disk(flat: FlatScene, index: Array, rays: Rays, s: Surface, at: Array) -> None:
    _flat_surface(s, at, xyz(flat.disks["center_radius"][index]), xyz(flat.disks["normal"][index]))


def _on_polygon(flat: FlatScene, index: Array, rays: Rays, s: Surface, at: Array) -> None:
    polygon, normal, met = flat.polygons[index], xyz(flat.polygons[index]["normal"]), s.point[:, at]
    first, count = polygon["first"], polygon["count"]
    _flat_surface(s, at, xyz(flat.vertices[first]), normal, polygon["normal"][:, 3])
    near, point, flatly = place_width(rays, met), s.point[:, at], np.abs(dot(normal, rays.direction))
    few = count <= _EDGES
    for i in range(count[few].max(initial=0)):  # beyond its last corner each begins again
        a, b = (xyz(flat.vertices[first + (i + step) % count]) for step in (-1, 0))
        e = b - a
        beside = np.abs(dot(cross(normal, e), point - a)) * flatly
        s.at_edge[at] |= few & (beside <= near * largest_coordinate(e))


def place_width(rays: Rays, point: Array) -> Array:
    """How far places across rays at points may be apart that are one but for rounding."""
    far = largest_coordinate(point - rays.origin)
    return np.float32(0.5) * (_OFFSET * largest_coordinate(point) + _ALONG * far)


def _flat_surface(s: Surface, at: Array, origin: Array, normal: Array, size: Array | None = None) -> None:
    point = s.point[:, at]
    point = point - normal * dot(normal, point - origin)
    s.point[:, at], s.outward[:, at], s.center[:, at] = point, normal, origin
    s.offset[at] = _OFFSET * larger(
        largest_coordinate(point), largest_coordinate(origin) if size is None else size
    )


def _on_triangle(flat: FlatScene, index: Array, rays: Rays, s: Surface, at: Array) -> None:
    triangle = flat.triangles[index]
    v0, v1, v2 = corners = [xyz(triangle[name]) for name in ("v0", "v1", "v2")]
    _, u, v = triangle_hit(v0, v1, v2, rays, frame_of(rays.direction))
    s.uv[:, at] = u, v
    met = s.point[:, at]
    s.point[:, at] = v0 + ((v1 - v0) * u + (v2 - v0) * v)
    normal = triangle_normal(v0, v1, v2)
    with np.errstate(all="ignore"):
        s.outward[:, at] = np.where(largest_coordinate(normal) > 0, unit_of_any(normal), -rays.direction)
    s.offset[at], width = _leave_triangle(corners, normal)
    with np.errstate(all="ignore"):
        inwards = smaller(smaller(u, v), 1.0 - u - v) * width * np.abs(dot(s.outward[:, at], rays.direction))
    s.at_edge[at] = inwards <= place_width(rays, met)
    first = triangle["normals"]
    n0, n1, n2 = (xyz(flat.normals[np.where(first < 0, 0, first + i)]) for i in range(3))
    s.smooth[:, at] = np.where(first < 0, np.float32(0.0), unit(n0 * (1.0 - u - v) + n1 * u + n2 * v))


def _leave_triangle(corners: list[Array], normal: Array) -> tuple[Array, Array]:
    """By how much rays leave triangles, and how wide these are: where they are long and thin, distances are
    rounded more."""
    v0, v1, v2 = corners
    reach = larger(larger(largest_coordinate(v0), largest_coordinate(v1)), largest_coordinate(v2))
    length = larger(largest_coordinate(v1 - v0), largest_coordinate(v2 - v0))
    with np.errstate(all="ignore"):
        width = largest_coordinate(normal) / length
        blur = _ULP * length * length / width
    return larger(smaller(blur, width), _OFFSET * reach), width


def _slopes(square: Array) -> Array:
    """Whether float32 holds a gradient of this square, the square itself and its inverse."""
    return np.asarray((square > np.float32(1e-30)) & (square < np.float32(1e36)))


def _on_quadric(flat: FlatScene, index: Array, rays: Rays, s: Surface, at: Array) -> None:
    """Two Newton steps onto F = 0 about the centre; the gradient is the normal, or -u without one."""
    q = flat.quadrics[index]
    center, (axes, form, g, constant) = xyz(q["center"]), quadric_form(q)

    def sloped_at(local: Array) -> tuple[Array, Array, Array]:
        """Coordinates along the axes, half the slope along them, and the gradient."""
        x = to_axes(axes, local)
        slope = form * x + g
        return x, slope, from_axes(axes, slope) * np.float32(2.0)

    local = s.point[:, at] - center
    for _ in range(2):
        x, half, gradient = sloped_at(local)
        slope = dot(gradient, gradient)
        value = dot(x, half + g) + constant
        with np.errstate(all="ignore"):
            along = value / slope
            moves = _slopes(slope) & (np.abs(along) < np.inf)
            local = np.where(moves, local - gradient * along, local)
    point = center + local
    x, half, gradient = sloped_at(local)
    square = dot(gradient, gradient)
    length = np.sqrt(square)
    n = gradient * (ONE / length)
    reach = larger(xyz(q["reach"]), np.abs(point))
    # what F's rounding error scales with: its coordinates are sums, of which each term is rounded
    sums, far = to_axes([np.abs(axis) for axis in axes], np.abs(local)), np.abs(x)
    terms = dot(far, np.abs(form) * far + np.abs(g) * np.float32(2.0))
    magnitude = np.float32(2.0) * dot(np.abs(half), sums) + terms + np.abs(constant)
    offset = _ULP * (magnitude / length + 2.0 * dot(np.abs(n), reach))

    sloped = _slopes(square) & (offset < np.inf)
    outward = np.where(sloped, n, np.float32(0.0))
    s.point[:, at] = point
    s.offset[at] = np.where(sloped, offset, _OFFSET * largest_coordinate(reach))
    s.outward[:, at] = np.where(dot(outward, outward) == 0.0, -rays.direction, outward)


_PLACE = {
    "SPHERE": _on_sphere,
    "PLANE": _on_plane,
    "DISK": _on_disk,
    "TRIANGLE": _on_triangle,
    "POLYGON": _on_polygon,
    "QUADRIC": _on_quadric,
}


def bands(values: Array) -> Array:
    """Values a band in a field of records (..., bands), bands first."""
    return np.ascontiguousarray(np.moveaxis(values, -1, 0))


def lat_long(d: Array) -> tuple[Array, Array]:
    """Longitude and latitude of directions as u, v in [0, 1]: u = .5 looks along -z, v = 0 straight up."""
    return 0.5 + arctan2(d[0], -d[2]) * 0.159154943, arccos(d[1]) * 0.318309886


def in_plane(n: Array, p: Array) -> tuple[Array, Array]:
    """Coordinates along the axes in a plane: u along the coordinate axis closest to it, v = n x u."""
    ax, ay, az = np.abs(n)
    lowest = np.where((ax <= ay) & (ax <= az), 0, np.where(ay <= az, 1, 2))
    axis = vector(*((lowest == k).astype(np.float32) for k in range(3)))
    u = unit(axis - n * dot(axis, n))
    return dot(p, u), dot(p, cross(n, u))


def second_color(s: Surface) -> Array:
    """Does the second colour of the checker show."""
    material = s.material
    around = [smaller(at, np.float32(1 - 2.0**-24)) for at in lat_long(s.outward)]  # at 1: the last
    flat = in_plane(s.outward, s.relative)
    on_sphere = material["checker"] == layout.CHECKER["CHECKER_SPHERE"]
    size = material["checker_size"]
    column = np.where(on_sphere, around[0] * size, flat[0] * (ONE / size))
    row = np.where(on_sphere, around[1] * (size * 0.5), flat[1] * (ONE / size))
    cell = np.floor(column) + np.floor(row)
    return (material["checker"] != layout.CHECKER["PLAIN"]) & (cell - 2.0 * np.floor(cell * 0.5) != 0.0)


def color_of(s: Surface) -> Array:
    """F of the model, a value a band."""
    return np.where(second_color(s), bands(s.material["color2"]), bands(s.material["color"]))


def background_of(flat: FlatScene, direction: Array) -> Array:
    """What rays that leave the scene see, a value a band: bilinear in the image, which wraps around in u."""
    info = flat.scene[0]
    width, height = int(info["background_width"]), int(info["background_height"])
    plain = np.repeat(info["background"][:, None], direction.shape[1], axis=1)
    if width == 0:
        return plain
    seen = dot(direction, direction) > 0.0
    u, v = lat_long(np.where(seen, direction, np.float32(0.0)))
    x, y = u * np.float32(width) - 0.5, v * np.float32(height) - 0.5
    x0, y0 = np.floor(x), np.floor(y)
    fx, fy = x - x0, y - y0
    left, top = (x0.astype(np.int32) + width) % width, np.clip(y0.astype(np.int32), 0, height - 1)
    right, bottom = (left + 1) % width, np.clip(y0.astype(np.int32) + 1, 0, height - 1)
    image = bands(flat.background.reshape(height, width, 3))
    above = image[:, top, left] * (1.0 - fx) + image[:, top, right] * fx
    below = image[:, bottom, left] * (1.0 - fx) + image[:, bottom, right] * fx
    red, green, blue = above * (1.0 - fy) + below * fy
    sky = [info[name][:, None] for name in ("sky_red", "sky_green", "sky_blue")]
    return np.where(seen, red * sky[0] + green * sky[1] + blue * sky[2], plain)
