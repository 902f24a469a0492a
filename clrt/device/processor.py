"""What processor this is, as far as compiled programs depend on it."""

from __future__ import annotations

import hashlib
import platform
from functools import cache
from pathlib import Path

_PARTS = ("vendor_id", "cpu family", "model", "stepping", "flags")


@cache
def signature() -> str:
    """The same text on processors that run the same programs."""
    try:
        first = Path("/proc/cpuinfo").read_text(encoding="utf-8", errors="replace").split("\n\n")[0]
    except OSError:
        first = ""
    facts = [line for line in first.splitlines() if line.split(":")[0].strip() in _PARTS]
    text = "\n".join([platform.machine(), platform.processor(), *facts])
    return hashlib.sha256(text.encode()).hexdigest()[:16]
