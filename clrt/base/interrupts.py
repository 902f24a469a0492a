"""Ctrl-C, SIGTERM and SIGHUP for clrt as a program: whenever they come, one line and the exit code of shells.

A signal's handler runs between two instructions of Python, wherever those are: also while a library starts,
where an exception may abort the process (OpenImageIO's start is C++ that lets none pass). So the handler
raises KeyboardInterrupt only while `main` stands ready to catch it, and never within an import or what is
`held`: it waits for the end of that, two seconds at most, since that may wait for what never comes. Before,
and on a second signal, it ends the process itself. What it raised may be dropped on the way, by libraries
that take any exception for a no: it is raised again until somebody asks for `word`. A program that only
imports clrt keeps its own handlers.
"""

from __future__ import annotations

import os
import sys
import time

TYPE_CHECKING = False
if TYPE_CHECKING:
    import signal
    from pathlib import Path
    from types import FrameType
    from typing import NoReturn
else:
    import _signal as signal  # what `signal` wraps, a hundred times sooner there: nothing is caught before

temporaries: set[Path] = set()
"""Files that are being written, to be removed before the process ends."""

folders: set[str] = set()
"""Folders of such files, to be removed with all that is in them."""

helpers: set[int] = set()
"""Processes that write there for this one, to be ended before."""

saved: list[Path] = []
"""The files that were written last, to be told after an interrupt."""

held: list[bool] = []
"""Holds something while a signal waits as within an import; not empty within `holding`."""

errors_to = 2
"""The descriptor that leads to standard error."""

_NAMES = ("SIGINT", "SIGTERM", "SIGHUP")
_KILL = 9  # on Windows, too, where it has no name
_MOST = 8  # that are told
_TRIES = 20  # to remove a folder
_AGAIN = 0.01  # seconds until a signal that came within an import is looked at again
_PATIENCE = 2.0  # seconds that an import may go on after a signal
_DROPPED = 0.1  # seconds until it is looked whether what was raised is still on its way
_LOST = 0.5  # seconds until a signal follows one that another thread took: Python 3.11 sleeps over that one
_installed: list[int] = []
_main: FrameType | None = None  # where KeyboardInterrupt is caught; None: nowhere
_received: int | None = None
_waiting: int | None = None
_since = 0.0  # when it came
_said = False


class holding:
    """A block in which a signal waits: a process is started, which must be told what for; a folder is made,
    which must be noted. Blocks may lie within each other, and run in several threads.
    """

    def __enter__(self) -> None:
        held.append(True)

    def __exit__(self, *_: object) -> None:
        held.pop()


def ended_by(code: int) -> str:
    """How a process ended whose exit code is negative, as Python tells it: "SIGSEGV", or "signal 40"."""
    from signal import Signals

    try:
        return Signals(-code).name
    except ValueError:  # most of the real-time signals have no name
        return f"signal {-code}"


def is_program() -> bool:
    """Whether this process is `clrt` or `python -m clrt`, as far as its first import can know.

    A process that such a one has spawned has its name, too; it is ended by the one that did.
    """
    if sys.orig_argv[-1:] and sys.orig_argv[-1].endswith("multiprocessing-fork"):
        return False
    name = getattr(sys, "argv", [""])[0]
    if name == "-m":  # so far: the module is only being looked for
        given = sys.orig_argv
        return given[given.index("-m") + 1 :][:1] == ["clrt"] if "-m" in given else False
    return os.path.basename(name) in ("clrt", "clrt.exe")


def install() -> None:
    """Catch the signals that nobody ignores (`nohup`, jobs in the background) or catches already."""
    for name in _NAMES:
        number = getattr(signal, name, None)
        if number is not None and signal.getsignal(number) in (signal.SIG_DFL, signal.default_int_handler):
            signal.signal(number, _caught)
            _installed.append(number)
    if _installed and hasattr(signal, "setitimer"):
        signal.signal(signal.SIGALRM, _look_again)
        sys.unraisablehook = _dropped


def catching() -> None:
    """From now on the caller catches KeyboardInterrupt."""
    global _main
    _main = sys._getframe(1)


def running() -> bool:
    """Whether this process is one of a command of clrt, as far as it has begun."""
    return _main is not None


def finished() -> None:
    """All is done: what comes now changes nothing any more."""
    _stop_looking()
    for number in _installed:
        signal.signal(number, signal.SIG_IGN)


