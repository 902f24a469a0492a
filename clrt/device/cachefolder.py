"""A folder of compiled kernels: what of it is clrt's own, who may write to it, what is in it."""

from __future__ import annotations

import math
import os
import shutil
import stat
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from typing import Final

VARIABLE: Final = "POCL_CACHE_DIR"
OURS: Final = ".clrt"  # beside the driver's files, by itself: the folder may hold all kinds of things


def ours(*names: str) -> Path:
    """What of clrt's own is kept beside the driver's files; `make` makes its folder."""
    return Path(os.environ[VARIABLE], OURS, *names)


def make(folder: Path) -> None:
    """Make a folder and those above it, for nobody else to write to. OSError."""
    missing = [place for place in (folder, *folder.parents) if not place.is_dir()]
    for place in reversed(missing):
        place.mkdir(mode=0o700, exist_ok=True)


def shared_with(folder: Path) -> str:
    """Who else may change what is in a folder, or put another in its place; '' where nobody can.

    Of one that is not there those above it tell.

    Compiled kernels are programs. (Windows keeps a user's cache folder private by itself.)
    """
    if not hasattr(os, "geteuid"):
        return ""
    folder, user = folder.resolve(), os.geteuid()
    for place in (folder, *folder.parents):
        if not place.exists():
            continue
        status = place.stat()
        if status.st_uid not in (user, 0) or (place == folder and status.st_uid != user):
            return f"{place} belongs to user {status.st_uid}"
        foreign = status.st_mode & stat.S_IWOTH or (
            status.st_mode & stat.S_IWGRP and (place == folder or status.st_gid not in (os.getegid(), 0))
        )
        if foreign and (place == folder or not status.st_mode & stat.S_ISVTX):
            return f"others may write to {place}"
    return ""


def contents(file: Path, most: int = 1 << 20) -> bytes:
    """What a small file of ours holds, at most so many bytes. OSError where there is no regular file."""
    if not stat.S_ISREG(file.stat().st_mode):
        raise OSError(f"{file} is not a regular file")  # reading a pipe would wait for ever
    with file.open("rb") as opened:
        return opened.read(most)


def remove(folder: Path) -> None:
    """Remove a folder, as far as that is possible."""
    with suppress(RecursionError):  # deeper than Python goes: nothing of a driver's
        shutil.rmtree(folder, ignore_errors=True)


def regular_files(folder: Path) -> Iterator[int]:
    """The size of each file in a folder and those within it, however deep; links are not followed."""
    for _, status, _ in within(folder):
        if stat.S_ISREG(status.st_mode):
            yield status.st_size


Entry = tuple[os.DirEntry[str], os.stat_result, int]


def within(folder: str | Path, put: int = 0, deepest: float = math.inf) -> Iterator[Entry]:
    """`entries_of` of a folder that was put there at a time, and of those within it."""
    folders = [(os.fspath(folder), put, 0)]
    while folders:
        place, put, depth = folders.pop()
        for entry, status, changed in entries_of(place):
            changed = max(put, changed)
            yield entry, status, changed
            if stat.S_ISDIR(status.st_mode) and depth < deepest:
                folders.append((entry.path, changed, depth + 1))


def entries_of(folder: str | Path) -> Iterator[Entry]:
    """What is in a folder, each with what is known of it and not of what it links to, and when it was last
    written to or put there, in nanoseconds."""
    with suppress(OSError), os.scandir(folder) as entries:  # removed meanwhile
        for entry in entries:
            with suppress(OSError):
                status = entry.stat(follow_symlinks=False)
                yield entry, status, max(status.st_mtime_ns, status.st_ctime_ns)
