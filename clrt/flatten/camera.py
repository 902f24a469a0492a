"""The camera as the device reads it: MODEL.md's unit vectors and half extents."""

from __future__ import annotations

import math
from typing import Final

import numpy as np

from clrt import layout
from clrt.base.errors import SceneError, fault
from clrt.base.records import At
from clrt.flatten.mesh import unit
from clrt.layout import ceilings
from clrt.scene.camera import Camera

_VECTORS: Final = ("origin", "forward", "right", "up")

def flatten_camera(
    camera: Camera,
    width: int | None = None,
    height: int | None = None,
    spp: int | None = None,
    jitter: int | None = None,
) -> np.ndarray:
    """The record `Camera`, shape (1,); what is given here replaces the camera's own size and samples.

    Of `width` and `height` (pixels) one alone scales the other to keep the aspect ratio. `spp`, a square, is
    the samples per pixel, `jitter` their seed. Raises `SceneError` for numbers that make no picture.
    """
    width, height = picture_size(camera, width, height)
    grid = _grid(camera.spp if spp is None else spp)
    seed = camera.jitter if jitter is None else jitter
    forward, right, up = axes(camera)
    half_width, half_height = camera.half_extents(width, height)

    out = np.zeros(1, layout.dtype("Camera"))
    record = out[0]
    record["origin"][:3] = camera.origin
    record["forward"][:3] = forward
    record["right"][:3] = right
    record["up"][:3] = up
    record["half_width"], record["half_height"] = half_width, half_height
    record["shift_x"], record["shift_y"] = camera.offset(width, height)
    record["near"] = camera.near
    record["aperture"], record["focus"] = camera.aperture, camera.in_focus
    record["orthographic"] = camera.type == "orthographic"
    record["width"], record["height"], record["grid"] = width, height, grid
    record["filter"] = layout.FILTERS.get(camera.filter.upper(), 0)
    record["reach"] = layout.REACH.get(camera.filter, 0.5)
    record["jitter"] = seed is not None
    record["seed"] = (seed or 0) & 0xFFFFFFFF
    return out


def axes(camera: Camera) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Unit vectors forward (d), right and up (v) in float64; `mirror` turns right only.

    Raises `SceneError` where an explicit `up` lies along the view; the default y axis then gives way to z.
    """
    camera.check(At(path="camera"))
    camera = camera.upright()
    assert camera.up is not None
    forward = unit(np.subtract(camera.target, camera.origin))
    right = unit(np.cross(forward, unit(camera.up)))
    return forward, -right if camera.mirror else right, np.cross(right, forward)


def near_corners(camera: np.ndarray) -> np.ndarray:
    """(n, 3) float64: all camera rays start at convex combinations of these points, but for rounding.

    camera: a record of `flatten_camera`. One point where all start at the same: that of a pinhole.
    """
    record = camera[0]
    origin, forward, right, up = (record[name][:3].astype(np.float64) for name in _VECTORS)
    near = float(record["near"])
    # the lens narrows towards what is in focus, and widens beyond it
    lens = float(record["aperture"]) * abs(1 - near / float(record["focus"]))
    square = lens * np.array([right + up, right - up, up - right, -right - up])
    around = square if record["aperture"] > 0 else np.zeros((1, 3))
    if not record["orthographic"] and near == 0:
        return origin + around
    scale = 1.0 if record["orthographic"] else near
    out = float(record["reach"]) - 0.5  # of the picture, by which a filter reaches
    width, height = float(record["width"]), float(record["height"])
    x = 2 * (float(record["shift_x"]) + np.array([-out, width + out])) / width - 1
    y = 1 - 2 * (float(record["shift_y"]) + np.array([-out, height + out])) / height
    x, y = x * scale * float(record["half_width"]), y * scale * float(record["half_height"])
    across, above = (grid.reshape(-1, 1) for grid in np.meshgrid(x, y))
    corners = origin + near * forward + across * right + above * up
    return (corners[:, None] + around).reshape(-1, 3)


def picture_size(camera: Camera, width: int | None, height: int | None) -> tuple[int, int]:
    """Width and height of the picture in pixels; one alone scales the other, to the nearest pixel."""
    for name, side in (("width", width), ("height", height)):
        _check_side(name, side)
    if width is None and height is None:
        return camera.width, camera.height
    if width is None:
        assert height is not None
        width = max(1, round(camera.width * height / camera.height))
        _check_side("width", width)
    elif height is None:
        height = max(1, round(camera.height * width / camera.width))
        _check_side("height", height)
    return width, height


def _check_side(name: str, side: int | None) -> None:
    if side is not None and not 1 <= side <= ceilings.SIDE:
        right = f"a picture has 1 pixel or more on each side, at most {ceilings.SIDE}"
        raise SceneError(fault("", name, side, right))


def _grid(spp: int) -> int:
    """Side of the square grid of samples in a pixel."""
    if spp < 1:
        raise SceneError(fault("", "spp", spp, "a pixel has 1 sample or more"))
    ceilings.check("samples", spp, ceilings.RAYS)
    side = math.isqrt(spp)
    if side * side != spp:
        near = f"{side * side} or {(side + 1) ** 2}"
        raise SceneError(fault("", "spp", spp, f"samples form a square grid, so take {near}"))
    return side
