"""The folder of compiled kernels, PoCL's and clrt's own: private, undamaged, each compiled by one at a time.

Measured with PoCL 3.0 and 3.1: where the folder cannot be written to, the driver shows no device; where the
disk is full, or a file in there is cut short or overwritten, it ends the process (SIGABRT, SIGBUS); and
24 processes that compile the same kernels at once take 175 s on 2 cores, and 44 s where one does it for all.
Programs and kernels are compiled side by side, each by one process: a file has its name when it is whole.
"""

from __future__ import annotations

import atexit
import hashlib
import math
import os
import re
import shutil
import stat
import struct
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, nullcontext, suppress
from functools import cache
from pathlib import Path
from typing import Final

from platformdirs import user_cache_dir

from clrt.base import interrupts, notices
from clrt.base.errors import DeviceError, show
from clrt.base.locks import FileLock, Timeout
from clrt.base.resources import kernel_folder, kernel_text
from clrt.base.scratch import noted

VARIABLE: Final = "POCL_CACHE_DIR"
LONGEST: Final = 700  # bytes of its name: of a file in it PoCL holds 1,024, and ends the process beyond
ROOM: Final = 32 << 20  # bytes that must be free: compiling all kernels takes about 4 MB
PATIENCE: Final = 60.0  # seconds that a process waits for another one that compiles
_KEPT: Final = 30 * 24 * 3600  # seconds that kernels of other versions are kept after their last use
_LEFT: Final = 24 * 3600  # seconds after which nobody needs a temporary file any more
_LEFT_OVER: Final = re.compile(r"tempfile_\w{6}|looking-\w{8}")
_LETTERS, _DIGEST = re.compile("[A-P]{2}"), re.compile("[A-P]{30,}")  # PoCL's two folders around a program
_DEEPEST: Final = 2  # folders of a kernel and of its work-group's size, within that of a program
_OURS: Final = ".clrt"  # beside the driver's files, by itself: the folder may hold all kinds of things
_LAUNCHED: Final = "launched"  # what has been compiled, by name
_LOOKED: Final = "looked"  # its time is when the last look for damage began
_own: list[Path] = []  # the folder that `prepare` chose, not the user
_hurry: list[bool] = []  # holds something once waiting was in vain
_COMPILING: Final = "compiling kernels"
_SOON: Final = 0.5  # seconds of waiting that nobody need be told of
watchers: list[Callable[[str], None]] = []  # each is told what a user waits for now, and "" when it is over


def given() -> bool:
    """Whether the user chose the folder."""
    return bool(os.environ.get(VARIABLE)) and not _own


def usual_folder() -> Path:
    """Where kernels of this version are kept: what POCL_CACHE_DIR says, else in the user's cache folder."""
    if given():
        return Path(os.environ[VARIABLE]).absolute()  # of "." PoCL makes a place where it finds no device
    digest = hashlib.sha256()
    for file in sorted(kernel_folder().glob("*.cl*")):
        digest.update(f"{file.name} {kernel_text(file)}".encode())
    return Path(user_cache_dir("clrt", appauthor=False)) / "kernels" / digest.hexdigest()[:16]


@cache
def prepare() -> Path:
    """Make the folder ready before the driver sees it, and tell the driver; once a process.

    Where the usual one cannot be used, with a warning a private one, which goes when the process ends.
    """
    folder = usual_folder()
    fault = problem(folder)
    if fault:
        folder = Path(noted(tempfile.mkdtemp, prefix="clrt-kernels-"))
        atexit.register(shutil.rmtree, folder, ignore_errors=True)
        notices.warn("", "", f"kernels are compiled anew in each run: {fault}")
        worse = problem(folder)
        if worse:
            raise DeviceError(f"there is no place for compiled kernels: {fault}; {worse}")
    elif not given():
        _forget_others(folder)
    if not given():
        _own.append(folder)
    os.environ[VARIABLE] = str(folder)
    with lock(wait=False) as alone:
        if alone:  # whoever holds the lock has looked, before it compiled
            remove_damaged(folder)
    return folder


