"""Files that belong to a scene: found only inside its folder, read only up to a limit."""

from __future__ import annotations

import stat
from pathlib import Path

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


def read_text_bytes(path: Path, limits: Limits) -> bytes:
    """The contents of a scene file of text, no larger than `limits.text_bytes` either."""
    return read_bytes(path, limits, "file_bytes", "text_bytes")


def read_bytes(path: Path, limits: Limits, *names: str) -> bytes:
    """The contents of a regular file within each of the `names` of `limits`; none: `file_bytes`."""
    names = names or ("file_bytes",)
    try:
        status = path.stat()
        if not stat.S_ISREG(status.st_mode):  # a pipe or a device may never end
            raise SceneError(located(str(path), "", "is not a regular file"))
        for name in names:
            limits.check(name, status.st_size, str(path))
        with path.open("rb") as file:
            data = file.read(min(getattr(limits, name) for name in names) + 1)
    except (OSError, ValueError) as error:
        raise SceneError(located(str(path), "", f"cannot be read: {_reason(error)}")) from None
    for name in names:  # it may have grown
        limits.check(name, len(data), str(path))
    return data


def _reason(error: Exception) -> str:
    return error.strerror or str(error) if isinstance(error, OSError) else str(error)
