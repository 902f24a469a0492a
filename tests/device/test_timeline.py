"""A trace holds every pass, copy and wait, where and when it was; and nothing is recorded unless asked."""

from __future__ import annotations

import json
import time
from collections import Counter
from itertools import pairwise
from pathlib import Path

import pytest

import clrt
from clrt.cli import main
from clrt.device import timeline
from clrt.device.device import Device
from clrt.device.opencl import cl
from clrt.device.timeline import Timeline, recording
from tests.cli.test_terminal import SCENE, fault


def test_every_pass_is_where_it_was() -> None:
    begin = time.perf_counter_ns()
    with recording() as found:
        tracer = clrt.Tracer("bubble", settings=clrt.Settings(tile=2000))
        launched: Counter[str] = Counter()
        for track in tracer.device.driver.tracks:
            track.launched = _counted(track.launched, launched)  # type: ignore[method-assign]
        image = tracer.render(width=64)
    end = time.perf_counter_ns()
    assert image.hash == clrt.render("bubble", width=64).hash
    passes = Counter(span.name for span in found.spans if span.kind == "pass")
    for name, count in launched.items():
        assert passes[name] == count, name  # those of the tree's builder came before the count began
    assert {span.row for span in found.spans if span.kind == "pass"} == {"track 0", "track 1"}
    assert {span.name for span in found.spans if span.kind == "copy"} >= {"upload", "read", "fill"}
    assert any(span.kind == "wait" and span.row.startswith("host, ") for span in found.spans)
    slack = 50_000_000  # ns: between the bounds of the two clocks, where the host was not running
    for span in found.spans:
        assert begin - slack <= span.queued <= span.begin <= span.end <= end + slack, span
    for row in {span.row for span in found.spans}:
        ordered = sorted((s for s in found.spans if s.row == row), key=lambda s: s.begin)
        for one, other in pairwise(ordered):
            assert other.begin >= one.end - 20_000, (one, other)  # a track does one thing after the other
    seconds = sum(span.end - span.begin for span in found.spans if span.kind == "pass") * 1e-9
    assert seconds >= 0.9 * sum(image.stats["seconds"].values())


def _counted(launched: object, counts: Counter[str]) -> object:
    def noted(name: str, event: object, timed: bool) -> None:
        counts[name] += 1
        launched(name, event, timed)  # type: ignore[operator]

    return noted


def test_nothing_is_recorded_unless_asked_for() -> None:
    assert timeline.current() is None and Device().driver.recorder is None
    with recording() as found:
        inner = Device()
        assert inner.driver.recorder is not None
    assert Device().driver.recorder is None and found.devices == [inner.info.label]


class Event:
    """Of a driver whose clock is some 7 us before the host's."""

    def __init__(self, queued: int) -> None:
        self.command_execution_status = cl.command_execution_status.COMPLETE
        info = cl.profiling_info
        self._times = {info.QUEUED: queued, info.START: queued + 500, info.END: queued + 700}

    def get_profiling_info(self, what: int) -> int:
        return self._times[what]


def test_the_document_is_what_viewers_read(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("clrt.device.timeline.MOST", 2)
    found = Timeline()
    recorder = found.opened("a device")
    for k in range(3):
        recorder.enqueued("pass", f"pass {k}", k % 2, Event(1000 * k), 7000 + 1000 * k, k)
    table = json.loads(json.dumps(found.document()))
    assert table["otherData"] == {"devices": ["a device"], "dropped": 1}
    names = {event["args"]["name"] for event in table["traceEvents"] if event["ph"] == "M"}
    assert names == {"a device", "track 0", "track 1"}
    one, two = (event for event in table["traceEvents"] if event["ph"] == "X")
    assert (one["ts"], one["dur"], one["tid"], two["tid"]) == (0.5, 0.2, 0, 1)
    assert two["args"] == {"queued_us": 0.5, "items": 1}
    assert Timeline().document()["traceEvents"] == []


def test_render_writes_a_trace(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    scene = tmp_path / "ball.toml"
    scene.write_text(SCENE.replace("0.9", "0.5"))
    picture, file = tmp_path / "a.png", tmp_path / "a.json"
    assert main(["render", str(scene), "-o", str(picture), "--trace", str(file), "--quiet"]) == 0
    events = json.loads(file.read_text())["traceEvents"]
    assert {event["cat"] for event in events if event["ph"] == "X"} == {"pass", "copy", "wait"}
    capsys.readouterr()
    other = tmp_path / "b.png"
    said = fault(capsys, "render", scene, "-o", other, "--trace", tmp_path / "none" / "a.json")
    assert "there is no folder" in said and not other.exists()
