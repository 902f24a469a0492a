"""u and v of hits as the corners of a scene's faces count.

A mesh whose transform mirrors has its triangles turned around where it is flattened, so that outside stays
outside: first, third, second corner. Kernels weigh the corners as they have them, and normals and pictures
are in the same order; who asks about rays has the faces as they were given.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

import numpy as np

from clrt.flatten.mesh import mirrors
from clrt.scene.mesh import Mesh
from clrt.scene.shapes import Shape


def turned_meshes(shapes: Sequence[Shape]) -> np.ndarray | None:
    """(n + 1,) bool: of each of n shapes whether its triangles are turned around; the last is of none.

    None where no shape's are.
    """
    found = [number for number, shape in enumerate(shapes) if isinstance(shape, Mesh) and _turned(shape)]
    if not found:
        return None
    out = np.zeros(len(shapes) + 1, bool)
    out[found] = True
    return out


def lacking(names: Iterable[str], turned: np.ndarray | None) -> tuple[str, ...]:
    """The fields of answers that `turn_back` needs to tell these, and that are not among them."""
    if turned is None or {"u", "v"}.isdisjoint(names):
        return ()
    return tuple(name for name in ("shape", "u", "v") if name not in names)


def turn_back(found: Mapping[str, np.ndarray], turned: np.ndarray | None) -> None:
    """Give u and v, in place, of hits (n,) for the second and third corner as the scene has them."""
    if turned is None or not {"u", "v"} <= found.keys():
        return
    # -1, of a miss, is the last; surfaces of lights have the numbers after the shapes
    (which,) = np.nonzero(turned[np.minimum(found["shape"], len(turned) - 1)])
    u, v = found["u"], found["v"]
    u[which], v[which] = v[which], u[which]


def _turned(mesh: Mesh) -> bool:
    return bool(mesh.transform) and mirrors(mesh.matrix)
