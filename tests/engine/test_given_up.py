"""A picture that is given up half-way: what its tracks still do is over before anything else begins."""

from __future__ import annotations

import time
from typing import Any

import pytest

import clrt
from clrt.device.device import Device
from clrt.device.opencl import cl

GLASS = {"diffuse": 0.1, "transmission": 0.8, "ior": 1.5}


def scene(lights: int, x: float) -> clrt.Scene:
    """Of media, so that kernels tell of lists that are too short."""
    return clrt.load_dict({
        "camera": {"origin": [0, 0, 8], "target": [0, 0, 0], "fov": 40, "width": 60, "height": 50},
        "max_depth": 3,
        "materials": {"glass": GLASS, "inner": {**GLASS, "ior": 1.2}, "grey": {}},
        "lights": [{"type": "point", "position": [3 + i, 4, 5]} for i in range(lights)],
        "shapes": [
            {"type": "sphere", "center": [x, 0, 0], "radius": 1, "material": "glass"},
            {"type": "sphere", "center": [x, 0, 0], "radius": 0.5, "material": "inner"},
            {"type": "plane", "point": [0, -1, 0], "normal": [0, 1, 0], "material": "grey"},
        ],
    })  # fmt: skip


class GivenUp(Exception):
    """What `progress` raises."""


@pytest.mark.parametrize("number", [0, 1])
def test_what_is_left_behind_comes_before_what_follows(number: int) -> None:
    """`progress` gives the picture up, and holds a track, on which there is more to do."""
    one, other = scene(1, 0), scene(3, 0.2)
    tracer = clrt.Tracer(one, settings=clrt.Settings(tile=1000))
    tracer.render()
    driver = tracer.device.driver
    gate = cl.UserEvent(driver.context)

    def give_up(*_: Any) -> None:
        track = tracer.device.on(number)
        cl.enqueue_barrier(track.queue, wait_for=[gate])
        raise GivenUp

    with pytest.raises(GivenUp):
        tracer.render(progress=give_up)
    later = [cl.enqueue_marker(track.queue) for track in driver.tracks]
    for track in driver.tracks:
        track.queue.flush()
    time.sleep(0.1)
    done = cl.command_execution_status.COMPLETE
    before = [event.command_execution_status == done for event in later]
    gate.set_status(done)
    assert before == [False, False]
    tracer.update(other)
    assert tracer.render().hash == clrt.render(other).hash, "nothing is read or told of the picture before"


def test_why_it_is_given_up_is_told_though_the_device_does_no_more(monkeypatch: pytest.MonkeyPatch) -> None:
    tracer = clrt.Tracer(scene(1, 0), settings=clrt.Settings(tile=1000))

    def gone(*_: Any, **__: Any) -> None:
        raise cl.RuntimeError("the device is lost")

    def lost(*_: Any, **__: Any) -> None:
        monkeypatch.setattr(cl, "enqueue_marker", gone)
        raise GivenUp

    monkeypatch.setattr(Device, "launch", lost)
    with pytest.raises(GivenUp):
        tracer.render()
