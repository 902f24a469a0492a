"""What the command that runs has read, or is going to: nothing that it writes may take the place of that.

A file is known by what it is (device and inode), so no link, slash or other spelling of its name hides it.
Only commands watch: a program may load a scene and save it to the file that it came from.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager

Identity = tuple[int, int]
Name = str | os.PathLike[str]

_read: dict[Identity, str] | None = None  # None: nobody watches


@contextmanager
def watched(watching: bool = True) -> Iterator[None]:
    """Within it, what is read, and what scenes name, is noted (or, where `watching` is False, is not)."""
    global _read
    before, _read = _read, {} if watching else None
    try:
        yield
    finally:
        _read = before


def note(file: int | Name, name: Name) -> None:
    """The file, or that of a descriptor, is read by this name, now or later."""
    if _read is not None:
        status = os.stat(file)
        _read.setdefault((status.st_dev, status.st_ino), os.fspath(name))


def noted() -> dict[Identity, str]:
    """The names of what has been read, by what it is."""
    return dict(_read or {})


def identity(file: Name) -> Identity | str:
    """What all names of one file have in common; of one that is not there yet, its path."""
    path = os.fspath(file)
    try:
        path = os.path.realpath(path)  # first: it forgives "scene.toml/"
        status = os.stat(path)
    except (OSError, ValueError):
        return path
    return status.st_dev, status.st_ino
