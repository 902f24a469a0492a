"""The float32 twin's geometry: where rays meet primitives. Brute force, no tree.

The distance functions broadcast. `nearest_hit` gives them rays (3, n, 1) and primitives (3, 1, m) for all
pairs; the surface at known hits gives them one primitive a ray.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from clrt import layout
from clrt.flatten.flatten import FlatScene

from .math import ONE, Array, component, cross, dot, vector, xyz

NO_PRIMITIVE = -1
BEFORE_ALL = 0x7FFFFFFF
KINDS = layout.KINDS
_NO_HIT = np.float32(np.nan)  # compares false with everything, so it never counts
_SHORT = np.float32(1 - layout.PAD / 4)
_SMALL = np.float32(1e-18)
_RAYS, _PAIRS = 1 << 12, 1 << 17  # computed at a time: rays, and rays times primitives


@dataclass(frozen=True)
class Rays:
    """Origins and unit directions (3, ...); hits count for 0 < t < t_max (...).

    cone: (2, ...), how wide their cones are at the origins, and what they grow by; None: 0.
    """

    origin: Array
    direction: Array
    t_max: Array
    cone: Array | None = None

    def __getitem__(self, index: object) -> Rays:
        """Some of the rays, or the same with further axes."""
        at = index if isinstance(index, tuple) else (index,)
        cone = None if self.cone is None else self.cone[:, *at]
        return Rays(self.origin[:, *at], self.direction[:, *at], self.t_max[at], cone)

    def width(self, t: Array) -> Array:
        """How wide their cones are at distances t."""
        return np.zeros_like(t) if self.cone is None else self.cone[0] + self.cone[1] * t

    def __len__(self) -> int:
        return len(self.t_max)


@dataclass(frozen=True)
class Hits:
    """`t` is the ray's t_max and `primitive` NO_PRIMITIVE on a miss."""

    t: Array
    primitive: Array


@dataclass(frozen=True)
class Frame:
    """Dominant axis z of a direction and the shear that turns the ray into it (Woop, Benthin, Wald 2013)."""

    x: Array
    y: Array
    z: Array
    shear: Array
    inverse: Array

    def seen(self, origin: Array, p: Array) -> Array:
        """Points in the rays' frames: the ray is at x = y = 0, z runs along it."""
        z = component(p, self.z) - component(origin, self.z)
        across = component(p, self.x) - component(origin, self.x)
        above = component(p, self.y) - component(origin, self.y)
        return vector(across - self.shear[0] * z, above - self.shear[1] * z, z)


def frame_of(d: Array) -> Frame:
    ax, ay, az = np.abs(d)
    z = np.where((ax >= ay) & (ax >= az), 0, np.where(ay >= az, 1, 2))
    x = np.where(z == 2, 0, z + 1)
    y = np.where(x == 2, 0, x + 1)
    inverse = ONE / component(d, z)
    shear = vector(component(d, x) * inverse, component(d, y) * inverse, inverse)
    return Frame(x, y, z, shear, np.stack([_short_inverse(component(d, x)), _short_inverse(component(d, y))]))


def _short_inverse(d: Array) -> Array:
    """Finite, and too short by more than rounding."""
    return ONE / np.where(np.abs(d) < _SMALL, np.where(d < 0.0, -_SMALL, _SMALL), d) * _SHORT


def sphere_roots(center: Array, radius: Array, rays: Rays) -> tuple[Array, Array]:
    """Both roots, ascending; a tangent counts (Haines, Günther, Akenine-Möller, Ray Tracing Gems ch. 7)."""
    to_center = center - rays.origin
    b = dot(to_center, rays.direction)
    nearest = to_center - rays.direction * b
    discriminant = radius * radius - dot(nearest, nearest)
    root = np.sqrt(discriminant)
    q = b + np.where(b < 0.0, -root, root)
    p = (dot(to_center, to_center) - radius * radius) / q
    met = discriminant >= 0.0
    swapped = p > q
    return np.where(met, np.where(swapped, q, p), _NO_HIT), np.where(met, np.where(swapped, p, q), _NO_HIT)


