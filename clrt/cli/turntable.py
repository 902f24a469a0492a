"""`clrt turntable`: a scene from all around its camera's target."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING, Any

from clrt.base.errors import ClrtError
from clrt.cli.series import render_series
from clrt.cli.source import scene_path

if TYPE_CHECKING:
    from clrt.scene.scene import Scene


def run(options: argparse.Namespace) -> int:
    """Render the circle. ClrtError for a scene without a camera."""
    from clrt.engine.sweep import PICTURES

    if not 1 <= options.frames <= PICTURES:
        raise ClrtError(f"--frames: {options.frames} is not allowed; it must be from 1 to {PICTURES}")
    return render_series(options, scene_path(options.scene), _values)


def _values(scene: Scene, options: argparse.Namespace) -> tuple[Scene, list[dict[str, Any]]]:
    from clrt.engine.campath import turntable
    from clrt.formats.native import with_values

    scene = with_values(scene, options.set)
    if scene.camera is None:
        raise ClrtError(f"{scene.source}: camera: missing; a turntable needs a [camera]")
    return scene, [{"camera.origin": view.origin} for view in turntable(scene.camera, options.frames)]
