"""Libraries that look into the current folder as they begin, where anybody may have put something for them.

matplotlib obeys a `matplotlibrc` there, Intel's OpenCL runtime a `cl.cfg`, and its list of folders with
libraries has empty entries, each of which stands for the current folder: a `librt.so.1` there was run.
"""

from __future__ import annotations

import ctypes
import os
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Final

from clrt.base import interrupts

_CLONE_FS: Final = 0x200  # of Linux: what `unshare` makes a thread's own, its current folder


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


def apart(folder: Path, action: Callable[[], Any]) -> Any:
    """What `action` gives or raises, done in a thread whose current folder is `folder`: others keep theirs.

    Where threads cannot have one of their own (not Linux, some containers), it is done in the current one.
    """
    answer: list[Any] = []
    failure: list[BaseException] = []

    def work() -> None:
        try:
            if sys.platform == "linux" and ctypes.CDLL(None).unshare(_CLONE_FS) == 0:
                os.chdir(folder)
            answer.append(action())
        except BaseException as error:
            failure.append(error)

    thread = threading.Thread(target=work, name="clrt-apart", daemon=True)
    try:
        with own_stack():
            thread.start()
    except RuntimeError:  # there is no room for another thread
        return action()
    try:
        thread.join()
    finally:
        thread.join()  # after Ctrl-C, too: a driver must not be left in the middle
    if failure:
        raise failure[0]
    return answer[0]


@contextmanager
def own_stack() -> Iterator[None]:
    """Threads that begin meanwhile have the system's stack, whatever the program wants for its own: compilers
    of drivers need more than the least that Python allows."""
    before = threading.stack_size(0)
    try:
        yield
    finally:
        threading.stack_size(before)


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
