"""Concave faces, cut into triangles that cover the face and no more.

trimesh cuts all about their first corner. Faces that such a fan covers exactly stay as it cuts them. Other
quadrilaterals are cut along their other diagonal, and faces of more corners by ear clipping
(`mapbox_earcut`), seen along an axis.
"""

from __future__ import annotations

import math
import re
from collections import defaultdict
from collections.abc import Callable, Sequence
from typing import Any, Final

import numpy as np

from clrt.base.install import pip_install
from clrt.meshfiles.planar import FLATNESS

Ears = Callable[[np.ndarray, np.ndarray], np.ndarray]

_POINTS: Final = 1 << 16  # corners looked at together
_FEW: Final = 8  # corners of a face for which numpy takes far longer than Python
_MANY: Final = 64  # corners of a face, from which on ear clipping's time is of account
_MOST: Final = 1 << 26  # of squared corners of all such faces: half a second where they cross themselves
_TURN: Final = np.array([[0.8, 0.6], [-0.6, 0.8]])
_POLYGON: Final = re.compile(rb"^f +[^\s]+ +[^\s]+ +[^\s]+ +[^\s]", re.MULTILINE)
_CROSSED: Final = "faces that cross themselves or are far from plane are cut about one corner"
_LISTS: Final = ("vertex_index", "vertex_indices")  # of a PLY's faces, in trimesh's order


