"""The modules of the program `clrt`, which imports a command's own when it is asked for it."""

from __future__ import annotations

from typing import Final

from clrt.base.resources import PACKAGE

COMMANDS: Final = tuple(sorted(path.stem for path in (PACKAGE / "cli").glob("[!_]*.py")))


def program(*commands: str) -> tuple[str, ...]:
    """Modules of `clrt COMMAND` for these commands, by the names of their modules; without any, for all."""
    unknown = {*commands} - {*COMMANDS}
    assert not unknown, f"no command: {', '.join(unknown)}"
    ours = (f"clrt.cli.{name}" for name in commands or COMMANDS)
    return "clrt.__main__", "clrt.base.display", "clrt.cli.options", *ours  # `clrt` imports the second
