"""The float32 twin's pictures on surfaces: where hits lie in them, their texels, and bent normals."""

from __future__ import annotations

from typing import Any

import numpy as np

from clrt import layout
from clrt.flatten.flatten import FlatScene

from .geometry import primitives_of
from .math import (
    ONE,
    Array,
    arccos,
    arctan2,
    cross,
    dot,
    frame_about,
    larger,
    largest_coordinate,
    smaller,
    unit_of_any,
    xyz,
)
from .mips import along_rows, corners_of, levels_of, reaches

_MAP = layout.MAPPINGS
_WRAP = layout.WRAP
_ZERO = np.float32(0.0)


def place_pictures(flat: FlatScene, s: Any, primitive: Array, direction: Array) -> None:
    """Fill in `place` of surfaces that primitives of these numbers have; their colours and normals."""
    if flat.pictured is None:
        return
    assert flat.mapping_of is not None and flat.mappings is not None
    records = primitives_of(flat)[primitive]
    mapping = flat.mapping_of[primitive]
    which = np.flatnonzero(mapping >= 0)
    if not len(which):
        return
    how, index = flat.mappings[mapping[which]], records["index"][which]
    here = s[which]
    u, v = _place(flat, how, index, here)
    s.place[:, which] = u, v
    reach = reaches(flat, how, index, here, direction[:, which])
    s.footprint[:2, which] = reach
    pictured = flat.pictured[records["material"][which]]
    for field in layout.PICTURES:
        _show(flat, s, which, field, pictured[field], (u, v, *reach))
    for number in np.unique(pictured["normal_map"][pictured["normal_map"] >= 0]):
        bent = np.flatnonzero(pictured["normal_map"] == number)
        at = which[bent]
        texel = larger(_shown(flat, number, u[bent], v[bent], *reach[:, bent]), np.float32(-1.0))
        scale = pictured["normal_scale"][bent]
        s.ns[:, at] = _bent(flat, how[bent], index[bent], here[bent], texel, scale, direction[:, at])


def _show(
    flat: FlatScene, s: Any, which: Array, field: str, textures: Array, at: tuple[Array, ...]
) -> None:
    """Replace a colour of the materials of surfaces `which` by what pictures show there.

    at: u, v, and how far footprints reach in them.
    """
    assert flat.primaries is not None
    info = flat.scene[0]
    sky = [info[name] for name in ("sky_red", "sky_green", "sky_blue")]
    own = [flat.primaries[name][0] for name in ("red", "green", "blue")]
    basis = sky if field == "emission" else own
    for number in np.unique(textures[textures >= 0]):
        shown = np.flatnonzero(textures == number)
        red, green, blue = _shown(flat, number, *(one[shown] for one in at))[..., None]
        value = red * basis[0] + green * basis[1] + blue * basis[2]
        s.material[field][which[shown]] = value
        if field == "color":
            s.material["color2"][which[shown]] = value


def _turns(x: Array, y: Array) -> Array:
    angle = arctan2(y, x) * np.float32(0.159154943)
    return np.where(angle < 0.0, angle + ONE, angle)


def _place(flat: FlatScene, how: Array, index: Array, s: Any) -> tuple[Array, Array]:
    kind = how["kind"]
    u0, v0, u1, v1, u2, v2, _, _ = corners_of(flat, how, index)
    b, c = s.uv
    a = ONE - b - c
    x, y, z = along_rows(how, s)
    turns = _turns(x, y)
    down = arccos(z / np.sqrt(x * x + y * y + z * z)) * np.float32(0.318309886)
    kinds = [kind == _MAP[name] for name in ("MAP_MESH", "MAP_FLAT", "MAP_POLAR", "MAP_AXIAL")]
    u = np.select(kinds, [u0 * a + u1 * b + u2 * c, x, np.sqrt(x * x + y * y), turns], turns)
    v = np.select(kinds, [v0 * a + v1 * b + v2 * c, y, turns, z], down)
    return u, v


def _shown(flat: FlatScene, number: int, u: Array, v: Array, reach_u: Array, reach_v: Array) -> Array:
    """(3, n): what a picture shows, between two levels of those that have some."""
    assert flat.textures is not None
    how = flat.textures[number]
    found = _texels(flat, number, u, v)
    if not how["levels"]:
        return found
    level, share = levels_of(how, reach_u, reach_v)
    for k in range(int(how["levels"]) + 1):
        shown = _texels(flat, number + int(how["smaller"]) + k - 1, u, v) if k else found
        found = np.where(level == k, shown, found)
        found = np.where((level == k - 1) & (share > 0.0), found + (shown - found) * share, found)
    return found


