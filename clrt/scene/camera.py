"""The camera as a scene states it."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from functools import partial
from typing import TYPE_CHECKING, Annotated, Any, Final, Literal

import msgspec
import numpy as np
from msgspec import Meta

from clrt.base.explain import FLOAT32_MAX
from clrt.base.hints import Numbers
from clrt.base.places import At
from clrt.base.records import Record, Unstated, Vector, float32, is_zero
from clrt.scene.pinhole import (
    Intrinsics,
    Pose,
    check_intrinsics,
    check_pose,
    intrinsics,
    pose_of,
    rows,
    view_of,
)

Side = Annotated[int, Meta(ge=1, le=1 << 16, description="must be a whole number of pixels from 1 to 65536")]

if TYPE_CHECKING:
    Shift = Numbers
else:
    Shift = Annotated[tuple[float, float], Meta(description="must be 2 numbers (pixels)")]

_FAR: Final = 1e18  # a ray that starts so far away, at any angle, still does at finite coordinates
_NEAR: Final = 1e-30  # of which float32 has the inverse
_ASIDE: Final = 1e12  # how far aside a view may be at distance 1: its square is a float32 at any size
_WIDEST: Final = 1e6  # radius of a lens over the distance in focus, beyond which float32 has no angle left
_FOV: Final = 45.0
_ENTRIES: Final = 16  # of the larger matrix; a view of one number may have as many as there are addresses


def _nothing() -> Any:
    return None


class Camera(Record, frozen=True, kw_only=True):
    """Where from, where to and how many pixels.

    Either `origin` and `target` (and `up`, `mirror`), or `pose`: 4 x 4, camera to world, with OpenCV's axes:
    x right, y down, z forward. Either `fov` (and `fov_axis`), or `K`: 3 x 3, in pixels of a picture of
    `width` x `height`, the first of which reaches from 0 to 1, as `shift` is: pictures of other sizes show
    the same view. What is not stated follows from what is, so every camera has `pose`, and every
    perspective one `K`.

    `fov` is in degrees, `size` in world units (of an orthographic view). `spp` is a square number, None
    where none is stated, which is 1. `jitter` is the seed of the samples' jitter, None for none. `up` is
    None until a scene holds the camera: then the y axis, or the z axis for a camera that looks along y.
    `filter` weighs the samples of a pixel, which lie wherever it is not 0: "box" (its own square, evenly),
    "tent" (1 pixel to each side), "gaussian", "mitchell" (2). `aperture` is the radius of the lens in world
    units, 0 for a pinhole, which sees all sharp; `focus` how far along the view things are sharp, None for
    the target's distance.
    """

    type: Annotated[
        Literal["perspective", "orthographic"],
        Meta(description="type must be 'perspective' or 'orthographic'"),
    ] = "perspective"
    origin: Vector = msgspec.field(default_factory=_nothing)
    target: Vector = msgspec.field(default_factory=_nothing)
    up: Vector | None = None
    pose: Pose | None = None
    fov: Annotated[float, Meta(gt=0, lt=180, description="must be an angle between 0 and 180 degrees")] = _FOV
    fov_axis: Annotated[
        Literal["horizontal", "vertical"], Meta(description="fov_axis must be 'horizontal' or 'vertical'")
    ] = "horizontal"
    K: Intrinsics | None = None
    size: Annotated[float, Meta(gt=0, le=_FAR, description="must be a length > 0, at most 1e18")] = 2.0
    near: Annotated[float, Meta(ge=0, le=_FAR, description="must be a distance from 0 to 1e18")] = 0.0
    aperture: Annotated[float, Meta(ge=0, le=_FAR, description="must be a radius from 0 to 1e18")] = 0.0
    focus: Annotated[float, Meta(ge=_NEAR, description="must be a distance > 0 along the view")] | None = None
    mirror: bool = False
    shift: Shift = (0.0, 0.0)
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

    def __post_init__(self) -> None:
        for name in ("pose", "K"):
            given = self.stated(name)
            if isinstance(given, np.ndarray) and given.ndim == 2 and given.size <= _ENTRIES:
                _SLOTS[name].__set__(self, tuple(map(tuple, given.tolist())))

    def __eq__(self, other: object) -> bool:
        """Equal numbers make equal cameras, whatever holds them: tuples, lists or arrays."""
        return _values(self) == _values(other) if isinstance(other, Camera) else NotImplemented

    def __ne__(self, other: object) -> bool:  # the base class has one of its own
        return not self == other

    def __hash__(self) -> int:
        return hash(_values(self))

    def stated(self, field: str) -> Any:
        """A field's value as it was stated; of others what follows from these is an attribute, too."""
        return _SLOTS[field].__get__(self) if field in _SLOTS else getattr(self, field)

    @property
    def has_pose(self) -> bool:
        """Whether the camera was stated by its pose."""
        return self.stated("pose") is not None

    @property
    def has_k(self) -> bool:
        """Whether its view was stated by `K`."""
        return self.stated("K") is not None

    @classmethod
    def instead_of(cls, field: str, table: Mapping[str, Any]) -> tuple[str, ...]:
        """The fields that say otherwise, in what is stated, what this one says: who edits it drops them."""
        follows = field == "K" and table.get("K") is None  # then it has the shift within
        return (*_INSTEAD.get(field, ()), *(("shift",) if follows else ()))

    def half_extents(self, width: int, height: int) -> tuple[float, float]:
        """Half width and height of the view of a picture of that size: tangents; lengths if orthographic."""
        if self.has_k:
            (fx, _, _), (_, fy, _), _ = self.K  # type: ignore[misc]
            return self.width / (2 * fx), self.height / (2 * fy)
        if self.type == "orthographic":
            half = 0.5 * self.size
        else:
            half = math.tan(math.radians(0.5 * self.fov))
        if self.fov_axis == "horizontal":
            return half, half * height / width
        return half * width / height, half

    def offset(self, width: int, height: int) -> tuple[float, float]:
        """What is added to places in a picture of that size, pixels, so that (0, 0) is in its upper left."""
        x, y = self.shift[0] * (width / self.width), self.shift[1] * (height / self.height)
        if not self.has_k:
            return x, y
        (_, _, cx), (_, _, cy), _ = self.K  # type: ignore[misc]
        more = (0.5 * self.width - cx) * width / self.width, (0.5 * self.height - cy) * height / self.height
        return x + more[0], y + more[1]

    def check(self, at: At) -> None:
        if self.has_pose:
            self._check_said_once(at, "pose", "origin", "target", "up")
            if self.mirror:
                raise at.key("mirror").error(True, "pose says where x is; leave out mirror, or pose")
            check_pose(self.pose, at.key("pose"))
            if self.aperture > 0 and self.focus is None:
                raise at.key("focus").says("missing; a camera with a pose has no target to be in focus")
        for name in ("origin", "target"):
            if getattr(self, name) is None:
                raise at.says(f"the key {name!r} is missing; a camera has origin and target, or a pose")
        if np.abs(self.origin).max() > _FAR:
            name = "pose" if self.has_pose else "origin"
            raise at.key(name).error(self.origin, f"a camera stands within {_FAR:g} of the scene's origin")
        if self.has_k:
            if self.type == "orthographic":
                raise at.key("K").says("an orthographic camera has none; give its size")
            check_intrinsics(self.K, self.width, self.height, at.key("K"))
            if self.stated("fov") != _FOV:
                self._check_said_once(at, "K", "fov")
            if self.fov_axis != "horizontal":
                raise at.key("fov_axis").error(self.fov_axis, "K says both angles; leave out fov_axis, or K")
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
        most = _FAR if self.type == "orthographic" else _ASIDE
        halves = self.half_extents(self.width, self.height)
        for moved, side, half in zip(self.shift, (self.width, self.height), halves, strict=True):
            if abs(moved) / side * 2 * half > most:
                allowed = f"{most * side / (2 * half):.3g}"
                text = f"too far aside for float32; at most {allowed} pixels"
                raise at.key("shift").error(self.shift, text)
        root = math.isqrt(self.spp)
        if root * root != self.spp:
            near = f"{root * root} or {(root + 1) ** 2}"
            raise at.key("spp").error(self.spp, f"spp must be a square number: {near} is the nearest")

    def _check_said_once(self, at: At, name: str, *others: str) -> None:
        for other in others:
            value = self.stated(other)
            if value is not None:
                raise at.key(other).error(value, f"{name} says it already; leave out {other}, or {name}")

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
        return msgspec.structs.replace(self, up=_default_up(self.origin, self.target))


