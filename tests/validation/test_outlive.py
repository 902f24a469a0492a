"""A program under test ends with who runs it, however that ends, and so does its folder."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
HANGS = """
import os, subprocess, sys, time
if len(sys.argv) > 3:  # one that leaves the group
    subprocess.Popen([sys.executable, __file__, *sys.argv[1:3]], start_new_session=True)
open(sys.argv[1], "a").write(f"{os.getpid()}\\n")
time.sleep(300)
"""
RUNS = """
import sys, clrt
from validation.suite.program import parse
camera = {"origin": [0, 0, 5], "target": [0, 0, 0], "width": 8, "height": 6}
parse(sys.argv[1]).render(clrt.load_dict({"camera": camera, "ambient": 1.0, "shapes": []}))
"""


def is_there(pid: int) -> bool:
    """Whether a process runs; what has ended and nobody has asked for is a zombie."""
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except OSError:
        return False


@pytest.mark.skipif(sys.platform != "linux", reason="asks Linux which processes there are")
@pytest.mark.parametrize("how", [signal.SIGKILL, signal.SIGTERM, signal.SIGINT])
def test_a_program_ends_with_who_runs_it(tmp_path: Path, how: signal.Signals) -> None:
    script, pids, temporary = tmp_path / "hangs.py", tmp_path / "pids", tmp_path / "tmp"
    script.write_text(HANGS)
    temporary.mkdir()
    against = f"{sys.executable} {script} {pids} {{scene.json}} {{out.exr}}"
    environment = {**os.environ, "TMPDIR": str(temporary)}
    running = subprocess.Popen([sys.executable, "-c", RUNS, against], cwd=ROOT, env=environment)
    try:
        until = time.monotonic() + 60
        while not (pids.exists() and pids.read_text().count("\n") == 2):
            assert running.poll() is None and time.monotonic() < until
            time.sleep(0.05)
        started = [*map(int, pids.read_text().split())]
        assert all(map(is_there, started)) and [*temporary.iterdir()]
        running.send_signal(how)
        running.wait(30)
        until = time.monotonic() + 30
        while any(map(is_there, started)) or [*temporary.iterdir()]:
            assert time.monotonic() < until, (started, [*temporary.iterdir()])
            time.sleep(0.05)
    finally:
        running.kill()
