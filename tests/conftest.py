"""Fixtures that several test files use."""

from __future__ import annotations

import signal
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from browser import Browser, installed
from validation.oracle_mitsuba import Mitsuba

collect_ignore = ["example_project"]  # another project: tests/judging/test_plugin.py runs it

# once, not once a process: a fixture that takes a minute; kernels of which all have to be launched
TOGETHER = ("tests/validation/test_validation.py", "tests/device/test_oclgrind.py")


def pytest_configure(config: pytest.Config) -> None:
    """Let processes that tests start hear the signals that this one ignores, as jobs in the background do:
    what is ignored is inherited, a handler is not."""
    for name in ("SIGINT", "SIGHUP"):
        number = getattr(signal, name, None)
        if number is not None and signal.getsignal(number) == signal.SIG_IGN:
            signal.signal(number, lambda *_: None)


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config: pytest.Config, log: Any) -> Any:
    """Tests go to the processes one by one, those of TOGETHER to one process, first of all.

    (pytest-xdist 3.8 has marks for this, which pytest 9.2 lets it set without effect.)
    """
    from xdist.scheduler import LoadScopeScheduling

    class Scheduling(LoadScopeScheduling):
        def _split_scope(self, nodeid: str) -> str:
            file = nodeid.partition("::")[0]
            return file if file in TOGETHER else nodeid

    return Scheduling(config, log)


@pytest.fixture(scope="module")
def chromium(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Browser]:
    """A headless browser."""
    if not installed():
        pytest.fail("nothing is proven: no chromium here; apt-get install chromium, or -m 'not browser'")
    with Browser(tmp_path_factory.mktemp("profile")) as opened:
        yield opened


@pytest.fixture(scope="session")
def shared_folder() -> Path:
    """The folder `shared` beside the repository, with foreign scenes that are not part of the project."""
    folder = Path(__file__).resolve().parents[2] / "shared"
    if not (folder / "data").is_dir():
        # they are nobody's to ship: `make test` names what it leaves out, and so does pytest's summary
        pytest.skip(f"the foreign scenes are not here: no folder {folder / 'data'}")
    return folder


@pytest.fixture(scope="session")
def mitsuba() -> Iterator[Mitsuba]:
    """Mitsuba in its process. Where it cannot run its tests fail: what they prove is not proven."""
    with Mitsuba() as found:
        reason = found.available()
        if reason is not None:
            pytest.fail(f"nothing is proven: {reason}")
        yield found


@pytest.fixture
def hasty(monkeypatch: pytest.MonkeyPatch) -> None:
    """For kernels with a planted fault, or in a cache of their own, which run once: without optimising,
    Intel's compiler takes a fifth of the time and PoCL's less than half; the bits are the same. Not for
    kernels as they are in this process, which keeps them.
    """
    monkeypatch.setenv("PYOPENCL_BUILD_OPTIONS", "-cl-opt-disable")
