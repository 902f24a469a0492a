"""The process that compiles kernels beside a command: it launches what the picture will, and may fail."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

import clrt
from clrt.base import interrupts
from clrt.device import beside, cachefolder, compiler
from clrt.device.device import Device
from clrt.device.platforms import choose, pocl_version
from clrt.device.settings import Settings
from clrt.engine.needed import needed
from clrt.flatten.flatten import flatten
from clrt.layout import RayFormat

GLASS = {"diffuse": 0.2, "reflection": 0.3, "transmission": 0.5, "absorption": [0.1, 0.2, 0.3]}
BALL: dict[str, Any] = {
    "camera": {"origin": [0, 0, 5], "target": [0, 0, 0], "width": 16, "height": 12},
    "lights": [{"type": "point", "position": [3, 4, 5]}],
    "shapes": [{"type": "sphere", "center": [0, 0, 0], "radius": 1}],
}
BALLS = [{"type": "sphere", "center": [0, 0, z], "radius": 1, "material": "a"} for z in (0, -3)]
SCENES: dict[str, dict[str, Any]] = {
    "plain": BALL,
    "dark": {**BALL, "lights": []},
    "glass": {**BALL, "materials": {"a": GLASS}, "shapes": BALLS},
    "tinted": {**BALL, "shadow": "tinted", "materials": {"a": GLASS}, "shapes": BALLS},
}


@pytest.mark.parametrize("name", SCENES)
def test_what_is_compiled_ahead_a_picture_launches(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    scene = clrt.load_dict(SCENES[name])
    flat, launched = flatten(scene), set()
    first = Device._first_launch

    def noted(self: Device, enqueue: Any, sizes: tuple[str, int, bool]) -> Any:
        launched.add(sizes)
        return first(self, enqueue, sizes)

    monkeypatch.setattr(Device, "_first_launch", noted)
    with clrt.Tracer(scene) as tracer:
        tracer.render(max_depth=8)
        label = tracer.device.info.label
    by_picture = set(launched)
    launched.clear()
    rays = vars(flat.ray_format)
    compiler._compile({"device": label, "settings": {}, "rays": rays, "needed": needed(flat)})
    assert {name for name, *_ in launched} == set(needed(flat)) and launched <= by_picture


def test_only_a_command_with_two_cores_starts_one(monkeypatch: pytest.MonkeyPatch) -> None:
    started: list[object] = []

    def refuse(*given: object, **named: object) -> None:
        started.append(given)
        raise OSError  # which nobody hears of

    monkeypatch.setattr(beside.subprocess, "Popen", refuse)
    monkeypatch.setattr(beside.trial, "circumstances", list)

    def starts(running: bool = True, cores: int = 2, settings: Settings | None = None, **more: bool) -> bool:
        started.clear()
        monkeypatch.setattr(interrupts, "running", lambda: running)
        monkeypatch.setattr(beside, "_cores", lambda: cores)
        beside.start("PoCL", settings or Settings(), RayFormat(), more)
        return bool(started)

    assert starts(generate=True)
    assert not starts() and not starts(running=False, generate=True) and not starts(cores=1, generate=True)
    assert not starts(settings=Settings(threads=1), generate=True)
    monkeypatch.setattr(beside.trial, "circumstances", lambda: ["POCL_DEBUG=all"])
    assert not starts(generate=True)


# what becomes of the process beside, `s`, once it is started
FATES = {
    "works": "pass",
    "cannot be started": "raise OSError",
    "is killed in the middle": "threading.Timer(4, s.kill).start()",
}


@pytest.mark.parametrize("fate", FATES)
def test_a_cold_start_gives_the_same_picture_whatever_becomes_of_it(fate: str, tmp_path: Path) -> None:
    (tmp_path / "a.json").write_text(str(SCENES["plain"]).replace("'", '"'))
    cache = tmp_path / "cache"
    cache.mkdir(mode=0o700)
    code = f"""
import subprocess, sys, threading; sys.argv[0] = 'clrt'
import clrt
from clrt.device import beside
class Popen(subprocess.Popen):
    def __init__(s, given, **more):
        super().__init__(given, **more)
        if 'clrt.device.compiler' in given: {FATES[fate]}
beside._cores, subprocess.Popen = lambda: 2, Popen
from clrt.cli import program; program()
"""
    done = subprocess.run(
        [sys.executable, "-c", code, "hash", str(tmp_path / "a.json")],
        env={**os.environ, cachefolder.VARIABLE: str(cache)}, capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout.split()[0] == clrt.render(clrt.load_dict(SCENES["plain"])).hash
    holders = {file.read_text() for file in (cache / ".clrt" / "launched").glob("*.holder")}
    # other drivers compile a program whole, in one process
    assert len(holders) == (2 if pocl_version(choose()[0]) else 1) or fate != "works"
