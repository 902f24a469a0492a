"""A student's folder: kernels with a fault, scenes, the right picture, what to do, and how far one is.

    DIR/README.md  kernels/  scenes/  right.png  right.exr  exercise.json
"""

from __future__ import annotations

import hashlib
import os
import shutil
import tempfile
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import msgspec

from clrt.base import inputs
from clrt.base.atomic import write_json, write_text
from clrt.base.errors import ClrtError, SceneError
from clrt.base.files import read_bytes, reason
from clrt.base.interrupts import folders, holding
from clrt.base.limits import Limits
from clrt.base.resources import kernel_folder, kernel_text
from clrt.device.foreign import VARIABLE
from clrt.exercises.judge import right_picture
from clrt.exercises.table import HINTS, SCENES, Exercise, exercise
from clrt.version import __version__

_STATE: Final = "exercise.json"
_STATE_BYTES: Final = 1 << 16


class State(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """What a folder's `exercise.json` says."""

    exercise: int
    hints: int  # that were given
    version: str
    kernels: str  # digest of the right ones


@dataclass(frozen=True)
class Started:
    """A student's folder that holds an exercise."""

    folder: Path
    exercise: Exercise
    hints: int  # that were given

    @property
    def kernels(self) -> Path:
        """The kernels that the student mends."""
        return self.folder / "kernels"


def start(number: int, folder: Path, device: int | str | None = None) -> Started:
    """Make a folder for an exercise: it may be there, but empty. Renders the right picture on the device.

    ClrtError where there is no exercise of that number, or the folder cannot be made.
    """
    chosen = exercise(number)
    _check_empty(folder)
    picture = right_picture(chosen.scene, device)
    temporary = None
    try:
        folder.parent.mkdir(parents=True, exist_ok=True)
        with holding():
            temporary = Path(tempfile.mkdtemp(prefix=".clrt-exercise-", dir=folder.parent))
            folders.add(str(temporary))
        temporary.chmod(0o755)
        (temporary / "kernels").mkdir()
        for file in kernel_folder().iterdir():  # one after the other: the first that fails says why
            shutil.copy(file, temporary / "kernels")
        planted = chosen.planted(kernel_text(kernel_folder() / chosen.file))
        (temporary / "kernels" / chosen.file).write_text(planted, encoding="utf-8")
        (temporary / "scenes").mkdir()
        for file in SCENES.iterdir():
            shutil.copy(file, temporary / "scenes")
        picture.save(temporary / "right.png")
        picture.save(temporary / "right.exr")
        write_text(temporary / "README.md", _readme(chosen))
        _write(temporary, State(number, 0, __version__, _digest()))
        if folder.exists():
            folder.rmdir()
        temporary.rename(folder)
    except (OSError, ValueError) as error:
        raise ClrtError(f"{folder}: cannot be made: {reason(error)}") from None
    finally:
        if temporary is not None:
            shutil.rmtree(temporary, ignore_errors=True)
            folders.discard(str(temporary))
    return Started(folder, chosen, 0)


def opened(folder: Path) -> Started:
    """The exercise in a folder. ClrtError where there is none, or one that another version began."""
    try:
        with inputs.watched(False):  # a hint replaces it
            data = read_bytes(folder / _STATE, Limits(file_bytes=_STATE_BYTES))
        state = msgspec.json.decode(data, type=State)
        chosen = exercise(state.exercise)
        if not 0 <= state.hints <= HINTS:
            raise ClrtError(f"{state.hints} hints")
    except SceneError:
        what = f"is no exercise (it has no {_STATE}); `clrt exercise start N DIR` makes one"
        raise ClrtError(f"{folder}: {what}") from None
    except (msgspec.MsgspecError, ClrtError, UnicodeDecodeError) as error:
        raise ClrtError(f"{folder / _STATE}: is not what `clrt exercise start` writes: {error}") from None
    if state.kernels != _digest():
        what = f"it was begun with clrt {state.version}, whose kernels were others"
        raise ClrtError(f"{folder}: {what}; begin again: `clrt exercise start {state.exercise} DIR`")
    return Started(folder, chosen, state.hints)


def next_hint(started: Started) -> str:
    """One hint more, which is noted in the folder; the last one again where all were given."""
    given = min(started.hints + 1, HINTS)
    _write(started.folder, State(started.exercise.number, given, __version__, _digest()))
    return started.exercise.hints[given - 1]


def _write(folder: Path, state: State) -> None:
    write_json(folder / _STATE, msgspec.to_builtins(state))


def _digest() -> str:
    """Of all kernels that ship."""
    digest = hashlib.sha256()
    for file in sorted(kernel_folder().glob("*.cl*")):
        digest.update(f"{file.name} {kernel_text(file)}".encode())
    return digest.hexdigest()[:32]


def _check_empty(folder: Path) -> None:
    try:
        if os.path.lexists(folder) and (folder.is_symlink() or not folder.is_dir()):
            raise ClrtError(f"{folder}: is no folder; give the name of one that is to be made")
        if folder.is_dir() and any(folder.iterdir()):
            raise ClrtError(f"{folder}: is not empty; give the name of a folder that is to be made")
        above = next(parent for parent in folder.absolute().parents if os.path.lexists(parent))
        if not above.is_dir():
            raise ClrtError(f"{folder}: cannot be made: {above} is no folder")
    except (OSError, ValueError) as error:
        raise ClrtError(f"{folder}: cannot be looked at: {reason(error)}") from None


def _readme(chosen: Exercise) -> str:
    scene = f"scenes/{chosen.scene}.toml"
    return f"""# Exercise {chosen.number}: {chosen.title}

One line of the kernels in `kernels/` is wrong. Find it and mend it.

**What is seen.** {chosen.picture}

`right.png` and `right.exr` show `{scene}` as it should be. See what your kernels make of
it, here in this folder:

    export {VARIABLE}=kernels                     # Windows: set {VARIABLE}=kernels
    clrt render {scene} -o mine.png
    clrt render {scene} -o mine.exr --layers all
    clrt compare mine.exr right.exr                 # how far, and why
    clrt explain {scene} X Y                        # the rays of a pixel: what each brings, what blocks it
    {VARIABLE}= clrt explain {scene} X Y              # the same with the right kernels

Then:

    clrt exercise hint .                            # there are {HINTS}, each tells more
    clrt exercise check .                           # is it mended

The check renders all of `scenes/`: whoever mends one thing and breaks another has not mended it. What is
asked for is the place and the reason; that the right kernels lie in clrt's own folder is no secret.
"""
