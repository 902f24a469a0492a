"""Makes the manual page and the shells' completion for a wheel (not for an editable install)."""

from __future__ import annotations

import importlib.util
import tempfile
from pathlib import Path
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface


class ShellHook(BuildHookInterface[Any]):
    """Adds them to what the wheel installs beside the package."""

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        if self.target_name != "wheel" or version == "editable":
            return
        root = Path(self.root)
        spec = importlib.util.spec_from_file_location("shell", root / "installers" / "shell.py")
        assert spec and spec.loader
        shell = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(shell)
        self._folder = tempfile.TemporaryDirectory(prefix="clrt-shell-")
        build_data.setdefault("shared_data", {}).update(shell.write(Path(self._folder.name), root))
