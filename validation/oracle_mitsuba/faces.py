"""Polygons, boxes and meshes as triangles."""

from __future__ import annotations

from typing import Any

import numpy as np

from . import meshing
from .forms import Array
from .meshing import Triangles
from .shapes import Box, Mesh


def moved(mesh: Triangles, to_world: Array) -> Triangles:
    """A mesh in world space: normals by the inverse transpose, windings kept facing them."""
    linear = to_world[:3, :3]
    normals = mesh.normals @ np.linalg.inv(linear)
    length = np.linalg.norm(normals, axis=1, keepdims=True)
    faces = mesh.faces[:, ::-1] if np.linalg.det(linear) < 0 else mesh.faces
    placed = mesh.vertices @ linear.T + to_world[:3, 3]
    return Triangles(placed, faces, normals / length, mesh.uv, mesh.colors)


def triangles(shape: Any) -> tuple[Triangles, bool]:
    """A polygon, box or mesh in world space, and whether its normals are for shading, not its faces'."""
    if isinstance(shape, Box):
        return _box(shape), False
    mirrored = np.linalg.det(shape.matrix[:3, :3]) < 0
    if isinstance(shape, Mesh):
        data = shape.data()
        if data.normals is not None:
            corners = data.faces if isinstance(data.faces, np.ndarray) else _fan(data.faces)
            smooth = Triangles(data.vertices, np.asarray(corners), data.normals, data.uv, data.colors)
            return moved(smooth, shape.matrix), True
        if data.colors is not None:
            of_vertices = len(data.colors) == len(data.vertices)
            own = data.colors[data.faces] if of_vertices else data.colors
            return _triangles(data.vertices[data.faces], shape.matrix, colors=own), False
        if data.uv is not None:
            fans = np.asarray(data.faces if isinstance(data.faces, np.ndarray) else _fan(data.faces))
            return _triangles(data.vertices[fans], shape.matrix, data.uv[fans]), False
        if isinstance(data.faces, np.ndarray):
            return _triangles(data.vertices[data.faces], shape.matrix), False
        outlines: Any = [data.vertices[face] for face in data.faces]
    else:
        outlines = [np.asarray(shape.points)]
    placed = [outline @ shape.matrix[:3, :3].T + shape.matrix[:3, 3] for outline in outlines]
    return _flat([outline[::-1] if mirrored else outline for outline in placed]), False


def _fan(faces: tuple[Array, ...]) -> Array:
    return np.concatenate([np.c_[np.full(len(f) - 2, f[0]), f[1:-1], f[2:]] for f in faces])


def _triangles(corners: Array, to_world: Array, uv: Array | None = None,
               colors: Array | None = None) -> Triangles:  # fmt: skip
    """Triangles (m, 3, 3) as a flat mesh in world space."""
    across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    length = np.linalg.norm(across, axis=1)
    spanning = length > 0  # one without area is never hit
    normals = np.repeat(across[spanning] / length[spanning, None], 3, axis=0)
    vertices = corners[spanning].reshape(-1, 3)
    places = None if uv is None else uv[spanning].reshape(-1, 2)
    tones = None if colors is None else colors[spanning].reshape(-1, 3)
    own = np.arange(len(vertices)).reshape(-1, 3)
    return moved(Triangles(vertices, own, normals, places, tones), to_world)


def _flat(outlines: list[Array]) -> Triangles:
    """Plane polygons as triangles; every corner has its polygon's normal, found in float64."""
    vertices, faces, normals, count = [], [], [], 0
    for outline in outlines:
        local = outline - outline[0]
        normal = np.sum(np.cross(local, np.roll(local, -1, axis=0)), axis=0)
        length = np.linalg.norm(normal)
        if length == 0:
            continue  # a triangle without area is never hit
        places, triangles = meshing.polygon(outline)
        vertices.append(places)
        faces.append(triangles + count)
        normals.append(np.tile(normal / length, (len(places), 1)))
        count += len(places)
    if not vertices:
        return Triangles(np.zeros((0, 3)), np.zeros((0, 3), int), np.zeros((0, 3)))
    return Triangles(np.concatenate(vertices), np.concatenate(faces), np.concatenate(normals))


def _box(shape: Box) -> Triangles:
    """All sides at once: a scene may have thousands of boxes."""
    low, high = np.asarray(shape.min, float), np.asarray(shape.max, float)
    sides = np.where(_SIDES, high, low) @ shape.matrix[:3, :3].T + shape.matrix[:3, 3]
    if np.linalg.det(shape.matrix[:3, :3]) < 0:
        sides = sides[:, ::-1]
    across = np.cross(sides[:, 2] - sides[:, 0], sides[:, 3] - sides[:, 1])
    length = np.linalg.norm(across, axis=1)
    spanning = length > 0  # of a flat box the others are never hit
    normals = np.repeat(across[spanning] / length[spanning, None], 4, axis=0)
    corners = sides[spanning].reshape(-1, 3)
    first = 4 * np.arange(len(corners) // 4)[:, None, None]
    halves = np.array([[0, 1, 2], [0, 2, 3]])
    return Triangles(corners, (first + halves).reshape(-1, 3), normals)


def box_sides(low: Array, high: Array) -> list[Array]:
    """The six sides (4, 3) of a box, counter-clockwise from outside: -x +x -y +y -z +z."""
    sides = []
    for axis in range(3):
        u, v = (axis + 1) % 3, (axis + 2) % 3
        for end, outwards in ((low, False), (high, True)):
            side = np.tile(end, (4, 1)).astype(float)
            side[:, u] = [low[u], high[u], high[u], low[u]]
            side[:, v] = [low[v], low[v], high[v], high[v]]
            sides.append(side if outwards else side[::-1])
    return sides


_SIDES = np.array(box_sides(np.zeros(3), np.ones(3))) > 0.5
"""Which coordinates of the corners (6, 4, 3) are the larger ones."""
