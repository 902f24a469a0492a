"""Every launch of a kernel with what it was given and what it left, from one right stage to the next."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Any
from unittest import mock

import numpy as np

from clrt.device.device import Device
from clrt.device.opencl import cl
from clrt.device.tracks import Answer
from clrt.engine.stage import Stage
from clrt.layout import ceilings, parameters


@dataclass(frozen=True)
class Launch:
    """One launch: arrays of words (uint32) before and after stand for buffers, numbers for numbers."""

    kernel: str
    source: str
    options: str  # of the build, as the driver tells them
    items: int  # in whole work-groups
    local: int | None  # None: the driver's choice
    names: tuple[str, ...]  # of the kernel's parameters
    arguments: tuple[Any, ...]  # as they were given
    before: tuple[Any, ...]
    after: tuple[Any, ...]


@dataclass
class Log:
    """The launches since `forget`; the pass that was looked at last."""

    launches: list[Launch] = field(default_factory=list)

    def forget(self, stage: Stage) -> None:
        """An observer: all that was launched so far has given the right values."""
        self.launches.clear()


@contextmanager
def watching() -> Iterator[Log]:
    """Log the launches of all devices of this process. Slow: every buffer is read twice a launch."""
    log, launch = Log(), Device.launch

    def logged(device: Device, name: str, items: int, *arguments: Any, local_size: int | None = None) -> None:
        if not items:
            return
        before = _contents(device, arguments)
        launch(device, name, items, *arguments, local_size=local_size)
        local = min(local_size or max(1, ceilings.PRIVATE // (4 * device.bands)), device.kernels.groups[name])
        options = options_of(device, device.kernels.program)
        names = tuple(parameter for parameter, _ in parameters.signatures(device.kernels.source)[name])
        log.launches.append(Launch(
            name, device.kernels.source, options, -(-items // local) * local, local, names, arguments, before,
            _contents(device, arguments),
        ))  # fmt: skip

    with mock.patch.object(Device, "launch", logged):
        yield log


def options_of(device: Device, program: Any) -> str:
    """How a program was built, as the driver tells it, without the folder that pyopencl adds."""
    text = str(program.get_build_info(device.driver.device, cl.program_build_info.OPTIONS))
    return " ".join(re.sub(r"-I\s+('[^']*'|\S+)", "", text).split())


def _contents(device: Device, arguments: tuple[Any, ...]) -> tuple[Any, ...]:
    return tuple(words_of(device, argument) for argument in arguments)


def words_of(device: Device, argument: Any) -> Any:
    """A copy of a buffer as uint32, up to a number of bytes that 4 divides; what is no buffer, as it is."""
    if not isinstance(argument, cl.MemoryObjectHolder):
        return argument
    return device.read(argument, np.empty(argument.size // 4, np.uint32))


def places(buffers: list[Any], read: Callable[[], np.ndarray]) -> Iterator[tuple[int, np.ndarray]]:
    """For each buffer what `read` gives where that one holds, in place of its words, their numbers.

    So it is seen which word of which buffer each value was made from, whatever the layout of a queue.
    """
    ask = Device.ask
    for number, buffer in enumerate(buffers):

        def numbered(asked: Device, source: Any, array: np.ndarray, buffer: Any = buffer) -> Answer:
            if source is not buffer or array.dtype.itemsize != 4:
                return ask(asked, source, array)
            array.reshape(-1).view(np.uint32)[:] = np.arange(array.size, dtype=np.uint32)
            return Answer(array, None, asked.driver.wait)

        with mock.patch.object(Device, "ask", numbered):
            try:
                found = read()
            except (IndexError, ValueError):  # numbers in place of what says where other values stand
                continue
        yield number, found
