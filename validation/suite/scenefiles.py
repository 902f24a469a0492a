"""A scene in the format that another program reads."""

from __future__ import annotations

import json
import shutil
import tomllib
from pathlib import Path
from typing import Final

import tomli_w
from msgspec.structs import replace

from clrt.base.errors import ClrtError
from clrt.scene.scene import Scene

FORMATS: Final = (".toml", ".json", ".xml", ".pov")


def write_scene(scene: Scene, path: Path) -> None:
    """Write the scene, and what files it needs beside it. ClrtError where the format has no words for it."""
    if path.suffix == ".xml":
        from ..oracle_mitsuba.xml import write_xml

        if lacks := write_xml(scene, path):
            raise ClrtError(f"Mitsuba's plugins lack {lacks} things of this scene")
    elif path.suffix == ".pov":
        from ..oracle_povray.scene import write_pov

        write_pov(scene, path)
    elif scene.background_path is None:
        scene.save(path)
    else:
        image = shutil.copyfile(scene.background_path, path.with_name(f"sky{scene.background_path.suffix}"))
        replace(scene, background=0.0).save(path)
        text = path.read_text(encoding="utf-8")
        table = tomllib.loads(text) if path.suffix == ".toml" else json.loads(text)
        table["background"] = image.name
        written = tomli_w.dumps(table) if path.suffix == ".toml" else json.dumps(table)
        path.write_text(written, encoding="utf-8")
