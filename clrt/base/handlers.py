"""The process' handlers of signals, whatever a library puts in their place.

LLVM, which drivers compile with, takes most signals for itself when it starts: its handler removes the files
that it is writing, then passes the signal on, or says nothing. What is being compiled then fails, with a line
on standard error that is nobody's; so does any file that meets `ulimit -f`, which Python ignores the signal
of; and a program's own handler of SIGUSR1 is never called again. LLVM takes them once a process, so what is
given back stays. SIGFPE is left to drivers: PoCL lives through divisions by zero with the help of it.
"""

from __future__ import annotations

import ctypes
import os
import signal
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from typing import Any, Final

_LEFT: Final = ("SIGFPE", "SIGKILL", "SIGSTOP")  # to drivers, and to the system
_ROOM: Final = 1024  # bytes for a `struct sigaction`, which has 152 on Linux and 16 on macOS
_POINTER: Final = ctypes.sizeof(ctypes.c_void_p)  # it begins with the function
_SET_HERE: Final = (signal.SIG_DFL, signal.SIG_IGN)  # what stands there in place of a function

_Handled = tuple[Any, Any]  # the system's `struct sigaction`, and what Python has installed, or None

_lock = threading.RLock()  # a handler of the program's own may render
_blocks = 0  # that are in `kept` now
_before: dict[int, _Handled] = {}  # how signals were handled when the first of them began


def _forget_threads() -> None:
    """In a forked child: another thread may have held the lock, and no block of another ends there."""
    global _lock, _blocks
    _lock, _blocks = threading.RLock(), 0


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_forget_threads)


@contextmanager
def kept() -> Iterator[None]:
    """After the block signals are handled as before it, also by what no Python has installed.

    What the program itself installs meanwhile, in another thread, stays. Of blocks in several threads at once
    the first one knows: the others may begin after a library has taken the signals.
    """
    global _blocks, _before
    with _lock:
        if not _blocks:
            _before = {number: (action, signal.getsignal(number)) for number, action in _actions()}
        _blocks += 1
    try:
        yield
    finally:
        with _lock:
            _blocks = max(0, _blocks - 1)  # it may have begun before a fork
            for number, action in _actions():
                if _is_taken(number, action):
                    _give_back(number)


def _is_taken(number: int, action: Any) -> bool:
    """Whether this is neither how a signal was handled before nor what the program has installed since."""
    function, installed = _function(action), signal.getsignal(number)
    if number not in _before or function == _function(_before[number][0]):
        return False
    if function in _SET_HERE:
        return function != installed
    return not _is_pythons(function)


def _give_back(number: int) -> None:
    """Handle a signal as the program wants it."""
    (action, before), now = _before[number], signal.getsignal(number)
    if now is not None and (now in _SET_HERE or before in _SET_HERE) and now != before:
        action = _installed(now)  # since then, and before a library took it
    taken = ctypes.create_string_buffer(_ROOM)
    if action and _sigaction()(number, action, taken) == 0 and not _is_taken(number, taken):
        _sigaction()(number, taken, None)  # the program was quicker


def _installed(wanted: Any) -> Any:
    """A `struct sigaction` for what Python has installed; None where no signal shows how that looks."""
    if wanted in _SET_HERE:
        return ctypes.create_string_buffer(int(wanted).to_bytes(_POINTER, sys.byteorder), _ROOM)
    return next((action for _, action in _actions() if _is_pythons(_function(action))), None)


def _actions() -> Iterator[tuple[int, Any]]:
    """The signals, and how the system has each handled, where it says so."""
    for number in _numbers():
        action = _action(number)
        if action:
            yield number, action


def _action(number: int) -> Any:
    """How the system has a signal handled; None where it does not say."""
    action = ctypes.create_string_buffer(_ROOM)
    return action if _sigaction()(number, None, action) == 0 else None


def _function(action: Any) -> int:
    return int.from_bytes(action[:_POINTER], sys.byteorder)


@cache
def _is_pythons(function: int) -> bool:
    """Whether a function is one of the interpreter's: a handler of `signal`, or of `faulthandler`."""
    return _home(function) == _home(ctypes.cast(ctypes.pythonapi.PyErr_CheckSignals, ctypes.c_void_p).value)


def _home(address: int | None) -> int | None:
    """Where the file of code lies that has an address; None where it is in none."""
    found = (ctypes.c_void_p * 4)()  # `Dl_info`: a name, where it begins, another name, an address
    known = address and ctypes.CDLL(None).dladdr(ctypes.c_void_p(address), found)
    return found[1] if known else None


@cache
def _numbers() -> tuple[int, ...]:
    """The signals; none on Windows, which has no `sigaction`."""
    if not _sigaction():
        return ()
    left = {getattr(signal, name) for name in _LEFT}
    return tuple(sorted(int(number) for number in signal.valid_signals() - left))


@cache
def _sigaction() -> Any:
    return getattr(ctypes.CDLL(None), "sigaction", None) if hasattr(signal, "SIGHUP") else None
