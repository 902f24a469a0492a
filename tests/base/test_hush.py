"""What libraries write to standard error does not stand beside clrt's own line."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from clrt.base import hush

PROGRAM = """
import os, sys
from clrt.base import hush, interrupts
if sys.argv[1] != "imported":
    hush.take()
    assert interrupts.errors_to != 2
def complain(text):
    os.write(2, text.encode() + b"\\n")
complain("before")
with hush.hushed():
    complain("library")
    print("own", file=sys.stderr)
    with hush.hushed():
        complain("within")
    complain("library again")
complain("after")
if sys.argv[1] == "end":
    hush.for_good()
    complain("at the end")
"""


@pytest.mark.parametrize(
    ("how", "debug", "lines"),
    [
        ("taken", "", "before own after"),
        ("end", "", "before own after"),
        ("imported", "", "before library own within library again after"),
        ("taken", "1", None),
    ],
)
def test_libraries_are_silent_where_clrt_is_the_program(how: str, debug: str, lines: str | None) -> None:
    environment = {**os.environ, "POCL_DEBUG": debug}
    done = subprocess.run(
        [sys.executable, "-c", PROGRAM, how], env=environment, capture_output=True, text=True, check=False
    )
    if lines is None:  # who debugs a driver reads what it writes
        assert done.returncode == 1 and "AssertionError" in done.stderr
    else:
        assert (done.returncode, " ".join(done.stderr.split())) == (0, lines)


def test_without_a_descriptor_left_it_stays_as_it_is(monkeypatch: pytest.MonkeyPatch) -> None:
    def none(*_: object) -> int:
        raise OSError

    monkeypatch.setattr(hush.os, "dup", none)
    before = sys.stderr
    hush.take()
    assert sys.stderr is before and not hush._own
    monkeypatch.setattr(hush.os, "open", none)
    assert hush._nowhere() == -1


def test_a_spoiled_png_is_one_line(tmp_path: Path) -> None:
    import numpy as np

    from clrt import Image

    picture = tmp_path / "a.png"
    Image(np.random.default_rng(1).random((8, 8, 3), np.float32)).save(picture)
    data = bytearray(picture.read_bytes())
    place = data.index(b"IDAT")
    data[place : place + 4] = b"\0\0\0M"
    picture.write_bytes(data)
    done = subprocess.run(
        [sys.executable, "-m", "clrt", "compare", str(picture), str(picture)],
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode == 2 and done.stderr.count("\n") == 1, done.stderr
    assert done.stderr.startswith("clrt: error: ") and done.stderr.isascii()


@pytest.mark.skipif(not hasattr(signal, "SIGUSR1"), reason="no such signal")
def test_a_signal_handler_may_be_hushed_where_it_interrupts_that() -> None:
    code = """
import os, signal
from clrt.base import hush
def handler(*_):
    hush.os.dup2 = real
    with hush.hushed():
        os.write(2, b"within ")
signal.signal(signal.SIGUSR1, handler)
real = os.dup2
def interrupted(*given):
    signal.raise_signal(signal.SIGUSR1)
    real(*given)
hush.take()
signal.alarm(20)  # where it waits for itself
for _ in range(2):
    hush.os.dup2 = interrupted
    with hush.hushed():
        os.write(2, b"block ")
        hush.os.dup2 = interrupted
    os.write(2, b"after ")
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (0, "after after ")


@pytest.mark.skipif(not hasattr(os, "fork"), reason="no processes are forked")
def test_a_forked_child_has_neither_lock_nor_blocks_of_other_threads() -> None:
    code = """
import os, sys, signal, threading
from clrt.base import hush
hush.take()
inside, done = threading.Event(), threading.Event()
def other():
    with hush.hushed(), hush._lock:
        inside.set()
        done.wait(60)
thread = threading.Thread(target=other)
thread.start()
inside.wait(60)
for outer in (False, True):
    if outer:
        done.set()
        thread.join()
        hush._enter()
    child = os.fork()
    if not child:
        signal.alarm(20)  # where it waits for the lock
        with hush.hushed():
            os.write(2, b"within ")
        os.write(2, b"after ")
        os._exit(0)
    assert os.waitpid(child, 0)[1] == 0
"""
    program = [sys.executable, "-W", "ignore", "-c", code]
    done = subprocess.run(program, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (0, "after ")
