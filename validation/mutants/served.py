"""Pictures of code with many faults in one copy, by a process that is told which fault is to count.

A fault may write where it should not, so the process is trusted no further than each picture of the code
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
import traceback
from collections.abc import Mapping
from contextlib import nullcontext, suppress
from pathlib import Path
from typing import Any, Final

from clrt.base.errors import ClrtError
from clrt.base.resources import PACKAGE
from clrt.base.scratch import placed
from clrt.device.cachefolder import VARIABLE as CACHE
from clrt.device.device import Device

from ..cases import matrix_cases
from ..types import OracleImage
from . import switched, switched_host
from .generated import Place
from .plant import (
    Lost,
    bound_memory,
    bound_time,
    ended_by,
    in_haste,
    patched_with,
    picture_of,
)

_CHILD: Final = (
    "from clrt.base.resources import validation_module as find; find('mutants.served').serve()"
)
_SECONDS: Final = 900.0  # for a picture that waits and does not compute
# seconds of processor time; with what is built for the first one of a format, which faults of the host may
# ask for, too
_BUILD, _PICTURE, _OF_HOST = 100, 10, 40
_WRONG: Final = re.compile(r"error: ([\w.]+):(\d+):")


class Served:
    """Code in which each of `faults` (by number, from 1 on) can be chosen. A context manager.

    faults: all in kernels, or all in the host's code.
    unable: those that cannot, as they cut into others, the compiler wants a constant there, or the module
    computes there when it is imported.
    """

    def __init__(self, faults: Mapping[int, Place], device: int | str | None = None) -> None:
        self._faults, self._device, self.unable = dict(faults), device, set[int]()
        self._files = sorted({place.file for place in faults.values()})
        self._of_kernels = all(file.startswith("kernels/") for file in self._files)
        self._child: subprocess.Popen[bytes] | None = None

    def __enter__(self) -> Served:
        self._errors = placed(lambda: tempfile.TemporaryFile())  # noqa: SIM115
        self._open()
        return self

    def __exit__(self, *_: Any) -> None:
        self.restart()
        self._folder.__exit__(None, None, None)
        self._errors.close()

    def _open(self) -> None:
        self._folder = patched_with(self._files, self._text)
        self._root = self._folder.__enter__()
        if not self._of_kernels:
            (self._root / f"{switched_host.MODULE}.py").write_text(switched_host.TEXT, "utf-8")

    def _text(self, file: str, text: str) -> str:
        """A file's text with all faults that are in it."""
        mine = [(n, place) for n, place in self._faults.items()
                if place.file == file and n not in self.unable]  # fmt: skip
        new, left = (switched if self._of_kernels else switched_host).with_all(text, mine)
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
                where = [(found[1], int(found[2])) for found in _WRONG.finditer(error.said)]
                wrong = {n for n, place in self._faults.items() if n not in self.unable
                         and (Path(place.file).name, place.line) in where}  # fmt: skip
                if not wrong:
                    raise
                self.unable |= wrong
                self._folder.__exit__(None, None, None)
                self._open()

    def picture(self, fault: int, case: str) -> OracleImage:
        """The picture of a case with a fault, 0: none. Lost where there is none, or it takes too long."""
        return self._answer(fault, case)[0]

    def _answer(self, fault: int, case: str) -> tuple[OracleImage, frozenset[int]]:
        fresh = self._child is None
        child = self._child = self._child or self._start()
        assert child.stdin is not None and child.stdout is not None
        clock = threading.Timer(_SECONDS, child.kill)
        clock.start()
        try:
            pickle.dump((fault, case), child.stdin)
            child.stdin.flush()
            if fresh:
                self.unable |= pickle.load(child.stdout)
            picture, reached = pickle.load(child.stdout)
        except (EOFError, BrokenPipeError, pickle.UnpicklingError):
            ended = child.wait()
            self._errors.seek(0)
            said = self._errors.read().decode(errors="replace").strip()[-2000:]
            self.restart()
            slow = -ended in (signal.SIGXCPU, signal.SIGKILL)
            why = f"no picture within {self._limit} s" if slow else said or ended_by(ended)
            raise Lost(why, not slow) from None
        finally:
            clock.cancel()
        if isinstance(picture, str):
            raise Lost(picture)
        return picture, reached

    @property
    def _limit(self) -> int:
        return _PICTURE if self._of_kernels else _OF_HOST

    def _start(self) -> subprocess.Popen[bytes]:
        self._errors.seek(0)
        self._errors.truncate()
        path = os.pathsep.join(filter(None, (str(self._root), os.environ.get("PYTHONPATH"))))
        command = [sys.executable, "-P", "-W", "ignore", "-c", _CHILD]
        child = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=self._errors,
                                 cwd=self._root, env={**os.environ, "PYTHONPATH": path})  # fmt: skip
        assert child.stdin is not None
        with suppress(BrokenPipeError):
            modules = [] if self._of_kernels else [
                file.removesuffix(".py").removesuffix("/__init__").replace("/", ".") for file in self._files]
            pickle.dump((str(self._root), self._device, modules, self._limit), child.stdin)
            child.stdin.flush()
        return child


def serve() -> None:
    """In the child: a picture for each fault and case that standard input names, or the error, to standard
    output; before the first one the faults that count when modules are imported."""
    root, device, modules, limit = pickle.load(sys.stdin.buffer)
    answers = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)  # what a driver prints must not get in between
    with answers, suppress(EOFError), nullcontext() if modules else in_haste():
        switch: switched.Switch | switched_host.Switch
        bound_memory()
        if modules:
            if Path(root) / "clrt" != PACKAGE:
                raise ClrtError(f"the package of {PACKAGE} was imported in place of the patched one")
            switch = switched_host.Switch(modules)
            pickle.dump(switch.reached(), answers)
            opened = Device(device)
        else:
            switch = switched.Switch()
            pickle.dump(frozenset(), answers)
            opened = _with_kernels(Path(root), device)
        matrix_cases()  # kept, as no fault is to change them
        while True:
            fault, case = pickle.load(sys.stdin.buffer)
            bound_time(_BUILD if fault == 0 else limit)
            switch.choose(fault)
            try:
                picture: OracleImage | str = picture_of(case, opened)
            except Exception:
                picture = traceback.format_exc()
            pickle.dump((picture, switch.reached()), answers)
            answers.flush()


def _with_kernels(root: Path, device: int | str | None) -> Device:
    built = root / "built"
    built.mkdir(mode=0o700, exist_ok=True)
    os.environ[CACHE] = str(built)
    return Device(device, kernels=root / "kernels")
