"""Runs one command of `commands` as a user would, and says what is wrong with how it ended."""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
import tempfile
import threading
import time
import tomllib
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Final

import clrt
from clrt.base.resources import PACKAGE

from . import gates
from .commands import Command, make

PATIENCE: Final = 300  # seconds of wall time: some compile all kernels, beside others that do
PROGRAM: Final = (b"-P", b"-m", b"clrt")
CODES: Final = (0, 1, 2, 130)
MUCH: Final = 1 << 16  # bytes on stderr: a fault is one line
_LOOK: Final = 0.02
_RAW: Final = re.compile(r"[\x00-\x08\x0b-\x1f\x7f-\x9f\u202a-\u202e\u2066-\u2069]")
_SPEAKS: Final = (  # of which all of stderr is ours
    b"render", b"hash", b"convert", b"devices", b"scenes", b"sweep", b"turntable", b"explain", b"check",
    b"exercise",
)  # fmt: skip
_KEPT_HERE: Final = {b"MPLCONFIGDIR": b"fontlist-", b"POCL_CACHE_DIR": b""}
"""How what is new begins in the folder that a variable names, if that is ".": a cache, PoCL's with a lock."""
_FILES: Final[dict[str, Callable[[Path], Any]]] = {
    **dict.fromkeys((".png", ".exr", ".tif", ".jpg", ".bmp"), clrt.read_image),
    ".json": lambda file: json.loads(file.read_text()),
    ".toml": lambda file: tomllib.loads(file.read_text()),
}


@dataclass
class Ended:
    """How a process ended; streams that nobody reads are b""."""

    code: int | None
    stdout: bytes
    stderr: bytes
    seconds: float
    bytes: int
    faults: list[str] = field(default_factory=list)


def attempt(task: dict[str, Any]) -> dict[str, Any]:
    """One task done: {"status": "ended well" | "ended badly" | "hangs" | "slow" | "large", "text", ...}."""
    command = make(task["seed"], task["index"])
    with tempfile.TemporaryDirectory(prefix="clrt-hostile-") as name:
        folder = Path(name, "run")
        command.prepare(folder)
        before = contents(folder)
        for beside in ("home", "tmp"):
            Path(name, beside).mkdir()
        ended = run(command, folder)
        faults = judged(command, ended, before, folder)
    status = "ended well"
    if ended.code is None:
        status = "hangs"
    elif faults:
        status = "ended badly"
    elif gates.is_slow(ended.seconds / gates.COMMAND_SECONDS):
        status = "slow"
    elif ended.bytes > gates.COMMAND_MEMORY:
        status = "large"
    words = (ended.stdout[-500:] + ended.stderr[-1500:]).decode(errors="backslashreplace")
    return {
        **task, "status": status, "text": f"{'; '.join(faults)}\n{words}" if status != "ended well" else "",
        "command": command.told(), "command seconds": ended.seconds, "command bytes": ended.bytes,
    }  # fmt: skip


def contents(folder: Path) -> dict[bytes, bytes | None]:
    """What every file below a folder holds; None for what is no file."""
    found: dict[bytes, bytes | None] = {}
    root = os.fsencode(folder)
    for place, folders, files in os.walk(root):
        for name in [*folders, *files]:
            path = os.path.join(place, name)
            plain = os.path.isfile(path) and not os.path.islink(path)
            if plain:
                with open(path, "rb") as file:
                    found[os.path.relpath(path, root)] = file.read()
            else:
                found[os.path.relpath(path, root)] = None
    return found


def environment(command: Command, folder: Path) -> dict[bytes, bytes]:
    """The user's own with an empty home and TMPDIR, kernels where they are, and the odd variables."""
    kept = {os.fsencode(name): os.fsencode(value) for name, value in os.environ.items()}
    kept.setdefault(b"XDG_CACHE_HOME", os.fsencode(Path.home() / ".cache"))
    kept[b"HOME"], kept[b"TMPDIR"] = os.fsencode(folder.parent / "home"), os.fsencode(folder.parent / "tmp")
    kept[b"PYTHONPATH"] = os.fsencode(os.pathsep.join([str(PACKAGE.parent), *sys.path]))
    for name, value in command.environment.items():
        kept.pop(name, None)
        if value is not None:
            kept[name] = value
    return kept


def run(command: Command, folder: Path) -> Ended:
    """Run it through a shell, which closes descriptors and sets limits."""
    closed = "".join(f" {number}>&-" for number, kind in enumerate(_kinds(command)) if kind == "closed")
    limits = "".join(f"ulimit -{kind} {value}; " for kind, value in command.limits.items())
    shell = [b"/bin/sh", b"-c", f'{limits}exec "$@"{closed}'.encode(), b"sh"]
    streams = [_Stream(kind, number == 0) for number, kind in enumerate(_kinds(command))]
    process = subprocess.Popen(
        [*shell, os.fsencode(sys.executable), *PROGRAM, *command.arguments],
        cwd=folder,
        env=environment(command, folder),
        start_new_session=True,
        stdin=streams[0].theirs,
        stdout=streams[1].theirs,
        stderr=streams[2].theirs,
    )
    for stream in streams:
        stream.begin()
    end, peak, code, used = time.monotonic() + PATIENCE, 0, None, None
    while code is None and time.monotonic() < end:
        time.sleep(_LOOK)
        peak = max(peak, _peak(process.pid))
        pid, status, used = os.wait4(process.pid, os.WNOHANG)
        if pid:
            code = os.waitstatus_to_exitcode(status)
    if code is None:
        os.killpg(process.pid, 9)
        _, _, used = os.wait4(process.pid, 0)
    process.returncode = -9 if code is None else code
    out, err = (stream.end() for stream in streams[1:])
    streams[0].end()
    assert used is not None
    return Ended(code, out, err, used.ru_utime + used.ru_stime, peak)


