"""Folders for files that nobody keeps: gone with the block that made them, or the process that is ended."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any, TypeVar

from clrt.base.errors import ClrtError
from clrt.base.files import reason
from clrt.base.interrupts import folders, holding

_Made = TypeVar("_Made")


def placed(make: Callable[..., _Made], **named: Any) -> _Made:
    """What a maker of `tempfile` makes. ClrtError where no place takes temporary files."""
    try:
        with holding():  # it tries the place with a file of its own
            return make(**named)
    except OSError as error:
        text = "let the variable TMPDIR name a folder that can be written to"
        raise ClrtError(f"there is no place for temporary files: {reason(error)}; {text}") from None


def noted(make: Callable[..., _Made], **named: Any) -> _Made:
    """A folder as `placed` makes it, which goes with the process until it is taken from `folders`."""
    with holding():
        made = placed(make, **named)
        folders.add(str(getattr(made, "name", made)))
    return made


@contextmanager
def scratch() -> Iterator[Path]:
    """An empty folder, which is removed after the block. ClrtError where no place takes temporary files."""
    made = noted(tempfile.TemporaryDirectory, prefix="clrt-", ignore_cleanup_errors=True)
    try:
        yield Path(made.name)
    finally:
        _remove(made)
        folders.discard(made.name)  # not before: a signal within leaves the rest


def _remove(made: tempfile.TemporaryDirectory[str]) -> None:
    """Remove it with all in it. Python goes down level by level, as far as stack and descriptors last."""
    with suppress(RecursionError):
        made.cleanup()
    if os.path.lexists(made.name):
        _level(made.name)
        made.cleanup()


def _level(folder: str) -> None:
    """Move all folders within a folder to its top."""
    found = [entry.path for entry in os.scandir(folder) if entry.is_dir(follow_symlinks=False)]
    for path in found:  # it grows
        with suppress(OSError):
            for entry in [*os.scandir(path)]:
                if entry.is_dir(follow_symlinks=False):
                    top = os.path.join(folder, f"{len(found)}.level")
                    os.rename(entry.path, top)
                    found.append(top)
