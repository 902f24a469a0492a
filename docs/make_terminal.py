"""Draw terminal.svg of the README anew: `python docs/make_terminal.py`. What commands say, as they say it."""

from __future__ import annotations

import io
import os
import re
import subprocess
import sys
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Final

from rich.console import Console
from rich.text import Text

FOLDER = Path(__file__).parent
COLUMNS: Final = 96
SCENE: Final = """
[camera]
origin = [0, 1, 4]
target = [0, 0, 0]
[[lights]]
type = "point"
position = [3, 5, 4]
[[shapes]]
type = "sphere"
center = [0, 0, 0]
radius = 1
material = { ior = "glas", diffuse = 0.1, specular = 0.1, transmission = 0.8 }
"""
COMMANDS: Final = (
    "clrt check ball.toml",
    "sed -i s/glas/glass/ ball.toml && clrt check ball.toml",
    "clrt render - -o - --set camera.fov=20 --width 64 --quiet <ball.toml | file -",
    "clrt hash ball.toml --width 64 --json",
)


def said(command: str, folder: Path) -> str:
    """What a command prints in a folder, both streams."""
    run = f'clrt() {{ "{sys.executable}" -W ignore -m clrt "$@"; }}; {command}'
    environment = {**os.environ, "COLUMNS": str(COLUMNS), "PYTHONPATH": str(FOLDER.parent)}
    done = subprocess.run(
        ["bash", "-c", run], cwd=folder, env=environment, text=True, check=False, stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
    )  # fmt: skip
    return done.stdout


def main() -> None:
    """The session as a picture of a terminal."""
    console = Console(record=True, width=COLUMNS, file=io.StringIO(), force_terminal=True)
    with TemporaryDirectory() as name:
        Path(name, "ball.toml").write_text(SCENE, "utf-8")
        for command in COMMANDS:
            console.print(Text(f"$ {command}", style="bold"))
            console.print(Text(said(command, Path(name))))
    picture = console.export_svg(title="clrt", unique_id="terminal")
    # whoever looks at it fetches nothing
    picture = re.sub(r"@font-face \{.*?\}", "", picture, flags=re.DOTALL)
    (FOLDER / "terminal.svg").write_text(picture, "utf-8")


if __name__ == "__main__":
    main()
