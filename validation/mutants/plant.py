"""Planting a fault in a copy, and pictures of what then runs.

The working tree is never touched: kernels are built from a patched copy of their folder, host code runs in a
process that imports a patched copy of the package.
"""

from __future__ import annotations

import os
import pickle
import shutil
import subprocess
import sys
import tempfile
import threading
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, nullcontext
from pathlib import Path
from typing import Final

from clrt.base.errors import ClrtError
from clrt.base.resources import PACKAGE, kernel_folder
from clrt.device import intel
from clrt.device.device import Device
from clrt.scene.scene import Scene

from ..cases import case_named
from ..oracles import our_picture, scene_of
from ..types import OracleImage

_MORE_OPTIONS: Final = "PYOPENCL_BUILD_OPTIONS"
_BESIDE: Final = ("kernels", "scenes", "validation")  # what a checkout has beside the package
_CHILD: Final = (
    "from clrt.base.resources import validation_module as find; find('mutants.plant').render_for_parent()"
)


def small(case: str) -> Scene:
    """A case's scene at half its size, at which a fault shows as well."""
    scene = scene_of(case_named(case))
    assert scene.camera is not None
    return scene.override(width=scene.camera.width // 2, height=scene.camera.height // 2)


@contextmanager
def patched(file: str, edit: Callable[[str], str]) -> Iterator[Path]:
    """A folder with a copy of the kernels, or of the package beside what it needs; `file` in it is edited."""
    of_kernels = file.startswith("kernels/")
    folder, name = (kernel_folder(), "kernels") if of_kernels else (PACKAGE, "clrt")
    with tempfile.TemporaryDirectory(prefix="clrt-mutant-") as place:
        root = Path(place)
        shutil.copytree(folder, root / name, ignore=shutil.ignore_patterns("__pycache__"))
        text = (root / file).read_text(encoding="utf-8")
        (root / file).write_text(edit(text), encoding="utf-8")
        for beside in () if of_kernels else _BESIDE:
            if (PACKAGE.parent / beside).is_dir():
                (root / beside).symlink_to(PACKAGE.parent / beside)
        yield root


@contextmanager
def in_haste(device: Device) -> Iterator[None]:
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


def pictures_by_child(
    root: Path, cases: Sequence[str], device: int | str | None, seconds: float
) -> Iterator[tuple[str, OracleImage]]:
    """Pictures by a process that takes kernels and package from `root` where it has them, as they are made.

    ClrtError where the process fails, crashes or takes longer than that.
    """
    path = os.pathsep.join(filter(None, (str(root), os.environ.get("PYTHONPATH"))))
    command = [sys.executable, "-P", "-W", "ignore", "-c", _CHILD]
    pipe = subprocess.PIPE
    with tempfile.TemporaryFile() as errors, subprocess.Popen(
        command, stdin=pipe, stdout=pipe, stderr=errors, cwd=root, env={**os.environ, "PYTHONPATH": path}
    ) as child:
        assert child.stdin is not None and child.stdout is not None
        clock = threading.Timer(seconds, child.kill)
        clock.start()
        try:
            with child.stdin as to:
                pickle.dump((str(root), tuple(cases), device), to)
            package = Path(pickle.load(child.stdout))
            if (root / "clrt").is_dir() and package != root / "clrt":
                raise ClrtError(f"the package of {package} was imported in place of the patched one")
            for case in cases:
                yield case, pickle.load(child.stdout)
        except (EOFError, BrokenPipeError, pickle.UnpicklingError):
            ended = child.wait()
            errors.seek(0)
            said = errors.read().decode(errors="replace").strip()[-2000:]
            why = f"no picture within {seconds:g} s" if not clock.is_alive() else said or f"ended by {-ended}"
            raise ClrtError(f"the patched program failed: {why}") from None
        finally:
            clock.cancel()
            child.kill()


def render_for_parent() -> None:
    """In the child: pictures of the cases that standard input names, to standard output."""
    root, cases, device = pickle.load(sys.stdin.buffer)
    answers = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)  # what a driver prints must not get in between
    kernels = Path(root) / "kernels"
    own = kernels.is_dir() and not kernels.is_symlink()
    with answers:
        pickle.dump(str(PACKAGE), answers)
        answers.flush()
        opened = Device(device, kernels=kernels) if own else Device(device)
        for case in cases:
            with in_haste(opened) if own else nullcontext():
                picture = our_picture(small(case), opened)
            pickle.dump(picture, answers)
            answers.flush()
