"""A driver that ends, or holds up, the process that loads it is left out, and another one used."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from clrt.base.errors import ClrtWarning
from clrt.device import harmful, trial, vendors

ENDS = "it ends the process (exit code -6)"
LIBRARY = """#include <stdlib.h>
#include <unistd.h>
__attribute__((constructor)) static void begin(void) {{ {}; }}
"""


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """Two drivers that are announced, of which nothing is known."""
    for name in ("bad", "good"):
        (tmp_path / f"{name}.icd").write_text(f"lib{name}.so\n")
    monkeypatch.setenv(vendors.VARIABLE, str(tmp_path))
    monkeypatch.setattr(vendors, "bundled_folder", lambda: None)
    monkeypatch.setattr(trial, "circumstances", list)
    harmful.harmful.cache_clear()
    yield tmp_path
    harmful.harmful.cache_clear()


def tried(monkeypatch: pytest.MonkeyPatch, *bad: str, anew: bool = True) -> list[str]:
    """Let loading end with these drivers among others; what is loaded then."""
    asked: list[str] = []

    def listing(key: str, variables: dict[str, str] | None = None) -> tuple[str, bool]:
        files = [Path(variables[vendors.VARIABLE])] if variables else vendors.files()
        asked.append(files[0].name if variables else "all")
        return ENDS if {file.name for file in files} & {*bad} else "", anew

    monkeypatch.setattr(trial, "listing", listing)
    return asked


def shown() -> list[str]:
    """The libraries that a loader finds where harmful ones are left out."""
    with harmful.left_out():
        place = Path(os.environ[vendors.VARIABLE])
        files = [place] if place.is_file() else sorted(place.glob("*.icd"))
        return [file.read_text().strip() for file in files]


def test_one_that_ends_the_process_is_left_out_and_told_once(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked = tried(monkeypatch, "bad.icd")
    with pytest.warns(ClrtWarning, match=r"of .*bad\.icd is left out: as it is loaded, it ends .*remove"):
        assert shown() == ["libgood.so"]
    assert os.environ[vendors.VARIABLE] == str(folder) and asked == ["all", "bad.icd", "good.icd"]
    assert shown() == ["libgood.so"] and len(asked) == 3, "asked once a process"
    harmful.harmful.cache_clear()
    tried(monkeypatch, "bad.icd", anew=False)
    assert shown() == ["libgood.so"]  # without a warning: pytest makes an error of it


def test_of_many_those_that_work_are_shown(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (folder / "other.icd").write_text("libother.so\n")
    tried(monkeypatch, "bad.icd", anew=False)
    assert shown() == ["libgood.so", "libother.so"]


def test_what_is_not_known_is_not_loaded_ahead(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A second thread would load them before anybody has tried."""
    known: list[str] = []
    monkeypatch.setattr(trial, "is_known_to_list", lambda key: key in known)
    assert not harmful.is_known()
    known.append(vendors.announced())
    assert harmful.is_known()
    (folder / "new.icd").write_text("libnew.so")
    assert not harmful.is_known()
    monkeypatch.setattr(vendors, "bundled_folder", lambda: folder)
    monkeypatch.setattr(vendors, "vendor_folders", lambda: [folder])
    assert harmful.is_known(), "the one beside pyopencl alone"


def test_where_all_are_harmful_none_is_shown(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    tried(monkeypatch, "bad.icd", "good.icd", anew=False)
    assert shown() == []


def test_the_driver_beside_pyopencl_may_be_the_one(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Of a folder the loader would take it, too; so it is shown one file."""
    beside = folder / ".libs"
    beside.mkdir()
    (beside / "pocl.icd").write_text("libpocl.so\n")
    monkeypatch.setattr(vendors, "bundled_folder", lambda: beside)
    tried(monkeypatch, "pocl.icd", anew=False)
    assert shown() == ["libbad.so"]
    harmful.harmful.cache_clear()
    tried(monkeypatch, "bad.icd", anew=False)
    assert shown() == ["libgood.so"], "with the one beside, which needs no file"


@pytest.mark.parametrize("what", ["alone", "a trial", "OCL_ICD_FILENAMES", "circumstances"])
def test_where_nothing_is_to_be_left_out_nobody_is_tried(
    folder: Path, monkeypatch: pytest.MonkeyPatch, what: str
) -> None:
    asked = tried(monkeypatch, "bad.icd")
    if what == "alone":
        monkeypatch.setattr(vendors, "bundled_folder", lambda: folder)
        monkeypatch.setattr(vendors, "vendor_folders", lambda: [folder])
    elif what == "circumstances":  # which are to blame; whoever asks for devices is told so
        monkeypatch.setattr(trial, "circumstances", lambda: ["POCL_DEBUG=all"])
    elif what == "a trial":
        monkeypatch.setenv("CLRT_TRIAL", trial.LISTING)
    else:
        monkeypatch.setenv(what, "libmine.so")
    assert shown() == ["libbad.so", "libgood.so"] and asked == []


@pytest.mark.usefixtures("hasty")
@pytest.mark.skipif(sys.platform != "linux", reason="elsewhere no loader reads these files")
@pytest.mark.parametrize("ends", ["abort()", "exit(1)", "_exit(0)"])
def test_a_library_that_ends_who_loads_it(ends: str, tmp_path: Path) -> None:
    """A real one, with a loader and a driver; commands ended with it, without a word."""
    compiler = shutil.which("cc")
    if compiler is None:
        pytest.skip("no C compiler here, of which a driver that aborts is made: apt-get install gcc")
    (tmp_path / "bad.c").write_text(LIBRARY.format(ends))
    (tmp_path / "scene.json").write_text('{"camera": {"origin": [0, 0, 4], "target": [0, 0, 0], "width": 4}}')
    bad, drivers = tmp_path / "libbad.so", tmp_path / "drivers"
    subprocess.run([compiler, "-shared", "-fPIC", "-o", bad, tmp_path / "bad.c"], check=True)
    drivers.mkdir()
    for number, vendor in enumerate(vendors.vendors(tried=False)):
        (drivers / f"{number}.icd").write_text(f"{vendor.library}\n")
    (drivers / "bad.icd").write_text(f"{bad}\n")
    environment = {**os.environ, vendors.VARIABLE: str(drivers), "POCL_CACHE_DIR": str(tmp_path / "cache")}
    for times, command in (1, ["hash", "scene.json"]), (0, ["devices"]):
        done = subprocess.run(
            [sys.executable, "-m", "clrt", *command], env=environment, capture_output=True, text=True,
            check=False, cwd=tmp_path,
        )  # fmt: skip
        assert done.returncode == 0 and done.stdout, done
        assert done.stderr.count(f"the driver of {drivers / 'bad.icd'} is left out: ") == times
