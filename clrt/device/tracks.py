"""Tracks: command queues of a device, each with the memory that its launches use and the time they took.

Launches on a track run in order. Launches on different tracks may run at the same time, so a buffer that one
track has given up must not be handed out on another: each has a memory pool of its own.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from pyopencl import tools as cl_tools

from clrt.device.opencl import cl


@dataclass(frozen=True)
class Answer:
    """What a track is going to write into an array on the host."""

    array: np.ndarray
    event: cl.Event | None  # None: there is nothing to write
    wait_for: Callable[[Callable[[], Any], str], None]  # how the device waits

    @property
    def ready(self) -> bool:
        """Would `wait` return at once?"""
        done = cl.command_execution_status.COMPLETE
        return self.event is None or self.event.command_execution_status == done

    def wait(self) -> np.ndarray:
        """The array, filled."""
        if self.event is not None and not self.ready:
            self.wait_for(self.event.wait, "read")
        return self.array


_in_flight: list[cl.Event] = []


def kept(event: cl.Event) -> cl.Event:
    """Keep the event of a copy from or to the host, and with it the array, until it is done.

    pyopencl waits where such an event is given up too early: Ctrl-C would have to wait, too.
    """
    done = cl.command_execution_status.COMPLETE
    _in_flight[:] = [other for other in _in_flight if other.command_execution_status != done]
    _in_flight.append(event)
    return event


class Track:
    """A command queue, its memory pool, and its launches."""

    def __init__(self, context: cl.Context, device: cl.Device) -> None:
        # PoCL's context names the whole device where it was made for a part: the queue must say which
        self.queue = cl.CommandQueue(
            context, device, properties=cl.command_queue_properties.PROFILING_ENABLE
        )
        # queues are never twice as long: with finer sizes than two an octave, blocks that another queue has
        # left would seldom do, and memory would grow by fresh pages that no cache knows
        self.pool = cl_tools.MemoryPool(cl_tools.ImmediateAllocator(self.queue), leading_bits_in_bin_id=1)
        self.last: cl.Event | None = None  # the launch that is done last
        self._events: list[tuple[str, Any]] = []

    def launched(self, name: str, event: cl.Event, timed: bool) -> None:
        """Note a launch; `timed`: its time is taken. A driver keeps a launch as long as its event is kept."""
        self.last = event
        if timed:
            self._events.append((name, event))

    def take_launches(self) -> list[tuple[str, cl.Event]]:
        """The launches until now whose times nobody has taken; from now on there are none."""
        launches, self._events = self._events, []
        return launches

    def forget(self, launches: list[tuple[str, cl.Event]]) -> None:
        """Nobody will take the times of the launches until now, but those of `launches`."""
        self._events = launches

    def send(self, target: Any, array: np.ndarray) -> cl.Event:
        """Copy an array, which must not change until it is there, to a buffer; does not wait."""
        return kept(cl.enqueue_copy(self.queue, target, array, is_blocking=False))

    def take_spans(self) -> list[tuple[int, int, str]]:
        """Begin and end (ns) and name of each kernel launched since the last call; all must be done."""
        start, end = cl.profiling_info.START, cl.profiling_info.END  # asked by themselves in half of the time
        spans = [
            (event.get_profiling_info(start), event.get_profiling_info(end), name)
            for name, event in self._events
        ]
        self._events.clear()
        return spans


def seconds_by_name(spans: list[tuple[int, int, str]]) -> dict[str, float]:
    """Seconds of work by kernel; where two were at work at once, the time counts for the one begun first."""
    seconds: dict[str, float] = {}
    worked_until = 0
    for begin, end, name in sorted(spans):
        seconds[name] = seconds.get(name, 0.0) + max(0, end - max(begin, worked_until)) * 1e-9
        worked_until = max(worked_until, end)
    return seconds
