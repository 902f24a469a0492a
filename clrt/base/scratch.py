"""Folders for files that nobody keeps: gone with the block that made them, or the process that is ended."""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, TypeVar

from clrt.base.errors import ClrtError
from clrt.base.files import reason
from clrt.base.interrupts import folders

_Made = TypeVar("_Made")


def placed(make: Callable[..., _Made], **named: Any) -> _Made:
    """What a maker of `tempfile` makes. ClrtError where no place takes temporary files."""
    try:
        return make(**named)
    except OSError as error:
        text = "let the variable TMPDIR name a folder that can be written to"
        raise ClrtError(f"there is no place for temporary files: {reason(error)}; {text}") from None


@contextmanager
def scratch() -> Iterator[Path]:
    """An empty folder, which is removed after the block. ClrtError where no place takes temporary files."""
    with placed(tempfile.TemporaryDirectory, prefix="clrt-", ignore_cleanup_errors=True) as folder:
        folders.add(folder)
        try:
            yield Path(folder)
        finally:
            folders.discard(folder)
