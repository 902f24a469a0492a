"""Calls that are under way in other threads when the program ends: they end first.

Daemon threads go on while Python takes itself apart, and one that comes back from a driver or from the
picture library then ends the process (Python ends the thread by an exception that C++ does not let through).
So a program's end waits for them: what renders stops at the next piece of work, what saves a file saves it.

That is done when all of the program's own handlers of `atexit` have been called, for they may wait for a
thread that is to finish its work; what is done in the caller's own code, or by whom that keeps waiting, is
not waited for.
"""

from __future__ import annotations

import atexit
import os
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any, Final

_PAUSE: Final = 0.001  # s
_under_way: Final[dict[int, int]] = {}  # thread -> how many calls it is in, one within the other
_ends_in: Final[list[int]] = []  # the thread in which the program ends, once it does
_last: Final[list[Callable[[], object]]] = []


def enter() -> None:
    """A public call begins. Once the program ends it does in no other thread: there it waits for the end."""
    thread = threading.get_ident()
    if thread not in _under_way:
        _stop_at_the_end(thread)
    _under_way[thread] = _under_way.get(thread, 0) + 1


def leave() -> None:
    """It has ended."""
    thread = threading.get_ident()
    left = _under_way.pop(thread, 1) - 1
    if left:
        _under_way[thread] = left


@contextmanager
def inside() -> Iterator[None]:
    """A public call, or what goes on within it `outside`."""
    enter()
    try:
        yield
    finally:
        leave()


@contextmanager
def outside() -> Iterator[None]:
    """Something within a public call that may wait for ever, and is in no library of C++."""
    thread = threading.get_ident()
    depth = _under_way.pop(thread, 0)
    try:
        yield
    finally:
        if depth:
            _stop_at_the_end(thread)
            _under_way[thread] = depth


def call_back(function: Callable[..., Any], *arguments: Any) -> Any:
    """What a function of the caller's gives; what it raises is its own (`is_callers`)."""
    with outside():
        return function(*arguments)


def is_callers(error: BaseException) -> bool:
    """Whether an exception comes from a function of the caller's."""
    trace = error.__traceback__
    while trace is not None and trace.tb_frame.f_code is not call_back.__code__:
        trace = trace.tb_next
    return trace is not None


def check() -> None:
    """Between two pieces of long work: end the thread where the program ends in another."""
    if _ends_in and threading.get_ident() not in _ends_in:
        raise SystemExit


def at_last(action: Callable[[], object]) -> None:
    """Do something when the program ends, after all calls."""
    _last.append(action)


def _stop_at_the_end(thread: int) -> None:
    while _ends_in and thread not in _ends_in:
        time.sleep(1.0)


class _Token:
    """What a handler of `atexit` is given: it is let go when all handlers have been called, the program's
    own, too, whichever came first, and daemon threads still run."""

    ends = False

    def __del__(self) -> None:
        if self.ends:  # and is not let go for another reason, as in processes that `multiprocessing` forks
            _wait()


def _end(token: _Token) -> None:
    token.ends = True


atexit.register(_end, _Token())


def _wait() -> None:
    _ends_in.append(threading.get_ident())
    while set(_under_way) - set(_ends_in):
        time.sleep(_PAUSE)
    for action in _last:
        action()


def _keep_this_thread() -> None:
    """In a process that was forked the others are not there."""
    thread = threading.get_ident()
    depth = _under_way.get(thread, 0)
    _under_way.clear()
    if depth:
        _under_way[thread] = depth


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_keep_this_thread)
