"""`clrt sweep`: a scene for every combination of some values, as files with a manifest, or as a video."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from clrt.base.errors import ClrtError
from clrt.cli.series import check_fps, render_series
from clrt.cli.source import scene_path

if TYPE_CHECKING:
    from clrt.scene.camera import Camera
    from clrt.scene.scene import Scene

Values = dict[str, Any]
_FRAMES: Final = 120  # along a path whose keyframes have no times


def run(options: argparse.Namespace) -> int:
    """Render the series. ClrtError, before anything is rendered, for values that the scene does not take."""
    return render_series(options, scene_path(options.scene), _values)


def _values(scene: Scene, options: argparse.Namespace) -> tuple[Scene, list[Values]]:
    from clrt.engine.sweep import checked, combinations
    from clrt.formats.native import value_list
    from clrt.scene.scene import edited

    changes = {place: value_list(text, scene.limits, place) for place, text in options.set}
    if options.keyframes is None:
        if options.frames is not None:
            raise ClrtError("--frames: is of --keyframes; --set has a count of its own, FIRST:LAST:COUNT")
        return scene, [*combinations(checked(scene, changes))]
    scene = _with_camera(scene, changes)
    many = [*combinations(checked(scene, changes))]
    cameras = _cameras(scene, options, len(many))
    scene, path = edited(scene, {"camera": cameras[0]}), _moves(cameras)
    return scene, [values | move for values in many for move in path]


def _with_camera(scene: Scene, changes: dict[str, list[Any]]) -> Scene:
    """The scene with the camera that keyframes start from; its values are taken out of `changes`."""
    from clrt.scene.scene import edited

    for place in [place for place in changes if place.partition(".")[0] == "camera"]:
        values = changes.pop(place)
        if len(values) > 1:
            text = "what changes along a path stands in its keyframes; give one value"
            raise ClrtError(f"--set {place}: {len(values)} values are too many; {text}")
        scene = edited(scene, {place: values[0]})
    return scene


def _cameras(scene: Scene, options: argparse.Namespace, times: int) -> list[Camera]:
    """The cameras of the path, each of which can render. times: how often the path is gone along."""
    from clrt.engine.campath import camera_path
    from clrt.engine.sweep import PICTURES
    from clrt.formats.keyframes import load_keyframes

    check_fps(options.fps)
    keys = load_keyframes(Path(options.keyframes), scene.camera, scene.limits)
    frames = keys.frames(options.fps) or _FRAMES if options.frames is None else options.frames
    least, most = 2, PICTURES // times
    if not least <= frames <= most:
        own = f"from {least} to {most} are; say how many by --frames"
        raise ClrtError(f"{options.keyframes}: {frames} pictures of a path are not allowed; {own}")
    try:
        return camera_path(keys.cameras, frames, keys.closed, keys.times)
    except ClrtError as error:  # the file calls them otherwise
        raise error.reworded(f"{options.keyframes}: {error}".replace("keys[", "keyframes[")) from None


def _moves(cameras: list[Camera]) -> list[Values]:
    """What changes in the scene for each camera: where it is, and whatever is not the same for all."""
    from clrt.formats.keyframes import MOVES

    first = cameras[0]
    changing = [name for name in MOVES if any(one.stated(name) != first.stated(name) for one in cameras)]
    names = dict.fromkeys(("origin", "target", *changing))
    return [{f"camera.{name}": camera.stated(name) for name in names} for camera in cameras]
