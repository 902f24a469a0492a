"""A lock that is a file: one process, or thread of one, holds it, and it is free when that one dies.

By `flock`, as the package filelock does it, which takes 10 ms to import and is needed on Windows alone.
"""

from __future__ import annotations

import os
import sys
import time
from pathlib import Path
from typing import Final

_PAUSE: Final = 0.02  # seconds between two looks whether it is free

if sys.platform == "win32":
    from filelock import FileLock, Timeout
else:
    import fcntl

    class Timeout(TimeoutError):
        """Another one holds it still."""

    class FileLock:
        """The lock; `acquire` raises Timeout, and OSError where there are no locks."""

        def __init__(self, file: Path) -> None:
            self._file, self._held = file, -1

        def acquire(self, timeout: float) -> None:
            """Hold it, within so many seconds."""
            end = time.monotonic() + timeout
            opened = os.open(self._file, os.O_RDWR | os.O_CREAT | os.O_NOFOLLOW, 0o600)
            try:
                while not _locked(opened):
                    if time.monotonic() >= end:
                        raise Timeout(f"{self._file} is held by another one")
                    time.sleep(_PAUSE)
                self._held, opened = opened, -1
            finally:
                if opened >= 0:
                    os.close(opened)

        def release(self) -> None:
            """Let it go, where it is held: also what a forked child has of it."""
            if self._held >= 0:
                held, self._held = self._held, -1
                fcntl.flock(held, fcntl.LOCK_UN)
                os.close(held)

    def _locked(opened: int) -> bool:
        try:
            fcntl.flock(opened, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            return False
        return True


__all__ = ["FileLock", "Timeout"]
