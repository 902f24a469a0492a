"""Kernels of the user's own: the folder that CLRT_KERNELS names takes the place of the one that ships.

For those who learn from the kernels or change them. It is said whenever they are used, and pictures carry
their hash (`metadata["kernel_hash"]`). Programs are known by their source, so no cache takes one for another.
"""

from __future__ import annotations

import hashlib
import os
from pathlib import Path
from typing import Final

from clrt import layout
from clrt.base import notices
from clrt.base.errors import ClrtError, show
from clrt.base.files import read_bytes
from clrt.base.limits import Limits
from clrt.base.resources import kernel_folder, kernel_text
from clrt.device.source import KERNEL_FILES, kernel_source
from clrt.version import __version__

VARIABLE: Final = "CLRT_KERNELS"
_MOST: Final = 1 << 20  # bytes of a file of kernels: ours have 16 kB at most


def folder() -> Path | None:
    """The folder that CLRT_KERNELS names, with a warning; None where it names none, or that of clrt itself.

    ClrtError where it is no folder of kernels.
    """
    named = _named()
    if named is not None:
        where = os.path.abspath(named)
        notices.warn("", VARIABLE, f"the kernels in {where} are used, not those of clrt {__version__}")
    return named


def source(ray_format: layout.RayFormat) -> str:
    """The program's source as this process takes it, of packets as wide as can be; nothing is said."""
    named = _named()
    return kernel_source(ray_format, folder=named, read=kernel_text if named is None else text)


def source_hash(ray_format: layout.RayFormat) -> str:
    """SHA-256 (hexadecimal) of `source`."""
    return hashlib.sha256(source(ray_format).encode()).hexdigest()


def _named() -> Path | None:
    given = os.environ.get(VARIABLE)
    if not given:
        return None
    named = Path(given)
    missing = [name for name in KERNEL_FILES if not os.path.isfile(named / name)]
    if missing:
        what = f"it must be a folder with all kernels, as {kernel_folder()} is; else: unset {VARIABLE}"
        where = "" if named.is_absolute() else f" in {os.getcwd()}"
        raise ClrtError(f"{VARIABLE}: {show(given)}{where} has no {missing[0]}; {what}")
    if os.path.samefile(named, kernel_folder()):
        return None
    return named


def text(file: Path) -> str:
    """The text of a file of kernels. ClrtError where it is none, without waiting for a pipe."""
    try:
        return read_bytes(file, Limits(file_bytes=_MOST)).decode()
    except UnicodeDecodeError as error:
        raise ClrtError(f"{file}: is not text in UTF-8 (byte {error.start})") from None
