"""Queries that Ctrl-C breaks off leave kernels at work: what these use is kept, the next query is right."""

from __future__ import annotations

import gc
import signal
import subprocess
import sys

import numpy as np
import pytest

import clrt
from clrt.device import shared
from clrt.engine.answers import FIELDS
from tests.engine.test_queries import SCENE, rays, same


@pytest.fixture
def tracer() -> clrt.Tracer:
    return clrt.Tracer(clrt.load_dict(SCENE))


def _given_up(tracer: clrt.Tracer, o: np.ndarray, d: np.ndarray) -> None:
    with pytest.raises(KeyboardInterrupt):
        tracer.intersect(o, d)
    gc.collect()


@pytest.mark.parametrize("place", ["clrt.device.shared._wait", "clrt.device.tracks.Track.launched"])
def test_what_is_given_up_keeps_its_arrays_until_the_device_is_done(
    tracer: clrt.Tracer, monkeypatch: pytest.MonkeyPatch, place: str
) -> None:
    """Ctrl-C leaves the kernel at work, on memory that nobody else may have meanwhile: also where it comes
    when a kernel has just been launched.
    """

    def interrupted(*_: object) -> None:
        raise KeyboardInterrupt

    o, d = rays(5000)
    expected = tracer.intersect(o, d)
    with monkeypatch.context() as patched:
        patched.setattr(place, interrupted)
        _given_up(tracer, o, d)
    assert len(shared._unfinished) == 1
    kept = shared._unfinished[0].kept
    assert len(kept) == 2 + len(FIELDS)  # origins, directions, answers
    assert same(tracer.intersect(o, d), expected)  # the track's launches are done in order
    assert kept[2][1].tobytes() == expected.t.tobytes()
    assert not shared._unfinished


INTERRUPTED = """
import random, signal
import numpy as np
import clrt
tracer = clrt.Tracer("showcase")
view = clrt.Camera(origin=[0, 2, 9], target=[0, 1, 0], width=512, height=256)
rays = [array.reshape(-1, 3) for array in tracer.camera_rays(view)]
expected = tracer.intersect(*rays).t
signal.signal(signal.SIGALRM, signal.default_int_handler)
chance, count = random.Random(1), 0
for _ in range(150):
    try:
        signal.setitimer(signal.ITIMER_REAL, chance.uniform(1e-6, 0.008))
        tracer.intersect(*rays)
        signal.setitimer(signal.ITIMER_REAL, 0)
    except KeyboardInterrupt:
        count += 1
    others = np.ones(1 << 19, np.float32)
    assert others.all() and (others == 1).all()
signal.setitimer(signal.ITIMER_REAL, 0)
assert np.array_equal(tracer.intersect(*rays).t, expected)
print(count)
"""


@pytest.mark.skipif(not hasattr(signal, "setitimer"), reason="Windows has no timers that signal")
def test_interrupts_at_any_time() -> None:
    """One call after the other is broken off: where arrays are not kept, Intel's runtime ends the process."""
    done = subprocess.run([sys.executable, "-c", INTERRUPTED], capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stderr[-2000:]
    assert int(done.stdout) > 20
