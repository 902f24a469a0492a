"""pyopencl, without the files that it keeps: `from clrt.device.opencl import cl`.

pyopencl writes pickles to the user's cache folder and loads them again: whoever can write there runs code
here, and a folder that is damaged, locked or missing stops the program. So clrt switches these caches off
for the process, which costs other users of pyopencl in it a few milliseconds a kernel, and keeps compiled
programs by itself: `clrt.device.binaries`.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from clrt.base import interrupts

_VARIABLE = "PYOPENCL_NO_CACHE"  # read once, when pyopencl is imported


@contextmanager
def _without_attrs() -> Iterator[None]:
    """Let pytools do without attrs, where that is not loaded yet: it takes 10 ms, for keys of those caches.

    In a program of another pytools may be asked for such keys.
    """
    modules: dict[str, Any] = sys.modules
    hidden = interrupts.running() and "attrs" not in modules
    if hidden:
        modules["attrs"] = None  # what is imported as this is not there
    try:
        yield
    finally:
        if hidden:
            del modules["attrs"]


if "pyopencl" in sys.modules:
    import pyopencl as cl

    cl._PYOPENCL_NO_CACHE = True  # as if the variable had been set: there is no public way
else:
    _given = os.environ.get(_VARIABLE)
    os.environ[_VARIABLE] = "1"
    try:
        with _without_attrs():
            import pyopencl as cl
    finally:
        if _given is None:
            del os.environ[_VARIABLE]
        else:
            os.environ[_VARIABLE] = _given

__all__ = ["cl"]
