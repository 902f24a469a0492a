"""A tree's rays as coloured tubes among the shapes that they meet: a .glb for any viewer of 3D models."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

import numpy as np

from clrt.base.room import check_date
from clrt.raytree.solids import triangles_of
from clrt.raytree.ways import COLOURS, ways

if TYPE_CHECKING:
    from clrt.raytree.tree import RayTree

_THICK: Final = 0.004  # of the box around all, for a ray that brings everything
_SIDES: Final = 8
_GLASS: Final = (200, 210, 220, 70)  # colour of shapes


def glb(tree: RayTree) -> bytes:
    """A binary glTF: a node for each ray, named as in the tree, and one for each shape of the scene."""
    check_date()
    import trimesh

    all_ways, low, high = ways(tree)
    size = float(np.linalg.norm(high - low))
    model = trimesh.Scene()
    for number, shape in enumerate(tree.scene.shapes):
        made = triangles_of(shape, low, high)
        if made is not None:
            _add(trimesh, model, tree.names.shape(number), *made, _GLASS)
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
