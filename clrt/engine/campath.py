"""Cameras on a way: around a target, and along a path through others."""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Sequence
from itertools import pairwise
from typing import Any, Final, TypeVar

import msgspec
import numpy as np

from clrt.base import arguments
from clrt.base.arguments import public
from clrt.base.errors import ClrtError, fault, show
from clrt.base.places import At
from clrt.base.records import read
from clrt.flatten.mesh import unit
from clrt.scene.camera import Camera, resized
from clrt.scene.edit import kept

T = TypeVar("T", float, np.ndarray)
MOST: Final = 1 << 20  # cameras of a path: eleven hours of a video
_NEAR: Final = 1e-6  # of its length at the keys: so near to 0 a vector of a path counts as 0


@public
def turntable(camera: Camera, frames: int) -> list[Camera]:
    """Cameras on a circle about the target and its `up`: `frames` (1 to 2^20), the given one first."""
    frames = arguments.whole("frames", frames, 1, MOST)
    camera = _checked("camera", camera)
    if camera.has_pose:
        raise ClrtError("camera: one with a pose has no target to go around; give origin and target")
    assert camera.up is not None
    axis, target = unit(np.asarray(camera.up, np.float64)), np.asarray(camera.target, np.float64)
    reach = np.asarray(camera.origin, np.float64) - target
    along, out = axis * (axis @ reach), reach - axis * (axis @ reach)
    side = np.cross(axis, out)
    cameras = [camera]
    for number in range(1, frames):
        angle = 2 * math.pi * number / frames
        place = target + along + out * math.cos(angle) + side * math.sin(angle)
        cameras.append(_moved(camera, place, target))
    return cameras


@public
def camera_path(
    keys: Sequence[Camera], frames: int, closed: bool = False, times: Sequence[float] | None = None
) -> list[Camera]:
    """Cameras that pass through `keys` (2 or more): `frames` (2 to 2^20) of them, evenly in time.

    Origin, target and up follow a Catmull-Rom spline (Catmull and Rom 1974), whose speed has no steps; fov,
    size, near, aperture, shift and the distance in focus (where a key states `focus`) are interpolated
    linearly, or K where one of them states it; all else is the first key's. Keys of other picture sizes see
    in the first one's what they see in theirs: K and shift are taken to its pixels. closed: the path leads
    back to the first key, which comes once. times: when the path is at each key, in any unit, growing; for a
    closed path one more, when it is back. None: equal times. ClrtError for arguments of another kind, for
    keys whose type, fov_axis (without K) or mirror differ: nothing lies between, and for keys between which
    the path leads through its target, or `up` through 0, or to a camera that cannot be.
    """
    frames = arguments.whole("frames", frames, 2, MOST)
    if not isinstance(keys, (list, tuple)) or len(keys) < 2:
        raise ClrtError(fault("", "keys", keys, "it must be a list of 2 cameras or more"))
    given = [_checked(f"keys[{i}]", key) for i, key in enumerate(keys)]
    views = [_sized(view, given[0].width, given[0].height) for view in given]
    by_k = any(view.has_k for view in views)
    for name in ("type", "mirror") if by_k else ("type", "mirror", "fov_axis"):
        _check_alike(views, name)
    parts = len(views) if arguments.flag("closed", closed) else len(views) - 1
    knots = _knots(times, parts + 1)
    lengths = [later - time for time, later in pairwise(knots)]
    steps = frames if closed else frames - 1
    points = np.array([[view.origin, view.target, view.up] for view in views], np.float64)
    arounds = [[_neighbour(part + k, len(views), closed) for k in (-1, 0, 1, 2)] for part in range(parts)]
    curves = [
        _curve(_four(points, around), _spans(lengths, here, closed)) for here, around in enumerate(arounds)
    ]
    for curve, around in zip(curves, arounds, strict=True):
        _check_way(curve, around[1:3])
    cameras = []
    for number in range(frames):
        at = knots[0] + number * (knots[-1] - knots[0]) / steps
        here = min(max(bisect_right(knots, at) - 1, 0), parts - 1)
        t = (at - knots[here]) / lengths[here]
        around, curve = arounds[here], curves[here]
        along = curve[0] + t * (curve[1] + t * (curve[2] + t * curve[3]))
        origin, target, up = points[around[2]] if t == 1 else along
        start, end = views[around[1]], views[around[2]]
        more = {"up": tuple(up.tolist()), **_lens(views, start, end, t)}
        if by_k:
            k = _between(_k_of(start), _k_of(end), t)
            more["K"] = tuple(map(tuple, k.tolist()))
        else:
            more |= {name: _between(getattr(start, name), getattr(end, name), t) for name in ("fov", "size")}
        camera = _moved(views[0], origin, target, **more)
        camera.check(At(path=f"{_pair(around[1:3])}, at frame {number}: camera"))
        cameras.append(camera)
    return cameras


