"""`clrt convert`: any scene format in, the project's own out, or Mitsuba's XML."""

from __future__ import annotations

import argparse
from pathlib import Path

from clrt.atomic import check_replaceable
from clrt.cli.outputs import check_apart, check_spares
from clrt.resources import scene_file


def run(options: argparse.Namespace) -> int:
    """Write the scene of `options.input` to `options.output`. ClrtError leaves the output as it was."""
    from clrt.shipped import load_scene

    source = scene_file(options.input)
    check_replaceable(options.output)
    check_apart({"OUT": options.output}, {"the scene": source})
    scene = load_scene(source)
    check_spares({"OUT": options.output}, scene)
    if Path(options.output).suffix.lower() == ".xml":
        from clrt.cli import say
        from clrt.resources import validation_module

        changed = validation_module("oracle_mitsuba.xml").write_xml(scene, options.output)
        if changed:
            say(f"{options.output}: Mitsuba lacks {changed} things of this scene; the first lines name them")
        return 0
    scene.save(options.output)
    return 0
