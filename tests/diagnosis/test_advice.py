"""What a message or a page advises can be done: the command and its option, the extra and the module."""

from __future__ import annotations

import argparse
import ast
import importlib.util
import re
import tomllib
from collections.abc import Iterator
from functools import cache
from pathlib import Path

import pytest

from clrt.cli import main
from clrt.cli.options import parser

ROOT = Path(__file__).resolve().parents[2]
FOREIGN = {"--help"}  # options of argparse itself
# of Debian and Homebrew
PACKAGES = {"binutils", "chromium", "g++", "libembree-dev", "pocl", "pocl-opencl-icd", "povray"}
# the parser itself; what other programs are called with, or (pytest) take from us
OTHERS_OPTIONS = {
    "options.py", "install.py", "doctor.py", "host.py", "embree.py", "scaling.py", "plugin.py",
}  # fmt: skip
OTHERS = {"intel-opencl-rt", "embreex"}  # of PyPI, and of no extra here
_COMMAND = re.compile(r"\bclrt ([a-z][a-z-]*)((?: +(?:--?[a-zA-Z][\w-]*|[^\s`;,()]+))*)")


def messages(folder: str) -> Iterator[tuple[str, str]]:
    """(file, text) of every string that is no docstring; what an f-string fills in is an X."""
    for file in sorted((ROOT / folder).rglob("*.py")):
        if "corpus" in file.parts:
            continue
        tree = ast.parse(file.read_text())
        joined = [node for node in ast.walk(tree) if isinstance(node, ast.JoinedStr)]
        within = {id(part) for node in joined for part in node.values}
        bare = {id(node.value) for node in ast.walk(tree) if isinstance(node, ast.Expr)}
        for node in ast.walk(tree):
            if isinstance(node, ast.JoinedStr):
                yield file.name, "".join(
                    str(part.value) if isinstance(part, ast.Constant) else "X" for part in node.values
                )
            elif isinstance(node, ast.Constant) and isinstance(node.value, str):
                if id(node) not in within | bare:
                    yield file.name, node.value


def pages() -> Iterator[tuple[str, str]]:
    """(file, text) of every line of code and every piece between backticks in the documentation."""
    concepts = sorted((ROOT / "docs" / "concepts").glob("*.md"))
    for file in [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md")), *concepts]:
        text = file.read_text()
        for block in re.findall(r"^(?:    |\$ )(clrt .*)$", text, re.MULTILINE):
            yield file.name, re.split(r"\s{2,}|\s#", block)[0]
        for piece in re.findall(r"`(clrt [^`]*)`", text):
            yield file.name, piece


@cache
def options(hidden: bool = False) -> dict[str, set[str]]:
    """The options of each command and of its actions; `hidden`: those of our own processes, too."""

    def within(made: argparse.ArgumentParser) -> set[str]:
        inner = [a.choices.values() for a in made._actions if isinstance(a, argparse._SubParsersAction)]
        deeper = {text for parsers in inner for one in parsers for text in within(one)}
        shown = (action for action in made._actions if hidden or action.help != argparse.SUPPRESS)
        return {text for action in shown for text in action.option_strings} | deeper

    (commands,) = [a for a in parser()._actions if isinstance(a, argparse._SubParsersAction)]
    return {name: within(made) for name, made in commands.choices.items()}


@cache
def advised() -> list[tuple[str, str]]:
    quoted = [
        (file, piece)
        for folder in ("clrt", "validation")
        for file, text in messages(folder)
        for piece in re.findall(r"`(clrt [^`]*)`|with: (clrt .*)", text)
        for piece in piece
        if piece
    ]
    return [*quoted, *pages()]


def test_every_command_that_is_advised_exists_with_its_options():
    found = 0
    for file, text in advised():
        for command, rest in _COMMAND.findall(text):
            found += 1
            assert command in options(), f"{file}: `{text}`: no such command"
            own = re.sub(r"'[^']*'", "", rest)  # without another program's command, which is one argument
            given = set(re.findall(r"(?<![\w-])--?[a-zA-Z][\w-]*", own))
            assert given <= options()[command] | FOREIGN, f"{file}: `{text}`"
    assert found > 40


@pytest.mark.parametrize("command", sorted(options()))
def test_every_command_explains_itself(command: str, capsys: pytest.CaptureFixture[str]):
    assert main([command, "--help"]) == 0
    text = capsys.readouterr().out
    for inner in re.findall(r"^    (\w+) ", text.split("ACTION\n")[1], re.M) if "ACTION\n" in text else ():
        assert main([command, inner, "--help"]) == 0
        text += capsys.readouterr().out
    assert all(option in text for option in options()[command])
    readme = (ROOT / "README.md").read_text()
    assert f"clrt {command}" in readme


def test_options_in_messages_exist():
    known = {"--version"}.union(*options(hidden=True).values())
    found = 0
    for file, text in messages("clrt"):
        if file in OTHERS_OPTIONS:
            continue
        for option in re.findall(r"(?:^|[\s(;])(--[a-z][a-z-]*)\b(?!=[\w]+[\",])", text):
            found += 1
            assert option in known, f"{file}: {option} in {text!r}"
    assert found > 8


def test_packages_extras_and_modules_exist():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    extras = project["optional-dependencies"]
    wanted = [*project["dependencies"], *(entry for entries in extras.values() for entry in entries)]
    names = {re.split(r"[<>=!;\[ ]", entry)[0].lower() for entry in wanted}
    texts = [*messages("clrt"), *messages("validation"), ("README.md", (ROOT / "README.md").read_text())]
    texts += [(file.name, file.read_text()) for file in sorted((ROOT / "docs").glob("*.md"))]
    seen: set[str] = set()
    for file, text in texts:
        for extra in re.findall(r"'(?:clrt|\.)\[([\w,]+)\]'", text):
            seen.add("extra")
            assert set(extra.split(",")) <= set(extras), f"{file}: [{extra}]"
        for package in re.findall(r"pip install (?!-)([\w][\w-]+)", text):
            seen.add("package")
            assert package.lower() in names | OTHERS, f"{file}: pip install {package}"
        for package in re.findall(r"(?:apt-get|brew) install (?:-y )?([\w][\w+-]*)", text):
            seen.add("system")
            assert package in PACKAGES, f"{file}: install {package}"
        for module in re.findall(r"python -m ([\w.]+)", text):
            seen.add("module")
            assert importlib.util.find_spec(module), f"{file}: python -m {module}"
    assert seen == {"extra", "package", "system", "module"}
