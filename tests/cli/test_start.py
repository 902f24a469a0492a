"""What a command waits for before it works: modules that nobody needs yet, and what the driver does aside."""

from __future__ import annotations

import os
import re
import subprocess
import sys
import threading
from pathlib import Path

import numpy as np
import pytest

from clrt.base.errors import DeviceError, SceneError
from clrt.base.limits import Limits
from clrt.base.resources import PACKAGE
from clrt.cli import main
from clrt.device import ahead, platforms, trial
from clrt.device.driver import Driver
from clrt.device.settings import Settings
from clrt.flatten.flatten import flatten, flatten_ahead
from clrt.formats import load_dict
from clrt.images.image import Image
from clrt.layout import RayFormat

HEAVY = "numpy|pyopencl|OpenImageIO|msgspec|rich|concurrent"
UNASKED = (  # by a render to a .png from a file of a scene, without a terminal
    "numpy.ma|difflib|rich|trimesh|scipy|matplotlib|mitsuba|dask|distributed|http|asyncio|unittest"
    "|clrt.meshfiles.file|clrt.formats.mesh|clrt.formats.mitsuba|clrt.formats.nff|clrt.raytree|clrt.engine.explain"
    "|multiprocessing|clrt.view|clrt.diagnosis|clrt.bench|clrt.judging|clrt.exercises|validation"
)
SCENE = """
[camera]
origin = [0, -5, 0]
target = [0, 0, 0]
width = 8
height = 6
[[lights]]
type = "point"
position = [3, -5, 4]
[[shapes]]
type = "sphere"
center = [0, 0, 0]
radius = 1
"""


def imported(*arguments: str, where: Path) -> tuple[int, set[str]]:
    """What a command ends with, and the modules that it imports."""
    root = str(Path(__file__).resolve().parents[2])
    done = subprocess.run(
        [sys.executable, "-X", "importtime", "-m", "clrt", *arguments], capture_output=True, text=True,
        cwd=where, env={**os.environ, "PYTHONPATH": root}, check=False,
    )  # fmt: skip
    return done.returncode, set(re.findall(r"^import time:.*\| +([\w.]+)$", done.stderr, re.MULTILINE))


def of(found: set[str], packages: str) -> set[str]:
    """Those that are, or are in, one of the packages."""
    return {name for name in found if re.match(rf"({packages})(\.|$)", name)}


def test_help_waits_for_no_library(tmp_path: Path) -> None:
    code, found = imported("render", "--help", where=tmp_path)
    assert code == 0 and "clrt.cli.options" in found and not of(found, HEAVY)


def test_a_wrong_name_waits_for_no_driver(tmp_path: Path) -> None:
    for scene, output in ("missing.toml", "a.png"), ("scene.toml", "a.psd"):
        (tmp_path / "scene.toml").write_text(SCENE)
        code, found = imported("render", scene, "-o", output, where=tmp_path)
        assert code == 2 and not of(found, "pyopencl|OpenImageIO|clrt.engine")


def test_a_render_imports_what_it_needs_and_ends_well(tmp_path: Path) -> None:
    (tmp_path / "scene.toml").write_text(SCENE)
    code, found = imported("render", "scene.toml", "-o", "a.png", "--stats", "a.json", where=tmp_path)
    assert code == 0 and of(found, "pyopencl") and of(found, "OpenImageIO") and of(found, "clrt.engine")
    assert not of(found, UNASKED)
    assert (tmp_path / "a.png").read_bytes()[-8:-4] == b"IEND" and (tmp_path / "a.json").exists()


