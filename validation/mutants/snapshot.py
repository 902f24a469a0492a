"""Runs a module in a copy of the checkout, so that what is edited meanwhile changes nothing."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any, Final

from clrt.base.errors import ClrtError
from clrt.base.scratch import scratch

from ..reliability import code

_HELD: Final = ("clrt", "kernels", "scenes", "validation")
_STAMP: Final = "--stamp"


def run(module: str, words: Sequence[str], stamp: dict[str, Any]) -> int:
    """The exit status of `python -m module words --stamp STAMP` in a copy of the checkout.

    stamp: what the checkout was before it was copied. ClrtError where it is something else afterwards.
    """
    with scratch() as root:
        copied(code.ROOT, root)
        if (stamp["commit"], stamp["dirty"]) != code.commit() or not same(code.ROOT, root):
            raise ClrtError("files of the checkout changed while they were copied; run it again")
        path = os.pathsep.join(filter(None, (str(root), os.environ.get("PYTHONPATH"))))
        command = [sys.executable, "-P", "-m", module, *words, _STAMP, json.dumps(stamp)]
        ran = subprocess.run(command, cwd=root, env={**os.environ, "PYTHONPATH": path}, check=False)
        return ran.returncode


def copied(checkout: Path, root: Path) -> None:
    """Copy of a checkout what runs."""
    for name in _HELD:
        shutil.copytree(checkout / name, root / name, ignore=shutil.ignore_patterns("__pycache__"))


def same(one: Path, other: Path) -> bool:
    """Whether two folders hold the same of what runs."""
    return _files(one) == _files(other)


def _files(root: Path) -> dict[str, bytes]:
    files = [file for name in _HELD for file in (root / name).rglob("*") if file.is_file()]
    return {str(file.relative_to(root)): file.read_bytes() for file in files
            if "__pycache__" not in file.parts}  # fmt: skip
