"""The float32 twin's footprints in pictures, and the mip levels that show them."""

from __future__ import annotations

from typing import Any

import numpy as np

from clrt import layout
from clrt.flatten.flatten import FlatScene

from .geometry import from_axes, quadric_form, to_axes
from .math import ONE, Array, cross, dot, larger, smaller, xyz

_MAP = layout.MAPPINGS


def _along(row: Array, p: Array) -> Array:
    return row[:, 0] * p[0] + row[:, 1] * p[1] + row[:, 2] * p[2] + row[:, 3]


def corners_of(flat: FlatScene, how: Array, index: Array) -> Array:
    """(8, n): u and v of the three corners of triangles, and two numbers that are 0."""
    assert flat.corner_uv is not None
    first = np.where(how["kind"] == _MAP["MAP_MESH"], index + how["corners"], 0)
    table = flat.corner_uv.reshape(-1, 8) if len(flat.corner_uv) > 1 else np.zeros((1, 8), np.float32)
    return table[first].T


def along_rows(how: Array, s: Any) -> tuple[Array, Array, Array]:
    """Points or normals along the rows of mappings."""
    p = np.where(how["kind"] == _MAP["MAP_NORMAL"], s.outward, s.point)
    x, y, z = (_along(how[name], p) for name in ("row_u", "row_v", "row_w"))
    return x, y, z


def reaches(flat: FlatScene, how: Array, index: Array, s: Any, direction: Array) -> Array:
    """(2, n): how far footprints of surfaces `s` reach in u and in v."""
    cosine, width = dot(s.outward, direction), s.footprint[2]
    found = []
    for gradient in _gradients(flat, how, index, s):
        across = gradient - s.outward * (dot(gradient, direction) / cosine)
        found.append(np.where(width > 0.0, width * np.sqrt(dot(across, across)), np.float32(0.0)))
    return np.stack(found)


def levels_of(texture: np.void, reach_u: Array, reach_v: Array) -> tuple[Array, Array]:
    """The larger of the two levels between which a picture is shown, (n,) int32; the smaller one's share."""
    across = larger(
        reach_u * (np.abs(texture["scale_u"]) * np.float32(texture["width"])),
        reach_v * (np.abs(texture["scale_v"]) * np.float32(texture["height"])),
    )
    x = larger(smaller(across, np.float32(2.0 ** int(texture["levels"]))), ONE).astype(np.float32)
    bits = x.view(np.int32)
    share = (bits & 0x7FFFFF | 0x3F800000).view(np.float32) - ONE
    return (bits >> 23) - 127, share


def _gradients(flat: FlatScene, how: Array, index: Array, s: Any) -> tuple[Array, Array]:
    """Those of u and v, each plus a multiple of the surface's normal."""
    kind = how["kind"]
    rows = [how[name][:, :3].T for name in ("row_u", "row_v", "row_w")]
    x, y, z = along_rows(how, s)
    square = x * x + y * y
    rim = np.sqrt(square)
    away = rows[0] * x + rows[1] * y
    around = (rows[1] * x + rows[0] * -y) * (np.float32(0.159154943) / square)
    down = (away * (z / rim) + rows[2] * -rim) * (np.float32(0.318309886) / (square + z * z))
    of_u, of_v = _over_normals(flat, how, index, s, around, down)
    flat_u, flat_v = _over_triangles(flat, how, index, s)
    kinds = [kind == _MAP[name] for name in ("MAP_MESH", "MAP_FLAT", "MAP_POLAR", "MAP_AXIAL", "MAP_SPHERE")]
    return (
        np.select(kinds, [flat_u, rows[0], away * (ONE / rim), around, around], of_u),
        np.select(kinds, [flat_v, rows[1], around, rows[2], down], of_v),
    )


def _over_triangles(flat: FlatScene, how: Array, index: Array, s: Any) -> tuple[Array, Array]:
    u0, v0, u1, v1, u2, v2, _, _ = corners_of(flat, how, index)
    triangle = flat.triangles[np.where(how["kind"] == _MAP["MAP_MESH"], index, 0)]
    corner = xyz(triangle["v0"])
    e1, e2 = xyz(triangle["v1"]) - corner, xyz(triangle["v2"]) - corner
    first, second = cross(e2, s.outward), cross(s.outward, e1)
    share = ONE / dot(e1, first)
    of_u = (first * (u1 - u0) + second * (u2 - u0)) * share
    return of_u, (first * (v1 - v0) + second * (v2 - v0)) * share


def _over_normals(
    flat: FlatScene, how: Array, index: Array, s: Any, of_u: Array, of_v: Array
) -> tuple[Array, Array]:
    """Gradients over unit normals, which turn as points on spheres and quadrics move."""
    by_normal = how["kind"] == _MAP["MAP_NORMAL"]
    bent = by_normal & (how["quadric"] != 0)
    radius = flat.spheres["center_radius"][np.where(by_normal & ~bent, index, 0), 3]
    q = flat.quadrics[np.where(bent, index, 0)]
    axes, form, g, _ = quadric_form(q)
    slope = form * to_axes(axes, s.point - xyz(q["center"])) + g
    share = ONE / np.sqrt(dot(slope, slope))
    u, v = (
        np.where(bent, from_axes(axes, form * to_axes(axes, of)) * share, of * (ONE / radius))
        for of in (of_u, of_v)
    )
    return u, v
