"""What to type for a package that is not installed: a command that works where clrt runs."""

from __future__ import annotations

import importlib.metadata
import importlib.util
import re
import shlex
import tomllib

from clrt.base import child
from clrt.base.resources import PACKAGE


def pip_install(*packages: str) -> str:
    """The command that installs packages for this Python."""
    python = shlex.quote(child.interpreter() or "python")
    names = " ".join(map(shlex.quote, packages))
    if importlib.util.find_spec("pip") is None:  # environments that uv makes
        return f"uv pip install --python {python} {names}"
    return f"{python} -m pip install {names}"


def install_extra(extra: str) -> str:
    """The command that installs what one of clrt's extras needs.

    It names the packages: clrt itself may have been installed from a folder, and stays as it is.
    """
    try:
        needed = importlib.metadata.requires("clrt") or []
    except importlib.metadata.PackageNotFoundError:  # a checkout that is not installed
        return _of_checkout(extra)
    mark = re.compile(rf"extra == ['\"]{re.escape(extra)}['\"]")
    found = [line for line in needed if mark.search(line)]
    # of the conditions only the extra's own is left out: pip knows the others
    packages = [re.sub(rf"\s*(and\s+|;\s*)?{mark.pattern}", "", line).strip() for line in found]
    return pip_install(*packages) if packages else pip_install(f"clrt[{extra}]")


def _of_checkout(extra: str) -> str:
    """The same where clrt runs from a folder: as its pyproject.toml says, for no index need have a `clrt`."""
    file = PACKAGE.parent / "pyproject.toml"
    try:
        said = tomllib.loads(file.read_text("utf-8"))["project"]["optional-dependencies"]
    except (OSError, ValueError, KeyError):
        said = {}
    return pip_install(*said.get(extra, [f"clrt[{extra}]"]))
