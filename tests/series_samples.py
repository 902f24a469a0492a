"""What tests of series share: a scene, running commands on it, and reading what they left."""

from __future__ import annotations

import csv
from pathlib import Path

from clrt.cli import main

TOML = """
background = 0.3
max_depth = 2
camera = {origin = [0, 1, 5], target = [0, 0, 0], width = 16, height = 12}
lights = [{type = "point", position = [2, 4, 3]}]
[materials.red]
color = [0.8, 0.1, 0.1]
[materials."=1+1"]
color = 0.5
[[shapes]]
type = "sphere"
center = [0, 0, 0]
radius = 1
material = "red"
"""


def rows(path: str = "frames.csv") -> list[dict[str, str]]:
    with open(path, newline="") as file:
        return [*csv.DictReader(file)]


def times() -> dict[str, int]:
    """When each picture was written, in ns."""
    return {file.name: file.stat().st_mtime_ns for file in Path().glob("*.png")}


def run(*arguments: str) -> int:
    named = () if "-o" in arguments else ("-o", "{index:02}_{camera.fov}.png")
    return main(["sweep", "s.toml", *named, "--quiet", *arguments])
