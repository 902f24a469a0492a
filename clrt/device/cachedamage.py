"""Damaged kernels are removed before the driver meets them: at a file in its folder that is cut short, or
overwritten, PoCL (3.0, 3.1) ends the process (SIGABRT, SIGBUS)."""

from __future__ import annotations

import os
import re
import stat
import struct
import tempfile
import time
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from typing import Final

from clrt.base import interrupts
from clrt.device.cachefolder import OURS, entries_of, make, remove, within
from clrt.device.cachelock import forget_launches

_LEFT: Final = 24 * 3600  # seconds after which nobody needs a temporary file any more
_LEFT_OVER: Final = re.compile(r"tempfile_\w{6}|looking-\w{8}")
_LETTERS, _DIGEST = re.compile("[A-P]{2}"), re.compile("[A-P]{30,}")  # PoCL's two folders around a program
_DEEPEST: Final = 2  # folders of a kernel and of its work-group's size, within that of a program
_LOOKED: Final = "looked"  # its time is when the last look for damage began


def remove_damaged(folder: Path) -> list[Path]:
    """Remove programs that hold a damaged file, to be compiled again; give their folders.

    Only what has PoCL's names is touched, and no link is followed: the folder may hold what is not ours. Of
    thousands of kernels only those are opened that were written, or put there, since the last look: that was
    most of a start. Times are those of the folder's own file system. What the driver leaves behind goes, too.
    """
    own, last, now = folder / OURS, 0, ""
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
        remove(program)
    if damaged:
        forget_launches(own)
    try:
        os.replace(now, looked)
    except OSError:  # a folder in its place: all is looked at each time
        with suppress(OSError):
            os.unlink(now)
    interrupts.temporaries.discard(Path(now))
    for place in (folder, own):
        _remove_left_overs(place)
    return sorted(damaged)


def _programs(folder: Path) -> Iterator[tuple[Path, int]]:
    """Where PoCL keeps a program each, and when that was last written to, or put there."""
    for letters, status, put in entries_of(folder):
        if _LETTERS.fullmatch(letters.name) and stat.S_ISDIR(status.st_mode):
            for program, _, changed in entries_of(letters.path):
                if _DIGEST.fullmatch(program.name):
                    yield Path(program.path), max(put, changed)


def _is_damaged(program: Path, put: int, last: int) -> bool:
    """Whether what a program's folder holds of programs and kernels, written or put there at `last` or later,
    is not whole. A link is not: nobody knows when what it links to changes."""
    if program.is_symlink():
        return True
    for entry, status, changed in within(program, put, _DEEPEST):
        compiled = entry.name.endswith((".bc", ".so"))
        # a link may be to a folder
        if changed >= last and (compiled or stat.S_ISLNK(status.st_mode)) and not whole(Path(entry.path)):
            return True
    return False


def _remove_left_overs(folder: Path) -> None:
    """Remove empty temporary files: PoCL leaves one for each build, a process that is killed here its own."""
    old = time.time_ns() - _LEFT * 10**9
    for file, status, _ in entries_of(folder):
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
