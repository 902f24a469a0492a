"""Where kernels are compiled to, PoCL's and clrt's own: a folder that is private, has room and is undamaged.

Measured with PoCL 3.0 and 3.1: where the folder cannot be written to, the driver shows no device; where the
disk is full it ends the process.
"""

from __future__ import annotations

import atexit
import hashlib
import os
import shutil
import tempfile
import time
from functools import cache
from pathlib import Path
from typing import Final

from platformdirs import user_cache_dir

from clrt.base import notices
from clrt.base.errors import DeviceError, show
from clrt.base.resources import kernel_folder, kernel_text
from clrt.base.scratch import noted
from clrt.device.cachedamage import remove_damaged
from clrt.device.cachefolder import VARIABLE, make, remove, shared_with
from clrt.device.cachelock import lock

LONGEST: Final = 700  # bytes of its name: of a file in it PoCL holds 1,024, and ends the process beyond
ROOM: Final = 32 << 20  # bytes that must be free: compiling all kernels takes about 4 MB
_KEPT: Final = 30 * 24 * 3600  # seconds that kernels of other versions are kept after their last use
_own: list[Path] = []  # the folder that `prepare` chose, not the user


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
        intruder = shared_with(folder)  # before anything is made in the folder of somebody else
        if not intruder:
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


def _forget_others(folder: Path) -> None:
    """Remove kernels of other versions that nobody has used for a month."""
    try:
        os.utime(folder)
        for other in folder.parent.iterdir():
            if other != folder and other.stat().st_mtime < time.time() - _KEPT:
                remove(other)
    except OSError:
        pass
