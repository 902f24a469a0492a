"""`python outlive.py FOLDER`: ends a program that is judged, and removes its folder, if nobody else does.

Who runs the program writes its process group to this one's input, and `done` when it has ended it. Where the
input ends before, as by SIGKILL, it is done here: the program has a session of its own, which no signal to
others reaches. This uses nothing but Python's own library, so that it starts at once.
"""

from __future__ import annotations

import os
import shutil
import signal
import sys
from contextlib import suppress
from pathlib import Path

_PASSES = 50  # of ending what others may have started meanwhile


def end_group(group: int) -> None:
    """Nothing of a process group stays, whatever it started."""
    with suppress(ProcessLookupError, PermissionError):
        os.killpg(group, signal.SIGKILL)


def end_strays(folder: str | os.PathLike[str]) -> None:
    """Nor what has left the group: it still has the folder for temporary files, which nothing else has."""
    mark = b"TMPDIR=" + os.fsencode(folder)
    for _ in range(_PASSES if sys.platform == "linux" else 0):
        found = [place for place in Path("/proc").glob("[0-9]*/environ") if mark in _words(place)]
        for place in found:
            with suppress(ProcessLookupError, PermissionError):
                os.kill(int(place.parent.name), signal.SIGKILL)
        if not found:
            return


def _words(place: Path) -> list[bytes]:
    try:
        return place.read_bytes().split(b"\0")
    except OSError:  # another user's, or gone
        return []


def _main() -> None:
    for name in ("SIGINT", "SIGTERM", "SIGHUP"):
        signal.signal(getattr(signal, name), signal.SIG_IGN)
    folder, groups = sys.argv[1], []
    for line in sys.stdin:
        if line == "done\n":
            return
        groups.append(int(line))
    for group in groups:
        end_group(group)
    end_strays(folder)
    shutil.rmtree(folder, ignore_errors=True)


if __name__ == "__main__":
    _main()
