"""`clrt hash`: the hash of a picture, equal wherever it was computed."""

from __future__ import annotations

import argparse
import json
from pathlib import Path
from typing import Final

from clrt.base.errors import ClrtError, in_line, legible
from clrt.cli.source import scene_path

_OTHERS: Final = (".png", ".tif", ".tiff", ".jpg", ".jpeg", ".bmp", ".hdr")


def run(options: argparse.Namespace) -> int:
    """Print `HASH  NAME` for a rendered scene, or for the pixels that an .exr file holds."""
    suffix = Path(options.scene).suffix.lower()
    if suffix in _OTHERS:
        raise ClrtError(f"{options.scene}: of pictures only an .exr has a hash; {suffix} rounds its values")
    if suffix == ".exr":
        _check_unasked(options)
        from clrt.images.file import read_samples
        from clrt.images.image import pixel_hash

        value = pixel_hash(read_samples(options.scene))
    else:
        from clrt.cli.render import render

        value = render(scene_path(options.scene), options).hash
    if options.json:
        print(json.dumps(legible({"hash": value, "scene": options.scene})))
    else:
        print(f"{value}  {in_line(options.scene)}")
    return 0


def _check_unasked(options: argparse.Namespace) -> None:
    """ClrtError for what is said of a render: a picture is as it is."""
    for name in ("width", "height", "crop", "spp", "set", "max_depth", "device", "threads", "limit"):
        if getattr(options, name) not in (None, []):
            option = "--set, --adaptive" if name == "set" else f"--{name.replace('_', '-')}"
            raise ClrtError(f"{option}: {options.scene} is a picture already; only a scene is rendered")
