"""Meshes of glass that do not close: a ray that is within and meets no face on its way out stays within."""

from __future__ import annotations

from typing import Final

import numpy as np

from clrt.base import notices
from clrt.flatten.mesh import fans, joined
from clrt.flatten.winding import is_open
from clrt.scene.mesh import Mesh
from clrt.scene.scene import Scene

_MOST_FACES: Final = 1 << 18  # triangles that are looked at: 0.2 s


def warn_of_open_meshes(scene: Scene, passes: np.ndarray) -> None:
    """Warn of the first mesh with a hole, or with faces of both windings, of a solid that light passes.

    passes: (n,) bool, of which shapes it does.
    """
    looked = 0
    for k in np.flatnonzero(passes).tolist():
        shape = scene.shapes[k]
        if not isinstance(shape, Mesh) or scene.material_of(shape).thin:
            continue
        looked += shape.primitives
        if looked > _MOST_FACES:
            return
        if has_rim(shape):
            text = (
                "an open mesh transmits but encloses nothing: edges of its faces have none that runs the "
                "other way, so it has a hole, or faces wound the wrong way; a sheet of glass has thin = true"
            )
            notices.warn(scene.source, f"shapes[{k}]", text)
            return


def has_rim(mesh: Mesh) -> bool:
    """Whether some edge of a mesh's faces has none that runs the other way, between places, not numbers."""
    data = mesh.data()
    return is_open(data.vertices, fans(*joined(data.faces)))
