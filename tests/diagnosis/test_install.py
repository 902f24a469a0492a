"""The commands that messages name: each works where clrt runs."""

from __future__ import annotations

import importlib.metadata
import shlex
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

from clrt.base import install

ROOT = Path(__file__).resolve().parents[2]


def test_pip_takes_what_an_extra_needs() -> None:
    extras = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["optional-dependencies"]
    for extra, packages in extras.items():
        command = shlex.split(install.install_extra(extra))
        assert command[:4] == [sys.executable, "-m", "pip", "install"]
        names = [package.split(";")[0].strip() for package in packages]
        assert sorted(part.split(";")[0].strip() for part in command[4:]) == sorted(names), extra


def test_pip_knows_the_command() -> None:
    done = subprocess.run(
        [*shlex.split(install.pip_install("numpy")), "--dry-run", "--quiet"], capture_output=True, check=False
    )
    assert done.returncode == 0, done.stderr


def test_where_there_is_no_pip_or_no_metadata(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    def missing(name: str) -> list[str]:
        raise importlib.metadata.PackageNotFoundError(name)

    monkeypatch.setattr(importlib.metadata, "requires", missing)
    test_pip_takes_what_an_extra_needs()  # of a folder that is not installed, what its own file says
    monkeypatch.setattr(install, "PACKAGE", tmp_path / "clrt")
    assert install.install_extra("mesh").endswith("pip install 'clrt[mesh]'")
    monkeypatch.setattr(install.importlib.util, "find_spec", lambda name: None)
    assert install.pip_install("a b") == f"uv pip install --python {shlex.quote(sys.executable)} 'a b'"
