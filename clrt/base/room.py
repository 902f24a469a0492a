"""What the system allows this process, looked at before a library meets it and ends us.

It imports nothing heavy: numpy is such a library.
"""

from __future__ import annotations

import os
from typing import Final

from clrt.base.errors import ClrtError, LimitError, fault

DATE: Final = "SOURCE_DATE_EPOCH"
"""The variable with the date of files that are to be the same whenever they are made."""

_OPTIONS: Final = {"RLIMIT_AS": "-v", "RLIMIT_DATA": "-d"}
# limit -> bytes that the import of what every command needs takes of it, and for each core (OpenBLAS)
_ROOM: Final = {"RLIMIT_AS": (96 << 20, 32 << 20), "RLIMIT_DATA": (256 << 20, 64 << 20)}


def process_limit(name: str) -> float:
    """A limit of this process, such as "RLIMIT_AS"; infinity where there is none."""
    try:
        import resource

        limit = resource.getrlimit(getattr(resource, name))[0]
    except (ImportError, AttributeError):  # Windows has no such limits
        return float("inf")
    return limit if limit >= 0 else float("inf")


def check_addresses(least: int, what: str, name: str = "RLIMIT_AS") -> None:
    """LimitError where this process may have fewer than `least` bytes, which `what` needs.

    name: the limit that is meant, of all addresses or, RLIMIT_DATA, of those that can be written to.
    """
    limit = process_limit(name)
    if limit < least:
        told = f"ulimit {_OPTIONS[name]} {limit / 1024:.0f}"
        raise LimitError(f"{told}: {what} needs more; allow at least {least >> 10}")


def check_date() -> None:
    """ClrtError where the environment has a date that is none: scipy, trimesh and others fail on that."""
    date = os.environ.get(DATE, "")
    if date and not (date.isascii() and date.isdecimal() and len(date) <= 11):
        raise ClrtError(fault("", DATE, date, "it must be a whole number of seconds since 1970; unset it"))


def check_room() -> None:
    """ClrtError where the libraries that commands import would fail or end the process."""
    check_date()
    for name, (least, for_each_core) in _ROOM.items():
        check_addresses(least + for_each_core * (os.cpu_count() or 1), "clrt", name)
