"""Results of jobs, kept from run to run: a job whose code and inputs have not changed is not done again.

A file a job and device, in a folder of clrt's own below the user's cache folder, that nobody else may write
to. It holds JSON and numbers, so that reading it runs nothing, and a SHA-256 over all that the result depends
on: the code that the job reaches, kernels, packages, driver, the case's scene and the files that it reads,
the fault's text. One with another SHA-256, or a damaged one, is as good as none. Only what passed, and had
all its oracles, is kept, and nothing whose code or inputs have changed since the run began.

Pictures are kept, too, where a report asked for them; where a report asks for what was kept without, the case
runs anew.
"""

from __future__ import annotations

import hashlib
import json
import os
import zlib
from collections.abc import Iterable, Mapping
from contextlib import suppress
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from typing import Any, Final
from zipfile import BadZipFile

import msgspec
import numpy as np
from platformdirs import user_cache_dir

from clrt.base import interrupts
from clrt.base.atomic import replacing
from clrt.base.errors import ClrtError
from clrt.base.resources import PACKAGE, kernel_folder
from clrt.device.added import added
from clrt.device.cachefolder import shared_with
from clrt.device.foreign import VARIABLE as FOREIGN
from clrt.device.platforms import choose

from ..cases import case_named
from ..mutants.kept import versions
from ..mutants.run import CHECK, MUTANTS, REFITTED
from ..reliability import code
from ..types import CaseResult, CheckResult, Comparison, CountResult, Gate, MutantResult, OracleImage

_TEXT: Final = "json"
_DAMAGED: Final = (OSError, ValueError, KeyError, TypeError, EOFError, RuntimeError, BadZipFile, zlib.error,
                   msgspec.MsgspecError)  # fmt: skip
_Arrays = dict[str, np.ndarray]
_Files = dict[str, tuple[int, int]]


@dataclass(frozen=True)
class Inputs:
    """What a job is made from, beside code. said: the rest of it, told by its repr. pictures: it has to have
    them."""

    module: str
    cases: tuple[str, ...] = ()
    faults: tuple[str, ...] = ()
    files: tuple[Path, ...] = ()
    said: Any = None
    pictures: bool = False


class _Found(msgspec.Struct):
    """A comparison and its oracle's picture, but for arrays."""

    name: str
    seconds: float
    metrics: dict[str, float]
    gates: tuple[Gate, ...]
    worst: str


class _Case(msgspec.Struct):
    """A `CaseResult`, but for arrays."""

    case: str
    ours: str
    ours_seconds: float
    seconds: float
    results: dict[str, _Found]


_KINDS: Final[dict[str, Any]] = {"case": _Case, "mutant": MutantResult, "check": CheckResult,
                                 "counts": list[CountResult], "names": list[str]}  # fmt: skip


@dataclass
class Kept:
    """The results on a device that are kept, and what keeps further ones. fresh: none is read. `fault`: why
    nothing is kept, "" where it is."""

    device: int | str | None
    packages: Mapping[str, str]
    fresh: bool = False
    folder: Path = field(default_factory=lambda: Path(user_cache_dir("clrt", appauthor=False), "results"))

    def __post_init__(self) -> None:
        for cached in (_code, _case):
            cached.cache_clear()
        code.forget()
        info = choose(self.device)[0]
        self._on = f"{info.label} {info.driver} {added()}"
        self._asked: dict[str, tuple[str, _Files]] = {}
        # kernels of the user's own are there to be changed
        self.fault = f"{FOREIGN} is set" if os.environ.get(FOREIGN) else ""
        try:
            self.folder.mkdir(mode=0o700, parents=True, exist_ok=True)
            self.fault = self.fault or shared_with(self.folder)
        except OSError as error:
            self.fault = f"{self.folder}: {error.strerror}"

    def read(self, jobs: Mapping[str, Inputs | None]) -> dict[str, Any]:
        """Results of those jobs that are kept. Inputs None: of a job that never is."""
        found = {}
        for name, inputs in jobs.items() if not self.fault else ():
            if inputs is not None:
                self._asked[name] = self._key(inputs)
                with suppress(*_DAMAGED):
                    if not self.fresh:
                        found[name] = self._result(name, inputs)
        return found

    def keep(self, name: str, inputs: Inputs | None, result: Any) -> None:
        """Keep the result of a job that was asked for, if it is good and all that it was made from stands."""
        key, files = self._asked.get(name, ("", {}))
        if not key or inputs is None or not good(result) or _state(map(Path, files)) != files:
            return
        kind, value, arrays = _plain(result)
        built = msgspec.to_builtins(value, enc_hook=lambda number: number.item())  # numpy's
        held = {"key": key, "pictures": inputs.pictures, "kind": kind, "result": built}
        arrays[_TEXT] = np.frombuffer(json.dumps(held).encode(), np.uint8)
        file = self._file(name, inputs)
        with suppress(OSError, ClrtError), replacing(file) as temporary, temporary.open("wb") as opened:
            np.savez_compressed(opened, **arrays)  # type: ignore[arg-type]
        # who interrupts the run is told of the folder, not of each file
        others = [path for path in interrupts.saved if path.parent.resolve() != self.folder.resolve()]
        interrupts.saved[:] = dict.fromkeys([*others, self.folder])

    def _result(self, name: str, inputs: Inputs) -> Any:
        """What is kept; one of _DAMAGED where it is not what was asked for."""
        file = self._file(name, inputs)
        if not file.is_file():  # a pipe would be waited for
            raise FileNotFoundError(file)
        with np.load(file, allow_pickle=False) as opened:
            held = json.loads(opened[_TEXT].tobytes())
            if held["key"] != self._asked[name][0] or inputs.pictures > held["pictures"]:
                raise KeyError(name)
            arrays = {key: opened[key] for key in opened.files if key != _TEXT} if inputs.pictures else None
        return _made(msgspec.convert(held["result"], _KINDS[held["kind"]]), arrays)

    def _file(self, name: str, inputs: Inputs) -> Path:
        """One a job, whatever its code: so the folder does not grow with each change."""
        said = f"{self._on} {name} {inputs.said!r}"
        return self.folder / f"{hashlib.sha256(said.encode()).hexdigest()[:32]}.npz"

    def _key(self, inputs: Inputs) -> tuple[str, _Files]:
        """The SHA-256 over all that a result depends on, and the state of the files among it."""
        faults = [MUTANTS[name] for name in inputs.faults]
        named = [case for fault in faults for case in fault.cases if not case.startswith(CHECK)]
        cases = [*inputs.cases, *(case.removeprefix(REFITTED) for case in named)]
        files, digest = _code(inputs.module, code.STATED if cases else ())
        held = hashlib.sha256(f"{digest} {self._on} {self.packages} {versions()} {inputs.said!r}".encode())
        for file in inputs.files:
            files = files | _state([file])
            held.update(hashlib.sha256(file.read_bytes()).digest())
        for fault in faults:
            folder, _, rest = fault.file.partition("/")
            file = (kernel_folder() if folder == "kernels" else PACKAGE) / rest
            files = files | _state([file])
            edited = hashlib.sha256(fault.edit(file.read_text("utf-8")).encode()).hexdigest()
            held.update(f"{fault.file} {fault.cases} {edited}".encode())
        for name in dict.fromkeys(cases):
            states, digest = _case(name)
            files = files | states
            held.update(digest.encode())
        return held.hexdigest(), files


