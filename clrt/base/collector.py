"""Python's collector of cycles, kept out of where millions of objects are made that form none."""

from __future__ import annotations

import gc
from collections.abc import Iterator
from contextlib import contextmanager


@contextmanager
def no_collections(paused: bool = True) -> Iterator[None]:
    """No collections meanwhile, where `paused`: each looks at all objects again, and frees none of them."""
    was_on = gc.isenabled()
    if paused:
        gc.disable()
    try:
        yield
    finally:
        if was_on:
            gc.enable()
