"""What was sent to a device is there for all tracks: drivers may write after a blocking copy returned."""

from __future__ import annotations

import numpy as np
import pytest

from clrt.device import tracks
from clrt.device.device import Device
from clrt.device.opencl import cl


def test_an_upload_is_done_when_it_returns(monkeypatch: pytest.MonkeyPatch) -> None:
    """Intel's runtime has done nothing yet when most of its blocking copies of a few bytes return."""
    events: list[cl.Event] = []

    def noted(*arguments: object, **how: object) -> cl.Event:
        events.append(cl.enqueue_copy(*arguments, **how))  # type: ignore[call-overload]
        return events[-1]

    monkeypatch.setattr(tracks, "cl", _With(noted))
    monkeypatch.setattr("clrt.device.device.cl", _With(noted))
    device, done = Device(), cl.command_execution_status.COMPLETE
    for number in range(200):
        device.upload(np.full(12, number, np.int32))
        assert events[-1].command_execution_status == done, number
    assert len(events) == 200


class _With:
    """pyopencl with another `enqueue_copy`."""

    def __init__(self, enqueue_copy: object) -> None:
        self.enqueue_copy = enqueue_copy

    def __getattr__(self, name: str) -> object:
        return getattr(cl, name)
