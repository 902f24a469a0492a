"""`clrt scenes`: the names that `clrt render` knows without a path."""

from __future__ import annotations

import argparse
import json
from pathlib import Path

from clrt.base.resources import scene_folder, shipped_scenes


def run(options: argparse.Namespace) -> int:
    """Print each shipped scene with the first comment of its file, and where the files are."""
    scenes = shipped_scenes()
    if options.json:
        rows = [{"name": name, "about": headline(file), "file": str(file)} for name, file in scenes.items()]
        print(json.dumps(rows, indent=2))
        return 0
    width = max(map(len, scenes))
    for name, file in scenes.items():
        print(f"{name:{width}}  {headline(file)}".rstrip())
    print(f"in {scene_folder()}")
    return 0


def headline(file: Path) -> str:
    """The text of a comment, or of a script's docstring, in the file's first line, else nothing."""
    with file.open(encoding="utf-8") as lines:
        first = lines.readline(200)
    return first.lstrip('#" ').strip() if first.startswith(("#", '"""')) else ""
