"""OpenImageIO, loaded when it is first used: checks that a picture can be saved need not wait for it.

`from clrt.images import library as oiio` stands for `import OpenImageIO as oiio`. It works in the thread
that calls it: its own threads, and OpenEXR's, are not there in a process that was forked, where it waits for
them, at the latest when that process ends.
"""

from __future__ import annotations

from functools import cache
from importlib import import_module
from typing import Any


def __getattr__(name: str) -> Any:
    return getattr(_loaded(), name)


@cache
def _loaded() -> Any:
    library = import_module("OpenImageIO")
    library.attribute("exr_threads", -1)  # 0 would be as many as there are processors
    library.attribute("threads", 1)
    library.attribute("try_all_readers", 1)  # files have no suffix here: without this none is read
    return library
