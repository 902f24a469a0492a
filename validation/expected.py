"""Hashes of small pictures that ship with the package: does this machine compute what ours did?

    python -m validation.expected      writes them anew, after the picture itself was meant to change
"""

from __future__ import annotations

import json
import warnings
from pathlib import Path
from typing import Final

import clrt
from clrt.base.atomic import replacing
from clrt.base.errors import MissingPackage
from clrt.base.resources import shipped_scenes
from clrt.formats.shipped import load_scene

FILE: Final = Path(__file__).with_name("expected_hashes.json")
WIDTH: Final = 24  # pixels


def hashes(device: int | str | None = None, quick: bool = False) -> dict[str, str]:
    """Hash of every shipped scene's picture, WIDTH pixels wide, by name; "" where a package is missing.

    quick: only of scenes that are files, in RGB.
    """
    out = {}
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", clrt.ClrtWarning)
        for name, file in shipped_scenes().items():
            if quick and file.suffix == ".py":
                continue
            try:
                scene = load_scene(name)
            except MissingPackage:
                out[name] = ""
                continue
            if not (quick and scene.spectrum is not None):
                out[name] = clrt.render(scene, width=WIDTH, device=device).hash
    return out


def check(device: int | str | None = None, quick: bool = False) -> tuple[bool, str]:
    """Whether all hashes are the expected ones, and a line about it."""
    expected, found = json.loads(FILE.read_text()), hashes(device, quick)
    missing = [name for name, found_hash in found.items() if not found_hash]
    compared = [name for name in (found if quick else expected) if name not in missing]
    wrong = [name for name in compared if found.get(name) != expected.get(name)]
    left_out = ""
    if missing:
        left_out = f"; not run, for they need clrt's extra [mesh] (trimesh): {', '.join(missing)}"
    if wrong:
        text = f"{len(wrong)} of {len(compared)} pictures differ from ours: {', '.join(wrong)}"
        return False, text + left_out
    return True, f"{len(compared)} small pictures have the hashes that they have elsewhere{left_out}"


def main() -> None:
    with replacing(FILE) as temporary:
        temporary.write_text(json.dumps(hashes(), indent=1) + "\n")


if __name__ == "__main__":
    main()
