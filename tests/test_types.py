"""What a type checker says of programs that use clrt, which ships its types (`py.typed`)."""

from __future__ import annotations

import ast
import inspect
import re
import subprocess
import sys
import typing
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

import clrt
import clrt.scene

ROOT = Path(__file__).resolve().parents[1]
TYPED = Path(__file__).parent / "typed"
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]
PAGES = [page for page in PAGES if "generated" not in page.parts]  # by `make docs`, of the others
# what pages get wrong of their own, to be short: no hints at their functions, a name used for two things,
# what may be None taken as it is. Whatever is left is between a page and clrt.
OWN = {"no-untyped-def", "no-untyped-call", "assignment", "union-attr", "name-defined", "index"}


def checked(*files: Path, folder: Path) -> list[str]:
    """The lines of mypy --strict about these files, as those see it who have installed clrt."""
    command = [sys.executable, "-m", "mypy", "--strict", "--follow-imports=silent", "--no-error-summary"]
    command += ["--config-file=", "--ignore-missing-imports", f"--cache-dir={folder / 'cache'}"]
    command += ["--no-incremental"] if sys.flags.dont_write_bytecode else []
    done = subprocess.run([*command, *map(str, files)], cwd=ROOT, capture_output=True, text=True, timeout=500)
    assert done.returncode in (0, 1), done.stdout + done.stderr
    return [line for line in done.stdout.splitlines() if ": note: " not in line]


@pytest.fixture(scope="module")
def told(tmp_path_factory: pytest.TempPathFactory) -> list[str]:
    """What mypy says of the sample programs and of each page's code, all at once: it looks at clrt once."""
    folder = tmp_path_factory.mktemp("typed")
    made = []
    for page in PAGES:
        blocks = re.findall(r"```python\n(.*?)```", page.read_text("utf-8"), re.DOTALL)
        if blocks:
            made.append(folder / f"page_{page.stem.replace('-', '_')}.py")
            made[-1].write_text("\n".join(blocks), "utf-8")
    assert len(made) > 15
    return checked(*made, TYPED / "program.py", TYPED / "unknown.py", folder=folder)


def test_a_program_of_all_public_names_is_right(told: list[str]) -> None:
    assert [line for line in told if "program.py:" in line] == []


def test_the_program_has_all_public_names() -> None:
    tree = ast.parse((TYPED / "program.py").read_text("utf-8"))
    used = {
        node.attr
        for node in ast.walk(tree)
        if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name) and node.value.id == "clrt"
    }
    assert set(clrt.__all__) <= used
    (imported,) = [n for n in ast.walk(tree) if isinstance(n, ast.ImportFrom) and n.module == "clrt.scene"]
    here = {alias.name for alias in imported.names} | {"Camera", "Scene"}
    records = {name for name in dir(clrt.scene) if hasattr(getattr(clrt.scene, name), "__struct_fields__")}
    assert here == records - {"Shape"}, "Shape is what all shapes have in common"


def test_what_is_not_there_is_an_error(told: list[str]) -> None:
    lines = (TYPED / "unknown.py").read_text("utf-8").splitlines()
    wrong = {number for number, line in enumerate(lines, 1) if line.endswith("# WRONG")}
    found = {int(line.split(":")[1]) for line in told if "unknown.py:" in line}
    assert found == wrong and len(wrong) > 10


def test_the_pages_code_has_the_types_that_clrt_takes(told: list[str]) -> None:
    """But for more of their own: a scene's camera may be None, dicts and lists hold things of two kinds."""
    of_pages = [line for line in told if Path(line.split(":")[0]).name.startswith("page_")]
    left = [line for line in of_pages if not OWN & {*re.findall(r"\[([\w-]+)\]$", line)}]
    short = ('"Camera | None"; expected "Camera"', '"**dict[str, int]"', 'to "inv" has', '"object" has')
    assert [line for line in left if not any(part in line for part in short)] == []


def public() -> Iterator[tuple[str, Any]]:
    """All that is public and can be called, by its name: functions, classes' own methods."""
    for name in clrt.__all__:
        value = getattr(clrt, name)
        if inspect.isclass(value):
            own = [(key, part) for key, part in vars(value).items() if not key.startswith("_")]
            yield from ((f"{name}.{key}", part) for key, part in own if inspect.isfunction(part))
        if inspect.isfunction(value) or inspect.isclass(value):
            yield name, value


@pytest.mark.parametrize("name", [name for name, _ in public()])
def test_hints_can_be_asked_for(name: str) -> None:
    """As documentation and validation of arguments do: names that are there for type checkers alone fail."""
    assert isinstance(typing.get_type_hints(dict(public())[name]), dict)


def test_the_hints_of_a_scene_are_its_fields() -> None:
    """Its constructor is written out for type checkers alone: a field that it lacks would go unnoticed."""
    tree = ast.parse(inspect.getsource(clrt.Scene))
    (stub,) = [n for n in ast.walk(tree) if isinstance(n, ast.FunctionDef) and n.name == "__init__"]
    assert {argument.arg for argument in stub.args.kwonlyargs} == {*clrt.Scene.__struct_fields__}
    defaults = {
        argument.arg: ast.literal_eval(value)
        for argument, value in zip(stub.args.kwonlyargs, stub.args.kw_defaults, strict=True)
        if value is not None and not (isinstance(value, ast.Constant) and value.value is ...)
    }
    del defaults["folder"]  # None is where one is now
    made = clrt.Scene()
    assert {name: getattr(made, name) for name in defaults} == defaults
