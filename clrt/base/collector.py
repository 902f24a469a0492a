"""Python's collector of cycles, kept out of where millions of objects are made that form none."""

from __future__ import annotations

import gc
from collections.abc import Iterator
from contextlib import contextmanager

from clrt.base import interrupts


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


@contextmanager
def beginning() -> Iterator[None]:
    """No collections while a command imports what it needs, and none of what it then has: it all stays.

    In a program of another what is made until now is none of our business.
    """
    with no_collections(interrupts.running()):
        yield
        if interrupts.running():
            gc.freeze()