def _texels(flat: FlatScene, number: int, u: Array, v: Array) -> Array:
    """(3, n): what a picture shows."""
    assert flat.textures is not None and flat.texels is not None
    how = flat.textures[number]
    first, width, height = (int(how[name]) for name in ("first", "width", "height"))
    back = _ZERO if how["nearest"] else np.float32(0.5)
    x = _wrapped(how, u * how["scale_u"] + how["offset_u"]) * np.float32(width) - back
    y = _wrapped(how, v * how["scale_v"] + how["offset_v"]) * np.float32(height) - back
    x0, y0 = np.floor(x), np.floor(y)
    picture = flat.texels[3 * first : 3 * (first + width * height)].reshape(height, width, 3)
    column, row = x0.astype(np.int32), y0.astype(np.int32)
    left, right = (_number(how, column + step, width) for step in (0, 1))
    top, bottom = (_number(how, row + step, height) for step in (0, 1))
    if how["nearest"]:
        return picture[top, left].T
    fx, fy = x - x0, y - y0
    corner = picture[top, left].T
    above = corner + (picture[top, right].T - corner) * fx
    corner = picture[bottom, left].T
    below = corner + (picture[bottom, right].T - corner) * fx
    return above + (below - above) * fy


def _wrapped(how: np.void, u: Array) -> Array:
    if how["wrap"] == _WRAP["WRAP_REPEAT"]:
        within = u - np.floor(u)
    elif how["wrap"] == _WRAP["WRAP_MIRROR"]:
        within = u - np.float32(2.0) * np.floor(u * np.float32(0.5))
    else:
        within = larger(smaller(u, ONE), _ZERO)
    return np.where((within >= 0.0) & (within <= 2.0), within, _ZERO)


def _number(how: np.void, i: Array, count: int) -> Array:
    if how["wrap"] == _WRAP["WRAP_REPEAT"]:
        i = np.where(i < 0, i + count, i)
        i = np.where(i >= count, i - count, i)
    elif how["wrap"] == _WRAP["WRAP_MIRROR"]:
        i = np.where(i < 0, i + 2 * count, i)
        i = np.where(i >= 2 * count, i - 2 * count, i)
        i = np.where(i >= count, 2 * count - 1 - i, i)
    return np.clip(i, 0, count - 1)


def _way_of_u(flat: FlatScene, how: Array, index: Array, s: Any, n: Array) -> tuple[Array, Array]:
    """The way in which u grows, of any length; negative where v grows to the right of it."""
    kind = how["kind"]
    mesh = kind == _MAP["MAP_MESH"]
    u0, v0, u1, v1, u2, v2, _, _ = corners_of(flat, how, index)
    triangle = flat.triangles[np.where(mesh, index, 0)]
    corner = xyz(triangle["v0"])
    e1, e2 = xyz(triangle["v1"]) - corner, xyz(triangle["v2"]) - corner
    area = (u1 - u0) * (v2 - v0) - (u2 - u0) * (v1 - v0)
    on_mesh = (e1 * (v2 - v0) + e2 * -(v1 - v0)) * np.where(area < 0.0, -ONE, ONE)

    x, y, z = along_rows(how, s)
    rows = [how[name][:, :3].T for name in ("row_u", "row_v", "row_w")]
    around = rows[1] * x + rows[0] * -y
    flat_map, polar, axial = (kind == _MAP[name] for name in ("MAP_FLAT", "MAP_POLAR", "MAP_AXIAL"))
    up_u = np.where(flat_map, rows[0], np.where(polar, rows[0] * x + rows[1] * y, around))
    up_v = np.where(flat_map, rows[1], np.where(polar, around, np.where(axial, rows[2], -rows[2])))
    ways = (rows[0] * x + rows[1] * y) * z - rows[2] * (x * x + y * y)
    up_v = np.where(kind == _MAP["MAP_NORMAL"], ways, up_v)
    way = cross(up_v, n)
    hand = dot(up_u, way)
    way = np.where(kind == _MAP["MAP_NORMAL"], around, way * np.where(hand < 0.0, -ONE, ONE))
    return np.where(mesh, on_mesh, way), np.where(mesh, dot(cross(e1, e2), n) * area, hand)


def _bent(
    flat: FlatScene, how: Array, index: Array, s: Any, texel: Array, scale: Array, direction: Array
) -> Array:
    x, y, z = texel[0] * scale, texel[1] * scale, texel[2]
    n = np.where(dot(s.smooth, s.smooth) > 0.0, s.smooth, s.outward)
    way, hand = _way_of_u(flat, how, index, s, n)
    way = way - n * dot(way, n)
    most = largest_coordinate(way)
    tangent = np.where((most > 0.0) & (most < np.inf), unit_of_any(way), frame_about(n)[0])
    bitangent = cross(n, tangent)
    bitangent = np.where(hand < 0.0, bitangent, -bitangent)
    bent = unit_of_any(tangent * x + bitangent * y + n * z)
    bent = np.where(dot(bent, s.n) < 0.0, -bent, bent)
    straight = (x == 0.0) & (y == 0.0) & (z > 0.0)
    return np.where((dot(bent, direction) < 0.0) & ~straight, bent, s.ns)
