"""Where the nodes of a glTF file stand."""

from __future__ import annotations

import numpy as np

from clrt.meshfiles.broken import BrokenMesh
from clrt.meshfiles.gltf.document import Node


def matrix_of(node: Node, above: np.ndarray) -> np.ndarray:
    """The node's matrix to the world, given that of the node above it."""
    if node.matrix is not None:
        if node.matrix[3::4] != (0.0, 0.0, 0.0, 1.0):
            raise BrokenMesh("the last row of a node's matrix must be 0, 0, 0, 1")
        above = above @ np.array(node.matrix).reshape(4, 4).T
    if node.translation is None and node.rotation is None and node.scale is None:
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
