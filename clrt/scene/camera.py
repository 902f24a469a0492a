"""The camera as a scene states it."""

from __future__ import annotations

import math
from functools import partial
from typing import Annotated, Final, Literal

import msgspec
import numpy as np
from msgspec import Meta

from clrt.base.explain import FLOAT32_MAX
from clrt.base.places import At
from clrt.base.records import Record, Unstated, Vector, float32, is_zero

Side = Annotated[int, Meta(ge=1, le=1 << 16, description="must be a whole number of pixels from 1 to 65536")]


_FAR: Final = 1e18  # a ray that starts so far away, at any angle, still does at finite coordinates
_NEAR: Final = 1e-30  # of which float32 has the inverse
_WIDEST: Final = 1e6  # radius of a lens over the distance in focus, beyond which float32 has no angle left


class Camera(Record, frozen=True, kw_only=True):
    """Where from, where to and how many pixels.

    `fov` is in degrees, `size` in world units (of an orthographic view), `shift` in pixels. `spp` is a
    square number, None where none is stated, which is 1. `jitter` is the seed of the samples' jitter, None
    for none. `up` is None until a scene holds the camera: then the y axis, or the z axis for a camera that
    looks along y. `filter` weighs the samples of a pixel, which lie wherever it is not 0: "box" (its own
    square, evenly), "tent" (1 pixel to each side), "gaussian", "mitchell" (2). `aperture` is the radius of
    the lens in world units, 0 for a pinhole, which sees all sharp; `focus` how far along the view things are
    sharp, None for the target's distance.
    """

    type: Annotated[
        Literal["perspective", "orthographic"],
        Meta(description="type must be 'perspective' or 'orthographic'"),
    ] = "perspective"
    origin: Vector
    target: Vector
    up: Vector | None = None
    fov: Annotated[float, Meta(gt=0, lt=180, description="must be an angle between 0 and 180 degrees")] = 45.0
    fov_axis: Annotated[
        Literal["horizontal", "vertical"], Meta(description="fov_axis must be 'horizontal' or 'vertical'")
    ] = "horizontal"
    size: Annotated[float, Meta(gt=0, description="must be a length > 0")] = 2.0
    near: Annotated[float, Meta(ge=0, le=_FAR, description="must be a distance from 0 to 1e18")] = 0.0
    aperture: Annotated[float, Meta(ge=0, le=_FAR, description="must be a radius from 0 to 1e18")] = 0.0
    focus: Annotated[float, Meta(ge=_NEAR, description="must be a distance > 0 along the view")] | None = None
    mirror: bool = False
    shift: Annotated[tuple[float, float], Meta(description="must be 2 numbers (pixels)")] = (0.0, 0.0)
    width: Side = 640
    height: Side = 480
    spp: Annotated[
        int, Meta(ge=1, le=1 << 24, description="must be a square number such as 1, 4, 9 or 16")
    ] = msgspec.field(default_factory=partial(Unstated, 1))
    filter: Annotated[
        Literal["box", "tent", "gaussian", "mitchell"],
        Meta(description="filter must be 'box', 'tent', 'gaussian' or 'mitchell'"),
    ] = "box"
    jitter: (
        Annotated[int, Meta(ge=0, lt=1 << 32, description="must be a seed from 0 to 4294967295")] | None
    ) = None

    def check(self, at: At) -> None:
        gaze = float32(self.target) - float32(self.origin)
        if is_zero(gaze):
            raise at.key("target").error(self.target, "target must not be at the camera's origin")
        if self.up is not None:
            if is_zero(self.up):
                raise at.key("up").error(self.up, "up must not be zero")
            if _parallel(gaze, self.up):
                raise at.key("up").error(
                    self.up, "up must not be parallel to the direction from origin to target"
                )
        if self.aperture > _WIDEST * self.in_focus:
            text = f"a lens's radius is at most {_WIDEST:g} times the distance in focus, {self.in_focus:g}"
            raise at.key("aperture").error(self.aperture, text)
        root = math.isqrt(self.spp)
        if root * root != self.spp:
            near = f"{root * root} or {(root + 1) ** 2}"
            raise at.key("spp").error(self.spp, f"spp must be a square number: {near} is the nearest")

    @property
    def in_focus(self) -> float:
        """How far along the view things are sharp: `focus`, or where that is not given the target."""
        if self.focus is not None:
            return self.focus
        return min(max(math.dist(self.origin, self.target), _NEAR), FLOAT32_MAX)

    def upright(self) -> Camera:
        """This camera with a given `up`."""
        if self.up is not None:
            return self
        gaze = float32(self.target) - float32(self.origin)
        up = (0.0, 0.0, 1.0) if _parallel(gaze, (0.0, 1.0, 0.0)) else (0.0, 1.0, 0.0)
        return msgspec.structs.replace(self, up=up)


def _parallel(gaze: np.ndarray, up: Vector) -> bool:
    """Whether the two leave `right` undefined in float32: an angle below 1e-6."""
    axis = float32(up)
    across = np.linalg.norm(np.cross(gaze / np.linalg.norm(gaze), axis / np.linalg.norm(axis)))
    return bool(across < 1e-6)
