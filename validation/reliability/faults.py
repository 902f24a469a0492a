"""Each call of the driver and of the disk fails once: the right error, nothing leaked, the next render works.

The calls of one whole run are counted: read a scene with a mesh and a sky, open the device, build, render
with layers, save. Then the run is repeated, and in each repetition another call fails. After it

* either the run succeeded all the same, with the same bits (what did not fit was split, what failed to build
  was built again), or it ended in a `ClrtError` of the class that belongs to the fault, in one line;
* no buffer of the failed run is left, the picture's file is the old one, and there is no other file;
* the same run then gives the same bits.
"""

from __future__ import annotations

import gc
import multiprocessing
import tempfile
import time
from collections import Counter
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Final
from unittest import mock

import clrt
from clrt.base.errors import ClrtError, DeviceError, LimitError, SceneError
from clrt.device import driver as driver_module
from clrt.device.tracks import Track
from clrt.images.image import Image

from .figures import Figure, Tell, listed
from .injection import injected
from .scene import write_scene

PROCESSES: Final = 2
PIECE: Final = 50  # calls a process: a driver keeps some 20 MB of each context that it has opened
_RIGHT: Final[dict[str, tuple[type[ClrtError], ...]]] = {
    "driver": (DeviceError,),
    "build": (DeviceError,),
    "launch": (DeviceError,),
    "copy": (DeviceError,),
    "fill": (DeviceError,),
    "wait": (DeviceError,),
    "memory": (LimitError,),
    "read": (SceneError, DeviceError, ClrtError),
    "write": (ClrtError,),
}


def run(count: int, tell: Tell) -> Figure:
    """Let `count` calls fail, evenly chosen from all; all of them, where there are not so many."""
    start = time.perf_counter()
    outcomes: Counter[str] = Counter()
    found: list[str] = []
    with multiprocessing.get_context("spawn").Pool(PROCESSES, maxtasksperchild=1) as pool:
        calls = pool.apply(_calls)
        chosen = range(0, len(calls), max(1, len(calls) // count))
        pieces = [chosen[first : first + PIECE] for first in range(0, len(chosen), PIECE)]
        for ended, wrong in pool.imap_unordered(_let_fail, pieces):
            outcomes += ended
            found += [f"call {call} ({', '.join(calls[call])}): {text}" for call, text in wrong]
            tell(outcomes.total() / len(chosen))
    ended_in = f"{outcomes['error']} of {len(calls)} calls ended in an error"
    detail = f"{ended_in}, {outcomes['picture']} in the picture"
    return Figure(len(chosen), len(found), detail + listed(sorted(found)), time.perf_counter() - start)


@contextmanager
def _prepared() -> Iterator[tuple[Path, Path, str]]:
    """The scene, the picture's file and its hash. Compiles, so that all later runs make the same calls."""
    with tempfile.TemporaryDirectory(prefix="clrt-faults-") as name:
        scene, out = write_scene(Path(name)), Path(name) / "out.exr"
        yield scene, out, whole_run(scene, out).hash


def _calls() -> list[tuple[str, str]]:
    """The calls that a whole run makes: which, and whose fault it is where they fail."""
    with _prepared() as (scene, out, _):
        _forget()
        with injected() as plan:
            whole_run(scene, out)
    return plan.calls


def _let_fail(calls: Sequence[int]) -> tuple[Counter[str], list[tuple[int, str]]]:
    """How the runs ended in which one of these calls failed, and after which of them what was wrong."""
    outcomes: Counter[str] = Counter()
    found = []
    with _prepared() as (scene, out, expected):
        for call in calls:
            wrong, ended = one(scene, out, call, expected)
            outcomes[ended] += 1
            if wrong:
                found.append((call, wrong))
    return outcomes, found


def one(scene: Path, out: Path, call: int, expected: str) -> tuple[str, str]:
    """What is wrong after this call failed ('' if nothing is), and how it ended: "error" or "picture"."""
    _forget()
    pools: list[Any] = []  # they know how many buffers are in use, also after their track has gone
    files = {file.name: file.read_bytes() for file in scene.parent.iterdir()}
    begin = Track.__init__

    def noted(track: Track, *arguments: Any) -> None:
        begin(track, *arguments)
        pools.append(track.pool)

    wrong, ended = "", "picture"
    try:
        with injected(call) as plan, mock.patch.object(Track, "__init__", noted):
            picture = whole_run(scene, out)
        if picture.hash != expected:
            wrong = "another picture"
        del picture
    except ClrtError as error:
        ended, kind = "error", plan.calls[call][1]
        if not isinstance(error, _RIGHT[kind]) or "\n" in str(error):
            wrong = f"{type(error).__name__}: {error}"
        if {file.name: file.read_bytes() for file in scene.parent.iterdir()} != files:
            wrong = wrong or "a file has changed"
    except Exception as error:  # what must not happen is reported, not raised
        wrong = f"foreign {type(error).__name__}: {error}"
    gc.collect()
    left = sum(pool.active_blocks for pool in pools)
    if left:
        wrong = wrong or f"{left} buffers left"
    if whole_run(scene, out).hash != expected:
        wrong = wrong or "the next picture differs"
    return wrong, ended


def whole_run(scene: Path, out: Path) -> Image:
    """Everything that a command does, from the file to the file."""
    settings = clrt.Settings(tile=256)
    image = clrt.render(clrt.load(scene), layers=("depth", "reflection"), settings=settings)
    image.save(out)
    return image


def _forget() -> None:
    """Let the next run open the device and load the program anew, as in a process of its own."""
    driver_module._context.cache_clear()
    driver_module._program.cache_clear()
    gc.collect()
