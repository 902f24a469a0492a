"""The process that runs Mitsuba, and what callers ask of it."""

from __future__ import annotations

import contextlib
import importlib.metadata
import importlib.util
import os
import pickle
import select
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from types import TracebackType
from typing import Any, Final

import numpy as np

from ..types import OracleImage
from . import modes
from .reading import read
from .records import Source
from .worker import HEADER, send

START_SECONDS: Final = 120.0  # a first start compiles Mitsuba's Python files
HOME: Final = Path(__file__).resolve().parents[2]  # the folder that holds this package
BOOT: Final = f"from {Path(__file__).resolve().parents[1].name}.oracle_mitsuba.worker import main; main()"


class MitsubaError(RuntimeError):
    """The worker could not start, crashed, hung or failed; the message says which and shows what it wrote."""


def find_llvm() -> str | None:
    """The LLVM library that Mitsuba is to load: DRJIT_LIBLLVM_PATH, else that of karellen-llvm-core, else
    None."""
    given = os.environ.get("DRJIT_LIBLLVM_PATH")
    if given:
        return given
    try:
        files = importlib.metadata.files("karellen-llvm-core") or []
    except importlib.metadata.PackageNotFoundError:
        return None
    found = [Path(str(file.locate())) for file in files if file.name.startswith("libLLVM.so")]
    return next((str(path) for path in sorted(found) if path.exists()), None)


@dataclass(frozen=True, eq=False)
class StatisticalImage(OracleImage):
    """A picture from random paths: `error` (h, w, 3) is the standard error of `pixels`."""

    error: np.ndarray = field(default_factory=lambda: np.zeros((0, 0, 3)))


