"""What a shell wants of clrt: a manual page, and completion for bash, zsh and tcsh; made from the parser.

The wheel's build runs this (`hatch_build.py`); `python installers/shell.py FOLDER` writes the files anywhere.
It needs shtab and argparse-manpage, and nothing that clrt itself needs.
"""

from __future__ import annotations

import argparse
import re
import sys
from pathlib import Path
from typing import Final

ROOT: Final = Path(__file__).resolve().parents[1]
PLACES: Final = {
    "clrt.1": "share/man/man1/clrt.1",
    "clrt.bash": "share/bash-completion/completions/clrt",
    "_clrt": "share/zsh/site-functions/_clrt",
    "clrt.csh": "share/clrt/completion/clrt.csh",
}
"""By file: where in an installation's folder it lies."""
_SCENES: Final = ("SCENE", "IN", "B", "C")  # what takes a file, or a scene that ships by its name
_FILES: Final = ("OUT", "FILE", "FILE.json", "FILE.csv", "OUT.html", "OLD.json", "F.xml", "A")
_PREAMBLE: Final = {
    "bash": '_clrt_scenes() {{ compgen -W "{names}" -- "$1"; compgen -f -- "$1"; }}\n',
    "zsh": "_clrt_scenes() {{ _alternative 'scenes:scene:({names})' 'files:file:_files' }}\n",
    "tcsh": "",
}


def scenes(root: Path = ROOT) -> list[str]:
    """The names of those that ship."""
    kinds = (".toml", ".json", ".nff", ".txt", ".py")
    files = [file for file in (root / "scenes").iterdir() if file.suffix in kinds]
    return sorted(file.stem for file in files if not file.name.startswith("generate_"))


def made(root: Path = ROOT) -> dict[str, str]:
    """The text of each file of PLACES."""
    import shtab
    from argparse_manpage.manpage import Manpage

    sys.path.insert(0, str(root))
    try:
        from clrt.cli.options import parser
        from clrt.version import __version__
    finally:
        sys.path.remove(str(root))
    commands = parser()
    _complete(commands, shtab.FILE)
    names = " ".join(scenes(root))
    texts = {
        file: shtab.complete(commands, shell, preamble={shell: _PREAMBLE[shell].format(names=names)})
        for file, shell in (("clrt.bash", "bash"), ("_clrt", "zsh"), ("clrt.csh", "tcsh"))
    }
    # a fixed text in place of today's date: the same source makes the same wheel
    about = {"date": f"version {__version__}", "manual_title": "clrt", "project_name": "clrt"}
    # a text that begins with a dot is no macro of roff's
    page = re.sub(r"^(?=[.'][a-z]\w{2})", r"\\&", str(Manpage(parser(), about)), flags=re.MULTILINE)
    return {"clrt.1": page, **texts}


def _complete(parser: argparse.ArgumentParser, files: object) -> None:
    """Say of each argument what may stand there."""
    for action in parser._actions:
        if isinstance(action, argparse._SubParsersAction):
            for command in action.choices.values():
                _complete(command, files)
        elif action.metavar in _SCENES:
            action.complete = {"bash": "_clrt_scenes", "zsh": "_clrt_scenes", "tcsh": "f"}  # type: ignore[attr-defined]
        elif action.metavar in _FILES:
            action.complete = files  # type: ignore[attr-defined]


def write(folder: Path, root: Path = ROOT) -> dict[str, str]:
    """Write the files into a folder: by their paths, where they are to be installed."""
    folder.mkdir(parents=True, exist_ok=True)
    for name, text in made(root).items():
        (folder / name).write_text(text, encoding="utf-8")
    return {str(folder / name): place for name, place in PLACES.items()}


if __name__ == "__main__":
    write(Path(sys.argv[1]))
