"""Writing files so that a reader finds the old one or the complete new one, never half of one."""

from __future__ import annotations

import json
import os
import stat
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any, Final

from clrt.base import inputs
from clrt.base.errors import ClrtError, exhausted, legible
from clrt.base.files import kind, reason
from clrt.base.interrupts import note_saved, temporaries

_SUFFIX: Final = 16


@contextmanager
def replacing(path: str | os.PathLike[str], told: bool = True) -> Iterator[Path]:
    """Give a new, empty file beside `path` to write to; it takes the place of `path` when the block ends.

    The new file has the suffix of `path` and the permissions of what it replaces, is forced to the disk
    before the replacement, and is removed when the block fails or is interrupted. ClrtError when `path` can
    be no file's name (one that ends in a slash is a folder's), is not a regular file's, is a file that the
    command has read, or its folder is missing or cannot be written to.

    told: whether an interrupted command says that it is saved.
    """
    target = _target(path)
    suffix = target.suffix if len(target.suffix) <= _SUFFIX else ""  # a name of 255 bytes may be all suffix
    temporary = target.with_name(f".clrt-{os.urandom(6).hex()}{suffix}")
    temporaries.add(temporary)
    old = _permissions(target)
    try:
        try:
            # Opened, not mkstemp: a new file then gets the permissions that the user's umask asks for.
            mode = 0o666 if old is None else 0o600
            os.close(os.open(temporary, os.O_CREAT | os.O_EXCL | os.O_WRONLY, mode))
        except (OSError, ValueError) as error:
            raise ClrtError(f"{path}: cannot be written: {_reason(target, error)}") from None
        yield temporary
        _sync(temporary)
        if old is not None:
            with suppress(OSError):  # of a drive without permissions
                os.chmod(temporary, old)
        os.replace(temporary, target)
        if told:
            note_saved(target)
        if os.name == "posix":
            with suppress(OSError):  # the file is there; its folder may not be read, or know nothing of this
                _sync(target.parent)
    except OSError as error:
        raise ClrtError(f"{path}: cannot be written: {error.strerror or error}") from None
    finally:
        with suppress(OSError, ValueError):  # it is not there any more, or never was
            temporary.unlink()
        temporaries.discard(temporary)


def write_text(path: str | os.PathLike[str], text: str) -> None:
    """Replace a file of text; what no file of text can hold is escaped. ClrtError as `replacing`."""
    with replacing(path) as temporary:
        temporary.write_text(legible(text), encoding="utf-8")


def write_json(path: str | os.PathLike[str], value: Any, indent: int = 1, finite: bool = False) -> None:
    """Replace a file of JSON: of built-in types, and numpy's numbers and arrays. ClrtError as `replacing`.

    finite: ValueError for NaN and infinity, which JSON does not have.
    """
    write_text(path, json.dumps(legible(value), indent=indent, allow_nan=not finite, default=_plain) + "\n")


def _plain(value: Any) -> Any:
    """A numpy number or array as JSON has it."""
    return value.tolist()


def check_replaceable(path: str | os.PathLike[str]) -> None:
    """Raise the ClrtError that `replacing(path)` would, without touching `path`."""
    try:
        with replacing(path):
            raise _Untouched
    except _Untouched:
        pass


def _target(path: str | os.PathLike[str]) -> Path:
    """The file to replace: what `path` is, or leads to."""
    if os.fspath(path).endswith(("/", os.sep)):
        raise ClrtError(f"{path}: is the name of a folder; give the name of a file to write")
    try:
        target = Path(os.path.realpath(path))
    except (OSError, ValueError) as error:  # the current folder was removed; a NUL inside
        raise ClrtError(f"{path}: cannot be written: {exhausted(error) or reason(error)}") from None
    try:
        status = target.lstat()
    except (FileNotFoundError, NotADirectoryError):
        return target
    except (OSError, ValueError) as error:  # too long, a NUL inside
        raise ClrtError(f"{path}: cannot be written: {reason(error)}") from None
    mode, read = status.st_mode, inputs.noted().get((status.st_dev, status.st_ino))
    if stat.S_ISDIR(mode):
        raise ClrtError(f"{path}: is a folder; give the name of a file in it")
    if stat.S_ISLNK(mode):  # `realpath` follows all links but these
        raise ClrtError(f"{path}: is a link that leads to itself; give the name of a file to write")
    if not stat.S_ISREG(mode):
        raise ClrtError(f"{path}: is {kind(mode)}, not a file; give the name of a file to write")
    if read is not None:
        raise ClrtError(f"{path}: is {read}, which is read; give the name of another file to write")
    return target


def _permissions(target: Path) -> int | None:
    """Who may read, write and run the file that is replaced; None where there is none."""
    try:
        return target.stat().st_mode & 0o777
    except (OSError, ValueError):
        return None


class _Untouched(Exception):
    """Leaves a `replacing` block before it replaces anything."""


def _reason(target: Path, error: Exception) -> str:
    if not target.parent.exists():
        return f"there is no folder {target.parent}; make it first"
    if not target.parent.is_dir():
        return f"{target.parent} is not a folder"
    return f"the folder {target.parent} refuses new files ({error})"


def _sync(path: Path) -> None:
    descriptor = os.open(path, os.O_RDONLY if path.is_dir() else os.O_RDWR)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)
