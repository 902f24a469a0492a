"""The command line: how a command is run, and how faults reach the user; a module for each command.

Nothing heavy is imported before the command is known, so that help comes at once.
"""

from __future__ import annotations

import atexit
import os
import sys
import warnings
from collections.abc import Sequence
from contextlib import suppress
from importlib import import_module
from typing import Any, Final, NoReturn

from clrt.base import collector, errors, hush, inputs, interrupts, room
from clrt.base.errors import ClrtError, ClrtWarning, exhausted
from clrt.cli import terminal
from clrt.cli.terminal import FAULT, say

_SAVE: Final = ("render", "convert", "explain", "plot-spectrum", "sweep", "turntable")
"""Commands that have done what they should once their file is saved, whatever becomes of the terminal."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command; return 0, 1 (a check failed), 2 (one line on stderr says why) or 130 (Ctrl-C)."""
    with terminal.surviving() as (out, _), warnings.catch_warnings(), inputs.watched():
        warnings.simplefilter("ignore")
        warnings.simplefilter("always", ClrtWarning)
        warnings.showwarning = _show_warning
        command = ""
        interrupts.saved.clear()
        try:
            interrupts.catching()
            with collector.beginning():
                from clrt.cli.options import read

                options = read(arguments)
                command = options.command
            errors.has_limit = hasattr(options, "limit")
            room.check_room()
            terminal.tell_more(options.verbose)
            with collector.beginning():
                run = import_module(f"clrt.cli.{command.replace('-', '_')}").run
            code: int = run(options)
        except ClrtError as error:
            code = say(f"error: {error}", FAULT)
        except Exception as error:
            if interrupts.came():  # a library took the interrupt for a fault of its own
                return interrupted()
            spent = exhausted(error)
            if not spent:
                raise
            code = say(f"error: {spent}", FAULT)
        except KeyboardInterrupt:
            return interrupted()
        except SystemExit as leaving:  # argparse has said all: help, or what is wrong
            code = leaving.code if isinstance(leaving.code, int) else 0
        finally:
            errors.has_limit = True
            terminal.tell_more(0)
        out.flush()
        lost = out.failure is not None and not isinstance(out.failure, BrokenPipeError)  # who left saw enough
        if lost and code == 0 and (command not in _SAVE or options.output in ("-", [])):
            assert out.failure is not None
            reason = out.failure.strerror or out.failure
            return say(f"error: the answer cannot be written to standard output: {reason}", FAULT)
        return code


def program() -> NoReturn:
    """`main` as a process. After Ctrl-C it ends at once: Python would wait for what the device still does."""
    os.environ["PYTHONSAFEPATH"] = "1"  # processes that are started import nothing from the current folder
    # numpy's threads wait for work by turning: 0.1 s of a start; and what is multiplied here is small
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    interrupts.install()
    terminal.hold_closed()
    hush.take()
    try:
        code = main()
        interrupts.finished()
    except KeyboardInterrupt:  # between two lines of `main`
        with terminal.surviving():
            code = interrupted()
    if code == interrupts.code():
        interrupts.sweep()
        os._exit(code)
    _leave(code)


def _leave(code: int) -> NoReturn:
    """End the process; not by `sys.exit`, for taking apart drivers and modules takes a tenth of a second."""
    atexit._run_exitfuncs()  # in public only the end of the interpreter runs them, and that takes long
    for stream in (sys.stdout, sys.stderr):
        with suppress(OSError, ValueError, AttributeError):  # `terminal` has told of it; None: there is none
            stream.flush()
    os._exit(code)


def interrupted(checkpoint: str | None = None) -> int:
    """Say what is left of a command that was interrupted; return its exit code."""
    kept = os.path.realpath(checkpoint) if checkpoint else ""
    saved = [str(path) for path in interrupts.saved if str(path) != kept]
    left = f"saved: {', '.join(saved)}" if saved else "nothing was saved"
    if not saved and os.path.exists(kept):
        left = f"{checkpoint} holds what is finished: the same command goes on from there"
    code = say(f"{interrupts.word()}; {left}", interrupts.code())
    hush.for_good()  # libraries complain of what they have to give up
    return code


def _show_warning(
    message: Warning | str, category: Any, filename: str, lineno: int, file: Any = None, line: Any = None
) -> None:
    say(f"warning: {message}")