_PLACE: Final = ("origin", "target", "up", "mirror")
def _values(camera: Camera) -> Any:
    return _as_tuples([camera.stated(name) for name in Camera.__struct_fields__])


def _as_tuples(value: Any) -> Any:
    if isinstance(value, np.ndarray):
        value = value.tolist()
    return tuple(map(_as_tuples, value)) if isinstance(value, (list, tuple)) else value


_INSTEAD: Final = {
    "pose": _PLACE, "K": ("fov", "fov_axis"), "fov": ("K",), "fov_axis": ("K",),
    **dict.fromkeys(_PLACE, ("pose",)),
}  # fmt: skip


def _default_up(origin: Vector, target: Vector) -> Vector:
    gaze = float32(target) - float32(origin)
    return (0.0, 0.0, 1.0) if _parallel(gaze, (0.0, 1.0, 0.0)) else (0.0, 1.0, 0.0)


# The fields that say the same, as msgspec holds them. As attributes they say what follows from those that
# were stated; msgspec itself (equality, copies, files) sees what was stated alone.
_SLOTS: Final[dict[str, Any]] = {
    name: vars(Camera)[name] for name in ("origin", "target", "up", "pose", "fov", "K")
}


def _followed(field: str, follows: Callable[[Camera, Any], Any]) -> property:
    def value(camera: Camera) -> Any:
        stated = _SLOTS[field].__get__(camera)
        try:
            with np.errstate(all="ignore"):
                return follows(camera, stated)
        except (ArithmeticError, TypeError, ValueError, LookupError):  # `check` says what is wrong
            return stated

    return property(value)


