"""Ctrl-C: how soon a command that renders has ended, with which exit code, line and files.

A heavy scene is rendered by `clrt render` on as many cores as there are; SIGINT is sent at a random time
after the first tile, when hardly anything has to be compiled any more.
"""

from __future__ import annotations

import random
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Final

from .figures import Figure, Tell, listed

SOON: Final = 0.5  # seconds
_SCENES: Final = ("ambient", "sphereflake", "showcase", "thesis_4_3_transmission")
_LONGEST: Final = 1.0  # seconds until the signal


def run(count: int, tell: Tell) -> Figure:
    """Interrupt renders at random times."""
    start, longest = time.perf_counter(), 0.0
    found: list[str] = []
    for number in range(count):
        scene = _SCENES[number % len(_SCENES)]
        seconds, wrong = interrupt(scene, random.Random(number).uniform(0, _LONGEST))
        longest = max(seconds, longest)
        if wrong or seconds > SOON:
            found.append(f"round {number}, {scene}: {seconds:.2f} s {wrong}".strip())
        tell((number + 1) / count)
    detail = f"{', '.join(_SCENES)}: at most {longest:.2f} s from the signal to the end of the process"
    return Figure(count, len(found), detail + listed(found), time.perf_counter() - start)


def interrupt(scene: str, after: float) -> tuple[float, str]:
    """Seconds from the signal to the end of the process, and what was wrong ('' if nothing)."""
    with tempfile.TemporaryDirectory(prefix="clrt-interrupts-") as folder:
        command = [sys.executable, "-m", __name__, scene]
        command += ["-o", f"{folder}/a.exr", "--width", "2000", "--spp", "64"]
        with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
            assert process.stdout and process.stderr
            process.stdout.readline()
            time.sleep(after)
            start = time.perf_counter()
            process.send_signal(signal.SIGINT)
            process.wait()
            seconds = time.perf_counter() - start
            said = process.stderr.read()
        left = [file.name for file in Path(folder).iterdir()]
    if process.returncode != 130:
        return seconds, f"exit code {process.returncode}: {said}"
    if said != "clrt: interrupted; nothing was saved\n":
        return seconds, f"said {said!r}"
    return seconds, f"left {left}" if left else ""


def _render(scene: str, *options: str) -> None:
    """`clrt render`, which tells on stdout when the first tile is done."""
    from clrt.cli import program
    from clrt.cli import progress as module

    @contextmanager
    def progress(*_: Any) -> Iterator[Any]:
        yield lambda *_: print("tile", flush=True)

    module.progress = progress  # type: ignore[assignment]
    signal.signal(signal.SIGINT, signal.default_int_handler)  # a background job ignores it
    sys.argv[1:] = ["render", scene, *options]
    program()


if __name__ == "__main__":
    _render(*sys.argv[1:])
