"""Processes of clrt's own: this Python again, with the clrt that runs here."""

from __future__ import annotations

import os
import re
import sys
from contextlib import suppress
from typing import Final

from clrt.base.resources import PACKAGE

_PYTHONS: Final = re.compile(r"python|pypy|graalpy|mayapy|hython", re.IGNORECASE)


def interpreter() -> str | None:
    """What runs Python's programs here. None within a program that holds Python, or was frozen: it would be
    started in its place, and do all that it does again."""
    frozen = getattr(sys, "frozen", False)
    known = not frozen and _PYTHONS.search(os.path.basename(sys.executable or ""))
    return sys.executable if known else None


def command(module: str, *arguments: str) -> list[str]:
    """What runs a module of clrt, wherever it is started; OSError where nothing can (`interpreter`)."""
    python = interpreter()
    if python is None:
        raise FileNotFoundError(f"{sys.executable or 'this program'} is no Python that could be started")
    return [python, "-P", "-m", module, *arguments]


def environment(**more: str) -> dict[str, str]:
    """Its variables: what this process finds packages in, which it may have been told only as it ran.

    But not what was put there for the script, or the folder, that was started: anything may lie there.
    """
    script = getattr(sys.modules.get("__main__"), "__file__", None)
    apart = {os.path.dirname(os.path.abspath(script)) if script else ""}
    with suppress(OSError):  # it may have been removed
        apart.add(os.getcwd())
    found = [path for path in sys.path if os.path.isabs(path) and path not in apart]
    paths = dict.fromkeys([str(PACKAGE.parent), *found, *filter(None, [os.environ.get("PYTHONPATH")])])
    return {**os.environ, "PYTHONPATH": os.pathsep.join(paths), **more}
