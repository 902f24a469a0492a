"""The process that runs Mitsuba: what it says when something is missing, crashes or hangs."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Any

import pytest

from validation.oracle_mitsuba import Mitsuba, MitsubaError, client


def test_a_crash_is_reported_and_survived() -> None:
    with Mitsuba() as mitsuba:
        with pytest.raises(MitsubaError, match="ended by SIGABRT during 'crash'"):
            mitsuba.request("crash", None)
        assert mitsuba.versions()["mitsuba"]
        with pytest.raises(MitsubaError, match=r"KeyError: 'nothing'"):
            mitsuba.request("nothing", None)


def test_a_process_that_hangs_is_ended_and_started_anew() -> None:
    with Mitsuba() as mitsuba:  # its process has yet to load Mitsuba, so it cannot answer at once
        with pytest.raises(MitsubaError, match=r"no answer to 'versions' in 1e-06 s"):
            mitsuba.request("versions", None, 1e-6)
        assert mitsuba.request("versions", None)["variant"] == "llvm_ad_rgb"


def test_missing_parts_are_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(client, "find_llvm", lambda: None)
    assert "pip install karellen-llvm-core" in Mitsuba().available()
    monkeypatch.setattr(client.importlib.util, "find_spec", lambda name: None)
    assert "install it with: " in Mitsuba().available()


def test_an_llvm_that_is_none_is_named(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("DRJIT_LIBLLVM_PATH", str(tmp_path / "libLLVM.so"))
    with Mitsuba() as mitsuba:
        assert mitsuba.available() is not None


def test_why_it_does_not_run_is_no_traceback(monkeypatch: pytest.MonkeyPatch) -> None:
    """As where memory for its libraries is short: `clrt doctor` prints it."""
    with Mitsuba() as mitsuba:
        request = mitsuba.request
        monkeypatch.setattr(mitsuba, "request", lambda *_: request("nothing", None))
        assert mitsuba.available() == "Mitsuba's process failed at 'nothing': KeyError: 'nothing'"


def test_versions_are_the_pinned_ones(mitsuba: Any) -> None:
    project = tomllib.loads((Path(__file__).parents[2] / "pyproject.toml").read_text())
    pinned = project["project"]["optional-dependencies"]["validation"]
    assert f"mitsuba=={mitsuba.versions()['mitsuba']}" in pinned
