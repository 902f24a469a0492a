"""Hashes of small pictures that ship with the package: does this machine compute what ours did?

    python -m validation.expected      writes them anew, after the picture itself was meant to change
"""

from __future__ import annotations

import json
import warnings
from pathlib import Path
from typing import Final

import clrt
from clrt.atomic import replacing
from clrt.resources import shipped_scenes
from clrt.shipped import load_scene

FILE: Final = Path(__file__).with_name("expected_hashes.json")
WIDTH: Final = 24  # pixels


def hashes(device: int | str | None = None) -> dict[str, str]:
    """Hash of every shipped scene's picture, WIDTH pixels wide, by name."""
    out = {}
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", clrt.ClrtWarning)
        for name in shipped_scenes():
            out[name] = clrt.render(load_scene(name), width=WIDTH, device=device).hash
    return out


def check(device: int | str | None = None) -> tuple[bool, str]:
    """Whether all hashes are the expected ones, and a line about it."""
    expected, found = json.loads(FILE.read_text()), hashes(device)
    wrong = [name for name in expected if found.get(name) != expected[name]]
    if wrong:
        return False, f"{len(wrong)} of {len(expected)} pictures differ from ours: {', '.join(wrong)}"
    return True, f"{len(expected)} small pictures have the hashes that they have elsewhere"


def main() -> None:
    with replacing(FILE) as temporary:
        temporary.write_text(json.dumps(hashes(), indent=1) + "\n")


if __name__ == "__main__":
    main()
