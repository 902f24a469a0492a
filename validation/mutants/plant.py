"""Planting a fault in a copy, and pictures of what then runs.

The working tree is never touched: kernels are built from a patched copy of their folder, host code runs in a
process that imports a patched copy of the package.
"""

from __future__ import annotations

import math
import os
import pickle
import re
import shutil
import subprocess
import sys
import tempfile
import threading
from collections.abc import Callable, Collection, Generator, Iterator, Sequence
from contextlib import contextmanager, nullcontext, suppress
from pathlib import Path
from typing import Final

from clrt.base import interrupts
from clrt.base.errors import ClrtError
from clrt.base.resources import PACKAGE, kernel_folder
from clrt.base.scratch import placed, scratch
from clrt.device.cachefolder import VARIABLE as CACHE
from clrt.device.device import Device
from clrt.formats import load_dict
from clrt.scene.scene import Scene

from ..cases import case_named
from ..oracles import our_picture, scene_of, tracer_of
from ..ours import render_ours
from ..types import OracleImage

REFITTED: Final = "refitted "
"""Before the name of a case whose shapes a tracer first has elsewhere."""
_STEP: Final = 0.02  # units, by which they are
_SECONDS: Final = 40  # of processor time that a picture may take, its kernels' build among them
_MEMORY: Final = 12 << 30  # bytes of addresses, of which drivers take much
_MORE_OPTIONS: Final = "PYOPENCL_BUILD_OPTIONS"
_BESIDE: Final = ("kernels", "scenes", "validation")  # what a checkout has beside the package
_ERROR: Final = re.compile(r"[\w.]*(?:Error|Exception|Exit|Interrupt)\b")  # as the last line of a traceback
_FOLDERS: Final = re.compile(r"(?<![\w.~])/(?:[^\s/\"':,;]+/)+")
_LONG: Final = 160
_CHILD: Final = (
    "from clrt.base.resources import validation_module as find; find('mutants.plant').render_for_parent()"
)


class Lost(ClrtError):
    """A program with a fault gave no picture: an error, a crash, too long a time.

    said: what it wrote, all of it; crashed: it ended by itself.
    """

    def __init__(self, said: str, crashed: bool = False) -> None:
        super().__init__(f"the patched program failed: {said}")
        self.said, self.crashed = said, crashed

    @property
    def word(self) -> str:
        """The error that it ended with, in a line without folders."""
        lines = [line.strip() for line in self.said.splitlines() if line.strip()] or [""]
        errors = [line for line in lines if _ERROR.match(line)]
        line = _FOLDERS.sub("", (errors or lines)[-1])
        return line if len(line) <= _LONG else f"{line[:_LONG]}..."


def ended_by(code: int) -> str:
    """How a process ended that wrote nothing."""
    return f"ended by {interrupts.ended_by(code)}" if code < 0 else f"ended with {code}"