def _check_way(curve: np.ndarray, keys: list[int]) -> None:
    """ClrtError where a part of the path leads a view, or its `up`, through 0."""
    for vector, what in ((curve[:, 0] - curve[:, 1], "the path leads through its target"),
                         (curve[:, 2], "`up` turns over, through 0")):  # fmt: skip
        size = max(np.abs(vector[0]).max(), np.abs(vector.sum(axis=0)).max())
        square = np.sum([np.convolve(cubic, cubic) for cubic in vector.T / size], axis=0)
        lowest = np.roots(np.polynomial.polynomial.polyder(square)[::-1]).real
        if (np.polynomial.polynomial.polyval(np.clip(lowest, 0, 1), square) < _NEAR**2).any():
            raise ClrtError(f"{_pair(keys)}: between them {what}; put a key that is aside between them")


def _pair(keys: list[int]) -> str:
    return " and ".join(f"keys[{key}]" for key in keys)


def _checked(name: str, camera: object) -> Camera:
    return read(Camera, arguments.instance(name, camera, Camera), At(path=name)).upright()


def _knots(times: object, count: int) -> list[float]:
    """When the path is at its keys."""
    if times is None:
        return [float(number) for number in range(count)]
    if isinstance(times, np.ndarray):
        times = times.tolist()
    right = f"it must be {count} numbers, each greater than the one before"
    if not isinstance(times, (list, tuple)) or len(times) != count:
        raise ClrtError(fault("", "times", times, right))
    found = [arguments.number(f"times[{i}]", time) for i, time in enumerate(times)]
    if not all(later - time > 0 for time, later in pairwise(found)) or not math.isfinite(
        found[-1] - found[0]
    ):
        raise ClrtError(fault("", "times", times, right))
    return found


def _lens(views: Sequence[Camera], start: Camera, end: Camera, t: float) -> dict[str, Any]:
    """What else changes between two cameras, in a straight line."""
    more: dict[str, Any] = {
        name: _between(getattr(start, name), getattr(end, name), t) for name in ("near", "aperture")
    }
    more["shift"] = tuple(_between(a, b, t) for a, b in zip(start.shift, end.shift, strict=True))
    if any(view.focus is not None for view in views):
        more["focus"] = _between(start.in_focus, end.in_focus, t)
    return more


def _between(a: T, b: T, t: float) -> T:
    """Exactly a where both are the same, and exactly b at the end."""
    return b if t == 1 else a + t * (b - a)


def _check_alike(views: Sequence[Camera], name: str) -> None:
    first = getattr(views[0], name)
    for number, view in enumerate(views):
        if getattr(view, name) != first:
            right = f"it must be {show(first)}, as that of keys[0]: a path has one"
            raise ClrtError(fault("", f"keys[{number}].{name}", getattr(view, name), right))


def _sized(view: Camera, width: int, height: int) -> Camera:
    """The same view in a picture of another size."""
    if (view.width, view.height) == (width, height):
        return view
    return resized(view, width, height)


def _k_of(view: Camera) -> np.ndarray:
    """What it states, or what follows from its angle alone: `shift` is a number of its own."""
    plain = msgspec.structs.replace(view, shift=(0.0, 0.0))
    assert plain.K is not None  # all are perspective, since one of them states it
    return np.array(plain.K, np.float64)


def _neighbour(number: int, count: int, closed: bool) -> int:
    return number % count if closed else min(max(number, 0), count - 1)


def _four(points: np.ndarray, around: Sequence[int]) -> np.ndarray:
    """The two points of a part and their neighbours; at an end of the path the part goes on as it is."""
    four = points[around]
    if around[0] == around[1]:
        four[0] = 2 * four[1] - four[2]
    if around[3] == around[2]:
        four[3] = 2 * four[2] - four[1]
    return four


def _spans(lengths: Sequence[float], here: int, closed: bool) -> tuple[float, float]:
    """How long a part of the path lasts, over the mean of it and the part before, and of it and the next.

    Both are 1 where times are equal, and at the ends of a path that is not closed.
    """
    own, last = lengths[here], len(lengths) - 1
    before = lengths[here - 1] if here or closed else own
    after = lengths[(here + 1) % len(lengths)] if here < last or closed else own
    return 2 * own / (own + before), 2 * own / (own + after)


def _curve(points: np.ndarray, spans: tuple[float, float]) -> np.ndarray:
    """From the second to the third of four points as t goes from 0 to 1: what 1, t, t^2 and t^3 stand with.

    At a key the speed is that from the key before to the one after, in as much time as this part takes. By
    differences alone: what is the same in all four stays that number exactly.
    """
    before, start, end, after = points
    way, leaving, arriving = end - start, spans[0] / 2 * (end - before), spans[1] / 2 * (after - start)
    return np.array([start, leaving, 3 * way - 2 * leaving - arriving, leaving + arriving - 2 * way])


def _moved(camera: Camera, origin: np.ndarray, target: np.ndarray, **changes: Any) -> Camera:
    changes |= {"origin": tuple(origin.tolist()), "target": tuple(target.tolist())}
    return Camera(**kept(camera, Camera, changes) | changes)
