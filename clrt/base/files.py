"""Files that are read: regular ones only, those of a scene only inside its folder, and only up to a limit."""

from __future__ import annotations

import os
import stat
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import BinaryIO, Final

from clrt.base import inputs
from clrt.base.errors import SceneError, located, show
from clrt.base.limits import Limits
from clrt.base.places import At

_BLOCK: Final = 1 << 20
_KINDS = (
    (stat.S_ISDIR, "a folder"), (stat.S_ISFIFO, "a named pipe"), (stat.S_ISSOCK, "a socket"),
    (stat.S_ISCHR, "a device"), (stat.S_ISBLK, "a device"),
)  # fmt: skip


def resolve(name: str, folder: Path | None, at: At) -> Path:
    """The existing regular file called `name` inside `folder` (None: the current folder), to be read.

    What lies elsewhere and is only linked from there is not inside, but for the source itself: who named that
    (a model on the command line) may keep it where he likes.
    """
    try:
        root = (folder or Path()).resolve()
        path = (root / name).resolve()
        if not path.is_relative_to(root):
            inside = Path(os.path.normpath(root / name)).is_relative_to(root)
            linked = f"it is a link to {show(str(path))}, and " if inside else ""
            if name != at.source or not inside:
                raise at.error(name, f"{linked}a file must lie in the scene's folder, {root}")
            path = root / name  # whose ending says what it is
        if not path.is_file():
            raise at.error(name, f"there is no such file in {root}")
        inputs.note(path, path)  # pictures are read late: who writes until then must know
    except (OSError, ValueError, RuntimeError) as error:  # too long, a NUL inside, a loop of links
        raise at.error(name, f"must be the path of a file: {reason(error)}") from None
    return path


_JUST_NOW: Final = 2 * 10**9  # nanoseconds: longer than a tick of the clock of any file system


def version(path: Path) -> tuple[int, ...] | None:
    """What is another where a file is another, or was written to; None where that cannot be told.

    To be asked before the file is read. Of what was written just now it cannot: what is written within the
    same tick of the clock leaves the same times.
    """
    try:
        status = path.stat()
    except OSError:  # who reads it says so
        return None
    written = max(status.st_mtime_ns, status.st_ctime_ns)
    if abs(time.time_ns() - written) < _JUST_NOW:
        return None
    return status.st_dev, status.st_ino, status.st_size, status.st_mtime_ns, status.st_ctime_ns


def open_input(path: str | os.PathLike[str]) -> BinaryIO:
    """A regular file, opened to be read. SceneError for all else that has this name, without waiting for it.

    A pipe or a device may never answer, or never end, and opening it may already do something.
    """
    try:
        _check_regular(path, os.stat(path).st_mode)
        file = open(path, "rb", opener=_opened)  # noqa: SIM115 (the caller closes it)
    except FileNotFoundError:
        raise SceneError(located(os.fspath(path), "", "there is no such file")) from None
    except (OSError, ValueError) as error:
        raise SceneError(located(os.fspath(path), "", f"cannot be read: {reason(error)}")) from None
    try:
        status = os.fstat(file.fileno())
        _check_regular(path, status.st_mode)
        inputs.note(file.fileno(), path)
        if status.st_size == 0:  # empty, or one of /proc, some of which wait for what is to come
            file.close()
            return open(os.devnull, "rb")
    except BaseException:
        file.close()
        raise
    return file


@contextmanager
def opened(path: str | os.PathLike[str], limits: Limits, *names: str) -> Iterator[BinaryIO]:
    """A regular file within each of the `names` of `limits` (none: `file_bytes`), open for reading."""
    with open_input(path) as file:
        for name in names or ("file_bytes",):
            limits.check(name, os.fstat(file.fileno()).st_size, os.fspath(path))
        try:
            yield file
        except OSError as error:
            raise SceneError(located(os.fspath(path), "", f"cannot be read: {reason(error)}")) from None


def read_text_bytes(path: str | os.PathLike[str], limits: Limits) -> bytes:
    """The contents of a scene file of text, no larger than `limits.text_bytes` either."""
    return read_bytes(path, limits, "file_bytes", "text_bytes")


def read_bytes(path: str | os.PathLike[str], limits: Limits, *names: str) -> bytes:
    """The contents of a regular file within each of the `names` of `limits`; none: `file_bytes`."""
    names = names or ("file_bytes",)
    with opened(path, limits, *names) as file:
        data = _read(file, os.fstat(file.fileno()).st_size, min(getattr(limits, name) for name in names) + 1)
    for name in names:  # it may have grown
        limits.check(name, len(data), os.fspath(path))
    return data


def _read(file: BinaryIO, size: int, most: int) -> bytes:
    """Up to `most` bytes of a file of that size, or, if it has grown, more, in the memory that it needs."""
    parts = [file.read(min(size + 1, most))]
    while parts[-1] and sum(map(len, parts)) < most:
        parts.append(file.read(min(_BLOCK, most - sum(map(len, parts)))))
    return parts[0] if len(parts) < 3 and not parts[-1] else b"".join(parts)


def kind(mode: int) -> str:
    """What a file is that is no regular one, by its mode: 'a folder', 'a named pipe' ..."""
    return next(name for is_of, name in _KINDS if is_of(mode))


def reason(error: Exception) -> str:
    """Why the system, or Python before it, refused a file."""
    return error.strerror or str(error) if isinstance(error, OSError) else str(error)


def _opened(path: str, flags: int) -> int:
    return os.open(path, flags | getattr(os, "O_NONBLOCK", 0))  # it may have become a pipe meanwhile


def _check_regular(path: str | os.PathLike[str], mode: int) -> None:
    if not stat.S_ISREG(mode):
        raise SceneError(located(os.fspath(path), "", f"is {kind(mode)}, not a file"))