def problem(folder: Path) -> str:
    """Why PoCL cannot keep kernels in a folder, and what mends it; '' where it can. Makes the folder."""
    size = len(os.fsencode(folder))
    if size > LONGEST:
        return (
            f"the name of the kernel cache, {show(str(folder))}, has {size} bytes, "
            f"and the driver takes {LONGEST}; set {VARIABLE} to a shorter one"
        )
    try:
        make(folder)
        intruder = shared_with(folder)
        if intruder:
            return (
                f"the kernel cache {folder} is not yours alone ({intruder}), so what it holds is not run; "
                f"mend that, or set {VARIABLE} to another folder"
            )
        with tempfile.TemporaryFile(dir=folder):
            pass
        free = shutil.disk_usage(folder).free
    except OSError as error:
        return (
            f"the kernel cache {folder} cannot be written to ({error.strerror or error}); "
            f"set {VARIABLE} to a folder that can"
        )
    if free < ROOM:
        return f"the disk of the kernel cache {folder} is full ({free >> 20} MiB left); make room there"
    return ""


def ours(*names: str) -> Path:
    """What of clrt's own is kept beside the driver's files; `make` makes its folder."""
    return Path(os.environ[VARIABLE], _OURS, *names)


def make(folder: Path) -> None:
    """Make a folder and those above it, for nobody else to write to. OSError."""
    missing = [place for place in (folder, *folder.parents) if not place.is_dir()]
    for place in reversed(missing):
        place.mkdir(mode=0o700, exist_ok=True)


def shared_with(folder: Path) -> str:
    """Who else may change what is in a folder, or put another in its place; '' where nobody can.

    Compiled kernels are programs. (Windows keeps a user's cache folder private by itself.)
    """
    if not hasattr(os, "geteuid"):
        return ""
    folder, user = folder.resolve(), os.geteuid()
    for place in (folder, *folder.parents):
        status = place.stat()
        if status.st_uid not in (user, 0) or (place == folder and status.st_uid != user):
            return f"{place} belongs to user {status.st_uid}"
        foreign = status.st_mode & stat.S_IWOTH or (
            status.st_mode & stat.S_IWGRP and (place == folder or status.st_gid not in (os.getegid(), 0))
        )
        if foreign and (place == folder or not status.st_mode & stat.S_ISVTX):
            return f"others may write to {place}"
    return ""


def remove_damaged(folder: Path) -> list[Path]:
    """Remove programs that hold a damaged file, to be compiled again; give their folders.

    Only what has PoCL's names is touched, and no link is followed: the folder may hold what is not ours. Of
    thousands of kernels only those are opened that were written, or put there, since the last look: that was
    most of a start. Times are those of the folder's own file system. What the driver leaves behind goes, too.
    """
    own, last, now = folder / _OURS, 0, ""
    looked = own / _LOOKED
    with suppress(OSError):
        status = looked.lstat()
        last = status.st_mtime_ns if stat.S_ISREG(status.st_mode) else 0
    with suppress(OSError):  # only time is lost
        make(own)
        with interrupts.holding():
            handle, now = tempfile.mkstemp(dir=own, prefix="looking-")
            interrupts.temporaries.add(Path(now))
        # the clock was put back; or the machine was started since, perhaps after it lost files with its power
        if not time.time_ns() - time.monotonic_ns() < last <= os.fstat(handle).st_mtime_ns:
            last = 0
        os.close(handle)
    damaged = [program for program, changed in _programs(folder) if _is_damaged(program, changed, last)]
    for program in damaged:
        if program.is_symlink():
            program.unlink(missing_ok=True)
        _remove(program)
    if damaged:
        _forget_launches(own / _LAUNCHED)
    try:
        os.replace(now, looked)
    except OSError:  # a folder in its place: all is looked at each time
        with suppress(OSError):
            os.unlink(now)
    interrupts.temporaries.discard(Path(now))
    for place in (folder, own):
        _remove_left_overs(place)
    return sorted(damaged)


def _remove(folder: Path) -> None:
    """Remove a folder, as far as that is possible."""
    with suppress(RecursionError):  # deeper than Python goes: nothing of a driver's
        shutil.rmtree(folder, ignore_errors=True)


def regular_files(folder: Path) -> Iterator[int]:
    """The size of each file in a folder and those within it, however deep; links are not followed."""
    for _, status, _ in _within(folder):
        if stat.S_ISREG(status.st_mode):
            yield status.st_size


_Entry = tuple[os.DirEntry[str], os.stat_result, int]