def plane_root(point: Array, normal: Array, rays: Rays) -> Array:
    return dot(normal, point - rays.origin) / dot(normal, rays.direction)


def disk_root(center: Array, radius: Array, normal: Array, rays: Rays) -> Array:
    t = plane_root(center, normal, rays)
    p = (rays.origin + rays.direction * t) - center
    return np.where(dot(p, p) <= radius * radius, t, _NO_HIT)


def straddles(a: Array, b: Array, c: Array) -> Array:
    """Is 0 within the extent of three coordinates."""
    return (np.minimum(np.minimum(a, b), c) <= 0.0) & (np.maximum(np.maximum(a, b), c) >= 0.0)


def not_before(t: Array, inverse: Array, origin: Array, corners: list[Array]) -> Array:
    """`t`, but not before the ray comes, along one axis, to the corners' extent."""
    low = np.minimum(np.minimum(corners[0], corners[1]), corners[2])
    high = np.maximum(np.maximum(corners[0], corners[1]), corners[2])
    entry = (np.where(inverse < 0.0, high, low) - origin) * inverse
    return np.where(entry > t, entry, t)


def triangle_hit(v0: Array, v1: Array, v2: Array, rays: Rays, frame: Frame) -> tuple[Array, Array, Array]:
    """Distance and the barycentric weights of v1 and v2; the weights mean nothing on a miss."""
    a, b, c = (frame.seen(rays.origin, corner) for corner in (v0, v1, v2))
    u = c[0] * b[1] - c[1] * b[0]
    v = a[0] * c[1] - a[1] * c[0]
    w = b[0] * a[1] - b[1] * a[0]
    determinant = u + v + w
    inside = (u >= 0.0) & (v >= 0.0) & (w >= 0.0) | (u <= 0.0) & (v <= 0.0) & (w <= 0.0)
    inside &= straddles(a[0], b[0], c[0]) & straddles(a[1], b[1], c[1])
    t = (u * a[2] + v * b[2] + w * c[2]) * frame.shear[2] / determinant
    for axis, inverse in zip((frame.x, frame.y), frame.inverse, strict=True):
        along = [component(corner, axis) for corner in (v0, v1, v2)]
        t = not_before(t, inverse, component(rays.origin, axis), along)
    return np.where(inside, t, _NO_HIT), v / determinant, w / determinant


def triangle_normal(v0: Array, v1: Array, v2: Array) -> Array:
    """Outward, not of unit length."""
    return cross(v1 - v0, v2 - v0)


def polygon_root(corners: list[Array], normal: Array, rays: Rays, frame: Frame) -> Array:
    """Crossing number (thesis Algorithm 1) in the rays' frames."""
    inside, on = np.zeros((2, *np.broadcast_shapes(corners[0].shape, rays.origin.shape)[1:]), bool)
    a = frame.seen(rays.origin, corners[-1])
    near, far = np.full(inside.shape, np.inf, np.float32), np.full(inside.shape, -np.inf, np.float32)
    for corner in corners:
        b = frame.seen(rays.origin, corner)
        e = a[0] * b[1] - b[0] * a[1]
        inside ^= ((a[1] >= 0.0) != (b[1] >= 0.0)) & ((e > 0.0) == (b[1] > a[1]))
        on |= (e == 0.0) & (a[0] * b[0] + a[1] * b[1] <= 0.0)
        depth = b[2] * frame.shear[2]
        near, far = np.where(depth < near, depth, near), np.where(depth > far, depth, far)
        a = b
    t = plane_root(corners[0], normal, rays)
    within = np.where(t > near, t, near)
    within = np.where(within < far, within, far)
    return np.where((inside | on) & (np.abs(t) < np.inf), within, _NO_HIT)


def quadric_form(q: Array) -> tuple[list[Array], Array, Array, Array]:
    """Axes, s, g and J of F(x) = sum s_i x_i^2 + 2 g.x + J, x_i = axis_i . p."""
    rows = [q[name] for name in ("axis_x", "axis_y", "axis_z")]
    g = vector(*(row[..., 3] for row in rows))
    return [xyz(row) for row in rows], xyz(q["form"]), g, q["form"][..., 3]


