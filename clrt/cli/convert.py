"""`clrt convert`: any scene format in, the project's own out, Mitsuba's XML, POV-Ray's language or NFF."""

from __future__ import annotations

import argparse
from pathlib import Path

from clrt.base.atomic import check_replaceable
from clrt.cli.outputs import check_apart
from clrt.cli.source import STREAM, read, scene_path


def run(options: argparse.Namespace) -> int:
    """Write the scene of `options.input` to `options.output`. ClrtError leaves the output as it was."""
    from clrt.base.limits import Limits
    from clrt.formats.native import with_values

    source, limits = scene_path(options.input), Limits(**dict(options.limit))
    if options.output == STREAM:
        from clrt.scene.save import encoded

        scene = with_values(read(source, limits), options.set)
        print(encoded(scene, Path("scene.toml")).decode(), end="")
        return 0
    check_replaceable(options.output)
    check_apart({"OUT": options.output}, {"the scene": source})
    scene = with_values(read(source, limits), options.set)
    check_apart({"OUT": options.output}, {})
    if Path(options.output).suffix.lower() == ".xml":
        from clrt.base.resources import validation_module
        from clrt.cli.terminal import say
        from clrt.formats.mitsuba.scene import with_itself

        path = Path(options.output)
        changed = validation_module("oracle_mitsuba.xml").write_xml(
            scene, path, lambda text: with_itself(scene, path, text)
        )
        if changed and not options.quiet:
            things = "1 thing" if changed == 1 else f"{changed} things"
            say(f"{options.output}: Mitsuba lacks {things} of this scene; its first lines name all")
        return 0
    if Path(options.output).suffix.lower() == ".pov":
        from clrt.base.resources import validation_module

        validation_module("oracle_povray.scene").write_pov(scene, options.output)
        return 0
    if Path(options.output).suffix.lower() == ".nff":
        from clrt.formats.nff.writer import write_nff

        write_nff(scene, options.output)
        return 0
    scene.save(options.output)
    return 0