def came() -> bool:
    """Whether a signal was raised as KeyboardInterrupt, whatever became of that."""
    return _received is not None


def code() -> int:
    """The exit code after a KeyboardInterrupt: 130, as shells expect after Ctrl-C, or that of the signal."""
    _stop_looking()  # who asks has caught it
    return 128 + (_received or signal.SIGINT)


def word() -> str:
    """What happened, to begin the last line with; who asks for it says it."""
    global _said
    _said = True
    _stop_looking()
    return _word(_received or signal.SIGINT)


def sweep() -> None:
    """End the helpers; remove files that are being written, and the folders of those that nobody keeps."""
    for number in tuple(helpers):  # never of another process: nobody has waited for the end of these
        try:  # noqa: SIM105
            os.kill(number, _KILL)
        except OSError:  # it has ended
            pass
    for folder in tuple(folders):  # `tempfile`, which made it, has imported what removes it
        for _ in range(_TRIES):  # a driver's threads go on writing there
            sys.modules["shutil"].rmtree(folder, ignore_errors=True)
            if not os.path.lexists(folder):
                break
    for path in tuple(temporaries):
        try:  # noqa: SIM105 (contextlib takes long to import, and nothing is caught before)
            os.unlink(path)
        except OSError:
            pass


def note_saved(path: Path) -> None:
    """A file has been replaced, and stays."""
    if not any(folder in map(str, path.parents) for folder in folders):
        saved.append(path)
        del saved[:-_MOST]


def _caught(number: int, frame: FrameType | None) -> None:
    global _received, _since, _waiting
    if _main is None or _received is not None or (_waiting is not None and number != signal.SIGALRM):
        _leave(_received or _waiting or number)
    number = _waiting or number
    if (held or _within_import(frame)) and hasattr(signal, "setitimer"):
        if _waiting is None:
            _waiting, _since = number, time.monotonic()
        elif time.monotonic() - _since > _PATIENCE:
            _leave(number)
        signal.setitimer(signal.ITIMER_REAL, _AGAIN, _LOST)
        return
    _waiting, _received = None, number
    if hasattr(signal, "setitimer"):
        signal.setitimer(signal.ITIMER_REAL, _DROPPED, _LOST)
    raise KeyboardInterrupt


def _look_again(number: int, frame: FrameType | None) -> None:
    if _waiting is not None:
        _caught(number, frame)
    elif _received is not None and not _said:
        signal.setitimer(signal.ITIMER_REAL, _DROPPED, _LOST)
        if not (held or _within_import(frame) or _on_its_way(sys.exc_info()[1])):
            raise KeyboardInterrupt


def _dropped(told: sys.UnraisableHookArgs) -> None:
    """Python dropped it, in a callback that nothing may leave: it is raised again, so nothing is said."""
    if not isinstance(told.exc_value, KeyboardInterrupt):
        sys.__unraisablehook__(told)


def _on_its_way(handled: BaseException | None) -> bool:
    """Whether what runs now does so because of a KeyboardInterrupt: it tidies up, or tells."""
    while handled is not None and not isinstance(handled, KeyboardInterrupt):
        handled = handled.__context__
    return handled is not None


def _stop_looking() -> None:
    if _installed and hasattr(signal, "setitimer"):
        signal.setitimer(signal.ITIMER_REAL, 0.0)


def _within_import(frame: FrameType | None) -> bool:
    """Whether an exception raised here may not reach `main`: a module begins, an object ends, or a signal is
    being answered.
    """
    here = _caught.__code__.co_filename
    while frame is not None and frame is not _main:
        file = frame.f_code.co_filename
        if file.startswith("<frozen importlib") or file == here or frame.f_code.co_name == "__del__":
            return True
        frame = frame.f_back
    return False


def _leave(number: int) -> NoReturn:
    """End the process at once."""
    sweep()
    if not _said:
        left = f"saved: {', '.join(map(_plain, saved))}" if saved else "nothing was saved"
        try:  # noqa: SIM105
            os.write(errors_to, f"clrt: {_word(number)}; {left}\n".encode(errors="replace"))
        except OSError:  # nobody reads it
            pass
    os._exit(128 + number)


def _plain(path: Path) -> str:
    return "".join(letter if letter.isprintable() else "?" for letter in str(path))


def _word(number: int) -> str:
    name = next(name for name in _NAMES if getattr(signal, name, None) == number)
    return "interrupted" if name == "SIGINT" else f"interrupted by {name}"
