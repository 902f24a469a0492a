"""Scenes that differ in a few values, and cameras on a way: what many pictures are made of."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from itertools import product
from typing import Any, Final

import msgspec
import numpy as np

from clrt.base import arguments
from clrt.base.arguments import public
from clrt.base.errors import ClrtError, fault
from clrt.flatten.mesh import unit
from clrt.scene.camera import Camera
from clrt.scene.scene import Scene, edited

Values = dict[str, Any]
MOST: Final = 1 << 20  # cameras of a path: eleven hours of a video
PICTURES: Final = 100_000  # of a sweep: all values are looked at before the first


def checked(scene: Scene, changes: object) -> dict[str, Sequence[Any]]:
    """The changes as lists, each value of which the scene takes by itself."""
    found: dict[str, Sequence[Any]] = {}
    for place, values in arguments.mapping("changes", changes).items():
        if isinstance(values, np.ndarray):
            values = list(values)
        if not isinstance(values, (list, tuple, range)) or not values:
            right = "it must be a list of values, such as [20, 30]"
            raise ClrtError(fault("", f"changes[{place!r}]", values, right))
        found[place] = values
    pictures = math.prod(map(len, found.values()))
    if pictures > PICTURES:
        raise ClrtError(f"changes: {pictures} pictures are too many; one sweep has at most {PICTURES}")
    for place, values in found.items():
        others = {other: values[0] for other, values in found.items()}
        for value in values:
            edited(scene, {**others, place: value})
    return found


def combinations(changes: Mapping[str, Sequence[Any]]) -> Iterator[Values]:
    """Every combination of the values, the last place changing fastest."""
    for values in product(*changes.values()):
        yield dict(zip(changes, values, strict=True))


@public
def turntable(camera: Camera, frames: int) -> list[Camera]:
    """Cameras on a circle about the target and its `up`: `frames` (1 to 2^20), the given one first."""
    frames = arguments.whole("frames", frames, 1, MOST)
    camera = arguments.instance("camera", camera, Camera).upright()
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
def camera_path(keys: Sequence[Camera], frames: int, closed: bool = False) -> list[Camera]:
    """Cameras that pass through `keys` (2 or more) in equal times: `frames` (2 to 2^20) of them.

    Origin, target and up follow a Catmull-Rom spline (Catmull and Rom 1974), fov and size are interpolated
    linearly, or K where the first key states it; all else is the first key's. closed: the path leads back to
    the first key, which comes once.
    """
    frames = arguments.whole("frames", frames, 2, MOST)
    if not isinstance(keys, (list, tuple)) or len(keys) < 2:
        raise ClrtError(fault("", "keys", keys, "it must be a list of 2 cameras or more"))
    views = [arguments.instance(f"keys[{i}]", key, Camera).upright() for i, key in enumerate(keys)]
    parts = len(views) if arguments.flag("closed", closed) else len(views) - 1
    steps = frames if closed else frames - 1
    points = np.array([[view.origin, view.target, view.up] for view in views], np.float64)
    numbers = np.array([[view.fov, view.size] for view in views])
    cameras = []
    for number in range(frames):
        at = number * parts / steps
        here = min(int(at), parts - 1)
        t = at - here
        around = [_neighbour(here + k, len(views), closed) for k in (-1, 0, 1, 2)]
        origin, target, up = _spline(points[around], t)
        fov, size = (1 - t) * numbers[around[1]] + t * numbers[around[2]]
        more = {"up": tuple(up.tolist()), "fov": float(fov), "size": float(size)}
        if views[0].has_k:
            k = (1 - t) * _k_of(views[around[1]]) + t * _k_of(views[around[2]])
            more = {"up": more["up"], "K": tuple(map(tuple, k.tolist()))}
        cameras.append(_moved(views[0], origin, target, **more))
    return cameras


def _k_of(view: Camera) -> np.ndarray:
    if view.K is None:
        raise ClrtError("keys: where the first states K all must be perspective")
    return np.array(view.K, np.float64)


def _neighbour(number: int, count: int, closed: bool) -> int:
    return number % count if closed else min(max(number, 0), count - 1)


def _spline(points: np.ndarray, t: float) -> np.ndarray:
    """Between the second and the third of four points, at 0 <= t <= 1."""
    before, start, end, after = points
    return 0.5 * (
        2 * start + (end - before) * t + (2 * before - 5 * start + 4 * end - after) * t**2
        + (3 * start - before - 3 * end + after) * t**3
    )  # fmt: skip


def _moved(camera: Camera, origin: np.ndarray, target: np.ndarray, **changes: Any) -> Camera:
    places = {"origin": tuple(origin.tolist()), "target": tuple(target.tolist()), "pose": None}
    return msgspec.structs.replace(camera, **places, **changes)
