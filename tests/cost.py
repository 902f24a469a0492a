"""What an input costs until it is refused or read: memory and processor time, in a process of its own.

Seconds are those of a core of `pace` 1: one that is half as fast, since others use its other half or it is
older, has twice the time.
"""

from __future__ import annotations

import json
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

BASE = 100 << 20  # bytes that any input may take
PER_BYTE = 60  # bytes more for each byte of its files
RATE = 1e6  # bytes a second, after the first second

_CHILD = """\
import json, resource, sys, time, warnings
resource.setrlimit(resource.RLIMIT_AS, (6 << 30, 6 << 30))
import clrt, clrt.flatten.flatten, clrt.images.file, trimesh
from clrt.base.resources import validation_module
pace = validation_module("hostile.pace").pace
warnings.simplefilter("always")
def peak():
    return next(int(line.split()[1]) << 10 for line in open("/proc/self/status") if line.startswith("VmHWM"))
def load(path):
    clrt.flatten.flatten.flatten(clrt.load(path))
def read(path):
    clrt.load(path)
def picture(path):
    clrt.read_image(path)
path, slowness = sys.argv[2], pace()
open("/proc/self/clear_refs", "w").write("5")  # the peak so far is forgotten
before, start, error = peak(), time.process_time(), ""
with warnings.catch_warnings(record=True) as said:
    try:
        {"load": load, "read": read, "picture": picture}[sys.argv[1]](path)
    except clrt.ClrtError as fault:
        error = str(fault)
    except BaseException as fault:
        error = f"foreign: {fault!r}"[:500]
seconds = time.process_time() - start
said = [str(warning.message)[:300] for warning in said]
taken = peak() - before
print(json.dumps([error, taken, seconds / max(slowness, pace()), said]))
"""


@dataclass(frozen=True)
class Cost:
    """What became of an input: the error's text ("" for none), bytes, seconds of processor time, warnings."""

    error: str
    peak: int
    seconds: float
    warnings: list[str]


def cost(kind: str, path: Path) -> Cost:
    """What a file costs: by `load` and `flatten` ("load"), `load` ("read"), `read_image` ("picture")."""
    command = [sys.executable, "-c", _CHILD, kind, str(path)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=300, check=False)
    assert done.returncode == 0, f"{path.name}: {done.returncode}: {done.stderr[-2000:]}"
    return Cost(*json.loads(done.stdout))


def bounded(kind: str, path: Path, declared: int = 0) -> Cost:
    """`cost`, once it is within bounds: those for any input, and `declared` bytes that a limit allows.

    Tests run beside each other, which makes each slower, never faster: the least of three times counts.
    """
    found = cost(kind, path)
    size = sum(file.stat().st_size for file in path.parent.iterdir())
    for _ in range(2):
        if found.seconds > 1 + size / RATE + declared / 1e9:
            found = min(found, cost(kind, path), key=lambda one: one.seconds)
    assert not found.error.startswith("foreign"), found.error
    assert found.peak <= BASE + PER_BYTE * size + declared, f"{found.peak >> 20} MiB: {found}"
    assert found.seconds <= 1 + size / RATE + declared / 1e9, f"{found.seconds:.2f} s: {found}"
    return found
