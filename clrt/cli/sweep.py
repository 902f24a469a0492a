"""`clrt sweep`: a scene for every combination of some values, as files with a manifest, or as a video."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING, Any

from clrt.cli.series import render_series
from clrt.cli.source import scene_path

if TYPE_CHECKING:
    from clrt.scene.scene import Scene


def run(options: argparse.Namespace) -> int:
    """Render the series. ClrtError, before anything is rendered, for values that the scene does not take."""
    return render_series(options, scene_path(options.scene), _values)


def _values(scene: Scene, options: argparse.Namespace) -> tuple[Scene, list[dict[str, Any]]]:
    from clrt.engine.sweep import checked, combinations
    from clrt.formats.native import value_list

    changes = {place: value_list(text, scene.limits, place) for place, text in options.set}
    return scene, [*combinations(checked(scene, changes))]


