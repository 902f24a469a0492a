"""Hostile inputs, kept and newly drawn, render or end in one `ClrtError`, in bounded time and memory."""

from __future__ import annotations

import os
import subprocess
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest

from clrt.resources import validation_module

ROOT = Path(__file__).resolve().parents[1]
COUNT = int(os.environ.get("CLRT_HOSTILE", "2000"))


@pytest.fixture(scope="module")
def hostile() -> ModuleType:
    return validation_module("hostile.run")


@pytest.fixture(scope="module")
def device() -> str | None:
    return os.environ.get("CLRT_DEVICE")


def seed() -> int:
    """Another one for every commit; 1 where there is no repository."""
    command = ["git", "-C", str(ROOT), "rev-parse", "--short=7", "HEAD"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    return int(done.stdout.strip() or "1", 16)


def said(failures: list[dict[str, Any]]) -> str:
    return "\n".join(f"{f.get('scene', f.get('index'))}: {f['status']}: {f['text']}" for f in failures)


def test_what_is_kept_renders_or_is_refused_in_a_line(hostile: ModuleType, device: str | None) -> None:
    outcome = hostile.run(hostile.corpus(), device)
    assert not outcome.failures, said(outcome.failures)
    assert outcome.counts["refused"] > 60 and outcome.counts["rendered"] >= 10


def test_what_a_seed_draws_renders_or_is_refused_in_a_line(hostile: ModuleType, device: str | None) -> None:
    outcome = hostile.run(hostile.drawn(seed(), COUNT), device)
    assert not outcome.failures, f"seed {seed()}:\n{said(outcome.failures)}"
    assert outcome.counts["rendered"] > COUNT / 20 and outcome.counts["refused"] > COUNT / 20


@pytest.mark.parametrize(
    ("fault", "status"),
    [
        ("import os; os.abort()", "died"),
        ("import os; os._exit(0)", "died"),
        ("import time; time.sleep(60)", "hangs"),
        ("raise KeyError('x')", "foreign"),
        ("raise clrt.ClrtError('x' * 3000)", "foreign"),
        ("import time; end = time.process_time() + 0.4\n while time.process_time() < end: pass", "slow"),
        ("import numpy; global kept; kept = numpy.ones(80 << 20)", "large"),
        ("return type('Image', (), dict(pixels=numpy.full((1, 1, 3), numpy.nan)))", "not finite"),
    ],
)
def test_each_kind_of_failure_is_noticed(
    hostile: ModuleType, monkeypatch: pytest.MonkeyPatch, fault: str, status: str
) -> None:
    """A worker whose `clrt.render` has a fault of its own, from the second picture on."""
    planted = "import clrt, numpy; whole = clrt.render; calls = []\ndef render(*a, **k):\n calls.append(1)\n"
    planted += f" if len(calls) == 1: return whole(*a, **k)\n {fault}\n return whole(*a, **k)\n"
    planted += "clrt.render = render\n"
    monkeypatch.setattr(hostile, "_BOOT", planted + hostile._BOOT)
    if status == "hangs":
        monkeypatch.setattr(hostile, "PATIENCE", 3.0)
    if status == "slow":
        monkeypatch.setattr(hostile, "SECONDS", 0.3)
    task = {"folder": str(hostile.CORPUS), "scene": "coincident.toml"}
    outcome = hostile.run([task], workers=1)
    assert [failure["status"] for failure in outcome.failures] == [status]


def test_what_the_starting_process_holds_is_not_counted(hostile: ModuleType) -> None:
    held = bytearray(1) * (hostile.MEMORY + (64 << 20))
    outcome = hostile.run([{"folder": str(hostile.CORPUS), "scene": "coincident.toml"}], workers=1)
    assert not outcome.failures and outcome.largest < len(held)


def test_the_inputs_of_a_seed_are_always_the_same(hostile: ModuleType, tmp_path: Path) -> None:
    make = validation_module("hostile.mutate").make
    for index in range(40):
        assert make(3, index) == make(3, index)
    kinds = {Path(make(3, index).scene).suffix for index in range(300)}
    assert kinds >= {".toml", ".json", ".nff", ".txt", ".obj", ".ply", ".glb", ".gltf", ".stl"}
    hostile.keep([{"seed": 3, "index": 1, "status": "not finite"}], tmp_path)
    (place,) = tmp_path.iterdir()
    assert (place / make(3, 1).scene).read_bytes() == make(3, 1).files[make(3, 1).scene]
