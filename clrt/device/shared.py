"""Arrays of the host that kernels read and write where they are: no copies, on devices that share its memory.

Other devices get copies of their own, and so does an array whose numbers do not start on whole words.
"""

from __future__ import annotations

import os
import threading
import time
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

_lock = threading.Lock()
_unfinished: list[Work] = []  # what was given up (Ctrl-C) while the device still reads and writes its arrays


def in_place(device: Device) -> bool:
    """Whether the device's memory is the host's. (Oclgrind takes what the host wrote for uninitialised.)"""
    return device.info.kind == "CPU" and "Oclgrind" not in device.info.platform


class Work:
    """Arrays that launches read and write; they are kept until the device is done."""

    def __init__(self, device: Device) -> None:
        with _lock:
            _unfinished[:] = [work for work in _unfinished if not work._done()]
        self._device = device
        self._given: list[Any] = []
        self._answers: list[tuple[Any, np.ndarray]] = []
        self._event: cl.Event | None = None

    def given(self, array: np.ndarray | None) -> Any:
        """A buffer of an array's values, C-contiguous, for kernels to read; None for None."""
        if array is None:
            return None
        if in_place(self._device) and array.flags.aligned and array.nbytes:
            made = self._share(_READ, array)
        else:
            made = self._device.upload(array)
        self._given.append(made)
        return made

    def answer(self, array: np.ndarray) -> Any:
        """A buffer for kernels to write all of an array, C-contiguous; `take` leaves it there."""
        if in_place(self._device) and array.nbytes:
            made = self._share(_WRITE, array)
        else:
            made = self._device.buffer(array.nbytes, element(array.dtype))
        self._answers.append((made, array))
        return made

    def take(self) -> None:
        """Wait for all launches of the track, and see in the arrays what they wrote."""
        device = self._device
        self._event = device.track.last
        try:
            _wait(device, self._event)
            if not in_place(device):
                for answer in [device.ask(made, array) for made, array in self._answers]:
                    answer.wait()
            elif not pocl_version(device.info):  # whose kernels write into the array, and nowhere else
                for made, array in self._answers:
                    self._see(made, array)
        except BaseException:
            with _lock:
                _unfinished.append(self)
            raise

    def _done(self) -> bool:
        return self._event is None or self._event.command_execution_status <= _DONE

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
