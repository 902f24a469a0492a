"""What one input costs a process that has seen others: its memory at the peak, its processor time."""

from __future__ import annotations

import ctypes
import gc
import re
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

_STATUS = Path("/proc/self/status")
_CLEAR = Path("/proc/self/clear_refs")


@dataclass
class Cost:
    """Bytes above what the process held before, at the peak, and seconds of processor time."""

    bytes: int = 0
    seconds: float = 0.0


def peak_can_be_reset() -> bool:
    """Whether this system tells the peak of a part of a process' life (Linux does)."""
    return _CLEAR.exists() and _STATUS.exists()


@contextmanager
def measured(collect: bool = True) -> Iterator[Cost]:
    """The cost of a block. What earlier blocks left free is given back first, so that it counts anew."""
    cost = Cost()
    if collect:
        gc.collect()
    _give_back()
    if _CLEAR.exists():
        _CLEAR.write_text("5")  # the peak becomes what is held now
    held, start = _kilobytes("VmRSS"), time.process_time()
    try:
        yield cost
    finally:
        cost.seconds = time.process_time() - start
        cost.bytes = max(0, _kilobytes("VmHWM") - held) << 10


def _kilobytes(name: str) -> int:
    found = re.search(rf"{name}:\s*(\d+) kB", _STATUS.read_text()) if _STATUS.exists() else None
    return int(found.group(1)) if found else 0


def _give_back() -> None:
    """glibc keeps freed memory for the next request, which would then seem to cost nothing."""
    trim = getattr(ctypes.CDLL(None), "malloc_trim", None)
    if trim:
        trim(0)
