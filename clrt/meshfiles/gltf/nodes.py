"""Where the nodes of a glTF file stand."""

from __future__ import annotations

import numpy as np

from clrt.meshfiles.broken import BrokenMesh
from clrt.meshfiles.gltf.document import Node

_ROUNDED = 1e-5  # that exporters leave in the last row of what they have multiplied

def matrix_of(node: Node, number: int, above: np.ndarray) -> np.ndarray:
    """The matrix to the world of the node of a number, given that of the node above it."""
    parts = [name for name in ("translation", "rotation", "scale") if getattr(node, name) is not None]
    if node.matrix is not None:
        if parts:
            text = f"nodes[{number}] has a matrix and {' and '.join(parts)}"
            raise BrokenMesh(f"{text}; one or the other places it, leave one out")
        if not np.allclose(node.matrix[3::4], (0.0, 0.0, 0.0, 1.0), rtol=0.0, atol=_ROUNDED):
            raise BrokenMesh(f"the last row of nodes[{number}].matrix must be 0, 0, 0, 1")
        own = np.array(node.matrix).reshape(4, 4).T
        own[3] = 0.0, 0.0, 0.0, 1.0
        return above @ own
    if not parts:
        return above
    own = np.eye(4)
    own[:3, :3] = _rotation(node.rotation or (0.0, 0.0, 0.0, 1.0)) * (node.scale or (1.0, 1.0, 1.0))
    own[:3, 3] = node.translation or (0.0, 0.0, 0.0)
    with np.errstate(all="ignore"):  # what is not finite is an error later, with its place
        return above @ own


def _rotation(quaternion: tuple[float, float, float, float]) -> np.ndarray:
    """The rotation (3, 3) of a quaternion x, y, z, w of any length."""
    with np.errstate(all="ignore"):
        q = np.array(quaternion)
        square = float(q @ q)
        if not square > 0:
            return np.eye(3)
        x, y, z, w = q * np.sqrt(2.0 / square)
        return np.array([
            [1.0 - y * y - z * z, x * y - z * w, x * z + y * w],
            [x * y + z * w, 1.0 - x * x - z * z, y * z - x * w],
            [x * z - y * w, y * z + x * w, 1.0 - x * x - y * y],
        ])  # fmt: skip
