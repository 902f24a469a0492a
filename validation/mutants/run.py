"""Does validation notice? Each deliberate fault is planted in a copy, rendered, and must fail a gate.

An oracle judges that does not reach the module with the fault: the float64 one, which shares no code with the
kernels and what is made for them, or Mitsuba's side for faults in what reads scenes. (The float32 twin would
catch anything, having been written after the kernels.) The working tree is never touched: kernels are built
from a patched copy of their folder, host code runs in a process that imports a patched copy of the package.

    python -m validation.mutants [NAME ...]      plants these, or all
"""

from __future__ import annotations

import dataclasses
import os
import pickle
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from typing import Final

import numpy as np

from clrt.base.errors import ClrtError
from clrt.base.resources import PACKAGE, kernel_folder
from clrt.device import intel
from clrt.device.device import Device
from clrt.scene.scene import Scene

from ..cases import case_named, limits_of, tables
from ..compare.oracle import compare
from ..independence import reached
from ..oracles import ORACLE64, SPECTRAL, edges64, our_picture, picture64, scene_of, source_of
from ..suite.worker import oracles
from ..types import Comparison, MutantResult, OracleImage
from .audit import AUDIT_FAULTS
from .host import HOST_FAULTS
from .kernels import KERNEL_FAULTS, Mutant
from .spectral import SPECTRAL_FAULTS

MUTANTS: Final = {
    mutant.name: mutant for mutant in (*KERNEL_FAULTS, *HOST_FAULTS, *SPECTRAL_FAULTS, *AUDIT_FAULTS)
}
_SECONDS = 120  # that a patched package may take for its pictures
_MORE_OPTIONS: Final = "PYOPENCL_BUILD_OPTIONS"
_BESIDE = ("kernels", "scenes", "validation")  # what a checkout has beside the package
_CHILD = "from clrt.base.resources import validation_module as find; find('mutants.run').render_for_parent()"


def run_mutant(name: str, device: int | str | None = None) -> MutantResult:
    """Plant a fault and see whether its judge notices it on one of its cases, and what it blames."""
    mutant = MUTANTS[name]
    for case, ours in _pictures(mutant, device):
        oracle = judge_of(mutant, case)
        reason = oracles().unable(oracle, source_of(case_named(case)))
        if reason is not None:
            return MutantResult(name, mutant.file, f"not judged: {reason}", (), True)
        comparison = judged(case, ours, oracle)
        if not comparison.passed and is_sound(case, device, oracle):
            gates = ", ".join(gate.name for gate in comparison.gates if not gate.passed)
            return MutantResult(name, mutant.file, f"{case}: {gates}", (oracle,), False, comparison.worst)
    return MutantResult(name, mutant.file, f"no gate failed on {', '.join(mutant.cases)}", (), True)


def judge_of(mutant: Mutant, case: str) -> str:
    """The oracle that does not reach the module in which the fault is (of a table: the one that reads it)."""
    file = Path(mutant.file)
    place = file.with_suffix("") if file.suffix == ".py" else file.parent
    module = ".".join(place.parent.parts if place.name == "__init__" else place.parts)
    if module not in reached(ORACLE64):
        return ORACLE64
    assert module not in reached("mitsuba"), f"{module}: every oracle reaches it"
    return SPECTRAL if "spectrum" in tables(case_named(case).scene) else "mitsuba-table"


def judged_by_mitsuba() -> list[str]:
    """The cases on which only Mitsuba's side can notice a fault: a quick run asks it for these, too."""
    return list(dict.fromkeys(case for mutant in MUTANTS.values() for case in mutant.cases
                              if judge_of(mutant, case) != ORACLE64))  # fmt: skip


def judged(case: str, ours: OracleImage, oracle: str) -> Comparison:
    """A picture of a case against an oracle's, by the case's gates on what differs."""
    reference, edges = _reference(case)
    found = case_named(case)
    limits = dataclasses.replace(limits_of(found, oracle), mask=None, clipped=None,
                                 lit=None)  # of the reference alone
    theirs = reference if oracle == ORACLE64 else _theirs(case, oracle)
    return compare(ours, theirs, edges, found.spp, limits)


@cache
def is_sound(case: str, device: int | str | None, oracle: str) -> bool:
    """Whether the kernels as they are pass here; AssertionError, for else failing says nothing of a fault."""
    comparison = judged(case, our_picture(_small(case), Device(device)), oracle)
    assert comparison.passed, f"{case}: fails without any fault, too: {comparison.worst}"
    return True


