"""Ctrl-C while a command begins: its libraries start, the scene is read, the device is opened.

SIGINT is sent at a random time after clrt's first line, until when the interrupts of `interrupts` begin. The
command is the script that pip installs. Each must end with exit code 130, one line and no file, or have done
its work before the signal.
"""

from __future__ import annotations

import random
import signal
import subprocess
import sys
import tempfile
import time
from collections import Counter
from pathlib import Path
from typing import Final

from .figures import Figure, Tell, listed

_LONGEST: Final = 1.2  # seconds until the signal
COMMANDS: Final = (
    ("render", "room", "-o", "a.png", "--width", "16"),
    ("hash", "gallery", "--width", "8"),
    ("convert", "booths", "a.toml"),
    ("devices",),
)
# `python -c` has its own first lines; SIGINT may be ignored in jobs in the background, and so it would stay
_SCRIPT: Final = (
    "import signal, sys; signal.signal(signal.SIGINT, signal.default_int_handler); sys.argv[0] = 'clrt'; "
    "from clrt.cli import program; program()"
)


def run(count: int, tell: Tell) -> Figure:
    """Interrupt `count` commands at random times."""
    start, found = time.perf_counter(), []
    ended: Counter[str] = Counter()
    for number in range(count):
        command = COMMANDS[number % len(COMMANDS)]
        how, wrong = interrupt(command, random.Random(number).uniform(0, _LONGEST))
        ended[how] += 1
        if wrong:
            found.append(f"round {number}, {command[0]}: {wrong}")
        tell((number + 1) / count)
    detail = f"{', '.join(f'{many:,} {how}' for how, many in sorted(ended.items()))}"
    return Figure(count, len(found), detail + listed(found), time.perf_counter() - start)


def interrupt(
    command: tuple[str, ...], after: float, sent: signal.Signals = signal.SIGINT
) -> tuple[str, str]:
    """How a command ended, "interrupted" or "done", and what was wrong ('' if nothing).

    The signal is sent `after` seconds after clrt's first line.
    """
    with tempfile.TemporaryDirectory(prefix="clrt-beginnings-") as folder:
        with subprocess.Popen(
            [sys.executable, "-c", _SCRIPT, *command],
            cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
        ) as process:  # fmt: skip
            _wait_for_first_line(process)
            time.sleep(after)
            process.send_signal(sent)
            _, said = process.communicate()
        left = sorted(file.name for file in Path(folder).iterdir())
    if process.returncode == 0:
        return "done", f"said {said!r}" if said else f"left {left}" if len(left) > 1 else ""
    line = "clrt: interrupted" + (f" by {sent.name}" if sent != signal.SIGINT else "")
    if process.returncode != 128 + sent:
        return "interrupted", f"exit code {process.returncode}: {said}"
    if not said.startswith(line) or said.count("\n") != 1:
        return "interrupted", f"said {said!r}"
    return "interrupted", f"left {left}" if left and "saved: " not in said else ""


def _wait_for_first_line(process: subprocess.Popen[str]) -> None:
    """Until the process catches SIGTERM, as clrt does from its first line on, and Python does not."""
    status = Path(f"/proc/{process.pid}/status")
    while process.poll() is None:
        caught = next(line for line in status.read_text().splitlines() if line.startswith("SigCgt"))
        if int(caught.split()[1], 16) >> (signal.SIGTERM - 1) & 1:
            return
        time.sleep(0.0002)
