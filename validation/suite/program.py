"""A renderer that somebody else wrote, as a command: it is handed a scene's file and has to write a picture.

    myrt {scene.toml} -o {out.exr}

The text is split as a shell would, but no shell sees it. The program runs in a folder of its own, which is
removed afterwards, in a process group of its own, which is ended with it, as is what left the group (on
Linux), and with who runs it, however that ends (outlive.py); what it writes is read as any picture is,
within `Limits`.
"""

from __future__ import annotations

import os
import re
import shlex
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import numpy as np

from clrt.base.errors import ClrtError, one_line, show
from clrt.base.interrupts import ended_by
from clrt.base.limits import Limits
from clrt.base.scratch import placed, scratch
from clrt.images.file import read_samples
from clrt.judging.verdict import RADIANCE, bits_of_file
from clrt.scene.scene import Scene

from ..compare.layers import read_layers
from . import outlive
from .outlive import end_group, end_strays
from .scenefiles import FORMATS, write_scene

PICTURES: Final = (".exr", ".png")
TIMEOUT: Final = 60.0  # seconds of wall time for a picture
_PLACE: Final = re.compile(r"\{([^{}]*)\}")
_NUMBERS: Final = ("width", "height", "spp", "depth")
_LAST_WORDS: Final = 2000  # bytes of what the program said
_LOOK: Final = 0.02  # seconds


@dataclass(frozen=True)
class Rendered:
    """What came of a run: a picture, or why there is none."""

    pixels: np.ndarray | None
    layers: dict[str, np.ndarray]
    seconds: float
    failure: str = ""
    bits: int = RADIANCE  # of a sample of its file


@dataclass(frozen=True)
class Program:
    """A command with its places for files. `parse` makes one."""

    text: str
    arguments: tuple[str, ...]
    scene_suffix: str
    out_suffix: str
    timeout: float = TIMEOUT

    @property
    def name(self) -> str:
        return os.path.basename(self.arguments[0])

    @property
    def integer(self) -> bool:
        """Whether its pictures hold no radiance above 1."""
        return self.out_suffix == ".png"

    def unable(self, scene: Scene, origin: Path | None = None) -> str:
        """Why its format has no words for a scene; "" where it has."""
        with scratch() as name:
            try:
                write_scene(scene, name.resolve() / f"scene{self.scene_suffix}", origin)
            except ClrtError as error:
                return str(error)
        return ""

    def render(self, scene: Scene, origin: Path | None = None) -> Rendered:
        """Its picture, from the scene's camera. ClrtError where its format has no words for the scene.

        origin: the scene's own file, if it has one.
        """
        assert scene.camera is not None
        camera = scene.camera
        with scratch() as name:
            folder = name.resolve()
            file, out = folder / f"scene{self.scene_suffix}", folder / f"out{self.out_suffix}"
            write_scene(scene, file, origin)
            places = {
                f"scene{self.scene_suffix}": str(file), f"out{self.out_suffix}": str(out),
                "width": str(camera.width), "height": str(camera.height), "spp": str(camera.spp),
                "depth": str(scene.max_depth),
            }  # fmt: skip
            command = [_PLACE.sub(lambda found: places[found[1]], text) for text in self.arguments]
            start = time.monotonic()
            failure = _run(command, folder, self.timeout)
            seconds = time.monotonic() - start
            if failure:
                return Rendered(None, {}, seconds, failure)
            if not os.path.exists(out):  # nor where the folder may not be looked into any more
                return Rendered(None, {}, seconds, f"wrote no picture to {{out{self.out_suffix}}}")
            try:
                pixels = read_samples(out, Limits())
                layers = read_layers(out, Limits()) if self.out_suffix == ".exr" else {}
            except ClrtError as error:
                return Rendered(None, {}, seconds, str(error).replace(str(folder) + os.sep, ""))
            return Rendered(pixels, layers, seconds, bits=bits_of_file(out))