def test_drivers_load_in_a_folder_of_ours_while_the_block_runs(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    for name in ahead.vendors.PLACES:
        monkeypatch.delenv(name, raising=False)
    seen: list[Path] = []
    begun = threading.Event()

    def load() -> None:
        seen.append(Path.cwd())
        begun.set()
        raise OSError  # which nobody hears of

    monkeypatch.setattr(ahead, "_load", load)
    monkeypatch.setattr(ahead.kernelcache, "prepare", lambda: None)
    monkeypatch.setattr(ahead.interrupts, "running", lambda: True)
    monkeypatch.setattr(ahead.trial, "circumstances", list)
    known = [True, False]
    monkeypatch.setattr(ahead.harmful, "is_known", lambda: known.pop(0) if known else True)
    with ahead.loading():
        assert begun.wait(10)
    assert seen == [PACKAGE] and Path.cwd() == tmp_path
    with ahead.loading():  # one of them may be harmful
        assert Path.cwd() == tmp_path
    assert len(seen) == 1
    monkeypatch.setattr(ahead.trial, "circumstances", lambda: ["POCL_DEBUG=all"])  # a driver may end there
    with ahead.loading():
        assert Path.cwd() == tmp_path
    assert len(seen) == 1


def test_only_what_was_compiled_is_read_back(monkeypatch: pytest.MonkeyPatch) -> None:
    driver, built = Driver(None, Settings(), None), []
    monkeypatch.setattr(driver, "build", lambda source, anew: built.append(source))
    for known in False, True:
        monkeypatch.setattr(driver, "is_compiled", lambda source, known=known: known)
        with ahead.building(driver, RayFormat(bands=5), {}):
            pass
        assert len(built) == known


def test_what_was_flattened_ahead_is_taken_once() -> None:
    data = {"shapes": [{"type": "sphere", "center": [0, 0, 0], "radius": 1}]}
    one, other = load_dict(data), load_dict(data)
    made = flatten_ahead(one)
    assert flatten(other) is not made and flatten(one) is made and flatten(one) is not made


def test_a_scene_that_is_wrong_is_flattened_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[str] = []

    def refuse(path: Path, limits: Limits, levels: bool) -> int:
        asked.append(path.name)
        raise SceneError(f"{path.name}: no picture")

    monkeypatch.setattr("clrt.flatten.images.texture_bytes", refuse)
    (tmp_path / "a.png").write_text("hello")
    camera = "[camera]\norigin = [0, 0, 3]\ntarget = [0, 0, 0]\n"
    ball = '[[shapes]]\ntype = "sphere"\ncenter = [0, 0, 0]\nradius = 1\n'
    (tmp_path / "a.toml").write_text(f'{camera}{ball}material.color = {{type = "image", file = "a.png"}}\n')
    assert main(["render", str(tmp_path / "a.toml"), "-o", str(tmp_path / "a.exr")]) == 2
    assert asked == ["a.png"]


def test_the_runtime_beside_is_loaded_only_where_it_may_be_chosen(monkeypatch: pytest.MonkeyPatch) -> None:
    found = [
        (platforms.DeviceInfo(n, "cpu", name, name, "CPU", 2, 1 << 30, "7"), None)
        for n, name in enumerate(("PoCL 3.0", "PoCL 3.1", "Intel(R) OpenCL"))
    ]
    loaded: list[int] = []

    def listed(beside: bool = True) -> list:
        loaded.extend([1] * beside)
        return found if beside else found[:2]

    good = {"PoCL 3.1"}
    monkeypatch.delenv("CLRT_DEVICE", raising=False)
    monkeypatch.delenv(platforms.VARIABLE, raising=False)
    monkeypatch.setattr(platforms, "listed", listed)
    monkeypatch.setattr(trial, "check_listing", lambda: None)
    monkeypatch.setattr(trial, "circumstances", list)
    monkeypatch.setattr(trial, "is_known_good", lambda info: info.version in good)
    monkeypatch.setattr(trial, "verdict", lambda info: ("" if info.version in good else "broken", False))
    for wanted, index, costs in (None, 1, 0), ("pocl", 0, 0), ("intel", 2, 1), ("1", 1, 1):
        loaded.clear()
        assert platforms.choose(wanted)[0].index == index and len(loaded) == costs
    good.clear()  # no PoCL works
    good.add("Intel(R) OpenCL")
    loaded.clear()
    assert platforms.choose()[0].index == 2 and loaded
    with pytest.raises(DeviceError, match="2: Intel"):
        platforms.choose("voodoo")


def test_masked_numbers_are_refused_once_somebody_has_made_some() -> None:
    pixels = np.ma.masked_less(np.zeros((1, 1, 3), np.float32), 1.0)
    with pytest.raises(Exception, match="3 of its numbers are masked"):
        Image(pixels)
