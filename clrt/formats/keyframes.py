"""Keyframes of a camera's path: a .toml or .json file.

    [[keyframes]]
    time = 0                     # seconds; leave them out everywhere for equal times
    origin = [0, 1, 5]           # what a keyframe does not say is as in the scene's camera
    [[keyframes]]
    time = 2.5
    origin = [4, 1, 3]
    fov = 30

`closed = true` leads back to the first, where there are times `until` says when.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

from clrt.base.errors import SceneError, located, show
from clrt.base.limits import Limits, written
from clrt.base.places import At, known_keys
from clrt.base.records import read
from clrt.formats.native import load_other
from clrt.scene.camera import Camera
from clrt.scene.edit import kept

MOVES: Final = ("origin", "target", "up", "pose", "fov", "K", "size", "near", "aperture", "focus", "shift")
"""Fields of a camera that a keyframe may say: all that change along a path."""
_SUFFIXES: Final = (".toml", ".json")
_MOST: Final = 1 << 13  # keyframes, of three bytes or more: each takes 100 us to check


@dataclass(frozen=True)
class Keyframes:
    """Cameras, when the path is there (None: in equal times; of a closed path, also when it is back)."""

    source: str
    cameras: tuple[Camera, ...]
    times: tuple[float, ...] | None
    closed: bool

    def frames(self, fps: float) -> int | None:
        """How many pictures that is, so many a second; None without times."""
        if self.times is None:
            return None
        frames = round((self.times[-1] - self.times[0]) * fps)
        return frames if self.closed else frames + 1


def load_keyframes(path: Path, base: Camera | None, limits: Limits) -> Keyframes:
    """The keyframes in a file, on top of a scene's camera. SceneError, LimitError."""
    if path.suffix.lower() not in _SUFFIXES:
        text = f"the suffix {show(path.suffix)} is not known; keyframes are .toml or .json files"
        raise SceneError(located(str(path), "", text))
    return load_other(path, limits, lambda table: _keyframes(table, base, At(path.name)))


def _keyframes(table: Any, base: Camera | None, at: At) -> Keyframes:
    if not isinstance(table, Mapping):
        raise at.error(table, "keyframes are a table of keys")
    known_keys(table, ("keyframes", "closed", "until"), at)
    closed, keys = table.get("closed", False), table.get("keyframes")
    if not isinstance(closed, bool):
        raise at.key("closed").error(closed, "it must be true or false")
    if not isinstance(keys, list) or len(keys) < 2:
        raise at.key("keyframes").error(keys, "it must be a list of 2 tables or more: [[keyframes]]")
    if len(keys) > _MOST:
        text = f"{written(len(keys))} keyframes are too many; at most {written(_MOST)} are read"
        raise at.key("keyframes").says(f"{text}, leave some out")
    cameras = tuple(_camera(key, base, at.key("keyframes").item(i)) for i, key in enumerate(keys))
    return Keyframes(at.source, cameras, _times(table, keys, at), closed)


def _camera(key: Any, base: Camera | None, at: At) -> Camera:
    if not isinstance(key, Mapping):
        raise at.error(key, "a keyframe must be a table")
    known_keys(key, ("time", *MOVES), at)
    said = {name: value for name, value in key.items() if name != "time"}
    return read(Camera, kept(base, Camera, said) | said, at).upright()


def _times(table: Mapping[str, Any], keys: list[Any], at: At) -> tuple[float, ...] | None:
    """When the path is at each keyframe, each later than the one before: all say so, or none does."""
    places = [at.key("keyframes").item(i) for i in range(len(keys))]
    stated = ["time" in key for key in keys]
    if not any(stated):
        if "until" in table:
            raise at.key("until").error(table["until"], "there are no times; give each keyframe its time")
        return None
    if not all(stated):
        raise places[stated.index(False)].says("the key 'time' is missing; give each keyframe one, or none")
    entries = [(place.key("time"), key["time"]) for place, key in zip(places, keys, strict=True)]
    if table.get("closed", False):
        if "until" not in table:
            raise at.key("until").says("missing; a closed path says when it is back at its first keyframe")
        entries.append((at.key("until"), table["until"]))
    elif "until" in table:
        raise at.key("until").error(table["until"], "it is of a closed path; add closed = true")
    times: list[float] = []
    for place, time in entries:
        if isinstance(time, bool) or not isinstance(time, (int, float)) or not abs(time) <= 1e9:
            raise place.error(time, "it must be a number of seconds, from -1e9 to 1e9")
        if times and not float(time) > times[-1]:
            raise place.error(time, f"times must grow; the one before is {show(times[-1])}")
        times.append(float(time))
    return tuple(times)
