"""Meshes of files that are edited: what is set of them takes the place of what says the same.

A mesh is either a file or arrays. Whoever sets some of its arrays has the others of what was read of the
file, and whoever names a file has those of that file alone.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from clrt.base.places import At
from clrt.scene.edit import Step, fields_of
from clrt.scene.mesh import ARRAYS, Mesh, edited_mesh, read_mesh

if TYPE_CHECKING:
    from clrt.scene.scene import Scene

_OF_FILE_ALONE: Final = ("file", "part")


def made_ready(scene: Scene, before: object, shape: Any, field: Step, value: Any, at: At) -> Any:
    """A shape, or its table, of which `field` is to be set, without what that stands in the place of.

    before: what the scene had there, None for nothing. value: what the whole field is to be; `...` where a
    part of it is set. Raises what reading the shape does.
    """
    table = fields_of(shape) if isinstance(shape, Mesh) else shape
    if not isinstance(table, Mapping) or field not in (*ARRAYS, "file"):
        return shape
    kind = table.get("type")  # of any kind, where it was given
    if not isinstance(kind, str) or kind != "mesh":
        return shape
    if field == "file" and value is not None:
        return {name: None if name in ARRAYS else own for name, own in table.items()}
    if table.get("file") is None or (field in ARRAYS and value is None):
        return shape
    if isinstance(shape, Mesh):
        mesh = shape
    elif isinstance(before, Mesh):
        mesh = edited_mesh(before, table, at, scene.folder, scene.limits)
    else:
        mesh = read_mesh(table, at, scene.folder, scene.limits)
    data = mesh.data()
    arrays = {name: getattr(data, name) for name in ARRAYS}
    if mesh.smooth and _is_computed(data.normals, data.vertices, data.faces):
        arrays["normals"] = None  # those of the new corners are computed, too
    return {**table, **dict.fromkeys(_OF_FILE_ALONE), **arrays}


def _is_computed(normals: np.ndarray | None, vertices: np.ndarray, faces: Any) -> bool:
    """Whether a file's normals are those that `smooth` makes where it has none."""
    from clrt.meshfiles.parts import smooth_normals

    if normals is None or not isinstance(faces, np.ndarray):
        return False
    return np.array_equal(normals, smooth_normals(vertices, faces))
