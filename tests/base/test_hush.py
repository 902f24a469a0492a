"""What libraries write to standard error does not stand beside clrt's own line."""

from __future__ import annotations

import os
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
