"""Pictures of kernels with many faults in one build, by a process that is told which fault is to count.

A fault may write where it should not, so the process is trusted no further than each picture of the kernels
without fault that it gives after one; where that is another than before, or none, a new process takes over.
"""

from __future__ import annotations

import os
import pickle
import re
import signal
import subprocess
import sys
import tempfile
import threading
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any, Final

from clrt.base.errors import ClrtError
from clrt.device.device import Device
from clrt.device.kernelcache import VARIABLE as CACHE

from ..types import OracleImage
from .generated import Place
from .plant import bound_memory, bound_time, in_haste, patched_with, picture_of
from .switched import Switch, with_all

_CHILD: Final = (
    "from clrt.base.resources import validation_module as find; find('mutants.served').serve()"
)
_SECONDS: Final = 900.0  # for a picture that waits and does not compute
_BUILD, _PICTURE = 100, 10  # seconds of processor time, with what is built for the first one of a format
_WRONG: Final = re.compile(r"error: ([\w.]+):(\d+):")


class Lost(ClrtError):
    """The process ended before it gave a picture: crashed, or took too long."""

    def __init__(self, said: str, crashed: bool = False) -> None:
        super().__init__(said)
        self.crashed = crashed


class Served:
    """Kernels in which each of `faults` (by number, from 1 on) can be chosen. A context manager.

    unable: those that cannot, as they cut into others or the compiler wants a constant there.
    """

    def __init__(self, faults: Mapping[int, Place], device: int | str | None = None) -> None:
        self._faults, self._device, self.unable = dict(faults), device, set[int]()
        self._child: subprocess.Popen[bytes] | None = None

    def __enter__(self) -> Served:
        self._errors = tempfile.TemporaryFile()
        self._folder = patched_with(self._texts)
        self._root = self._folder.__enter__()
        return self

    def __exit__(self, *_: Any) -> None:
        self.restart()
        self._folder.__exit__(None, None, None)
        self._errors.close()

    def _texts(self, file: str, text: str) -> str:
        """A file's text with all faults that are in it."""
        mine = [(n, place) for n, place in self._faults.items()
                if place.file == file and n not in self.unable]  # fmt: skip
        new, left = with_all(text, mine)
        self.unable |= left
        return new

    def restart(self) -> None:
        """Let a new process render what comes next."""
        if self._child is not None:
            self._child.kill()
            self._child.wait()
            self._child = None

    def sound(self, case: str) -> tuple[OracleImage, frozenset[int]]:
        """The picture without any fault, and those whose places it comes by; faults that do not build with
        the others become `unable`."""
        while True:
            try:
                return self._answer(0, case)
            except Lost as error:
                where = [(found[1], int(found[2])) for found in _WRONG.finditer(str(error))]
                wrong = {n for n, place in self._faults.items() if n not in self.unable
                         and (Path(place.file).name, place.line) in where}  # fmt: skip
                if not wrong:
                    raise
                self.unable |= wrong
                self._folder.__exit__(None, None, None)
                self._folder = patched_with(self._texts)
                self._root = self._folder.__enter__()

    def picture(self, fault: int, case: str) -> OracleImage:
        """The picture of a case with a fault, 0: none. Lost where the process ends or takes too long."""
        return self._answer(fault, case)[0]

    def _answer(self, fault: int, case: str) -> tuple[OracleImage, frozenset[int]]:
        child = self._child = self._child or self._start()
        assert child.stdin is not None and child.stdout is not None
        clock = threading.Timer(_SECONDS, child.kill)
        clock.start()
        try:
            pickle.dump((fault, case), child.stdin)
            child.stdin.flush()
            picture, reached = pickle.load(child.stdout)
            return picture, reached
        except (EOFError, BrokenPipeError, pickle.UnpicklingError):
            ended = child.wait()
            self._errors.seek(0)
            said = self._errors.read().decode(errors="replace").strip()[-2000:]
            self.restart()
            slow = -ended in (signal.SIGXCPU, signal.SIGKILL)
            why = f"no picture within {_PICTURE} s" if slow else said or f"ended by {-ended}"
            raise Lost(why, not slow) from None
        finally:
            clock.cancel()

    def _start(self) -> subprocess.Popen[bytes]:
        self._errors.seek(0)
        self._errors.truncate()
        path = os.pathsep.join(filter(None, (str(self._root), os.environ.get("PYTHONPATH"))))
        command = [sys.executable, "-P", "-W", "ignore", "-c", _CHILD]
        child = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=self._errors,
                                 cwd=self._root, env={**os.environ, "PYTHONPATH": path})  # fmt: skip
        assert child.stdin is not None
        with suppress(BrokenPipeError):
            pickle.dump((str(self._root), self._device), child.stdin)
            child.stdin.flush()
        return child


def serve() -> None:
    """In the child: a picture for each fault and case that standard input names, to standard output."""
    root, device = pickle.load(sys.stdin.buffer)
    answers = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)  # what a driver prints must not get in between
    switch = Switch()
    bound_memory()
    built = Path(root) / "built"
    built.mkdir(mode=0o700, exist_ok=True)
    os.environ[CACHE] = str(built)
    opened = Device(device, kernels=Path(root) / "kernels")
    with answers, in_haste(), suppress(EOFError):
        while True:
            fault, case = pickle.load(sys.stdin.buffer)
            bound_time(_BUILD if fault == 0 else _PICTURE)
            switch.choose(fault)
            picture = picture_of(case, opened)
            pickle.dump((picture, switch.reached()), answers)
            answers.flush()