_SAID: Final = ("clrt: ", "Invalid -W option ignored: ")  # the second by the interpreter alone


def judged(command: Command, ended: Ended, before: dict[bytes, bytes | None], folder: Path) -> list[str]:
    """What is wrong."""
    faults = []
    if ended.code is not None and ended.code not in CODES:
        faults.append(f"exit code {ended.code}")
    stdout, stderr = ended.stdout.decode(errors="replace"), ended.stderr.decode(errors="replace")
    errors = sum(line.startswith("clrt: error:") for line in stderr.splitlines())
    if "Traceback" in stdout + stderr or "Exception ignored" in stderr:
        faults.append("a traceback")
    if command.stderr == "pipe":
        wrong = command.arguments[:1] == [b"check"] and ended.code == 1  # of each scene that is
        if not wrong and errors != (ended.code == 2) and ended.code in CODES:
            faults.append(f"exit code {ended.code} with {errors} lines of errors")
        if len(ended.stderr) > MUCH:
            faults.append(f"{len(ended.stderr):,} bytes on stderr")
        strange = [line for line in stderr.splitlines() if not line.startswith(_SAID)]
        told = any(name.startswith(b"POCL_") for name in command.environment)  # the driver answers
        if strange and not told and command.arguments[:1] and command.arguments[0] in _SPEAKS:
            faults.append(f"a line that is not ours: {strange[0][:200]!r}")
    for kind, text in ((command.stdout, stdout), (command.stderr, stderr)):
        raw = _RAW.search(text)
        if kind == "pipe" and raw:
            faults.append(f"a raw {raw.group()!r}")
    return faults + _files(command, ended, before, folder)


def _files(command: Command, ended: Ended, before: dict[bytes, bytes | None], folder: Path) -> list[str]:
    faults = []
    after = contents(folder)
    outputs = {os.path.normpath(name) for name in command.outputs if name}
    places = {value for value in command.environment.values() if value}
    for name in before.keys() | after.keys():
        shown = name.decode(errors="backslashreplace")[-60:]
        if any(name == place or name.startswith(place + b"/") for place in places):
            continue  # a folder for caches
        here = (start for key, start in _KEPT_HERE.items() if command.environment.get(key) == b".")
        if name not in before and any(name.startswith(start) for start in here):
            continue
        if before.get(name, b"") == after.get(name, b"") and (name in before) == (name in after):
            continue
        if any(output.startswith(name + b"/") and output in after for output in outputs):
            continue  # a folder that was made for what was written
        if not any(name == output or name.startswith(output + b"/") for output in outputs):
            faults.append(f"{shown} is {'left' if name not in before else 'changed'}")
            continue
        file = Path(os.fsdecode(os.path.join(os.fsencode(folder), name)))
        check = _FILES.get(file.suffix.lower())
        try:
            if check and name in after:
                check(file)
        except (clrt.ClrtError, OSError, ValueError) as error:
            faults.append(f"{shown} is not whole: {error}")
    if ended.code == 0 and command.arguments[:1] == [b"render"] and b"-o" in command.arguments:
        asked = command.arguments[command.arguments.index(b"-o") + 1 :][:1]
        helps = {b"--help", b"--version", b"-h"} & set(command.arguments)
        name = os.path.normpath(asked[0]) if asked else b""
        path = os.path.join(os.fsencode(folder), name)
        if os.path.islink(path):  # what it leads to was written
            name = os.readlink(path)
        if asked and not helps and after.get(name) == before.get(name):
            faults.append("exit code 0 and no new picture")
    left = contents(folder.parent / "tmp")
    if left and ended.code is not None and ended.code >= 0:
        faults.append(f"left in TMPDIR: {sorted(left)[:3]}")
    return faults


def _kinds(command: Command) -> tuple[str, str, str]:
    return command.stdin, command.stdout, command.stderr


def _peak(pid: int) -> int:
    try:
        found = re.search(r"VmHWM:\s*(\d+) kB", Path(f"/proc/{pid}/status").read_text())
    except OSError:
        return 0
    return int(found.group(1)) << 10 if found else 0


class _Stream:
    """One of a process' first three descriptors, and who reads it."""

    def __init__(self, kind: str, read: bool) -> None:
        self.kind, self.read, self.ours = kind, read, -1
        self._found: list[bytes] = []
        self._thread: threading.Thread | None = None
        if kind == "terminal":
            self.ours, self.theirs = os.openpty()
        elif kind in ("pipe", "broken", "unread"):
            self.ours, self.theirs = os.pipe()
            if kind == "broken":
                os.close(self.ours)
                self.ours = -1
        else:
            path = "/dev/full" if kind == "full" else os.devnull
            self.theirs = os.open(path, os.O_RDONLY if read else os.O_WRONLY)

    def begin(self) -> None:
        """The process has its end: read ours, where somebody does."""
        os.close(self.theirs)
        if self.ours >= 0 and self.kind != "unread":
            self._thread = threading.Thread(target=self._drain, daemon=True)
            self._thread.start()

    def end(self) -> bytes:
        """All that came."""
        if self._thread:
            self._thread.join(5.0)
        if self.ours >= 0:
            os.close(self.ours)
        return b"".join(self._found) if self.kind == "pipe" else b""

    def _drain(self) -> None:
        try:
            while data := os.read(self.ours, 1 << 16):
                if len(self._found) < 1000:
                    self._found.append(data)
        except OSError:  # a terminal whose last user has gone
            return
