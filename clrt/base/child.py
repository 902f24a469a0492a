"""Processes of clrt's own: this Python again, with the clrt that runs here."""

from __future__ import annotations

import os
import re
import sys
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
    """Its variables: a checkout need not be installed."""
    paths = os.pathsep.join(part for part in (str(PACKAGE.parent), os.environ.get("PYTHONPATH")) if part)
    return {**os.environ, "PYTHONPATH": paths, **more}
