"""What a start waits for the driver, done in a second thread while Python imports and reads the scene.

PoCL's compiler is loaded in some 30 ms, and reads a program that it compiled back in 80: without Python.
Nothing here fails or tells anything: what goes wrong is met again where the driver is asked in earnest.
"""

from __future__ import annotations

import ctypes
import threading
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, suppress
from importlib import import_module
from typing import TYPE_CHECKING

from clrt.base import handlers, interrupts
from clrt.base.collector import beginning
from clrt.base.elsewhere import own_stack, relative, within
from clrt.base.errors import ClrtError
from clrt.base.resources import PACKAGE
from clrt.device import harmful, kernelcache, trial, vendors

if TYPE_CHECKING:
    from clrt import layout
    from clrt.device.driver import Driver


@contextmanager
def loading() -> Iterator[None]:
    """Let the loader find its drivers while the block is run, which may only import.

    For it is run in a folder of ours: drivers look into the current one. Not within a program of another, not
    where the user wants drivers from the current folder, nor where they may end the process, which is tried
    first (`clrt.device.trial`).
    """
    if not interrupts.running() or relative(*vendors.PLACES) or trial.circumstances():
        with beginning():
            yield
        return
    known = False
    with suppress(ClrtError, OSError):
        kernelcache.prepare()  # PoCL looks at its folder once, now
        known = harmful.is_known()
    if not known:
        with beginning():
            yield
        return
    with beginning():
        import_module("clrt.device.opencl")  # a loader in pyopencl's wheels ends a process that has not
        with within(PACKAGE), _beside(_load):
            yield


def _load() -> None:
    """Ask pyopencl's loader how many platforms there are; `ctypes` lets Python go on meanwhile."""
    from pyopencl import _cl

    with handlers.kept():
        ctypes.CDLL(_cl.__file__).clGetPlatformIDs(0, None, ctypes.byref(ctypes.c_uint()))


@contextmanager
def building(driver: Driver, ray_format: layout.RayFormat, needed: Mapping[str, bool]) -> Iterator[None]:
    """Let a program that was compiled before be read back while the block is run.

    Where it was not, a process beside this one will compile some of the kernels that are `needed`
    (`clrt.device.beside`), once there is the program.
    """

    def build() -> None:
        kernels = driver.kernels(ray_format)
        if driver.is_compiled(kernels.source):
            _ = kernels.program
        else:
            kernels.needed = needed

    with beginning(), _beside(build):
        yield


@contextmanager
def _beside(action: Callable[[], None]) -> Iterator[None]:
    """Do something in a second thread while the block is run; both are done when it ends."""

    def surely() -> None:
        with suppress(Exception):  # see above
            action()

    thread = threading.Thread(target=surely, name="clrt-ahead", daemon=True)
    try:
        with own_stack():
            thread.start()
    except RuntimeError:  # there is no room for another thread
        yield
        return
    try:
        yield
    finally:
        thread.join()
