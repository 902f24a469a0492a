"""Charts are the same for everybody, whatever stands in folders of settings or the environment."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

import clrt
from clrt.images import plotting

PLOT = [sys.executable, "-m", "clrt", "plot-spectrum", "D65", "-o", "out.png"]
LATEX = "text.usetex: True\nfont.size: 40\nsavefig.facecolor: red\nfigure.figsize: 2, 2\n"


def _plotted(folder: Path, **environment: str) -> bytes:
    """The plot that a process makes in this folder."""
    told = {"XDG_CONFIG_HOME": str(folder / "config"), **environment}
    done = subprocess.run(PLOT, cwd=folder, env={**os.environ, **told}, capture_output=True, timeout=60)
    assert (done.returncode, done.stderr) == (0, b""), done.stderr
    return (folder / "out.png").read_bytes()


@pytest.fixture(scope="module")
def usual(tmp_path_factory: pytest.TempPathFactory) -> bytes:
    return _plotted(tmp_path_factory.mktemp("usual"))


FILES: dict[str, Callable[[Path], Any]] = {
    "other values": lambda path: path.write_text(LATEX),
    "not UTF-8": lambda path: path.write_bytes(b"font.size: \xff"),
    "a pipe": os.mkfifo,
}


@pytest.mark.parametrize("what", FILES)
@pytest.mark.parametrize("place", [".", "config/matplotlib", "given", "config"])
def test_files_of_settings_are_not_read(what: str, place: str, tmp_path: Path, usual: bytes) -> None:
    (tmp_path / place).mkdir(parents=True, exist_ok=True)
    FILES[what](tmp_path / place / "matplotlibrc")
    named = {"given": str(tmp_path / "given"), "config": "config/matplotlibrc"}
    assert _plotted(tmp_path, MATPLOTLIBRC=named.get(place, "")) == usual


def test_styles_of_the_user_are_not_read(tmp_path: Path, usual: bytes) -> None:
    styles = tmp_path / "config" / "matplotlib" / "stylelib"
    styles.mkdir(parents=True)
    os.mkfifo(styles / "own.mplstyle")
    assert _plotted(tmp_path) == usual


@pytest.mark.parametrize("backend", ["xyz", "TkAgg", "module://nothing", "agg", ""])
def test_the_environments_backend_is_not_asked_for(backend: str, tmp_path: Path, usual: bytes) -> None:
    assert _plotted(tmp_path, MPLBACKEND=backend) == usual


IMPORTED = """
import os, sys
sys.path.insert(0, os.getcwd())
import matplotlib
matplotlib.rcParams["font.size"] = 40
matplotlib.rcParams["savefig.facecolor"] = "red"
before = dict(matplotlib.rcParams)
from clrt.images.plotting import save
from clrt.spectra.plot import draw
save(draw("D65"), "out.png")
assert dict(matplotlib.rcParams) == before
"""


def test_a_program_keeps_its_own_settings(tmp_path: Path, usual: bytes) -> None:
    subprocess.run([sys.executable, "-c", IMPORTED], cwd=tmp_path, check=True, timeout=60)
    assert (tmp_path / "out.png").read_bytes() == usual


RESTORED = """
import os
from clrt.images.plotting import known_formats
before = os.getcwd(), dict(os.environ)
assert {"png", "svg", "pdf"} <= known_formats()
assert (os.getcwd(), dict(os.environ)) == before
os.mkdir("gone"); os.chdir("gone"); os.rmdir("../gone")
"""


def test_folder_and_environment_are_put_back(tmp_path: Path) -> None:
    environment = {**os.environ, "MPLBACKEND": "xyz"}
    subprocess.run([sys.executable, "-c", RESTORED], cwd=tmp_path, check=True, timeout=60, env=environment)
    begin, end = RESTORED.index("before ="), RESTORED.index("os.mkdir")
    gone = RESTORED[:begin] + RESTORED[end:] + "known_formats()\nassert os.stat('.').st_nlink == 0\n"
    subprocess.run([sys.executable, "-c", gone], cwd=tmp_path, check=True, timeout=60, env=environment)


def test_without_matplotlib_it_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delitem(sys.modules, "matplotlib", raising=False)
    monkeypatch.setattr(plotting.importlib.util, "find_spec", lambda name: None)
    with pytest.raises(clrt.ClrtError, match="charts need matplotlib; install it with: "), plotting.drawing():
        pass
