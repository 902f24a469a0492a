"""Files that belong to a scene: found only inside its folder, read only up to a limit."""

from __future__ import annotations

import os
import stat
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import BinaryIO

from clrt.errors import SceneError, located
from clrt.limits import Limits
from clrt.places import At


def resolve(name: str, folder: Path | None, at: At) -> Path:
    """The existing regular file called `name` inside `folder` (None: the current folder)."""
    root = (folder or Path()).resolve()
    try:
        path = (root / name).resolve()
        if not path.is_relative_to(root):
            raise at.error(name, f"a file must lie in the scene's folder, {root}")
        if not path.is_file():
            raise at.error(name, f"there is no such file in {root}")
    except (OSError, ValueError, RuntimeError) as error:  # too long, a NUL inside, a loop of links
        raise at.error(name, f"must be the path of a file: {_reason(error)}") from None
    return path


@contextmanager
def opened(path: str | os.PathLike[str], limits: Limits) -> Iterator[BinaryIO]:
    """A regular file no larger than `limits.file_bytes`, open for reading."""
    try:
        status = os.stat(path)
        if not stat.S_ISREG(status.st_mode):  # a pipe or a device may never end
            raise SceneError(located(str(path), "", "is not a regular file"))
        limits.check("file_bytes", status.st_size, str(path))
        with open(path, "rb") as file:
            yield file
    except (OSError, ValueError) as error:
        raise SceneError(located(str(path), "", f"cannot be read: {_reason(error)}")) from None


def read_bytes(path: Path, limits: Limits) -> bytes:
    """The contents of a regular file no larger than `limits.file_bytes`."""
    with opened(path, limits) as file:
        data = file.read(limits.file_bytes + 1)
    limits.check("file_bytes", len(data), str(path))
    return data


def _reason(error: Exception) -> str:
    return error.strerror or str(error) if isinstance(error, OSError) else str(error)
