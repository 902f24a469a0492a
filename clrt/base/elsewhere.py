"""Libraries that look into the current folder as they begin, where anybody may have put something for them.

matplotlib obeys a `matplotlibrc` there, Intel's OpenCL runtime a `cl.cfg`, and its list of folders with
libraries has empty entries, each of which stands for the current folder: a `librt.so.1` there was run.
"""

from __future__ import annotations

import os
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from clrt.base import interrupts


@contextmanager
def within(folder: Path) -> Iterator[None]:
    """Make `folder`, which is nobody else's to write to, the current one for a moment.

    Not where a program has other threads, since they have the same current folder.
    """
    if not interrupts.running() and threading.active_count() > 1:
        yield
        return
    here = _here()
    try:
        os.chdir(folder)
        yield
    finally:
        os.chdir(here)
        if isinstance(here, int):
            os.close(here)


@contextmanager
def without(name: str) -> Iterator[None]:
    """Take a variable out of the environment for a moment."""
    value = os.environ.pop(name, None)
    try:
        yield
    finally:
        if value is not None:
            os.environ[name] = value


def _here() -> str | int:
    """The current folder: its name, or, where that leads to it no more, a descriptor.

    No descriptor else: a driver that is loaded with few of them left ends the process.
    """
    try:
        name = os.getcwd()
        if os.path.samefile(name, "."):
            return name
    except OSError:  # it was removed, or what it lies in must not be looked into
        pass
    return os.open(".", getattr(os, "O_PATH", os.O_RDONLY))


def relative(*names: str) -> bool:
    """Whether one of these variables names a file or a folder from the current one: the user wants that."""
    places = [place for name in names for place in os.environ.get(name, "").split(os.pathsep)]
    return any(place and not os.path.isabs(place) for place in places)
