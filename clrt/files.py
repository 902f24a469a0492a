"""Files that belong to a scene: found only inside its folder, written whole or not at all."""

from __future__ import annotations

import os
import stat
import tempfile
from contextlib import suppress
from pathlib import Path

from clrt.errors import SceneError, located
from clrt.limits import Limits
from clrt.records import At


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
        raise at.error(name, f"must be the path of a file: {error}") from None
    return path


def read_bytes(path: Path, limits: Limits) -> bytes:
    """The contents of a regular file no larger than `limits.file_bytes`."""
    try:
        status = path.stat()
        if not stat.S_ISREG(status.st_mode):  # a pipe or a device may never end
            raise SceneError(located(str(path), "", "is not a regular file"))
        limits.check("file_bytes", status.st_size, str(path))
        with path.open("rb") as file:
            data = file.read(limits.file_bytes + 1)
    except (OSError, ValueError) as error:
        raise SceneError(located(str(path), "", f"cannot be read: {_reason(error)}")) from None
    limits.check("file_bytes", len(data), str(path))
    return data


def write_bytes(path: Path, data: bytes) -> None:
    """Make `path` hold `data`: the old file stays as it was until the new one is complete on disk."""
    try:
        mode = stat.S_IMODE(path.stat().st_mode) if path.exists() else 0o666 & ~_umask()
        handle, temporary = tempfile.mkstemp(prefix=f".{path.name[:40]}.", dir=path.parent)
        try:
            with os.fdopen(handle, "wb") as file:
                file.write(data)
                file.flush()
                os.fchmod(file.fileno(), mode)
                os.fsync(file.fileno())
            os.replace(temporary, path)
        except BaseException:
            with suppress(OSError):
                os.unlink(temporary)
            raise
    except (OSError, ValueError) as error:
        raise SceneError(located(str(path), "", f"cannot be written: {_reason(error)}")) from None


def _reason(error: Exception) -> str:
    return error.strerror or str(error) if isinstance(error, OSError) else str(error)


def _umask() -> int:
    mask = os.umask(0)
    os.umask(mask)
    return mask
