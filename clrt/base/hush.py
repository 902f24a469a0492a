"""Standard error while libraries work: libpng and OpenMP write there what clrt says in its own line.

Only where clrt is the program (`take`): it then writes its own lines through a descriptor of its own, and
within `hushed` the usual one leads nowhere. Not around drivers: where the disk fills up while LLVM compiles,
it ends the process, and its line is the only one. A program that imports clrt keeps its own.
"""

from __future__ import annotations

import os
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Final

from clrt.base import interrupts

_DEBUG: Final = "POCL_DEBUG"  # whoever sets it wants to read what the driver writes
_lock = threading.RLock()  # a handler of the program's own may read a picture
_own: list[int] = []  # the descriptor that leads where standard error did
_within: list[int] = []  # the thread of each block that is being run


def take() -> None:
    """Let `sys.stderr` and the lines of interrupts use another descriptor than libraries do."""
    if sys.stderr is None or _own or os.environ.get(_DEBUG):
        return
    try:
        own = os.dup(2)
        stream = open(  # noqa: SIM115 - for as long as the process lives
            own, "w", encoding=sys.stderr.encoding, errors=sys.stderr.errors, buffering=1, closefd=False
        )
    except (OSError, LookupError):  # no descriptor is left: it stays as it is
        return
    sys.stderr.flush()
    sys.stderr, interrupts.errors_to = stream, own
    _own.append(own)


@contextmanager
def hushed() -> Iterator[None]:
    """Within the block, of whichever thread, what libraries write to standard error is dropped."""
    _enter()
    try:
        yield
    finally:
        _leave()


def for_good() -> None:
    """Drop all that comes: the last line has been written."""
    _enter()


def _enter() -> None:
    with _lock:
        if _own and not _within:
            nowhere = _nowhere()
            if nowhere >= 0:
                os.dup2(nowhere, 2)
                os.close(nowhere)
        _within.append(threading.get_ident())  # not before: what interrupts this has a block of its own


def _leave() -> None:
    with _lock:
        _within.remove(threading.get_ident())
        if _own and not _within:
            os.dup2(_own[0], 2)


def _nowhere() -> int:
    try:
        return os.open(os.devnull, os.O_WRONLY)
    except OSError:  # no descriptor is left
        return -1


def _keep_this_thread() -> None:
    """In a process that was forked the others are not there: they leave no block, and no lock."""
    global _lock
    _lock = threading.RLock()
    thread = threading.get_ident()
    others = len(_within) - _within.count(thread)
    _within[:] = [thread] * _within.count(thread)
    if _own and others and not _within:
        os.dup2(_own[0], 2)


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_keep_this_thread)
