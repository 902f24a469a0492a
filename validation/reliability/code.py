"""The code that a figure was measured with: what its modules import, one after the other, and the kernels."""

from __future__ import annotations

import ast
import hashlib
import subprocess
from collections.abc import Collection, Iterable, Iterator
from functools import cache
from pathlib import Path
from typing import Final

from clrt.base.resources import PACKAGE, kernel_folder, scene_folder

from ..independence import is_words

VALIDATION: Final = Path(__file__).resolve().parents[1]
ROOT: Final = VALIDATION.parent
COMMANDS: Final = tuple(sorted(path.stem for path in (PACKAGE / "cli").glob("[!_]*.py")))
"""Modules of the program `clrt`, which imports a command's own when it is asked for it."""
STATED: Final = (
    *(f"validation.scenes.{path.stem}" for path in sorted((VALIDATION / "scenes").glob("[!_]*.py"))),
    *(f"validation.mutants.{name}" for name in ("audit", "engine", "extent", "host", "kernels", "spectral",
                                                "surfaces")),
    "validation.spd", "validation.twin.check", "clrt",
)  # fmt: skip
"""What only says which cases and faults there are, jobs with code of their own, and `clrt`, which offers
names of its rooms: left out by who counts the case's scene and the fault's text itself."""


UNREAD: Final = tuple(f"-clrt.{name}" for name in (
    "meshfiles.file", "meshfiles.pictures", "meshfiles.embedded", "view.notebook", "judging.verdict",
    "engine.explain", "engine.raymesh", "engine.shown", "engine.watcher", "engine.apart", "images.dataset",
    "raytree.document", "raytree.tree",
))  # fmt: skip
"""What reads files of models, judges pictures, and shows rays and windows: imported by who asks for it alone,
and so left out of figures of clrt's own scenes (tests/validation/test_figure_stamps.py sees that none is)."""
DATA: Final = {
    "clrt.spectra": (PACKAGE / "spectra" / "tables", "*.csv"),
    "clrt.exercises": (PACKAGE / "exercises", "*.toml"),
    "validation.expected": (VALIDATION, "expected_hashes.json"),
    "validation.hostile": (VALIDATION / "hostile" / "corpus", "*"),
    "validation.proofs": (VALIDATION / "kernels", "*.cl"),
}
"""What modules of a package, or of that name, read beside them."""


def program(*commands: str) -> tuple[str, ...]:
    """Modules of `clrt COMMAND` for these commands, by the names of their modules; without any, for all."""
    unknown = {*commands} - {*COMMANDS}
    assert not unknown, f"no command: {', '.join(unknown)}"
    ours = (f"clrt.cli.{name}" for name in commands or COMMANDS)
    return "clrt.__main__", "clrt.base.display", "clrt.cli.options", *ours  # `clrt` imports the second


@cache
def digest(modules: tuple[str, ...], apart: tuple[str, ...] = ()) -> str:
    """SHA-256 of these modules, of what they import from here, kernels and, if used, scenes and other DATA.

    apart: as of `files`.
    """
    held = hashlib.sha256()
    for name, file in files(modules, apart):
        held.update(f"{name}\n".encode() + file.read_bytes())
    return held.hexdigest()


def files(modules: tuple[str, ...], apart: tuple[str, ...] = ()) -> list[tuple[str, Path]]:
    """Names and files of what `digest` is of. apart: modules that are left out, and with them all scenes."""
    found = {module: file for module in closure(modules, apart) if (file := module_file(module))}
    data = [*kernel_folder().iterdir()]
    for package, (folder, pattern) in DATA.items():
        if any(module == package or module.startswith(f"{package}.") for module in found):
            data += folder.glob(pattern)
    data += scene_folder().iterdir() if "clrt.formats.shipped" in found and not apart else []
    return [*sorted(found.items()), *((file.name, file) for file in sorted(data) if file.is_file())]


def forget() -> None:
    """Look at the files anew: they may have changed."""
    digest.cache_clear()
    _imports.cache_clear()
    _above.cache_clear()


def closure(modules: Iterable[str], apart: Collection[str] = ()) -> set[str]:
    """These modules and all of clrt's and validation's that they import, wherever in the file they do.

    Those that begin with a "-" are left out, as `apart`, and what they alone import.
    """
    found: set[str] = set()
    apart = {*apart, *(module[1:] for module in modules if module.startswith("-"))}
    waiting = [module for module in modules if not module.startswith("-")]
    while waiting:
        module = waiting.pop()
        if module not in found and module not in apart and module_file(module):
            found.add(module)
            waiting += [*_imports(module), *_above(module)]
    return found


@cache
def _above(module: str) -> tuple[str, ...]:
    """The packages that a module is in, of which each runs first, but those that hold words alone; and not
    `clrt`, which offers names of all rooms and imports those that somebody asks for."""
    parts = module.split(".")
    names = [".".join(parts[:k]) for k in range(1, len(parts))]
    files = {name: file for name in names if name != "clrt" and (file := module_file(name))}
    return tuple(name for name, file in files.items() if not holds_words(file))


def holds_words(file: Path) -> bool:
    """Whether a module has nothing but a docstring."""
    return is_words(ast.parse(file.read_bytes()))


@cache
def _imports(module: str) -> tuple[str, ...]:
    file = module_file(module)
    assert file
    package = module if file.name == "__init__.py" else module.rpartition(".")[0]
    return tuple(_named(ast.parse(file.read_bytes()), package))


def _named(tree: ast.Module, package: str) -> Iterator[str]:
    """Modules that a file may mean: of `from a import b` both a and a.b."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            for alias in node.names:
                yield alias.name
        elif isinstance(node, ast.ImportFrom):
            above = package.rsplit(".", node.level - 1)[0] if node.level > 1 else package
            base = ".".join(part for part in (above if node.level else "", node.module or "") if part)
            yield base
            for alias in node.names:
                yield f"{base}.{alias.name}"


def module_file(module: str) -> Path | None:
    """The file of a module of this repository; None of others."""
    package, *parts = module.split(".")
    if package not in ("clrt", "validation"):
        return None
    path = (VALIDATION if package == "validation" else PACKAGE).joinpath(*parts)
    return next((file for file in (path.with_suffix(".py"), path / "__init__.py") if file.is_file()), None)


def commit() -> tuple[str, bool]:
    """The commit of the checkout, and whether files have changed since; pages do not count."""
    asked = ["git", "-C", str(ROOT), "rev-parse", "--short", "HEAD"]
    changed = ["git", "-C", str(ROOT), "status", "--porcelain", "--", ":!docs"]
    name, state = (
        subprocess.run(words, capture_output=True, text=True, check=False).stdout.strip()
        for words in (asked, changed)
    )
    return name, bool(state)
