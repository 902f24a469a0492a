"""Kernels are compiled by one process at a time, and the others find them in the folder.

24 processes that compile the same kernels at once take 175 s on 2 cores, and 44 s where one does it for all.
Programs and kernels are compiled side by side, each by one process: a file has its name when it is whole.
"""

from __future__ import annotations

import os
import stat
from collections.abc import Callable, Iterator
from contextlib import contextmanager, nullcontext, suppress
from pathlib import Path
from typing import Final

from clrt.base import interrupts, notices
from clrt.base.locks import FileLock, Timeout
from clrt.device.cachefolder import contents, entries_of, make, ours, remove

PATIENCE: Final = 60.0  # seconds that a process waits for another one that compiles
_LAUNCHED: Final = "launched"  # what has been compiled, by name
_COMPILING: Final = "compiling kernels"
_SOON: Final = 0.5  # seconds of waiting that nobody need be told of
_hurry: list[bool] = []  # holds something once waiting was in vain
watchers: list[Callable[[str], None]] = []  # each is told what a user waits for now, and "" when it is over


@contextmanager
def lock(wait: bool = True, name: str = "clrt") -> Iterator[bool]:
    """Hold the folder alone; False where that was not to be had, without `wait` at once.

    name: of the lock; another one holds one program or kernel, not the folder.

    The lock of a process that died is free; one that is stuck is passed by. Without locks (some network
    drives), or after PATIENCE seconds once, everybody goes on without.
    """
    file = ours(f"{name}.lock")
    held, holder = FileLock(file), Path(f"{file}.holder")
    got = False
    with suppress(OSError):
        make(file.parent)
        if not stat.S_ISREG(file.lstat().st_mode):  # it would keep everybody from it, and damage in its place
            remove(file) if file.is_dir() and not file.is_symlink() else file.unlink()
    # where there are no locks, everybody goes on without: as promised above
    with suppress(OSError, NotImplementedError):
        got = _acquired(held, PATIENCE if wait and not _hurry else 0.0, holder)
    try:
        if got:
            _note(holder)
        yield got
    finally:
        held.release()


def _acquired(held: FileLock, patience: float, holder: Path) -> bool:
    try:
        held.acquire(timeout=min(_SOON, patience))
        return True
    except Timeout:
        if not patience:
            return False
    with waiting(_reason(holder)):
        try:
            held.acquire(timeout=max(patience - _SOON, 0.0))
            return True
        except Timeout:
            _hurry.append(True)
            return False


@contextmanager
def waiting(what: str) -> Iterator[None]:
    """Tell the watchers what goes on; without a watcher, a warning says whom this process waits for."""
    if not watchers and what.startswith("waiting"):
        notices.warn("", "", what)
    for watcher in watchers:
        watcher(what)
    try:
        yield
    finally:
        for watcher in watchers:
            watcher("")


def _note(holder: Path) -> None:
    with suppress(OSError):  # only a message knows less
        if not holder.exists() or holder.is_file():  # a pipe would wait for a reader
            holder.write_text(f"{os.getpid()}\n", "ascii")


def _reason(holder: Path) -> str:
    """What goes on while a lock is waited for."""
    number = _holder(holder)
    if number in interrupts.helpers:
        return _COMPILING
    return f"waiting for {f'process {number}' if number else 'another process'}, which compiles kernels"


def _holder(holder: Path) -> int:
    """The number of the process that holds a lock; 0 where that is not known."""
    with suppress(OSError):
        text = contents(holder, 20).decode(errors="replace").strip()
        if text.isascii() and text.isdecimal():
            return int(text)
    return 0


def was_compiled(what: str) -> bool:
    """Whether what `compiling` names has been done before."""
    return _mark(what).exists()


def _mark(what: str) -> Path:
    return ours(_LAUNCHED, what)


@contextmanager
def compiling(program: str, *sizes: object) -> Iterator[bool]:
    """Around a build, or a launch for which the driver may compile first: whether that has been done before.

    The first process does it alone, so that the others find it in the folder. sizes: of a launch, with its
    kernel's name.
    """
    what = "-".join(map(str, (program, *sizes)))
    done = _mark(what)
    if done.exists():
        yield True
        return
    with lock(name=f"{_LAUNCHED}/{what}"):
        known = done.exists()
        with nullcontext() if known else waiting(_COMPILING):
            yield known
        with suppress(OSError):
            done.touch()


def forget_launches(own: Path) -> None:
    """Let all be compiled by one process at a time again (`compiling`); locks stay, for others hold them."""
    for mark, _, _ in entries_of(own / _LAUNCHED):
        if not mark.name.endswith((".lock", ".holder")):
            with suppress(OSError):
                os.unlink(mark.path)
