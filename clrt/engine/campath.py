"""Cameras on a way: around a target, and along a path through others."""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Sequence
from itertools import pairwise
from typing import Any, Final

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

MOST: Final = 1 << 20  # cameras of a path: eleven hours of a video


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
    closed path one more, when it is back. None: equal times. ClrtError for arguments of another kind, and for
    keys whose type, fov_axis (without K) or mirror differ: nothing lies between.
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
    numbers = np.array([[view.fov, view.size] for view in views])
    cameras = []
    for number in range(frames):
        at = knots[0] + number * (knots[-1] - knots[0]) / steps
        here = min(max(bisect_right(knots, at) - 1, 0), parts - 1)
        t = (at - knots[here]) / lengths[here]
        around = [_neighbour(here + k, len(views), closed) for k in (-1, 0, 1, 2)]
        origin, target, up = _spline(points[around], _spans(lengths, here, closed), t)
        fov, size = (1 - t) * numbers[around[1]] + t * numbers[around[2]]
        start, end = views[around[1]], views[around[2]]
        more = {"up": tuple(up.tolist()), "fov": float(fov), "size": float(size)}
        if by_k:
            k = (1 - t) * _k_of(start) + t * _k_of(end)
            more = {"up": more["up"], "K": tuple(map(tuple, k.tolist()))}
        cameras.append(_moved(views[0], origin, target, **more, **_lens(views, start, end, t)))
    return cameras


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
    """What else changes between two cameras, in a straight line; exactly theirs where both say the same."""
    more: dict[str, Any] = {
        name: _between(getattr(start, name), getattr(end, name), t) for name in ("near", "aperture")
    }
    more["shift"] = tuple(_between(a, b, t) for a, b in zip(start.shift, end.shift, strict=True))
    if any(view.focus is not None for view in views):
        more["focus"] = _between(start.in_focus, end.in_focus, t)
    return more


def _between(a: float, b: float, t: float) -> float:
    return a + t * (b - a)


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


def _spans(lengths: Sequence[float], here: int, closed: bool) -> tuple[float, float]:
    """How long a part of the path lasts, over the mean of it and the part before, and of it and the next.

    Both are 1 where times are equal, and at the ends of a path that is not closed.
    """
    own, last = lengths[here], len(lengths) - 1
    before = lengths[here - 1] if here or closed else own
    after = lengths[(here + 1) % len(lengths)] if here < last or closed else own
    return 2 * own / (own + before), 2 * own / (own + after)


def _spline(points: np.ndarray, spans: tuple[float, float], t: float) -> np.ndarray:
    """Between the second and the third of four points, at 0 <= t <= 1.

    At a key the speed is that from the key before to the one after. Where times are not equal the outer
    points are moved to where they would be, at that speed, in as much time as this part takes.
    """
    before, start, end, after = points
    before = spans[0] * before + (1 - spans[0]) * end
    after = spans[1] * after + (1 - spans[1]) * start
    return 0.5 * (
        2 * start + (end - before) * t + (2 * before - 5 * start + 4 * end - after) * t**2
        + (3 * start - before - 3 * end + after) * t**3
    )  # fmt: skip


def _moved(camera: Camera, origin: np.ndarray, target: np.ndarray, **changes: Any) -> Camera:
    changes |= {"origin": tuple(origin.tolist()), "target": tuple(target.tolist())}
    return Camera(**kept(camera, Camera, changes) | changes)
