"""Many processes at once that all have to compile the kernels: all get the same picture.

Each round empties the folder of compiled kernels and starts the processes together.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Final

import clrt
from clrt.device import cachedamage, cachefolder

from .figures import Figure, Tell, listed
from .scene import write_alone

TOGETHER: Final = 24


def run(count: int, tell: Tell, together: int = TOGETHER) -> Figure:
    """Start `count` processes, so many together, each time on a cold cache."""
    start = time.perf_counter()
    found: list[str] = []
    rounds, longest = -(-count // together), 0.0
    with tempfile.TemporaryDirectory(prefix="clrt-cold-") as name:
        scene = write_alone(Path(name))
        expected = clrt.render(clrt.load(scene)).hash
        for number in range(rounds):
            with tempfile.TemporaryDirectory(prefix="clrt-cold-") as cache:
                begun = time.perf_counter()
                for code, out, err in _together(scene, Path(cache), together):
                    if (code, out.split()[:1]) != (0, [expected]):
                        found.append(f"round {number}: exit code {code}: {out} {err[-300:]}")
                longest = max(longest, time.perf_counter() - begun)
                damaged = cachedamage.remove_damaged(Path(cache))
                found += [f"round {number}: {file} is damaged" for file in damaged]
            tell((number + 1) / rounds)
    detail = f"{rounds} times {together} at once, at most {longest:.0f} s until the last has its picture"
    return Figure(rounds * together, len(found), detail + listed(found), time.perf_counter() - start)


def _together(scene: Path, cache: Path, processes: int) -> list[tuple[int, str, str]]:
    """Exit code, stdout and stderr of processes that render a scene with an empty cache."""
    command = [sys.executable, "-m", "clrt", "hash", str(scene)]
    environment = {**os.environ, cachefolder.VARIABLE: str(cache)}
    started = [
        subprocess.Popen(command, env=environment, text=True, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
        for _ in range(processes)
    ]
    ended = []
    for process in started:
        out, err = process.communicate()
        ended.append((process.returncode, out, err))
    return ended
