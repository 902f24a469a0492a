"""The parts of a mesh file: how large they say they are, and all of them joined in world space.

A part may stand at many places. What all of them together come to is checked against the limits before any of
their numbers is read.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from clrt.meshfiles.broken import BrokenMesh
from clrt.meshfiles.look import NONE, Look, Used

Arrays = tuple[np.ndarray, np.ndarray, np.ndarray | None, np.ndarray | None]
"""Vertices (n, 3), triangles (m, 3) of vertex numbers, normals (n, 3) or None, uv (n, 2) or None.

uv have v = 0 at the top row of a picture.
"""

MOST_GROUPS = 4096  # shapes of their own that a file is taken apart to
_BLOCK = 1 << 16  # vertices and triangles that are moved at a time


@dataclass(frozen=True, eq=False)
class Part:
    """`vertices` and `faces` are how many there are; `read` gives the arrays, `color` the mean of
    the vertices' colours, linear, (3,), `corners` those of each triangle's corners, (faces, 3, 3)."""

    vertices: int
    faces: int
    normals: bool
    colored: bool
    read: Callable[[], Arrays]
    uv: bool = False
    color: Callable[[], np.ndarray] | None = None
    corners: Callable[[], np.ndarray] | None = None


@dataclass(frozen=True, eq=False)
class Placed:
    """The parts of a file, and where they stand.

    Place i of p, in the file's order, has the part `which[i]` and the (4, 4) matrix to the world
    `matrices[where[i]]`. `left_out` is what of the file is not read and would change where they stand.
    Its material has the number `materials[i]` (None: no place has one); `names[where[i]]` is what the file
    calls what stands there. `look` says what the materials of some numbers are (with each: whether what has
    it has uv), and what else makes the picture, given the middle and the radius of all that is placed.
    `colors`: the number of the file's picture that its vertices' colours make. `textured`: whether the
    material of a number may show pictures. `warn`: what of it is read otherwise than it stands there.
    """

    parts: Sequence[Part]
    which: np.ndarray
    where: np.ndarray
    matrices: np.ndarray
    left_out: tuple[str, ...] = ()
    materials: np.ndarray | None = None
    names: Sequence[str] = ()
    look: Callable[[Used, np.ndarray, float], Look] | None = None
    colors: int = 0
    textured: Callable[[int], bool] = lambda number: True
    warn: Callable[[str], None] = lambda text: None

    @cached_property
    def groups(self) -> list[tuple[int, int, np.ndarray]]:
        """Of each number that a shape may name: where it stands, its material, and its places, ascending.

        What stands at one place and has one material goes together, but what lacks the uv for its textures is
        apart; all of one material does where there would be more than `MOST_GROUPS`, and then stands nowhere:
        NONE. BrokenMesh for more materials.
        """
        materials = np.full(len(self.which), NONE) if self.materials is None else self.materials
        textured = np.array([m != NONE and self.textured(m) for m in materials.tolist()], bool)
        bare = textured & ~np.array([part.uv for part in self.parts], bool)[self.which]
        pairs = np.stack([self.where, materials, bare], axis=1).astype(np.int64)
        found, first, group = np.unique(pairs, axis=0, return_index=True, return_inverse=True)
        if len(found) > MOST_GROUPS:
            pairs[:, 0] = NONE
            found, first, group = np.unique(pairs, axis=0, return_index=True, return_inverse=True)
        if len(found) > MOST_GROUPS:
            raise BrokenMesh(f"it shows {len(found)} materials; at most {MOST_GROUPS} are read")
        order = np.lexsort((first, -found[:, 0]))  # as in the file: readers walk what stands in it backwards
        sorted_places = np.argsort(group.reshape(-1), kind="stable")
        places = np.split(sorted_places, np.cumsum(np.bincount(group.reshape(-1)))[:-1])
        return [(*found[number, :2].tolist(), places[number]) for number in order]

    def only(self, places: np.ndarray) -> Placed:
        """Some of the places."""
        used, which = np.unique(self.which[places], return_inverse=True)
        parts = [self.parts[number] for number in used]
        return replace(self, parts=parts, which=which.reshape(-1), where=self.where[places], materials=None)

    def sizes(self, smooth: bool | None) -> tuple[int, int]:
        """Vertices and triangles of all places, as `joined` makes them."""
        counts = np.bincount(self.which, minlength=len(self.parts)).tolist()
        own = self.own(smooth)
        vertices = sum(n * _vertices(part, own, smooth) for n, part in zip(counts, self.parts, strict=True))
        return vertices, sum(n * part.faces for n, part in zip(counts, self.parts, strict=True))

    def own(self, smooth: bool | None) -> bool:
        """Whether the file's own normals count."""
        return smooth is not False and any(part.normals for part in self.parts)

    def joined(self, smooth: bool | None) -> Arrays:
        """All places in world space, outer sides still outside; `smooth` as in `read_mesh_file`."""
        own = self.own(smooth)
        lengths = np.array([[_vertices(part, own, smooth), part.faces] for part in self.parts])[self.which]
        firsts = np.cumsum(lengths, axis=0)
        corners, sides = firsts[-1].tolist()
        firsts -= lengths
        del lengths  # as large as the numbers of a small part
        vertices, faces = np.empty((corners, 3)), np.empty((sides, 3), np.int32)
        normals = np.empty_like(vertices) if own else None
        # a part without has none to find in a picture: all its corners are at one place of it
        uv = np.zeros((corners, 2)) if any(part.uv for part in self.parts) else None
        order = np.argsort(self.which, kind="stable")
        bounds = np.searchsorted(self.which[order], np.arange(len(self.parts) + 1))
        for number, part in enumerate(self.parts):
            points, triangles, directions, flat = _prepared(part.read(), own, smooth, self.warn)
            step = max(1, _BLOCK // max(len(points), len(triangles)))
            for start in range(bounds[number], bounds[number + 1], step):
                places = order[start : min(start + step, bounds[number + 1])]
                matrices = self.matrices[self.where[places]]
                linear = matrices[:, :3, :3]
                mirrored = np.linalg.det(linear) < 0
                first = firsts[places]
                at = first[:, :1] + np.arange(len(points))
                vertices[at] = points @ linear.transpose(0, 2, 1) + matrices[:, None, :3, 3]
                turned = np.where(mirrored[:, None, None], triangles[:, ::-1], triangles)
                faces[first[:, 1:] + np.arange(len(triangles))] = turned + first[:, :1, None]
                if uv is not None and flat is not None:
                    uv[at] = flat
                if normals is not None and directions is not None:
                    # the inverse transpose, times the determinant
                    cofactors = np.cross(linear[:, [1, 2, 0]], linear[:, [2, 0, 1]])
                    sign = np.where(mirrored, -1.0, 1.0)[:, None, None]
                    normals[at] = _units(directions @ cofactors.transpose(0, 2, 1) * sign)
        if own:
            return vertices, faces, normals, uv
        return vertices, faces, smooth_normals(vertices, faces) if smooth else None, uv


def smooth_normals(vertices: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """`vertex_normals` with all vertices at one position taken as one."""
    places, place = np.unique(vertices, axis=0, return_inverse=True)
    place = place.reshape(-1)
    return vertex_normals(places, place[faces])[place]


def vertex_normals(vertices: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Unit normals (n, 3), the mean of the adjoining triangles' weighted by area; z where that vanishes."""
    normals = np.zeros_like(vertices)
    a, b, c = (vertices[triangles[:, corner]] for corner in range(3))
    across = _cross(b - a, c - a)
    for corner in range(3):
        np.add.at(normals, triangles[:, corner], across)
    return _units(normals)


def _vertices(part: Part, own: bool, smooth: bool | None) -> int:
    """The part's vertices once it is `_prepared`."""
    return 3 * part.faces if own and not part.normals and not smooth else part.vertices


def _prepared(arrays: Arrays, own: bool, smooth: bool | None, warn: Callable[[str], None]) -> Arrays:
    """Arrays with normals if the file's own count, and none are there.

    These are smooth ones, or each triangle's own on corners of its own. Smooth ones take the place of those
    that have no direction, which programs write that made none, or failed to.
    """
    vertices, faces, normals, uv = arrays
    if not own:
        return arrays
    if normals is not None:
        length = np.linalg.norm(normals, axis=1)
        lost = np.zeros(len(vertices), bool)
        lost[faces] = ~((length > 0) & (length < np.inf))[faces]
        if lost.any():
            text = "of its normals have no direction; those of the triangles there take their place"
            warn(f"{lost.sum()} {text}")
            normals = np.where(lost[:, None], smooth_normals(vertices, faces), normals)
        return vertices, faces, normals, uv
    if smooth:
        return vertices, faces, smooth_normals(vertices, faces), uv
    corners = faces.reshape(-1)
    vertices, faces = vertices[corners], np.arange(faces.size).reshape(-1, 3)
    return vertices, faces, vertex_normals(vertices, faces), None if uv is None else uv[corners]


def _cross(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """As `np.cross` of (n, 3), which takes longer over few than over their arithmetic."""
    x, y, z = a.T
    u, v, w = b.T
    return np.stack([y * w - z * v, z * u - x * w, x * v - y * u], axis=1)


def _units(vectors: np.ndarray) -> np.ndarray:
    """Vectors (..., 3) of length 1; z for those of length 0."""
    length = np.linalg.norm(vectors, axis=-1, keepdims=True)
    return np.where(length > 0, vectors / np.where(length > 0, length, 1.0), (0.0, 0.0, 1.0))
