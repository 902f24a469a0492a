"""Cameras as computer vision states them: a pose and a matrix K, and what they are in clrt's words.

The axes are OpenCV's: x to the right, y down, z along the view. (Hartley and Zisserman 2004, "Multiple View
Geometry in Computer Vision", chapter 6.) K maps a point (x, y, z) before the camera to the pixel
((fx x + cx z) / z, (fy y + cy z) / z); the first pixel reaches from 0 to 1.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Annotated, Any, Final

import numpy as np
from msgspec import Meta

from clrt.base.hints import Numbers, Rows
from clrt.base.places import At

Row3 = tuple[float, float, float]
Row4 = tuple[float, float, float, float]
if TYPE_CHECKING:
    Pose = Rows
else:
    Pose = Annotated[
        tuple[Row4, Row4, Row4, Row4],
        Meta(description="must be a 4 x 4 matrix, camera to world: 4 rows of 4 numbers"),
    ]
if TYPE_CHECKING:
    Intrinsics = Rows
else:
    Intrinsics = Annotated[
        tuple[Row3, Row3, Row3], Meta(description="must be a 3 x 3 matrix of pixels: 3 rows of 3 numbers")
    ]

_SKEWED: Final = 1e-3  # how far a rotation's numbers may be from one: calibrations are written with 4 places
_WIDEST: Final = 1e6  # half a picture over its focal length, and the inverse of the least


def view_of(pose: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Origin, target and up (3,) of a camera with this pose."""
    origin = pose[:3, 3]
    return origin, ahead(origin, pose[:3, 2]), -pose[:3, 1]


def ahead(origin: np.ndarray, forward: np.ndarray) -> np.ndarray:
    """A target (3,) in a direction of length 1: at 1, or as far as float32 parts it from a far origin."""
    return origin + max(1.0, 2.0 ** (math.frexp(np.abs(origin).max())[1] - 20)) * forward


def pose_of(origin: Any, target: Any, up: Any, mirror: bool) -> np.ndarray:
    """The pose (4, 4) of a camera; a mirrored one has its x axis to the left."""
    forward = np.subtract(target, origin)
    forward = forward / np.linalg.norm(forward)
    right = np.cross(forward, up)
    right /= np.linalg.norm(right)
    pose = np.eye(4)
    pose[:3, :3] = np.column_stack([-right if mirror else right, np.cross(forward, right), forward])
    pose[:3, 3] = origin
    return pose


def intrinsics(
    half_width: float, half_height: float, size: tuple[int, int], shift: Numbers
) -> np.ndarray:
    """K (3, 3) of a camera whose picture of `size` spans these tangents to each side."""
    (width, height), (x, y) = size, shift
    fx, fy = width / (2 * half_width), height / (2 * half_height)
    return np.array([[fx, 0, width / 2 - x], [0, fy, height / 2 - y], [0, 0, 1.0]])


def rows(matrix: np.ndarray) -> tuple[tuple[float, ...], ...]:
    """A matrix as a camera holds it. ValueError for one that is not finite."""
    if not np.isfinite(matrix).all():
        raise ValueError("not finite")
    return tuple(map(tuple, matrix.tolist()))


def check_pose(pose: Any, at: At) -> None:
    """Raise `SceneError` for what is no pose."""
    matrix = np.array(pose, np.float64)
    if np.abs(matrix[3] - [0, 0, 0, 1]).max() > 0:
        text = "a pose ends with the row 0, 0, 0, 1"
        raise at.item(3).error(pose[3], f"{text}; is this one transposed?" if matrix[3, :3].any() else text)
    turn = matrix[:3, :3]
    if not np.abs(turn.T @ turn - np.eye(3)).max() <= _SKEWED:
        text = "its first 3 columns must be of length 1 and at right angles: a rotation"
        raise at.says(f"{text}; a scale belongs to the shapes")
    if np.linalg.det(turn) < 0:
        right = "x is right, y down and z forward"
        raise at.says(f"a rotation is not mirrored: {right}; the axes of this one are a left hand's")


def check_intrinsics(matrix: Any, width: int, height: int, at: At) -> None:
    """Raise `SceneError` for what is no K of a picture of that size."""
    (fx, skew, cx), (zero, fy, cy), last = matrix
    if skew or zero:
        place, value = (at.item(0).item(1), skew) if skew else (at.item(1).item(0), zero)
        raise place.error(value, "it must be 0: clrt has no skew")
    if tuple(last) != (0, 0, 1):
        raise at.item(2).error(last, "K ends with the row 0, 0, 1")
    for row, (focal, middle, side) in enumerate(((fx, cx, width), (fy, cy, height))):
        if not side / (2 * _WIDEST) <= focal <= side * _WIDEST / 2:
            right = f"a focal length, in pixels, for a picture of {side} is from {side / (2 * _WIDEST):g}"
            raise at.item(row).item(row).error(focal, f"{right} to {side * _WIDEST / 2:g}")
        if not abs(middle) <= side * _WIDEST:
            raise at.item(row).item(2).error(middle, "the principal point is too far out, in pixels")
