"""Calls that are under way in other threads when the program ends: they end first.

Daemon threads go on while Python takes itself apart, and one that comes back from a driver or from the
picture library then ends the process (Python ends the thread by an exception that C++ does not let through).
So a program's end waits for them: what renders stops at the next piece of work, what saves a file saves it.
"""

from __future__ import annotations

import atexit
import os
import threading
import time
from typing import Final

_PAUSE: Final = 0.001  # s
_under_way: Final[dict[int, int]] = {}  # thread -> how many calls it is in, one within the other
_ends_in: Final[list[int]] = []  # the thread in which the program ends, once it does


def enter() -> None:
    """A public call begins. Once the program ends it does in no other thread: there it waits for the end."""
    thread = threading.get_ident()
    while _ends_in and thread not in _ends_in and thread not in _under_way:
        time.sleep(1.0)
    _under_way[thread] = _under_way.get(thread, 0) + 1


def leave() -> None:
    """It has ended."""
    thread = threading.get_ident()
    if _under_way[thread] == 1:
        del _under_way[thread]
    else:
        _under_way[thread] -= 1


def check() -> None:
    """Between two pieces of long work: end the thread where the program ends in another."""
    if _ends_in and threading.get_ident() not in _ends_in:
        raise SystemExit


@atexit.register
def _wait() -> None:
    _ends_in.append(threading.get_ident())
    while set(_under_way) - set(_ends_in):
        time.sleep(_PAUSE)


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_under_way.clear)  # the other threads are not there