class Mitsuba:
    """Mitsuba in a process of its own, started when first needed and again after a crash. A context manager.

    timeout: seconds that one picture may take. install: the command that installs a missing package.
    """

    def __init__(
        self, timeout: float = 600.0, install: Callable[[str], str] = "pip install {}".format
    ) -> None:
        self.timeout, self.install = timeout, install
        self._process: subprocess.Popen[bytes] | None = None
        self._log: Any = None
        self._versions: dict[str, str] | None = None

    def __enter__(self) -> Mitsuba:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None,
                 trace: TracebackType | None) -> None:  # fmt: skip
        self.close()

    def available(self) -> str | None:
        """None where Mitsuba runs here, else why it does not, in one line."""
        for package in ("mitsuba", "drjit"):
            if importlib.util.find_spec(package) is None:
                return f"{package} is not installed; install it with: {self.install(package)}"
        if find_llvm() is None:
            return f"no LLVM for Mitsuba; install it with: {self.install('karellen-llvm-core')}"
        try:
            self.versions()
        except MitsubaError as error:
            said, trace, _ = str(error).partition("Traceback (most recent call last):")
            last = str(error).strip().splitlines()[-1] if trace else ""  # of the traceback what was raised
            return " ".join(f"{said} {last}".split())
        return None

    def versions(self) -> dict[str, str]:
        """Versions of `mitsuba`, `drjit`, `llvm` and the `variant`. Raises MitsubaError."""
        if self._versions is None:
            found: dict[str, str] = self.request("versions", None, START_SECONDS)
            try:
                package = importlib.metadata.version("karellen-llvm-core")
            except importlib.metadata.PackageNotFoundError:
                package = ""
            if package and "DRJIT_LIBLLVM_PATH" not in os.environ:
                found["llvm"] = f"karellen-llvm-core {package}"
            self._versions = found
        return dict(self._versions)

    def supports(self, scene: Source, mode: str) -> str | None:
        """None where `mode` can express the scene, else why not (modes.MODES and SPECTRAL are the modes)."""
        return modes.supports(read(scene), mode)

    def render(self, scene: Source, mode: str = "table", paths: int | None = None) -> OracleImage:
        """The scene's picture from its camera, by one of modes.MODES or SPECTRAL.

        paths: random paths a sample, for the modes that need them; these return a StatisticalImage.
        ValueError where the mode cannot express the scene, MitsubaError where Mitsuba failed.
        """
        start = time.perf_counter()
        found = self.request("picture", self._job(scene, mode) | {"paths": paths})
        name = f"Mitsuba {self.versions()['mitsuba']} {mode}"
        seconds = time.perf_counter() - start
        picture = OracleImage(**found, name=name, seconds=seconds) if "error" not in found else None
        return picture or StatisticalImage(**found, name=name, seconds=seconds)

    def radiance(self, scene: Source, origins: Any, directions: Any, mode: str = "table") -> np.ndarray:
        """Radiance (n, 3) along rays (n, 3) of any length, by a mode of layer B ("table" or "bsdf")."""
        rays = {"origin": np.asarray(origins, float), "direction": np.asarray(directions, float)}
        return np.asarray(self.request("radiance", self._job(scene, mode) | rays))

    def _job(self, scene: Source, mode: str) -> dict[str, Any]:
        """The request: no more than the scene's tables, for the worker reads them itself."""
        reason = self.supports(scene, mode)
        if reason is not None:
            raise ValueError(f"{mode}: {reason}")
        return {"source": vars(scene), "mode": mode}

    def request(self, name: str, job: Any, timeout: float | None = None) -> Any:
        """One task of the worker; MitsubaError where it fails, with the worker's own words."""
        process = self._running()
        assert process.stdin is not None
        try:
            send(process.stdin, (name, job))  # type: ignore[arg-type]
            state, value = pickle.loads(self._receive(timeout or self.timeout))
        except (BrokenPipeError, EOFError):
            raise MitsubaError(
                f"Mitsuba's process {self._ended()} during {name!r}{self._last_words()}"
            ) from None
        except TimeoutError:
            self.close()
            raise MitsubaError(
                f"Mitsuba's process gave no answer to {name!r} in {timeout or self.timeout:g} s"
            ) from None
        except BaseException:  # an interrupted exchange leaves half a message in the pipe
            self.close()
            raise
        if state == "failed":
            raise MitsubaError(f"Mitsuba's process failed at {name!r}: {value}")
        return value

    def close(self) -> None:
        """End the process; a later request starts a new one."""
        process, self._process = self._process, None
        if process is None:
            return
        assert process.stdin is not None and process.stdout is not None
        process.kill()
        process.wait()
        process.stdout.close()
        with contextlib.suppress(BrokenPipeError):  # what it never read
            process.stdin.close()
        self._log.close()

    def _running(self) -> subprocess.Popen[bytes]:
        if self._process is not None and self._process.poll() is None:
            return self._process
        self.close()
        paths = [str(HOME), os.environ.get("PYTHONPATH", "")]
        environment = {**os.environ, "PYTHONPATH": os.pathsep.join(path for path in paths if path)}
        llvm = find_llvm()
        if llvm:
            environment["DRJIT_LIBLLVM_PATH"] = llvm
        try:
            self._log = tempfile.TemporaryFile()  # noqa: SIM115  # lives as long as the process
        except OSError as error:
            raise MitsubaError(f"Mitsuba does not start: no place for temporary files: {error}") from None
        # a session of its own: Ctrl-C reaches the caller only, who ends the worker
        self._process = subprocess.Popen(
            [sys.executable, "-P", "-c", BOOT],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=self._log,
            env=environment,
            start_new_session=True,
        )
        return self._process

    def _receive(self, timeout: float) -> bytes:
        deadline = time.monotonic() + timeout
        (length,) = HEADER.unpack(self._read(HEADER.size, deadline))
        return self._read(length, deadline)

    def _read(self, length: int, deadline: float) -> bytes:
        assert self._process is not None and self._process.stdout is not None
        pipe = self._process.stdout.fileno()
        parts: list[bytes] = []
        while length:
            if not select.select([pipe], [], [], max(0.0, deadline - time.monotonic()))[0]:
                raise TimeoutError
            part = os.read(pipe, min(length, 1 << 20))
            if not part:
                raise EOFError
            parts.append(part)
            length -= len(part)
        return b"".join(parts)

    def _ended(self) -> str:
        """How the process ended."""
        assert self._process is not None
        code = self._process.wait()
        names = {known.value: known.name for known in signal.Signals}  # not all signals have one
        return f"was ended by {names.get(-code, -code)}" if code < 0 else f"ended with code {code}"

    def _last_words(self) -> str:
        self._log.seek(0)
        text = self._log.read().decode(errors="replace").strip()
        return f"; its last words: {text[-2000:]}" if text else "; it wrote nothing"
