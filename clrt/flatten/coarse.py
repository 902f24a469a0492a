"""What is so far from the origin that float32, which kernels compute with, cannot tell its points apart."""

from __future__ import annotations

import math
from typing import Any, Final

import numpy as np

from clrt.base import notices
from clrt.scene.camera import Camera
from clrt.scene.scene import Mesh, Scene

_STEPS: Final = 5000  # of float32 in a thing's size, or before the camera, below which it is rounded much
_SEEN: Final = 2  # as many, that are a pixel wide, are seen: half of it changes 4 % of the pixels at most
_LOOSE: Final = 16  # times a mesh that a box may be


def warn_of_coarse_places(scene: Scene, low: np.ndarray, high: np.ndarray) -> None:
    """Warn of the first shape that rounding deforms, as it does buildings and scans in coordinates of maps,
    or of a camera that is as far out, and near to what it sees.

    low, high: of boxes around shapes, (n, 3), which may be larger than they are.
    """
    size = (high - low).max(axis=1, initial=0.0)
    far = np.maximum(np.abs(low), np.abs(high)).max(axis=1, initial=0.0)
    step, camera = _step(far), scene.camera
    for k in np.flatnonzero((step * (_STEPS * _LOOSE) > size) & (size > 0)).tolist():
        shape, own, middle = scene.shapes[k], float(size[k]), (low[k] + high[k]) / 2
        what, of = "it is", ""  # its box is wider by some steps
        if isinstance(shape, Mesh):
            corners = _corners(shape)
            own, middle = float(np.ptp(corners, axis=0).max()), corners.mean(axis=0)
            what, of = "its corners are", f" of its {own:.3g} units"
        seen = camera is None or step[k] * _SEEN > _pixel(camera, _away(camera, low[k], high[k]))
        if step[k] * _STEPS > own > 0 and seen:
            text = f"{what} rounded to {step[k]:.2g}{of}, so far out"
            notices.warn(scene.source, f"shapes[{k}]", f"{text}; {_moved(middle)}")
            return
    if camera is None:
        return
    origin, target = (np.array(place, np.float64) for place in (camera.origin, camera.target))
    step_there = float(_step(np.abs(origin).max()))
    away = float(np.linalg.norm(target - origin))
    seen = step_there * _SEEN > _pixel(camera, away)
    if seen and step_there * _STEPS > away and _shows(scene, camera, step_there * _STEPS, low, high):
        text = f"it is rounded to {step_there:.2g}, so far out, and looks at what is {away:.3g} away"
        notices.warn(scene.source, "camera.origin", f"{text}; {_moved(origin)}")


def _shows(scene: Scene, camera: Camera, reach: float, low: np.ndarray, high: np.ndarray) -> bool:
    """Whether something is within so much of the camera: a corner of a mesh, or another shape's box."""
    there = np.isfinite(high).all(axis=1) & (low <= high).all(axis=1)
    for k in np.flatnonzero((_away(camera, low, high) < reach) & there).tolist():
        shape = scene.shapes[k]
        if not isinstance(shape, Mesh):
            return True
        if np.linalg.norm(_corners(shape) - np.array(camera.origin), axis=1).min() < reach:
            return True
    return False


def _away(camera: Camera, low: np.ndarray, high: np.ndarray) -> np.ndarray:
    """How far boxes (..., 3) are from the camera; 0 around it."""
    origin = np.array(camera.origin, np.float64)
    away: np.ndarray = np.linalg.norm(np.maximum(np.maximum(low - origin, origin - high), 0.0), axis=-1)
    return away


def _pixel(camera: Camera, distance: Any) -> Any:
    """How wide a pixel is, so far from the camera."""
    across = camera.width if camera.fov_axis == "horizontal" else camera.height
    if camera.type == "orthographic":
        return camera.size / across
    if camera.K is not None:
        return distance / camera.K[0][0]
    return distance * 2 * math.tan(math.radians(camera.fov) / 2) / across


def _step(far: np.ndarray) -> np.ndarray:
    """Of float32 at coordinates that are so large."""
    with np.errstate(all="ignore"):  # of planes
        return np.spacing(np.asarray(far, np.float32)).astype(np.float64)


def _corners(mesh: Mesh) -> np.ndarray:
    """In the world, (n, 3)."""
    matrix = np.asarray(mesh.matrix, np.float64)
    corners: np.ndarray = mesh.data().vertices @ matrix[:3, :3].T + matrix[:3, 3]
    return corners


def _moved(middle: np.ndarray) -> str:
    offset = ", ".join(f"{-value:.0f}" for value in middle)
    return f"move all of the scene, its camera and lights too, by [{offset}]"
