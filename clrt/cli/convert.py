"""`clrt convert`: any scene format in, the project's own out."""

from __future__ import annotations

import argparse

from clrt.resources import scene_file


def run(options: argparse.Namespace) -> int:
    """Write the scene of `options.input` to `options.output`. ClrtError leaves the output as it was."""
    import clrt

    clrt.load(scene_file(options.input)).save(options.output)
    return 0