def parse(text: str, timeout: float = TIMEOUT) -> Program:
    """A command from what was typed; ClrtError in one line where it cannot be run.

    Arguments that name files from where the user is become absolute, since it runs elsewhere.
    """
    try:
        words = shlex.split(text)
    except ValueError as error:
        raise ClrtError(f"--against: {show(text)}: {error}") from None
    if not words:
        raise ClrtError(f"--against: {show(text)} names no program")
    if not 0 < timeout < float("inf"):
        raise ClrtError(f"--timeout: {timeout} is not allowed; it must be a number of seconds > 0")
    scenes, outs = set(), set()
    for place in _PLACE.findall(text):
        kind, _, suffix = place.partition(".")
        if kind == "scene" and f".{suffix}" in FORMATS:
            scenes.add(f".{suffix}")
        elif kind == "out" and f".{suffix}" in PICTURES:
            outs.add(f".{suffix}")
        elif place not in _NUMBERS:
            known = [*(f"scene{kind}" for kind in FORMATS), *(f"out{kind}" for kind in PICTURES), *_NUMBERS]
            listed = ", ".join("{" + name + "}" for name in known)
            raise ClrtError(f"--against: {show('{' + place + '}')} stands for nothing; there are {listed}")
    for found, example in ((scenes, "{scene.toml}"), (outs, "{out.exr}")):
        if len(found) != 1:
            how = "names no place" if not found else "names more than one kind of place"
            what = "the scene" if found is scenes else "the picture"
            raise ClrtError(f"--against: {show(text)} {how} for {what}, such as {example}")
    program = shutil.which(words[0])
    if program is None:
        raise ClrtError(f"--against: {show(words[0])}: there is no such program")
    arguments = (os.path.abspath(program), *map(_from_here, words[1:]))
    return Program(text, arguments, scenes.pop(), outs.pop(), timeout)


def _from_here(word: str) -> str:
    with suppress(OSError, ValueError):
        if not _PLACE.search(word) and os.path.isfile(word):
            return os.path.abspath(word)
    return word


def _run(command: list[str], folder: Path, timeout: float) -> str:
    """Run a command in a folder; "" where it ended well, else what went wrong."""
    environment = {**os.environ, "TMPDIR": str(folder)}
    # no name: nothing can take its place
    with placed(lambda: tempfile.TemporaryFile()) as words, _outlived(folder) as outlives:
        try:
            process = subprocess.Popen(
                command, cwd=folder, env=environment, stdin=subprocess.DEVNULL, stdout=words, stderr=words,
                start_new_session=True,
            )  # fmt: skip
        except OSError as error:
            return f"{command[0]}: cannot be started: {error.strerror or error}"
        try:
            outlives(process.pid)
            _bound_files(process.pid)
            code: int | None = process.wait(timeout)
        except subprocess.TimeoutExpired:
            code = None
        finally:
            _end(process)
            end_strays(folder)
        words.seek(max(0, os.fstat(words.fileno()).st_size - _LAST_WORDS))
        text = words.read(_LAST_WORDS)
    if code is None:
        return f"had not ended after {timeout:g} s"
    if code == 0:
        return ""
    how = f"ended by {ended_by(code)}" if code < 0 else f"exit code {code}"
    last = text.decode(errors="replace").replace(str(folder) + os.sep, "").strip().splitlines()
    return one_line(f"{how}: {last[-1]}" if last else how)


def _end(process: subprocess.Popen[bytes]) -> None:
    """Nothing of the group stays, whatever it started."""
    if hasattr(os, "killpg"):
        end_group(process.pid)
    else:
        process.kill()
    process.wait()


@contextmanager
def _outlived(folder: Path) -> Iterator[Callable[[int], None]]:
    """What is told the process group that has to end with the block, however this process ends."""
    if not hasattr(os, "killpg"):
        yield lambda group: None
        return
    command = [sys.executable, "-P", "-S", outlive.__file__, str(folder)]
    watcher = subprocess.Popen(
        command, stdin=subprocess.PIPE, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
        start_new_session=True,
    )  # fmt: skip
    told = watcher.stdin
    assert told is not None
    with watcher:  # which closes it

        def tell(text: str) -> None:
            with suppress(OSError):  # somebody ended it
                os.write(told.fileno(), text.encode())

        try:
            yield lambda group: tell(f"{group}\n")
        finally:
            tell("done\n")


def _bound_files(pid: int) -> None:
    """No file that it writes may be larger than one that is read; where the system can be asked for that."""
    if sys.platform == "linux":
        import resource

        most = Limits().file_bytes
        bound: Callable[..., object] = resource.prlimit
        with suppress(ProcessLookupError, PermissionError, ValueError):
            bound(pid, resource.RLIMIT_FSIZE, (most, most))
