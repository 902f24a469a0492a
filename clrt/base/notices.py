"""Warnings as users meet them: at the line of their own that caused them, once each, and not without end."""

from __future__ import annotations

import os
import sys
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from typing import Final

from clrt.base.errors import ClrtWarning, located

MOST: Final = 20
"""Warnings that reading one scene gives; how many more there were is said, too."""

_PACKAGE: Final = os.path.dirname(os.path.dirname(os.path.abspath(__file__))) + os.sep
_told: ContextVar[_Told | None] = ContextVar("clrt_told", default=None)
_unsaid: ContextVar[tuple[str, ...]] = ContextVar("clrt_unsaid", default=())


def warn(source: str, place: str, text: str) -> None:
    """Give the `ClrtWarning` 'source: place: text'; within `bounded` only if it is new, and not too many."""
    if any(part in text for part in _unsaid.get()):
        return
    message, told = located(source, place, text.removeprefix(f"{source}: ")), _told.get()
    if told is not None and not told.passes(message):
        return
    warnings.warn(message, ClrtWarning, stacklevel=_outside())


@contextmanager
def bounded(source: str) -> Iterator[None]:
    """Let only the first `MOST` warnings within the block pass, each once; at its end say how many more."""
    if _told.get() is not None:
        yield
        return
    told = _Told()
    token = _told.set(told)
    try:
        yield
    finally:
        _told.reset(token)
        if told.more:
            warn(source, "", f"{told.more} more warnings like these")


@contextmanager
def without(part: str) -> Iterator[None]:
    """Give no warnings within the block that say `part`."""
    token = _unsaid.set((*_unsaid.get(), part))
    try:
        yield
    finally:
        _unsaid.reset(token)


class _Told:
    """The first warnings, and how many there were beyond them, which are not kept."""

    def __init__(self) -> None:
        self.first: set[str] = set()
        self.more = 0

    def passes(self, message: str) -> bool:
        """Whether a warning is new, and among the first."""
        if message in self.first:
            return False
        if len(self.first) == MOST:
            self.more += 1
            return False
        self.first.add(message)
        return True


def _outside() -> int:
    """The `stacklevel` in `warn` of the first caller that is not the package's."""
    level, frame = 1, sys._getframe(1)
    while frame.f_back is not None and _own(frame.f_code.co_filename):
        level, frame = level + 1, frame.f_back
    return level


def _own(file: str) -> bool:
    # contextlib's frames stand between a block of ours and what leaves it, numpy's around a function that
    # np.errstate decorates; <frozen runpy> runs our scripts
    between = ("contextlib.py", "_ufunc_config.py")
    return file.startswith((_PACKAGE, "<frozen")) or os.path.basename(file) in between
