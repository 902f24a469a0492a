"""Meshes so far from the origin that float32, which kernels compute with, cannot tell their corners apart."""

from __future__ import annotations

from typing import Final

import numpy as np

from clrt.base import notices
from clrt.scene.scene import Mesh, Scene

_STEPS: Final = 5000  # of float32 in a mesh's size, below which it is seen that corners are rounded
_LOOSE: Final = 16  # times a mesh that a box may be


def warn_of_coarse_meshes(scene: Scene, low: np.ndarray, high: np.ndarray) -> None:
    """Warn of the first mesh that rounding deforms, as it does buildings and scans in coordinates of maps.

    low, high: of boxes around shapes, (n, 3), which may be larger than they are.
    """
    far = np.maximum(np.abs(low), np.abs(high)).max(axis=1, initial=0.0)
    with np.errstate(all="ignore"):  # of planes
        step = np.spacing(far.astype(np.float32)).astype(np.float64)
    for k in np.flatnonzero(step * (_STEPS * _LOOSE) > (high - low).max(axis=1, initial=0.0)).tolist():
        shape = scene.shapes[k]
        if isinstance(shape, Mesh) and len(shape.data().vertices):
            matrix = np.asarray(shape.matrix, np.float64)
            corners = shape.data().vertices @ matrix[:3, :3].T + matrix[:3, 3]
            size = float(np.ptp(corners, axis=0).max())
            if step[k] * _STEPS > size > 0:
                moved = ", ".join(f"{-value:.0f}" for value in corners.mean(axis=0))
                text = f"its corners are rounded to {step[k]:.2g} of its {size:.3g} units, so far out"
                mend = f"transform = [{{ translate = [{moved}] }}]"
                notices.warn(scene.source, f"shapes[{k}]", f"{text}; {mend}")
                return