class Outlines:
    """Cuts the concave faces of one file; `left_over`: what stays as it was, and what to do.

    instead: clips ears where mapbox_earcut is not installed.
    """

    def __init__(self, instead: Ears | None = None) -> None:
        self.left_over: dict[str, None] = {}
        self._instead = instead
        self._cost = 0

    def obj(self, data: bytes) -> bytes:
        """An OBJ's plain lines, with its concave faces in triangles; `data` itself where it has none."""
        if not _POLYGON.search(data):
            return data
        lines = data.replace(b"\r\n", b"\n").replace(b"\\\n", b"").split(b"\n")
        vertices = np.array([line.split()[1:4] for line in lines if line.startswith(b"v ")], np.float64)
        places: dict[int, list[int]] = defaultdict(list)
        for place, line in enumerate(lines):
            if line.startswith(b"f ") and (size := len(line.split()) - 1) > 3:
                places[size].append(place)
        changed = False
        for which in places.values():
            numbers = [[int(corner.partition(b"/")[0]) for corner in lines[k].split()[1:]] for k in which]
            rows, cuts = self.cut(vertices, np.array(numbers) - 1)
            changed |= len(rows) > 0
            for row, cut in zip(rows, cuts, strict=True):
                words = lines[which[row]].split()[1:]
                triangles = [b"f " + b" ".join([words[k] for k in three]) for three in cut]
                lines[which[row]] = b"\n".join(triangles)
        return b"\n".join(lines) if changed else data

    def ply(self, vertices: np.ndarray, faces: np.ndarray, elements: dict[str, Any]) -> np.ndarray:
        """The triangles (m, 3) that trimesh made of a PLY's `elements`, with its concave faces cut anew."""
        sizes = _sizes(elements)
        if np.any(sizes > 3):
            faces = self._cut_ply(vertices, faces.copy(), sizes)
        if np.any(sizes < 3):
            self.left_over["faces of fewer than 3 corners are left out"] = None
        return faces

    def _cut_ply(self, vertices: np.ndarray, faces: np.ndarray, sizes: np.ndarray) -> np.ndarray:
        """The triangles, changed in place, of faces of so many corners."""
        # trimesh's order: triangles, first halves of quadrilaterals, second halves, fans
        quads = np.sum(sizes == 4)
        first = np.sum(sizes == 3) + np.stack([np.arange(quads), quads + np.arange(quads)], axis=1)
        self._anew(vertices, faces, first, [0, 0, 0, 1], [0, 1, 2, 1])
        after = np.cumsum(np.where(sizes > 4, sizes - 2, 0)) + np.sum(sizes == 3) + 2 * quads
        for size in np.unique(sizes[sizes > 4]):
            fans = after[sizes == size, None] + np.arange(2 - size, 0)
            self._anew(vertices, faces, fans, [0, 0, *range(size - 2)], [0, 1, *[2] * (size - 2)])
        return faces

    def _anew(self, vertices: np.ndarray, faces: np.ndarray, rows: np.ndarray, at: Any, of: Any) -> None:
        """Cut polygons anew in place, the triangles of each in a row of `rows`.

        Its corners are the corners `of` of the triangles `at` of these.
        """
        corners = faces[rows[:, at], of]
        which, cuts = self.cut(vertices, corners)
        faces[rows[which]] = corners[which[:, None, None], cuts]

    def cut(self, vertices: np.ndarray, corners: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Which of the faces (m, n > 3) to cut anew, and how: places (k, n - 2, 3) of corners in a face."""
        size = corners.shape[1]
        middle = np.arange(1, size - 1)
        fan = np.stack([np.zeros_like(middle), middle, middle + 1], axis=1)
        step = max(1, _POINTS // size)
        found = [np.zeros(0, np.int64)]
        for start in range(0, len(corners), step):
            found.append(start + np.flatnonzero(_wrong(_local(vertices[corners[start : start + step]]), fan)))
        rows = np.concatenate(found)
        points = _local(vertices[corners[rows]])
        cuts = np.broadcast_to(fan, (len(rows), *fan.shape)).copy()
        if size == 4:
            cuts[:] = [[1, 2, 3], [3, 0, 1]]
        elif len(rows) and (ears := self._ears()):
            whole = _normals(points, fan).sum(axis=1)
            axis = np.abs(whole).argmax(axis=1)[:, None]
            flat = np.take_along_axis(points, np.stack([(axis + 1) % 3, (axis + 2) % 3], axis=2), axis=2)
            for k in range(len(rows)):
                cuts[k] = self._clipped(flat[k], fan, ears)
            turned = np.einsum("mtk,mk->m", _normals(points, cuts), whole) < 0
            cuts[turned] = cuts[turned, :, ::-1]
        good = ~_wrong(points, cuts)
        if not good.all() and not self.left_over:
            self._leave(_CROSSED)
        return rows[good], cuts[good]

    def triangles(self, vertices: np.ndarray, faces: Sequence[np.ndarray] | np.ndarray) -> np.ndarray:
        """Triangles (m, 3) of faces of 3 or more corners: fans, and others where these cover too much."""
        found, sizes = [np.zeros((0, 3), np.int64)], np.fromiter(map(len, faces), np.int64, len(faces))
        for size in np.unique(sizes):
            corners = np.array([faces[int(k)] for k in np.flatnonzero(sizes == size)])
            middle = np.arange(1, size - 1)
            fan = np.stack([np.zeros_like(middle), middle, middle + 1], axis=1)
            cuts = np.broadcast_to(fan, (len(corners), *fan.shape)).copy()
            if size > 3:
                rows, better = self.cut(vertices, corners)
                cuts[rows] = better
            found.append(corners[np.arange(len(corners))[:, None, None], cuts].reshape(-1, 3))
        return np.concatenate(found)

    def few(self, vertices: np.ndarray, face: np.ndarray) -> tuple[np.ndarray, ...] | None:
        """What `cut` makes of one face of few corners: itself, or triangles. None where that is not clear.

        For a face alone numpy takes ten times as long.
        """
        if len(face) > _FEW:
            return (face,) if len(face) == 3 else None
        points = _local(vertices[face][None])[0].tolist()
        fan = [[0, k, k + 1] for k in range(1, len(face) - 1)]
        whole, excess = _covered(points, fan)
        if excess <= 0.1 * FLATNESS:
            return (face,)
        cuts = [[1, 2, 3], [3, 0, 1]]
        if len(face) > 4 and (ears := self._ears()):
            axis = max(range(3), key=lambda k: abs(whole[k]))
            flat = np.array([(point[(axis + 1) % 3], point[(axis + 2) % 3]) for point in points])
            cuts = self._clipped(flat, np.array(fan), ears).tolist()
        if excess < 10 * FLATNESS or len(cuts) != len(fan):
            return None
        turned, excess = _covered(points, cuts)
        if excess >= 10 * FLATNESS:
            self._leave(_CROSSED)
            return (face,)
        if excess > 0.1 * FLATNESS:
            return None
        way = -1 if sum(a * b for a, b in zip(turned, whole, strict=True)) < 0 else 1
        triangles = face[np.array(cuts)[:, ::way]]
        triangles.flags.writeable = False
        return tuple(triangles)

    def _clipped(self, flat: np.ndarray, fan: np.ndarray, ears: Ears) -> np.ndarray:
        """The triangles (n - 2, 3) of a face (n, 2), or the `fan` where it cannot be cut."""
        size = len(flat)
        self._cost += size * size if size > _MANY else 0
        for _ in range(3):
            if self._cost > _MOST:
                self._leave("concave faces are too many or too large to be cut well, and some cover too much")
                break
            found = ears(flat, np.array([size], np.uint32)).reshape(-1, 3)
            if len(found) == len(fan):
                return found
            # corners in line with their neighbours may be lost to rounding: other rounding keeps them
            flat = np.ascontiguousarray(flat @ _TURN)
            self._cost += max(size, _MANY) ** 2
        return fan

    def _ears(self) -> Ears | None:
        try:
            from mapbox_earcut import triangulate_float64
        except ImportError:
            if self._instead is not None:
                return self._instead
            text = "concave faces of more than 4 corners are cut about one corner and cover too much"
            self._leave(text, f"install mapbox-earcut with: {pip_install('mapbox-earcut')}")
            return None
        return triangulate_float64

    def _leave(self, what: str, remedy: str = "save it in triangles") -> None:
        self.left_over[f"{what}; {remedy}"] = None


def rows_of(elements: dict[str, Any]) -> np.ndarray:
    """Of each triangle that trimesh makes of a PLY's `elements`, in its order, the row of its face."""
    sizes = _sizes(elements)
    quads, fans = np.flatnonzero(sizes == 4), np.flatnonzero(sizes > 4)
    return np.concatenate([np.flatnonzero(sizes == 3), quads, quads, np.repeat(fans, sizes[fans] - 2)])


def corners_of(elements: dict[str, Any]) -> Sequence[np.ndarray] | np.ndarray:
    """The corners of the faces of a PLY, as trimesh read it."""
    rows = elements.get("face", {}).get("data")
    if isinstance(rows, dict):
        return next((rows[name] for name in _LISTS if name in rows), ())
    if isinstance(rows, np.ndarray) and rows.dtype.names:
        names = rows.dtype.names
        lists: np.ndarray = rows[next((name for name in _LISTS if name in names), names[0])]["f1"]
        return lists
    return ()


def _sizes(elements: dict[str, Any]) -> np.ndarray:
    """How many corners they have."""
    return np.array([len(corners) for corners in corners_of(elements)], np.int64)


def _local(points: np.ndarray) -> np.ndarray:
    """Faces (m, n, 3) from their first corners, and of size 1."""
    local = points - points[:, :1]
    size = np.abs(local).max(axis=(1, 2), initial=0.0)
    return local / np.where(size > 0, size, 1.0)[:, None, None]


def _normals(points: np.ndarray, cuts: np.ndarray) -> np.ndarray:
    """The normals (m, n - 2, 3), twice the area long, of triangles (n - 2, 3) or (m, n - 2, 3) of faces."""
    cuts = np.broadcast_to(cuts, (len(points), *cuts.shape[-2:]))
    a, b, c = np.moveaxis(points[np.arange(len(points))[:, None, None], cuts], 2, 0)
    return np.cross(b - a, c - a)


def _covered(points: Sequence[Sequence[float]], cuts: Sequence[Sequence[int]]) -> tuple[list[float], float]:
    """The sum of the normals of a face's triangles, twice the area long, and by which share of its area they
    cover more than it: as `_wrong` has it, of one face."""
    normals = []
    for k, m, n in cuts:
        x0, y0, z0 = points[k]
        ax, ay, az = (a - b for a, b in zip(points[m], (x0, y0, z0), strict=True))
        bx, by, bz = (a - b for a, b in zip(points[n], (x0, y0, z0), strict=True))
        normals.append((ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx))
    x, y, z = whole = [sum(part) for part in zip(*normals, strict=True)]
    area, each = x * x + y * y + z * z, sum(a * a + b * b + c * c for a, b, c in normals)
    if each <= 1e-15:
        return whole, 0.0
    if area < 1e-6 * each:
        return whole, math.inf
    return whole, sum(abs(a * x + b * y + c * z) for a, b, c in normals) / area - 1.0


def _wrong(points: np.ndarray, cuts: np.ndarray) -> np.ndarray:
    """Whether the triangles (n - 2, 3) or (m, n - 2, 3) of faces (m, n, 3) cover more than these."""
    normals = _normals(points, cuts)
    whole = normals.sum(axis=1)
    area, all_of_them = (whole * whole).sum(axis=1), (normals * normals).sum(axis=(1, 2))
    covered = np.abs(np.einsum("mtk,mk->mt", normals, whole)).sum(axis=1)
    cancelled = area < 1e-8 * all_of_them  # as in an hourglass
    return (all_of_them > 1e-14) & (cancelled | (covered > (1.0 + FLATNESS) * area))