@cache
def _code(module: str, apart: tuple[str, ...]) -> tuple[_Files, str]:
    states = _state(file for _, file in code.files((module,), apart))
    return states, code.digest((module,), apart)


@cache
def _case(name: str) -> tuple[_Files, str]:
    """The files that a case's scenes read, and the digest of all that makes its picture."""
    from .shared import files_of

    case = case_named(name)
    held, states = hashlib.sha256(name.encode()), _Files()
    scenes = [scene for scene in (case.scene, case.stand_in) if scene is not None]
    for scene in scenes:
        read = files_of(scene)
        states |= _state(map(Path, read))
        for file, content in read.items():
            held.update(f"{Path(file).name} {hashlib.sha256(content).hexdigest()}".encode())
    tables = [scene.name if isinstance(scene, Path) else scene for scene in scenes]
    size = [case.width, case.height, case.spp, case.max_depth]
    held.update(json.dumps([tables, size], sort_keys=True, default=str).encode())
    return states, held.hexdigest()


def _state(files: Iterable[Path]) -> _Files:
    """What tells that a file was written to."""
    found = _Files()
    for file in files:
        found[str(file)] = (-1, -1)
        with suppress(OSError):
            status = file.stat()
            found[str(file)] = (status.st_mtime_ns, status.st_size)
    return found


def good(result: Any) -> bool:
    """Whether a result may be kept: it passed, and no oracle was missing."""
    if isinstance(result, CaseResult):
        return result.passed and not result.unproven
    if isinstance(result, MutantResult):
        return not result.survived
    if isinstance(result, list):
        return all(not isinstance(one, CountResult) or one.passed for one in result)
    return isinstance(result, CheckResult) and result.passed


def _plain(result: Any) -> tuple[str, Any, _Arrays]:
    """A result's kind, the result without arrays, and these by name."""
    if not isinstance(result, CaseResult):
        kinds = {MutantResult: "mutant", CheckResult: "check"}
        counted = isinstance(result, list) and result and isinstance(result[0], CountResult)
        return kinds.get(type(result)) or ("counts" if counted else "names"), result, {}
    arrays, found = {"ours": result.ours.pixels}, {}
    for oracle, (image, comparison) in result.results.items():
        arrays[f"{oracle}/pixels"] = image.pixels
        arrays |= {f"{oracle}/maps/{name}": values for name, values in comparison.maps.items()}
        said = comparison.metrics, comparison.gates, comparison.worst
        found[oracle] = _Found(image.name, image.seconds, *said)
    ours = result.ours
    return "case", _Case(result.case.name, ours.name, ours.seconds, result.seconds, found), arrays


def _made(result: Any, arrays: _Arrays | None) -> Any:
    """The result again; without arrays where there are to be none."""
    if not isinstance(result, _Case):
        return result

    def image(name: str, key: str, seconds: float) -> OracleImage:
        pixels = np.zeros((0, 0, 3), np.float32) if arrays is None else arrays[key]
        return OracleImage(pixels, {}, None, None, name, seconds)

    results = {}
    for oracle, found in result.results.items():
        start = f"{oracle}/maps/"
        maps = {k.removeprefix(start): values for k, values in (arrays or {}).items() if k.startswith(start)}
        comparison = Comparison(found.metrics, found.gates, maps, found.worst)
        results[oracle] = image(found.name, f"{oracle}/pixels", found.seconds), comparison
    ours = image(result.ours, "ours", result.ours_seconds)
    return CaseResult(case_named(result.case), ours, results, {}, result.seconds)
