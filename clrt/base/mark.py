"""The mark of UTF-8 that editors put before texts: no part of what they say, in any format."""

from __future__ import annotations

from codecs import BOM_UTF8
from typing import TypeVar

T = TypeVar("T", bytes, memoryview)


def unmarked(data: T) -> T:
    """A text without the byte order mark that it may begin with; one without it is not copied."""
    return data[len(BOM_UTF8) :] if data[: len(BOM_UTF8)] == BOM_UTF8 else data
