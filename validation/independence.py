"""Which oracles share code: read from what their modules import, never from their names.

Two oracles are two only if the modules that they reach have none in common beyond SHARED. What a module
reaches is what its text imports, anywhere in it, and what that imports in turn; modules of other projects do
not count.
"""

from __future__ import annotations

import ast
import hashlib
import importlib.util
from collections.abc import Iterator, Mapping
from functools import cache
from pathlib import Path
from typing import Final

Roots = Mapping[str, Path]  # package -> its folder

SHARED: Final[Mapping[str, str]] = {
    "validation.types": "the records in which a picture is handed to its comparison",
    "validation.independence": "this count itself",
}
"""Modules that two oracles may share, and what they are."""

RENDERER: Final = "clrt"
_STARTS: Final[Mapping[str, tuple[str, ...]]] = {
    "oracle64": ("validation.oracle64",),
    "mitsuba": ("validation.oracle_mitsuba.client", "validation.oracle_mitsuba.worker"),
    "stock": ("validation.oracle_mitsuba.client", "validation.oracle_mitsuba.worker"),
    "povray": ("validation.oracle_povray.client",),
    RENDERER: ("clrt.engine.tracer", "clrt.formats"),
}


def family(oracle: str, roots: Roots | None = None) -> str:
    """The first oracle, by name, with which this one shares code; "closed form" and such stand for
    themselves."""
    name = oracle.split("-")[0]
    if name not in _STARTS:
        return name
    others = sorted(set(_STARTS) - {RENDERER})
    return next(other for other in others if other == name or shared(other, name, roots))


def shared(one: str, other: str, roots: Roots | None = None) -> list[str]:
    """The modules beyond SHARED that both reach; `one` and `other` are oracles or RENDERER."""
    return sorted((reached(one, roots) & reached(other, roots)) - set(SHARED))


def reached(oracle: str, roots: Roots | None = None) -> frozenset[str]:
    """The modules that an oracle, or the renderer, is made of."""
    roots = roots or {"clrt": _folder("clrt"), "validation": Path(__file__).parent}
    return _reached(_STARTS[oracle.split("-")[0]], tuple(roots.items()))


@cache
def code(oracle: str) -> str:
    """SHA-256 of what an oracle is made of: its modules, and the tables beside them."""
    roots: Roots = {"clrt": _folder("clrt"), "validation": Path(__file__).parent}
    files = {file for module in reached(oracle) if (file := _file(module, roots)) is not None}
    files |= {table for folder in {file.parent for file in files} for table in folder.rglob("*.csv")}
    held = hashlib.sha256()
    for file in sorted(files):
        held.update(file.read_bytes())
    return held.hexdigest()


@cache
def _reached(starts: tuple[str, ...], roots: tuple[tuple[str, Path], ...]) -> frozenset[str]:
    found: set[str] = set()
    todo = list(starts)
    while todo:
        module = todo.pop()
        if module not in found:
            found.add(module)
            todo += _imports(module, dict(roots))
    return frozenset(found)


def _folder(package: str) -> Path:
    spec = importlib.util.find_spec(package)
    assert spec is not None and spec.origin is not None
    return Path(spec.origin).parent


def _file(module: str, roots: Roots) -> Path | None:
    """The file of a module of ours; None of anything else."""
    package, *parts = module.split(".")
    if package == "clrt_validation":  # its name where it is installed
        package = "validation"
    if package not in roots:
        return None
    place = roots[package].joinpath(*parts)
    return next((file for file in (place / "__init__.py", place.with_suffix(".py")) if file.is_file()), None)


def _imports(module: str, roots: Roots) -> Iterator[str]:
    """The modules of ours that a module's text imports; all beside it where it says only later which."""
    file = _file(module, roots)
    assert file is not None, module
    yield from _above(module, roots)
    package = module if file.name == "__init__.py" else module.rpartition(".")[0]
    for node in ast.walk(ast.parse(file.read_text("utf-8"))):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names if _file(alias.name, roots))
        elif isinstance(node, ast.ImportFrom):
            base = package.split(".")[: len(package.split(".")) - node.level + 1] if node.level else []
            name = ".".join([*base, *([node.module] if node.module else [])])
            inner = [f"{name}.{alias.name}" for alias in node.names]
            modules = [each for each in inner if _file(each, roots)]
            if _file(name, roots) and len(modules) < len(inner):
                modules.append(name)
            yield from modules
        elif isinstance(node, ast.Call) and _called(node) in ("import_module", "__import__"):
            said = node.args[0]
            if not isinstance(said, ast.Constant):
                beside = file.parent.glob("*.py")
                yield from (f"{package}.{each.stem}" for each in beside if each.stem != "__init__")
                continue
            dots = len(str(said.value)) - len(str(said.value).lstrip("."))
            above = package.split(".")[: len(package.split(".")) - dots + 1] if dots else []
            name = ".".join([*above, str(said.value).lstrip(".")])
            if _file(name, roots):
                yield name


def _above(module: str, roots: Roots) -> Iterator[str]:
    """The packages that a module is in, of which each runs first, but those that hold words alone.

    Not the renderer's outermost: it offers names of its rooms, and imports those that somebody asks for.
    """
    parts = module.split(".")
    for name in (".".join(parts[:k]) for k in range(1, len(parts))):
        file = _file(name, roots)
        if name != RENDERER and file is not None and not is_words(ast.parse(file.read_text("utf-8"))):
            yield name


def is_words(tree: ast.Module) -> bool:
    """Whether a module has nothing but a docstring, and says of what Python it is."""
    return all(
        (isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant))
        or (isinstance(node, ast.ImportFrom) and node.module == "__future__")
        for node in tree.body
    )


def _called(node: ast.Call) -> str:
    return getattr(node.func, "id", getattr(node.func, "attr", ""))
