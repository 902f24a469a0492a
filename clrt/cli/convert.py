"""`clrt convert`: any scene format in, the project's own out."""

from __future__ import annotations

import argparse


def run(options: argparse.Namespace) -> int:
    """Write the scene of `options.input` to `options.output`. ClrtError leaves the output as it was."""
    from clrt.shipped import load_scene

    load_scene(options.input).save(options.output)
    return 0