def _within(folder: str | Path, put: int = 0, deepest: float = math.inf) -> Iterator[_Entry]:
    """`_entries` of a folder that was put there at a time, and of those within it."""
    folders = [(os.fspath(folder), put, 0)]
    while folders:
        place, put, depth = folders.pop()
        for entry, status, changed in _entries(place):
            changed = max(put, changed)
            yield entry, status, changed
            if stat.S_ISDIR(status.st_mode) and depth < deepest:
                folders.append((entry.path, changed, depth + 1))


def _entries(folder: str | Path) -> Iterator[_Entry]:
    """What is in a folder, each with what is known of it and not of what it links to, and when it was last
    written to or put there, in nanoseconds."""
    with suppress(OSError), os.scandir(folder) as entries:  # removed meanwhile
        for entry in entries:
            with suppress(OSError):
                status = entry.stat(follow_symlinks=False)
                yield entry, status, max(status.st_mtime_ns, status.st_ctime_ns)


def _programs(folder: Path) -> Iterator[tuple[Path, int]]:
    """Where PoCL keeps a program each, and when that was last written to, or put there."""
    for letters, status, put in _entries(folder):
        if _LETTERS.fullmatch(letters.name) and stat.S_ISDIR(status.st_mode):
            for program, _, changed in _entries(letters.path):
                if _DIGEST.fullmatch(program.name):
                    yield Path(program.path), max(put, changed)


def _is_damaged(program: Path, put: int, last: int) -> bool:
    """Whether what a program's folder holds of programs and kernels, written or put there at `last` or later,
    is not whole. A link is not: nobody knows when what it links to changes."""
    if program.is_symlink():
        return True
    for entry, status, changed in _within(program, put, _DEEPEST):
        compiled = entry.name.endswith((".bc", ".so"))
        # a link may be to a folder
        if changed >= last and (compiled or stat.S_ISLNK(status.st_mode)) and not whole(Path(entry.path)):
            return True
    return False


def _forget_launches(launched: Path) -> None:
    """Let all be compiled by one process at a time again (`compiling`); locks stay, for others hold them."""
    for mark, _, _ in _entries(launched):
        if not mark.name.endswith((".lock", ".holder")):
            with suppress(OSError):
                os.unlink(mark.path)


def _remove_left_overs(folder: Path) -> None:
    """Remove empty temporary files: PoCL leaves one for each build, a process that is killed here its own."""
    old = time.time_ns() - _LEFT * 10**9
    for file, status, _ in _entries(folder):
        if _LEFT_OVER.fullmatch(file.name) and stat.S_ISREG(status.st_mode) and not status.st_size:
            with suppress(OSError):
                if status.st_mtime_ns < old:
                    os.unlink(file.path)


def whole(file: Path) -> bool:
    """Whether a compiled program (LLVM bitcode) or kernel (ELF) is as long as its own tables say."""
    try:
        status = file.lstat()
        if not stat.S_ISREG(status.st_mode):
            return False  # the driver makes no others, and may wait for them for ever
        size = status.st_size
        with file.open("rb") as opened:
            head = opened.read(64)
            if file.suffix == ".so":
                if not head.startswith(b"\x7fELF\x02") or len(head) < 64:
                    return False
                sections, entry, count = struct.unpack_from("<40xQ10xHH", head)
                return bool(sections + entry * count <= size)
            # blocks follow each other: two words of head, the second of which is the length in words
            place = 4 if head.startswith(b"BC\xc0\xde") and size > 4 else size + 1
            while place < size:
                opened.seek(place)
                block = opened.read(8)
                words = struct.unpack("<II", block)[1] if len(block) == 8 else 0
                place += 8 + 4 * words if words else size  # no block is empty: it ends with a word
            return place == size
    except OSError:
        return True  # removed meanwhile


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
            _remove(file) if file.is_dir() and not file.is_symlink() else file.unlink()
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


def contents(file: Path, most: int = 1 << 20) -> bytes:
    """What a small file of ours holds, at most so many bytes. OSError where there is no regular file."""
    if not stat.S_ISREG(file.stat().st_mode):
        raise OSError(f"{file} is not a regular file")  # reading a pipe would wait for ever
    with file.open("rb") as opened:
        return opened.read(most)


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


def _forget_others(folder: Path) -> None:
    """Remove kernels of other versions that nobody has used for a month."""
    try:
        os.utime(folder)
        for other in folder.parent.iterdir():
            if other != folder and other.stat().st_mtime < time.time() - _KEPT:
                _remove(other)
    except OSError:
        pass
