"""The kernels' source: one text of all files, the same for every scene."""

from __future__ import annotations

import os
import re
from collections.abc import Callable
from contextlib import suppress
from functools import lru_cache
from pathlib import Path
from typing import Final

from clrt import layout
from clrt.base.errors import ClrtError
from clrt.base.resources import kernel_folder, kernel_text
from clrt.layout.declarations import c_declarations

KERNEL_FILES: Final = (
    "generate.cl",
    "arrange.cl",
    "trace.cl",
    "surface.cl",
    "boundaries.cl",
    "light.cl",
    "bounce.cl",
    "ambient.cl",
    "compact.cl",
    "film.cl",
    "filter.cl",
    "tree.cl",
    "refit.cl",
    "query.cl",
    "crossings.cl",
)
_ONCE: Final = "#pragma once"
_INCLUDE: Final = re.compile(r'^#include "([\w.]+)"$')


def flatten_includes(
    files: tuple[str, ...], folder: Path, read: Callable[[Path], str] = kernel_text
) -> str:
    """One source of all files: each include in place, with #line so that messages name file and line.

    A file that says `#pragma once` stands there once; what is written for any number of lanes, at each width.
    (Real -I paths break on folders with a space in their name.) ClrtError where one includes itself.
    """
    seen: set[str] = set()
    out: list[str] = []

    def add(name: str, within: tuple[str, ...] = ()) -> None:
        if name in within:
            raise ClrtError(f"{folder / name}: includes itself")
        lines = read(folder / name).splitlines()
        if name in seen and _ONCE in lines:
            return
        seen.add(name)
        out.append(f'#line 1 "{name}"')
        for number, line in enumerate(lines, 1):
            match = line.startswith("#include") and _INCLUDE.match(line)
            if match:
                add(match.group(1), (*within, name))
                out.append(f'#line {number + 1} "{name}"')
            else:
                out.append("" if line == _ONCE else line)

    for name in files:
        add(name)
    return "\n".join(out) + "\n"


def kernel_source(
    ray_format: layout.RayFormat | None = None, lanes: int = 16, packet: int = 16, folder: Path | None = None,
    read: Callable[[Path], str] = kernel_text,
) -> str:  # fmt: skip
    """The program: the layout's declarations and every kernel file of `folder`, as `read` reads it."""
    declarations, folder = c_declarations(ray_format, lanes, packet), folder or kernel_folder()
    if read is not kernel_text:
        return declarations + flatten_includes(KERNEL_FILES, folder, read)
    return declarations + _flattened(folder, _state(folder))


@lru_cache(4)
def _flattened(folder: Path, state: tuple[tuple[str, int, int, int], ...]) -> str:
    """All files of a folder as it is now: reading them took half of the time of a small picture."""
    return flatten_includes(KERNEL_FILES, folder)


def _state(folder: Path) -> tuple[tuple[str, int, int, int], ...]:
    """Another one for every change of a file in there."""
    with suppress(OSError), os.scandir(folder) as entries:  # what cannot be read is told where it is read
        return tuple((one.name, (s := one.stat()).st_mtime_ns, s.st_size, s.st_ino) for one in entries)
    return ()
