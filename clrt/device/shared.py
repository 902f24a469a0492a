"""Arrays of the host that kernels read and write where they are: no copies, on devices that share its memory.

Other devices get copies of their own, and so does an array whose numbers do not start on whole words.
"""

from __future__ import annotations

import os
import time
import weakref
from collections import deque
from contextlib import suppress
from dataclasses import dataclass
from typing import Any, Final

import numpy as np

from clrt.device.device import Device
from clrt.device.opencl import cl
from clrt.device.platforms import pocl_version
from clrt.layout.parameters import element

_READ: Final = cl.mem_flags.READ_ONLY | cl.mem_flags.USE_HOST_PTR
_WRITE: Final = cl.mem_flags.WRITE_ONLY | cl.mem_flags.USE_HOST_PTR
_DONE: Final = cl.command_execution_status.COMPLETE
_MOMENT: Final = 2e-4  # seconds to look whether a launch is done before a thread waits, which takes 20 us
_yield = getattr(os, "sched_yield", lambda: time.sleep(0))


@dataclass(eq=False)
class _Left:
    """What was given up (Ctrl-C) while the device may use it, and an event that comes after all launches."""

    event: cl.Event | None  # None: the driver gives none
    kept: list[Any]


_unfinished: deque[_Left] = deque()


def in_place(device: Device) -> bool:
    """Whether the device's memory is the host's. (Oclgrind takes what the host wrote for uninitialised.)"""
    return device.info.kind == "CPU" and "Oclgrind" not in device.info.platform


class Work:
    """Arrays that launches read and write; wherever it is given up, they are kept while the device works."""

    def __init__(self, device: Device) -> None:
        for left in tuple(_unfinished):
            # before anything else: with two buffers of one array at work, one of which ends, Intel's crashes
            if left.event is None:
                continue
            if left.event.command_execution_status > _DONE:
                device.driver.wait(left.event.wait, "finish")
            with suppress(ValueError):  # another thread was sooner
                _unfinished.remove(left)
        self._device = device
        self._kept: list[Any] = []
        self._answers: list[tuple[Any, np.ndarray]] = []
        self._end = weakref.finalize(self, _give_up, device, self._kept)
        self._end.atexit = False

    def given(self, array: np.ndarray | None) -> Any:
        """A buffer of an array's values, C-contiguous, for kernels to read; None for None."""
        if array is None:
            return None
        if in_place(self._device) and array.flags.aligned and array.nbytes:
            made = self._share(_READ, array)
        else:
            made = self._device.upload(array)
        self._kept.append((made, array))
        return made

    def answer(self, array: np.ndarray) -> Any:
        """A buffer for kernels to write all of an array, C-contiguous; `take` leaves it there."""
        if in_place(self._device) and array.nbytes:
            made = self._share(_WRITE, array)
        else:
            made = self._device.buffer(array.nbytes, element(array.dtype))
        self._answers.append((made, array))
        self._kept.append((made, array))
        return made

    def take(self) -> None:
        """Wait for all launches of the track, and see in the arrays what they wrote."""
        device = self._device
        _wait(device, device.track.last)
        if not in_place(device):
            for answer in [device.ask(made, array) for made, array in self._answers]:
                answer.wait()
        elif not pocl_version(device.info):  # whose kernels write into the array, and nowhere else
            for made, array in self._answers:
                self._see(made, array)
        self._end.detach()

    def _see(self, made: Any, array: np.ndarray) -> None:
        """What was written into a buffer is in its array once it was mapped (OpenCL 1.2, 5.2.4)."""
        queue, driver = self._device.queue, self._device.driver
        if not array.nbytes:
            return
        flags = cl.map_flags.READ
        mapped, event = driver.guard(
            lambda: cl.enqueue_map_buffer(queue, made, flags, 0, array.shape, array.dtype, is_blocking=False),
            "map",
        )
        _wait(self._device, event)
        mapped.base.release(queue)

    def _share(self, flags: int, array: np.ndarray) -> Any:
        driver = self._device.driver
        made: Any = driver.guard(lambda: cl.Buffer(driver.context, flags, hostbuf=array), "an array")
        made.kind = element(array.dtype)
        return made


def _give_up(device: Device, kept: list[Any]) -> None:
    """Keep what launches that nobody waits for may still use. A launch need not be known to its track yet."""
    event = None
    with suppress(cl.Error):
        event = cl.enqueue_marker(device.queue)
        device.queue.flush()
    _unfinished.append(_Left(event, kept))


def _wait(device: Device, event: cl.Event | None) -> None:
    """A short launch is waited for here, a long one as `Driver.wait` does: Ctrl-C ends both waits at once."""
    if event is None:
        return
    device.flush()
    until = time.perf_counter() + _MOMENT
    while event.command_execution_status > _DONE and time.perf_counter() < until:
        _yield()
    if event.command_execution_status != _DONE:
        device.driver.wait(event.wait, "finish")
