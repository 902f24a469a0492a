"""The references: every public name from its docstring, every command from the parser."""

from __future__ import annotations

import argparse
import inspect
import re
from functools import cache
from pathlib import Path

import clrt
from clrt.cli.examples import EXAMPLES
from clrt.cli.options import parser

DOCS = Path(__file__).resolve().parents[1]


def write(folder: Path) -> None:
    """Write python.md and commands.md."""
    (folder / "python.md").write_text(python(), "utf-8")
    (folder / "commands.md").write_text(commands(), "utf-8")


def python() -> str:
    """The page of all public names, as autodoc reads them."""
    lines = ["# Python reference", ""]
    lines += ["All public names with their docstrings. [From Python](../api.md) shows how they fit.", ""]
    for name in sorted(clrt.__all__, key=str.lower):
        if name.startswith("__"):
            continue
        value = getattr(clrt, name)
        kind = "autofunction" if inspect.isfunction(value) else "autoclass"
        kind = "autoexception" if isinstance(value, type) and issubclass(value, BaseException) else kind
        members = ["   :members:"] if kind == "autoclass" else []
        lines += [f"## {name}", "", "```{eval-rst}", f".. {kind}:: clrt.{name}", *members, "```", ""]
    return "\n".join(lines)


@cache
def public_words() -> frozenset[str]:
    """All words of api.md: what it names is public (versions.md)."""
    return frozenset(re.findall(r"\w+", (DOCS / "api.md").read_text("utf-8")))


def plain_type(text: str) -> str:
    """A type as a reader wants it: of `Annotated[float, msgspec.Meta(..., description='must be > 0')]` the
    float and what it must be.
    """
    while (start := text.find("Annotated[")) >= 0:
        depth, end, comma = 0, start, 0
        for end in range(start + len("Annotated"), len(text)):
            depth += (text[end] in "[(") - (text[end] in "])")
            comma = comma or (end if depth == 1 and text[end] == "," else 0)
            if not depth:
                break
        said = re.search(r"description=(['\"])(.*?)\1\)", text[comma:end])
        inner = text[start + len("Annotated[") : comma] + (f", {said[2]}" if said else "")
        text = text[:start] + inner + text[end + 1 :]
    return text


def commands() -> str:
    """The page of all commands."""
    lines = ["# Command reference", "", "What `clrt COMMAND --help` says. A SCENE is a file, a name from",
             "`clrt scenes`, or `-`: standard input.", ""]  # fmt: skip
    for name, command in parser().commands.items():
        lines += [f"## clrt {name}", "", _escaped(command.description or ""), ""]
        nested = [action for action in command._actions if isinstance(action, argparse._SubParsersAction)]
        if not nested:
            lines += _options(command)
        for inner in nested:
            for action, made in inner.choices.items():
                lines += [f"### clrt {name} {action}", "", _escaped(made.description or ""), ""]
                lines += _options(made)
        for line, what in EXAMPLES.get(name, ()):
            lines += [f"    {line}", f"        {what}"]
        lines.append("")
    return "\n".join(lines)


def _options(command: argparse.ArgumentParser) -> list[str]:
    """A table of what a command takes."""
    rows = ["| | |", "|---|---|"]
    for action in command._actions:
        if "--help" in action.option_strings:
            continue
        value = _value(action)
        shown = " ".join(filter(None, (", ".join(action.option_strings), value)))
        rows.append(f"| `{shown.replace('|', '/')}` | {_escaped(action.help or '')} |")
    return [*rows, ""]


def _value(action: argparse.Action) -> str:
    if action.nargs == 0:
        return ""
    name = action.metavar or ("/".join(map(str, action.choices)) if action.choices else action.dest)
    text = " ".join(name) if isinstance(name, tuple) else str(name)
    return f"{text} ..." if action.nargs in ("+", "*") else text


def _escaped(text: str) -> str:
    """Plain text within a table: `%%` is argparse's, braces and stars would be MyST's."""
    return text.replace("%%", "%").replace("|", "\\|").replace("*", "\\*").replace("<", "&lt;")