def _of_pose(number: int) -> Callable[[Camera, Any], Any]:
    def vector(camera: Camera, stated: Any) -> Any:
        pose = camera.stated("pose")
        if stated is not None or pose is None:
            return stated
        return tuple(view_of(np.array(pose, np.float64).reshape(4, 4))[number].tolist())

    return vector


def _pose(camera: Camera, stated: Any) -> Any:
    if stated is not None:
        return stated
    up = _default_up(camera.origin, camera.target) if camera.up is None else camera.up
    return rows(pose_of(camera.origin, camera.target, up, camera.mirror))


def _fov(camera: Camera, stated: Any) -> Any:
    return 2 * math.degrees(math.atan(camera.half_extents(1, 1)[0])) if camera.has_k else stated


def _k(camera: Camera, stated: Any) -> Any:
    if stated is not None or camera.type == "orthographic":
        return stated
    size = camera.width, camera.height
    return rows(intrinsics(*camera.half_extents(*size), size, camera.shift))


for _name, _follows in (
    ("origin", _of_pose(0)), ("target", _of_pose(1)), ("up", _of_pose(2)),
    ("pose", _pose), ("fov", _fov), ("K", _k),
):  # fmt: skip
    setattr(Camera, _name, _followed(_name, _follows))


def resized(camera: Camera, width: int, height: int) -> Camera:
    """The same view in a picture of another size: `shift` and `K` are in its pixels."""
    across, down = width / camera.width, height / camera.height
    k = rows(np.array(camera.K) * [[across], [down], [1.0]]) if camera.has_k else None
    shift = camera.shift[0] * across, camera.shift[1] * down
    return msgspec.structs.replace(camera, width=width, height=height, shift=shift, K=k)


def _parallel(gaze: np.ndarray, up: Vector) -> bool:
    """Whether the two leave `right` undefined in float32: an angle below 1e-6."""
    axis = float32(up)
    across = np.linalg.norm(np.cross(gaze / np.linalg.norm(gaze), axis / np.linalg.norm(axis)))
    return bool(across < 1e-6)