def to_axes(axes: list[Array], v: Array) -> Array:
    """Coordinates along three axes."""
    return vector(*(dot(axis, v) for axis in axes))


def from_axes(axes: list[Array], v: Array) -> Array:
    """The vector of these coordinates."""
    return axes[0] * v[0] + axes[1] * v[1] + axes[2] * v[2]


def quadric_clips(q: Array, p: Array) -> Array:
    """Is `p` (about the centre) inside the clip box."""
    inside = np.ones(p.shape[1:], bool)
    for i, name in enumerate(("clip_x", "clip_y", "clip_z")):
        coordinate = dot(xyz(q[name]), p)
        inside &= (coordinate >= q[name][..., 3]) & (coordinate <= q["clip_high"][..., i])
    return inside


def quadric_roots(q: Array, rays: Rays, front_only: Array) -> tuple[Array, Array]:
    """Both roots, ascending. Solved about the line's point nearest the centre, or, in the box, the origin;
    where b^2 - ac cancels it is taken from the cross product, by Lagrange."""
    axes, s, g, j = quadric_form(q)
    whole, way = rays.origin - xyz(q["center"]), rays.direction
    half_box = vector(*(q[name][..., 3] for name in ("center", "clip_high", "reach")))
    within = (np.abs(whole) <= half_box).all(axis=0)
    shift = np.where(within, np.float32(0), -dot(whole, way) / dot(way, way))
    p = whole + way * shift
    o, d = to_axes(axes, p), to_axes(axes, way)
    bent, slope = s * d, s * o + g
    a, b, c = dot(d, bent), dot(d, slope), dot(o, slope + g) + j
    n, pairs = cross(o, d), vector(s[1] * s[2], s[2] * s[0], s[0] * s[1])
    along, square = dot(g, d), b * b
    direct = square - a * c
    level, leaning, crossed = a * j, np.float32(2) * dot(n, cross(bent, g)), pairs * (n * n)
    lagrange = along * along - level + leaning - (crossed[0] + crossed[1] + crossed[2])
    sizes = along * along + np.abs(level) + np.abs(leaning) + np.abs(crossed[0])
    terms = sizes + np.abs(crossed[1]) + np.abs(crossed[2])
    cancels = (np.abs(direct) < np.float32(0.5) * square) & (terms < square)
    discriminant = np.where(cancels, lagrange, direct)
    root = np.sqrt(discriminant)
    rise = np.where(b < 0.0, -root, root)
    k = -(b + rise)
    far = k / a
    near = np.where((k == 0.0) & (c == 0.0), far, c / k)
    swapped = (near > far) | np.isnan(near)

    def counted(r: Array, rise: Array) -> Array:
        hit = (discriminant >= 0.0) & (np.abs(r) < 1e30) & quadric_clips(q, p + way * r)
        return np.where(hit & ~(front_only & (rise > 0.0)), r + shift, _NO_HIT)

    first = counted(np.where(swapped, far, near), np.where(swapped, -rise, rise))
    return first, counted(np.where(swapped, near, far), np.where(swapped, rise, -rise))


def precedes(t: Array, primitive: Array, other_t: Array, other_primitive: Array) -> Array:
    """The order of hits: by distance, then by the primitive's number."""
    return (t < other_t) | (t == other_t) & (primitive < other_primitive)


def primitives_of(flat: FlatScene) -> Array:
    """The records of all primitives, in the order of their numbers."""
    return flat.primitives[: int(flat.scene["primitives"][0])]


