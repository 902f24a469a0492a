"""A tree's rays as coloured tubes among the shapes that they meet: a .glb for any viewer of 3D models."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

import numpy as np

from clrt.base import notices
from clrt.base.room import check_date
from clrt.raytree.solids import COARSE, FINE, triangles_of
from clrt.raytree.ways import COLOURS, ways
from clrt.scene.mesh import Mesh

if TYPE_CHECKING:
    from clrt.raytree.tree import RayTree

_THICK: Final = 0.004  # of the box around all, for a ray that brings everything
_SIDES: Final = 8
_GLASS: Final = (200, 210, 220, 70)  # colour of shapes
_MOST: Final = 2_000_000  # vertices of shapes, each of which takes some 130 bytes
_NODE: Final = 64  # as many take what a shape takes besides


def glb(tree: RayTree) -> bytes:
    """A binary glTF: a node for each ray, named as in the tree, and one for each shape of the scene.

    Of very many shapes, those that no ray meets are coarser, and then left out, which a warning says.
    """
    check_date()
    import trimesh

    all_ways, low, high = ways(tree)
    size = float(np.linalg.norm(high - low))
    model = trimesh.Scene()
    shapes, room, left = tree.scene.shapes, _MOST, 0
    met = {ray.hit.shape for ray in tree.rays if ray.hit is not None}
    for number in sorted(range(len(shapes)), key=lambda number: number not in met):
        shape = shapes[number]
        if number not in met and room <= (len(shape.data().vertices) if isinstance(shape, Mesh) else 0):
            left += 1
            continue
        made = triangles_of(shape, low, high, FINE if 2 * room > _MOST else COARSE)
        room -= _NODE
        if made is not None:
            _add(trimesh, model, tree.names.shape(number), *made, _GLASS)
            room -= len(made[0])
    if left:
        text = f"a .glb holds about {_MOST} vertices of shapes: {left} of {len(shapes)}, which no ray of this"
        notices.warn(tree.scene.source, "", f"{text} pixel meets, are left out")
    for count, way in enumerate(all_ways):
        radius = size * _THICK * (0.25 + 0.75 * np.sqrt(min(max(way.share, 0.0), 1.0)))
        if way.kind in ("light", "blocked"):
            radius = size * _THICK * 0.2
        made = _tube(way.start, way.end, radius)
        if made is not None:
            _add(trimesh, model, f"{way.kind} of ray {way.ray} ({count})", *made, (*COLOURS[way.kind], 255))
    written: bytes = model.export(file_type="glb")
    return written


def _add(
    trimesh: Any, model: Any, name: str, vertices: np.ndarray, faces: np.ndarray, colour: tuple[int, ...]
) -> None:
    material = trimesh.visual.material.PBRMaterial(
        baseColorFactor=colour, metallicFactor=0.0, roughnessFactor=0.6, doubleSided=True,
        alphaMode="BLEND" if colour[3] < 255 else "OPAQUE",
    )  # fmt: skip
    mesh = trimesh.Trimesh(vertices, faces, process=False)
    mesh.visual = trimesh.visual.TextureVisuals(material=material)
    model.add_geometry(mesh, node_name=name, geom_name=name)


def _tube(start: np.ndarray, end: np.ndarray, radius: float) -> tuple[np.ndarray, np.ndarray] | None:
    """A prism around the line; None for one of no length."""
    axis = end - start
    length = float(np.linalg.norm(axis))
    if not (length > 0 and np.isfinite(length)):
        return None
    axis = axis / length
    one = np.cross(axis, np.eye(3)[np.argmin(np.abs(axis))])
    one /= np.linalg.norm(one)
    angle = np.linspace(0, 2 * np.pi, _SIDES, endpoint=False)
    ring = radius * (np.cos(angle)[:, None] * one + np.sin(angle)[:, None] * np.cross(axis, one))
    k = np.arange(_SIDES)
    after = (k + 1) % _SIDES
    sides = [np.stack([k, after, after + _SIDES], 1), np.stack([k, after + _SIDES, k + _SIDES], 1)]
    return np.concatenate([start + ring, end + ring]), np.concatenate(sides)
