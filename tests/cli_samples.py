"""A small scene on the disk, and the command line in a process of its own."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path

SCENE = """
max_depth = 2
background = [0.1, 0.2, 0.3]
[camera]
origin = [0, 0, 4]
target = [0, 0, 0]
width = 24
height = 16
[[lights]]
type = "point"
position = [3, 4, 5]
[[shapes]]
type = "sphere"
center = [0.2, 0.1, 0]
radius = 1
material = { reflection = 0.3, diffuse = 0.6 }
"""


def scene_in(folder: Path) -> Path:
    path = folder / "ball.toml"
    path.write_text(SCENE)
    return path


def run(*arguments: object, **environment: str) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-m", "clrt", *map(str, arguments)]
    return subprocess.run(command, env={**os.environ, **environment}, capture_output=True, text=True)


def with_options(command: str, **values: object) -> str:
    """The command with these options, in the place of its own: each is given once."""
    for name, value in values.items():
        command = re.sub(rf" --{name} \S+", "", command) + f" --{name} {value}"
    return command
