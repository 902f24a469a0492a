"""When each pass, copy and wait began and ended, for viewers of traces: Chrome's, Perfetto.

The format is Chrome's "Trace Event Format", which https://ui.perfetto.dev reads, too. Passes and copies are
on their track's row, by the driver's own clock, which is brought to the host's: a command was queued between
two looks at the host's. Waits are the host's, on a row for each of its threads. Nobody records unless asked;
drivers that were opened before then are not seen.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from typing import Any, Final

from clrt.device.opencl import cl

MOST: Final = 1_000_000  # spans of a trace: viewers hold no more
now = time.perf_counter_ns


@dataclass(frozen=True)
class Span:
    """kind: "pass", "copy" or "wait". queued, begin, end: ns of one clock. items: a pass's work-items."""

    kind: str
    name: str
    device: int
    row: str
    queued: int
    begin: int
    end: int
    items: int = 0


class Timeline:
    """What was recorded. devices: the labels of the drivers; dropped: spans beyond MOST."""

    def __init__(self) -> None:
        self.devices: list[str] = []
        self.dropped = 0
        self._recorders: list[Recorder] = []
        self._count = 0

    def opened(self, label: str) -> Recorder:
        """A recorder for a driver."""
        self.devices.append(label)
        self._recorders.append(Recorder(self, len(self.devices) - 1))
        return self._recorders[-1]

    def has_room(self) -> bool:
        """Count one span more; False where there are enough."""
        self._count += 1
        self.dropped += self._count > MOST
        return self._count <= MOST

    @property
    def spans(self) -> list[Span]:
        """All of them, by the host's clock."""
        return [span for recorder in self._recorders for span in recorder.spans()]

    def document(self) -> dict[str, Any]:
        """As trace viewers read it; times in microseconds from the first."""
        spans = sorted(self.spans, key=lambda span: span.begin)
        start = min((span.queued for span in spans), default=0)
        rows = sorted({(span.device, span.row) for span in spans})
        events: list[dict[str, Any]] = [
            {"ph": "M", "name": "process_name", "pid": number, "args": {"name": label}}
            for number, label in enumerate(self.devices)
        ]
        for number, (device, row) in enumerate(rows):
            events.append(
                {"ph": "M", "name": "thread_name", "pid": device, "tid": number, "args": {"name": row}}
            )
        for span in spans:
            more: dict[str, Any] = {"queued_us": (span.begin - span.queued) / 1e3}
            if span.items:
                more["items"] = span.items
            events.append({
                "ph": "X", "name": span.name, "cat": span.kind, "pid": span.device,
                "tid": rows.index((span.device, span.row)), "ts": (span.begin - start) / 1e3,
                "dur": (span.end - span.begin) / 1e3, "args": more,
            })  # fmt: skip
        other = {"devices": self.devices, "dropped": self.dropped}
        return {"displayTimeUnit": "ms", "otherData": other, "traceEvents": events}


class Recorder:
    """What a driver tells of its commands and waits."""

    def __init__(self, timeline: Timeline, device: int) -> None:
        self._timeline, self._device = timeline, device
        self._pending: list[tuple[str, str, int, int, Any, int, int]] = []
        self._commands: list[Span] = []  # by the driver's clock
        self._waits: list[Span] = []
        self._least, self._most = -(1 << 62), 1 << 62  # bounds of the host's clock minus the driver's

    def enqueued(
        self, kind: str, name: str, track: int, event: cl.Event, before: int, items: int = 0
    ) -> None:
        """A command that was given to the driver since `before`."""
        if self._timeline.has_room():
            self._pending.append((kind, name, track, items, event, before, now()))

    def waited(self, name: str, begin: int) -> None:
        """The host has waited since `begin`."""
        row = f"host, {threading.current_thread().name}"
        if self._timeline.has_room():
            self._waits.append(Span("wait", f"wait: {name}", self._device, row, begin, begin, now()))

    def settle(self) -> None:
        """Read the times of what is done. To be called when a track is."""
        info, done = cl.profiling_info, cl.command_execution_status.COMPLETE
        waiting, self._pending = self._pending, []
        for entry in waiting:
            kind, name, track, items, event, before, after = entry
            if event.command_execution_status != done:
                self._pending.append(entry)
                continue
            try:
                times = (info.QUEUED, info.START, info.END)
                queued, begin, end = (event.get_profiling_info(what) for what in times)
            except cl.Error:  # a driver need not time copies
                continue
            self._least, self._most = max(self._least, before - queued), min(self._most, after - queued)
            row = f"track {track}"
            self._commands.append(Span(kind, name, self._device, row, queued, begin, max(begin, end), items))

    def spans(self) -> list[Span]:
        """All that is done, by the host's clock."""
        self.settle()
        shift = (self._least + self._most) // 2
        moved = [
            replace(span, queued=span.queued + shift, begin=span.begin + shift, end=span.end + shift)
            for span in self._commands
        ]
        return self._waits + moved


_recording: list[Timeline] = []


def current() -> Timeline | None:
    """The one that drivers which are opened now tell."""
    return _recording[-1] if _recording else None


@contextmanager
def recording() -> Iterator[Timeline]:
    """Within the block, drivers that are opened are recorded."""
    timeline = Timeline()
    _recording.append(timeline)
    try:
        yield timeline
    finally:
        _recording.remove(timeline)