def _batches(flat: FlatScene, rays: int) -> Iterator[tuple[int, int, Array]]:
    """(kind, corners of a polygon or 0, primitive numbers ascending), few enough for all pairs at once."""
    primitives = primitives_of(flat)
    for kind in KINDS.values():
        numbers = np.flatnonzero(primitives["kind"] == kind)
        counts = (
            flat.polygons["count"][primitives["index"][numbers]] if kind == KINDS["POLYGON"] else 0 * numbers
        )
        for count in np.unique(counts):
            alike = numbers[counts == count]
            step = max(1, _PAIRS // max(rays, 1))
            for start in range(0, len(alike), step):
                yield kind, int(count), alike[start : start + step]


def _roots(
    flat: FlatScene, kind: int, count: int, numbers: Array, rays: Rays, frame: Frame
) -> tuple[Array, Array]:
    """Distances (n, m) at which rays (n, 1) meet primitives of one kind, ascending; NaN where they do not."""
    records = primitives_of(flat)[numbers]
    index = records["index"]
    one_sided = flat.materials["one_sided"][records["material"]] != 0
    front_only = one_sided & bool(flat.scene["one_sided"][0])
    if kind == KINDS["SPHERE"]:
        sphere = flat.spheres["center_radius"][index]
        first, second = sphere_roots(xyz(sphere)[:, None], sphere[:, 3], rays)
        return first, np.where(front_only, _NO_HIT, second)
    if kind == KINDS["QUADRIC"]:
        return quadric_roots(flat.quadrics[index][None], rays, front_only)
    if kind == KINDS["TRIANGLE"]:
        v0, v1, v2 = (xyz(flat.triangles[name][index])[:, None] for name in ("v0", "v1", "v2"))
        normal = triangle_normal(v0, v1, v2)
        t = triangle_hit(v0, v1, v2, rays, frame)[0]
    elif kind == KINDS["POLYGON"]:
        normal = xyz(flat.polygons["normal"][index])[:, None]
        first_corner = flat.polygons["first"][index]
        outline = [xyz(flat.vertices[first_corner + i])[:, None] for i in range(count)]
        t = polygon_root(outline, normal, rays, frame)
    elif kind == KINDS["DISK"]:
        disk = flat.disks["center_radius"][index]
        normal = xyz(flat.disks["normal"][index])[:, None]
        t = disk_root(xyz(disk)[:, None], disk[:, 3], normal, rays)
    else:
        normal = xyz(flat.planes["normal"][index])[:, None]
        t = plane_root(xyz(flat.planes["point"][index])[:, None], normal, rays)
    behind = front_only & (dot(normal, rays.direction) > 0.0)
    return np.where(behind, _NO_HIT, t), np.full_like(t, _NO_HIT)


def nearest_hit(
    flat: FlatScene, rays: Rays, after: Hits | None = None, own: Array | None = None
) -> Hits:
    """The first hit of n rays, or the first that comes after the hits `after` in the order of (t, primitive).

    A zero or NaN direction misses. `own` (n,): primitives that rays pass by, -1 for none.
    """
    n = len(rays)
    own = np.full(n, NO_PRIMITIVE) if own is None else own
    if after is None:
        after = Hits(np.zeros(n, np.float32), np.full(n, BEFORE_ALL))
    parts = [slice(start, start + _RAYS) for start in range(0, max(n, 1), _RAYS)]
    found = [
        _nearest(flat, rays[part], Hits(after.t[part], after.primitive[part]), own[part]) for part in parts
    ]
    return Hits(
        np.concatenate([hits.t for hits in found]), np.concatenate([hits.primitive for hits in found])
    )


def _nearest(flat: FlatScene, rays: Rays, after: Hits, own: Array) -> Hits:
    n = len(rays)
    best_t, best = rays.t_max, np.full(n, NO_PRIMITIVE, np.int32)
    column = rays[:, None]
    frame = frame_of(column.direction)
    after_t, after_primitive = after.t[:, None], after.primitive[:, None]
    for kind, count, numbers in _batches(flat, n):
        first, second = _roots(flat, kind, count, numbers, column, frame)
        t = np.where(precedes(after_t, after_primitive, first, numbers), first, second)
        t = np.where(precedes(after_t, after_primitive, t, numbers), t, np.float32(np.inf))
        t = np.where(numbers == own[:, None], np.float32(np.inf), t)
        which = t.argmin(axis=1)  # the lowest number among equals
        nearest, number = t[np.arange(n), which], numbers[which]
        better = precedes(nearest, number, best_t, best)
        best_t, best = np.where(better, nearest, best_t), np.where(better, number, best).astype(np.int32)
    meets = dot(rays.direction, rays.direction) > 0.0
    return Hits(np.where(meets, best_t, rays.t_max), np.where(meets, best, NO_PRIMITIVE).astype(np.int32))
