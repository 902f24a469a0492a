"""Folders for files that nobody keeps: gone with the block that made them, or the process that is ended."""

from __future__ import annotations

import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from clrt.base.errors import ClrtError
from clrt.base.files import reason
from clrt.base.interrupts import folders


@contextmanager
def scratch() -> Iterator[Path]:
    """An empty folder, which is removed after the block. ClrtError where no place takes temporary files."""
    try:
        made = tempfile.TemporaryDirectory(prefix="clrt-", ignore_cleanup_errors=True)
    except OSError as error:
        text = "let the variable TMPDIR name a folder that can be written to"
        raise ClrtError(f"there is no place for temporary files: {reason(error)}; {text}") from None
    with made as folder:
        folders.add(folder)
        try:
            yield Path(folder)
        finally:
            folders.discard(folder)
