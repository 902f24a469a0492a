"""`clrt validate` on an executor's workers: what one process finds; what is lost is done again."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import clrt
from clrt.base.resources import validation_module
from clrt.cli import main
from clrt.cluster import calls, worker
from clrt.cluster.pool import pool_of
from tests.farm_samples import Here

pytestmark = pytest.mark.usefixtures("fresh")
suite, shared = validation_module("suite.run"), validation_module("suite.shared")
cases, runner = validation_module("cases"), validation_module("suite.worker")
SHIPPED = "picture on a sphere"
OWN = """
background = "sky.exr"
camera = {origin = [0, 1, 5], target = [0, 0, 0], width = 24, height = 18}
lights = [{type = "point", position = [2, 4, 3]}]
[[shapes]]
type = "mesh"
file = "parts/mesh.obj"
"""


@pytest.fixture()
def own(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A scene of three files; the float64 oracle alone."""
    monkeypatch.setattr(suite, "able", lambda oracle, case: oracle == "oracle64")
    (tmp_path / "parts").mkdir()
    (tmp_path / "parts" / "mesh.obj").write_text("v -1 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    clrt.Image(np.full((4, 8, 3), 0.5, np.float32)).save(tmp_path / "sky.exr")
    (tmp_path / "own.toml").write_text(OWN)
    return tmp_path / "own.toml"


def note(told: list[tuple[int, int]], done: int, total: int, name: str) -> None:
    told.append((done, total))


def said(result: Any) -> list[tuple[Any, ...]]:
    """What a run found, without times."""
    return [
        (one.case.name, oracle, found.metrics, picture.pixels.tobytes(), one.ours.pixels.tobytes())
        for one in result.cases
        for oracle, (picture, found) in one.results.items()
    ]


def test_the_run_is_that_of_one_process(own: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Where workers see no file of the client's, too: they are sent along, and leave nothing behind."""
    plan = suite.Plan(cases=(SHIPPED,), scenes=(str(own), "tetrahedron"), pictures=True)
    right = [runner.run_case(replace(task, oracles=("oracle64",))) for task in suite.tasks_of(plan)]
    laid: list[str] = []
    for sees in (True, False):
        if not sees:
            monkeypatch.setattr(calls, "_same", lambda name, data: False)
        monkeypatch.setattr(runner, "case_named", lambda name: laid.append(name) or cases.case_named(name))
        told: list[tuple[int, int]] = []
        result = suite.run(replace(plan, executor=Here()), partial(note, told))
        assert said(result) == said(suite.SuiteResult(right, [], [], {}, {}, "", 0, None))
        assert told == [(1, 3), (2, 3), (3, 3)] and result.device and result.passed
        assert [one.case.scene for one in result.cases] == [one.case.scene for one in right]
    here, there = (cases.own_file(name) for name in laid if name.endswith("own.toml"))
    assert here == own and there != own and not there.exists()


RAYS = {"camera_hits": 1, "reflection": 2, "transmission": 3, "total_internal_reflection": 4, "feelers": 5}


@pytest.mark.parametrize(("times", "error"), [(1, ""), (99, "was lost 5 times: it is likely what ends")])
def test_what_is_lost_is_done_again(times: int, error: str) -> None:
    def changed(answer: Any) -> Any:
        seen.append(answer)
        return replace(answer, found=answer.found + b" ") if len(seen) <= times else answer

    seen: list[Any] = []
    before = worker._bench().orders
    jobs = {name: calls.Call("spd", "counted", (RAYS,)) for name in "ab"}
    told = calls.Told()
    work = calls.answers(pool_of(Here(after=changed)), jobs, told)
    if error:
        with pytest.raises(clrt.ClrtError, match=error):
            dict(work)
    else:
        assert dict(work) == dict.fromkeys("ab", (1, 2, 7, 5))
        assert (told.answers, told.lost, len(seen)) == (2, 1, 3)
        assert worker._bench().orders - before == 3 and sum(told.workers.values()) == 2


REFUSED: dict[str, Callable[[calls.Sent], calls.Sent]] = {
    "it has clrt .*, the client 0.0.1": lambda order: replace(order, version="0.0.1"),
    "its kernels are others: .*, not 123": lambda order: replace(order, kernels="123"),
    "device 'no such' is not here": lambda order: replace(order, device="no such"),
}


@pytest.mark.parametrize("text", REFUSED)
def test_a_worker_that_differs_is_refused_by_name(text: str) -> None:
    jobs = {"a": calls.Call("spd", "counted", (RAYS,))}
    with pytest.raises(clrt.ClrtError, match=rf"^worker \S+, process \d+: a: {text}"):
        dict(calls.answers(pool_of(Here(REFUSED[text])), jobs, calls.Told()))


def test_published_scenes_travel_and_other_jobs_are_called_by_name(tmp_path: Path) -> None:
    (tmp_path / "balls_c_s4.nff").write_bytes(b"b 0 0 0\n")
    call = shared.call_of((runner.count_published, "balls_c_s4", tmp_path, None), None)
    assert call.arguments == ("balls_c_s4", tmp_path, None) and call.function == "count_published"
    assert call.files == {str(tmp_path / "balls_c_s4.nff"): b"b 0 0 0\n"}
    call = shared.call_of((runner.run_twin, "pocl"), "pocl")
    assert (call.module, call.function, call.arguments) == ("suite.worker", "run_twin", ("pocl",))


@pytest.mark.parametrize("more", [[], ["--as-oracle"]])
def test_a_program_under_test_stays_here(more: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["validate", "--against", "myrt {scene.toml} {out.exr}", "--cluster", "local:1", *more]) == 2
    assert capsys.readouterr().err.endswith("--against: the program under test runs on this machine\n")