def small(case: str) -> Scene:
    """A case's scene at half its size, at which a fault shows as well."""
    scene = scene_of(case_named(case))
    assert scene.camera is not None
    return scene.override(width=scene.camera.width // 2, height=scene.camera.height // 2)


def picture_of(case: str, device: Device) -> OracleImage:
    """Our picture of a case, half its size; where it is refitted, from a tree made for other places."""
    scene = small(case.removeprefix(REFITTED))
    if not case.startswith(REFITTED):
        return our_picture(scene, device)
    tracer = tracer_of(_elsewhere(scene), device)
    tracer.update(scene)
    return render_ours(tracer)


def _elsewhere(scene: Scene) -> Scene:
    """The scene with each shape a little away from its place, all in other directions."""
    table = scene.to_dict()
    for number, shape in enumerate(table["shapes"]):
        if shape["type"] != "plane":
            way = [_STEP * math.cos(number + turn) for turn in (0.0, 2.0, 4.0)]
            shape["transform"] = [*shape.get("transform", ()), {"translate": way}]
    return load_dict(table, folder=scene.folder)


@contextmanager
def patched(file: str, edit: Callable[[str], str]) -> Iterator[Path]:
    """A folder with a copy of the kernels, or of the package beside what it needs; `file` in it is edited."""
    with patched_with([file], lambda _, text: edit(text)) as root:
        yield root


@contextmanager
def patched_with(files: Collection[str], edit: Callable[[str, str], str]) -> Iterator[Path]:
    """The same with several files, all of kernels or none; `edit` is given each one's name and text."""
    of_kernels = all(file.startswith("kernels/") for file in files)
    folder, name = (kernel_folder(), "kernels") if of_kernels else (PACKAGE, "clrt")
    with _copied(folder, name) as root:
        for file in files:
            (root / file).write_text(edit(file, (root / file).read_text("utf-8")), "utf-8")
        for beside in () if of_kernels else _BESIDE:
            if (PACKAGE.parent / beside).is_dir():
                (root / beside).symlink_to(PACKAGE.parent / beside)
        yield root


@contextmanager
def _copied(folder: Path, name: str) -> Iterator[Path]:
    with scratch() as place:
        shutil.copytree(folder, place / name, ignore=shutil.ignore_patterns("__pycache__"))
        yield place


@contextmanager
def in_haste() -> Iterator[None]:
    """Build without optimising, which takes Intel's compiler a quarter of the time and PoCL's 0.4 of it; the
    bits are the same.

    For kernels that render a small picture once. Only those of the mutant may be built meanwhile.
    """
    before = os.environ.get(_MORE_OPTIONS)
    os.environ[_MORE_OPTIONS] = f"{before or ''} -cl-opt-disable".strip()
    try:
        yield
    finally:
        os.environ.pop(_MORE_OPTIONS, None)
        if before is not None:
            os.environ[_MORE_OPTIONS] = before


def pictures_by_child(
    root: Path, cases: Sequence[str], device: int | str | None, seconds: float
) -> Generator[tuple[str, OracleImage], None, None]:
    """Pictures by a process that takes kernels and package from `root` where it has them, as they are made.

    Lost where the process fails, crashes, takes longer than that, or _SECONDS of processor time for one.
    """
    path = os.pathsep.join(filter(None, (str(root), os.environ.get("PYTHONPATH"))))
    command = [sys.executable, "-P", "-W", "ignore", "-c", _CHILD]
    pipe = subprocess.PIPE
    with placed(lambda: tempfile.TemporaryFile()) as errors, subprocess.Popen(
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
            late = f"no picture within {seconds:g} s"
            raise Lost(late if not clock.is_alive() else said or ended_by(ended), True) from None
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
        bound_memory()
        if own:  # nobody else needs what is built, and it goes with the folder
            (Path(root) / "built").mkdir(mode=0o700)
            os.environ[CACHE] = str(Path(root) / "built")
        opened = Device(device, kernels=kernels) if own else Device(device)
        for case in cases:
            bound_time()
            with in_haste() if own else nullcontext():
                picture = picture_of(case, opened)
            pickle.dump(picture, answers)
            answers.flush()


def bound_time(seconds: int = _SECONDS) -> None:
    """End this process once it has used so much more of processor time. (Windows has no such limit.)"""
    with suppress(ImportError):
        import resource

        used = resource.getrusage(resource.RUSAGE_SELF)
        most = math.ceil(used.ru_utime + used.ru_stime) + seconds
        resource.setrlimit(resource.RLIMIT_CPU, (most, resource.getrlimit(resource.RLIMIT_CPU)[1]))


def bound_memory() -> None:
    """Take no more than _MEMORY, whatever a fault makes of a size."""
    with suppress(ImportError):
        import resource

        resource.setrlimit(resource.RLIMIT_AS, (_MEMORY, resource.getrlimit(resource.RLIMIT_AS)[1]))
