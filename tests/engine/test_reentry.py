"""A Tracer that is asked again while it answers: by `progress`, which may, and by a signal's handler."""

from __future__ import annotations

import signal

import pytest

import clrt
from clrt.device.tracks import Track
from tests.engine.test_queries import SCENE

LOOKED = {**SCENE, "camera": {"origin": [0, 1, 6], "target": [0, 0, 0], "width": 16, "height": 16}}
RAYS = [[0.0, 0.0, 4.0]], [[0.0, 0.0, -1.0]]
QUESTIONS = {
    "render": lambda tracer: tracer.render(8),
    "identity": lambda tracer: tracer.identity(8),
    "camera_rays": lambda tracer: tracer.camera_rays(),
    "explain": lambda tracer: tracer.explain(0, 0),
    "intersect": lambda tracer: tracer.intersect(*RAYS),
    "occluded": lambda tracer: tracer.occluded(*RAYS),
    "count_hits": lambda tracer: tracer.count_hits(*RAYS),
    "all_hits": lambda tracer: tracer.all_hits(*RAYS),
    "radiance": lambda tracer: tracer.radiance(*RAYS),
    "update": lambda tracer: tracer.update(LOOKED),
    "close": lambda tracer: tracer.close(),
}


@pytest.fixture
def tracer() -> clrt.Tracer:
    return clrt.Tracer(clrt.load_dict(LOOKED))


@pytest.mark.skipif(not hasattr(signal, "SIGUSR1"), reason="no such signal")
@pytest.mark.parametrize("name", QUESTIONS)
def test_a_signal_handler_cannot_use_the_tracer_that_it_interrupts(
    tracer: clrt.Tracer, monkeypatch: pytest.MonkeyPatch, name: str
) -> None:
    """Between a kernel's arguments and its launch its own would take their place; another Tracer is free."""
    other = clrt.Tracer(clrt.load_dict(LOOKED))
    expected, said = tracer.render(16).hash, []

    def handler(*_: object) -> None:
        QUESTIONS[name](other)
        with pytest.raises(clrt.ClrtError, match=r"this Tracer is in use .* one of its own") as caught:
            QUESTIONS[name](tracer)
        said.append(caught.value)

    def launched(*given: object) -> None:
        monkeypatch.undo()
        signal.raise_signal(signal.SIGUSR1)
        real(*given)  # type: ignore[arg-type]

    real, before = Track.launched, signal.signal(signal.SIGUSR1, handler)
    try:
        monkeypatch.setattr(Track, "launched", launched)
        assert tracer.render(16).hash == expected
        assert len(said) == 1
    finally:
        signal.signal(signal.SIGUSR1, before)


def test_progress_may_use_the_tracer_whatever_it_raises(tracer: clrt.Tracer) -> None:
    expected, inner = tracer.render(16).hash, []

    def progress(*_: int) -> None:
        if len(inner) < 2:
            inner.append("")
            inner[-1] = tracer.render(16, progress=progress).hash
        raise KeyError(len(inner))

    for _ in range(2):
        inner.clear()
        with pytest.raises(KeyError):
            tracer.render(16, progress=progress)
        assert tracer.render(16).hash == expected


def test_a_picture_within_a_picture_leaves_the_times_of_both(tracer: clrt.Tracer) -> None:
    inner: list[clrt.Image] = []

    def progress(*_: int) -> None:
        if not inner:
            inner.append(tracer.render(16))

    small = clrt.Tracer(clrt.load_dict(LOOKED), settings=clrt.Settings(tile=64))
    outer = small.render(16, progress=lambda *_: inner.append(small.render(16)) if not inner else None)
    usual = small.render(16).stats["seconds"].keys()
    assert outer.stats["seconds"].keys() == inner[0].stats["seconds"].keys() == usual
    inner.clear()
    assert tracer.render(16, progress=progress).stats["seconds"].keys() == usual
