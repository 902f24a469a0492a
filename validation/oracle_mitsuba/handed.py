"""Tables of a scene as clrt has read it, for what is no proof of how files are read: what is written of it,
and scenes in formats that only clrt reads. No part of what the oracle itself is made of."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from clrt.scene.mesh import Mesh
from clrt.scene.scene import Scene

from . import meshfile
from .patches import Unreadable


def tables(scene: Scene, whole: bool) -> dict[str, Any]:
    """The scene's tables, its meshes with the arrays that clrt made of them.

    whole: all of them, else those of the files that the oracle does not read by itself.
    """
    found = scene.to_dict()
    for shape, table in zip(scene.shapes, found.get("shapes", ()), strict=True):
        if isinstance(shape, Mesh) and (whole or not _is_read(shape, scene.folder)):
            data = shape.data()
            for key in ("file", "part", "smooth", "normals", "uv"):
                table.pop(key, None)
            arrays = {"vertices": data.vertices, "faces": data.faces, "normals": data.normals, "uv": data.uv}
            table |= {key: array for key, array in arrays.items() if array is not None}
    return found


def _is_read(shape: Mesh, folder: Path | None) -> bool:
    if shape.file is None:
        return True
    try:
        meshfile.read((folder or Path()) / shape.file, shape.smooth, shape.part)
    except Unreadable:
        return False
    return True