@cache
def _reference(case: str) -> tuple[OracleImage, np.ndarray]:
    scene = _small(case)
    picture = picture64(scene)
    return picture, edges64(scene, picture)


@cache
def _theirs(case: str, oracle: str) -> OracleImage:
    source = source_of(case_named(case))
    assert source.width is not None and source.height is not None
    return oracles().render(oracle, dataclasses.replace(source, width=source.width // 2, height=source.height
    // 2))


def _small(case: str) -> Scene:
    """A case's scene at half its size, at which a fault shows as well."""
    scene = scene_of(case_named(case))
    assert scene.camera is not None
    return scene.override(width=scene.camera.width // 2, height=scene.camera.height // 2)


def _pictures(mutant: Mutant, device: int | str | None) -> Iterator[tuple[str, OracleImage]]:
    """The mutant's pictures of its cases, one after the other."""
    if mutant.file.startswith("kernels/"):
        with _patched(mutant, kernel_folder(), "kernels") as root:
            opened = Device(device, kernels=root / "kernels")
            for case in mutant.cases:
                with _in_haste(opened):
                    picture = our_picture(_small(case), opened)
                yield case, picture
        return
    with _patched(mutant, PACKAGE, "clrt") as root:
        for folder in _BESIDE:
            if (PACKAGE.parent / folder).is_dir():
                (root / folder).symlink_to(PACKAGE.parent / folder)
        yield from _by_child(root, mutant.cases, device)


@contextmanager
def _in_haste(device: Device) -> Iterator[None]:
    """Build without optimising, which takes Intel's compiler a quarter of the time; the bits are the same.

    For kernels that render a small picture once. Only those of the mutant may be built meanwhile.
    """
    before = os.environ.get(_MORE_OPTIONS)
    if device.info.platform == intel.PLATFORM:
        os.environ[_MORE_OPTIONS] = f"{before or ''} -cl-opt-disable".strip()
    try:
        yield
    finally:
        os.environ.pop(_MORE_OPTIONS, None)
        if before is not None:
            os.environ[_MORE_OPTIONS] = before


@contextmanager
def _patched(mutant: Mutant, folder: Path, name: str) -> Iterator[Path]:
    """A folder that holds a copy of `folder`, called `name`, with the fault planted."""
    with tempfile.TemporaryDirectory(prefix="clrt-mutant-") as place:
        root = Path(place)
        shutil.copytree(folder, root / name, ignore=shutil.ignore_patterns("__pycache__"))
        file = root / mutant.file
        text = file.read_text(encoding="utf-8")
        if text.count(mutant.old) != 1:
            raise ClrtError(f"{mutant.file}: {mutant.name!r} must replace a text that stands there once, "
                            f"and it does {text.count(mutant.old)} times: {mutant.old}")  # fmt: skip
        file.write_text(text.replace(mutant.old, mutant.new), encoding="utf-8")
        yield root


def _by_child(root: Path, cases: tuple[str, ...],
              device: int | str | None) -> Iterator[tuple[str, OracleImage]]:
    """Pictures by a process in which `root` comes first among the places to import from."""
    path = os.pathsep.join(filter(None, (str(root), os.environ.get("PYTHONPATH"))))
    request = pickle.dumps((cases, device))
    child = subprocess.run([sys.executable, "-P", "-W", "ignore", "-c", _CHILD], input=request, cwd=root,
                           env={**os.environ, "PYTHONPATH": path}, capture_output=True,
                           timeout=_SECONDS)  # fmt: skip
    if child.returncode:
        raise ClrtError(f"the patched package failed: {child.stderr.decode(errors='replace')[-2000:]}")
    package, pictures = pickle.loads(child.stdout)
    if Path(package) != root / "clrt":
        raise ClrtError(f"the package of {package} was imported in place of the patched one")
    yield from zip(cases, pictures, strict=True)


def render_for_parent() -> None:
    """In the child: pictures of the cases that standard input names, to standard output."""
    cases, device = pickle.load(sys.stdin.buffer)
    answers = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)  # what a driver prints must not get in between
    opened = Device(device)
    pictures = [our_picture(_small(case), opened) for case in cases]
    with answers:
        pickle.dump((str(PACKAGE), pictures), answers)
