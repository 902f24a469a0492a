"""The process' handlers of signals that others send, whatever a library puts in their place.

LLVM, which drivers compile with, takes these signals for itself when it starts: its handler removes the
files that it is writing, then passes the signal on. What is being compiled then fails, with a line on
standard error that is nobody's; so does any file that meets `ulimit -f`, which Python ignores the signal of.
LLVM takes them once a process, so what is given back stays. Those of faults (SIGSEGV, SIGFPE) are left to
drivers: PoCL lives through divisions by zero with the help of one.
"""

from __future__ import annotations

import ctypes
import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from typing import Any, Final

_SIGNALS: Final = ("SIGINT", "SIGTERM", "SIGHUP", "SIGQUIT", "SIGUSR2", "SIGXCPU", "SIGXFSZ")
_ROOM: Final = 1024  # bytes for a `struct sigaction`, which has 152 on Linux and 16 on macOS


_lock = threading.RLock()  # a handler of the program's own may render
_blocks = 0  # that are in `kept` now
_before: dict[int, Any] = {}  # how signals were handled when the first of them began


@contextmanager
def kept() -> Iterator[None]:
    """After the block these signals are handled as before it, also by what no Python has installed.

    Of blocks in several threads at once the first one knows: the others may begin after a library has taken
    the signals.
    """
    global _blocks, _before
    with _lock:
        if not _blocks:
            _before = {number: action for number in _numbers() if (action := _action(number))}
        _blocks += 1
    try:
        yield
    finally:
        with _lock:
            _blocks -= 1
            for number, action in _before.items():
                _sigaction()(number, action, None)


def _action(number: int) -> Any:
    """How the system has a signal handled; None where it does not say."""
    action = ctypes.create_string_buffer(_ROOM)
    return action if _sigaction()(number, None, action) == 0 else None


@cache
def _numbers() -> tuple[int, ...]:
    """The signals; none on Windows, which has no `sigaction`."""
    return tuple(getattr(signal, name) for name in _SIGNALS if hasattr(signal, name) and _sigaction())


@cache
def _sigaction() -> Any:
    return getattr(ctypes.CDLL(None), "sigaction", None) if hasattr(signal, "SIGHUP") else None
