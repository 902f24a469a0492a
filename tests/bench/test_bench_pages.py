"""What docs/performance.md says follows from the kept times, and is met only where it is."""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest

from clrt.bench import host, report

DOCS = Path(__file__).resolve().parents[2] / "docs"
KEPT = DOCS / "performance"


@pytest.fixture(scope="module")
def pages() -> Iterator[dict[str, ModuleType]]:
    sys.path.insert(0, str(DOCS))
    try:
        import make_turns
        import performance_aims
        import performance_tables

        yield {"aims": performance_aims, "tables": performance_tables, "turns": make_turns}
    finally:
        sys.path.remove(str(DOCS))


def found(name: str) -> Any:
    file = KEPT / f"{name}.json"
    return json.loads(file.read_text()) if file.exists() else None


def test_the_page_s_aims_follow_from_the_kept_times(pages: dict[str, ModuleType]) -> None:
    made, asked, narrow = (report.load(KEPT / f"{name}.json") for name in ("bench", "queries", "bench_avx2"))
    cluster = json.loads((DOCS / "cluster.json").read_text())
    said = pages["aims"].aims(made, found("scaling"), found("povray"), asked, narrow, found("turns"), cluster)
    assert said in (DOCS / "performance.md").read_text("utf-8")
    for scene in ("terrain", "lumps", "flake"):
        for queue in pages["aims"].RAYS:
            assert said.count(f"| {scene}, {queue} rays, against Embree's best call, default / robust |") == 1


def test_an_aim_is_met_where_all_of_it_is(pages: dict[str, ModuleType]) -> None:
    aim = pages["aims"]._aim
    assert aim("a", ">=", (1.1, 1.15), (1.1, 1.2)) == ("a", ">= 1.10 / 1.15", "1.10 / 1.20", "met")
    assert aim("a", ">=", (1.1, 1.15), (1.2, 1.1499))[2:] == ("1.20 / 1.15", "missed")
    assert aim("a", ">=", (1.6,), (1.7, 1.5))[3] == aim("a", "<=", (5,), (5.1,))[3] == "missed"
    assert aim("a", "<=", (5,), (4.9,), unit=" s") == ("a", "<= 5.00 s", "4.90 s", "met")


def test_turns_are_told_by_case_and_all_in_all(pages: dict[str, ModuleType]) -> None:
    frame = "frame, flake, picture, 1048576 pixels, 2 threads"
    cases = {frame: {"ours": [2.0, 1.0, 1.0], "other": [2.0, 2.0, 9.0]},
             pages["tables"].MBS: {"ours": [4.0], "other": [2.0]}}  # fmt: skip
    told = {"other": "abc1234", "cases": cases}
    assert pages["tables"].faster(told) == {frame: 2.0, pages["tables"].MBS: 0.5}
    lines = pages["tables"].turns(told).splitlines()
    assert lines[2] == f"| {frame} | 2000 | 1000 | 2.00 |" and lines[-1] == "| geometric mean |  |  | 1.00 |"
    rows = [row[1:] for row in pages["aims"]._in_turns(told)]
    assert rows == [(">= 1.45", "2.00", "met"), ("<= 0.75", "2.00", "missed"), (">= 0.95", "0.50", "missed"),
                    (">= 1.00", "1.00", "met")]  # fmt: skip


def test_an_aim_without_a_value_is_on_the_page_as_not_measured(pages: dict[str, ModuleType]) -> None:
    """As many rows as where all is measured."""
    aims, grown = pages["aims"], {"series": {"pixels of 1M triangles": [{"peak_bytes": 2**30}]}}
    assert aims._aim("a", ">=", (1.1, 1.15), []) == ("a", ">= 1.10 / 1.15", "", "not measured")
    nothing = report.Report({}, [])
    said = aims.aims(nothing, grown, {"scenes": {}}, nothing, None, None, {})
    rows = [line.split(" | ") for line in said.splitlines()[2:]]
    held = [row[-1] for row in rows if row[-1] != "not measured |"]
    assert held == ["missed |", "met |"], "a tree that nobody has built, and memory"
    made, asked, narrow = (report.load(KEPT / f"{name}.json") for name in ("bench", "queries", "bench_avx2"))
    times = {name: {"wall": 1.0} for name in ("process", "local:1", "local:2")}
    turns = {"other": "abc1234", "cases": {pages["tables"].MBS: {"ours": [4.0], "other": [2.0]}}}
    cluster = {"walls": {"rounds": [times]}}
    whole = aims.aims(made, found("scaling"), found("povray"), asked, narrow, turns, cluster)
    assert len(whole.splitlines()) == len(said.splitlines()) == 51
    unmeasured = [line for line in whole.splitlines() if "| not measured |" in line]
    assert [line.split(",")[0] for line in unmeasured] == ["| sphereflake"], "of which these turns have none"


def test_a_cluster_s_aims_are_of_its_wall_times(pages: dict[str, ModuleType]) -> None:
    def one(process: float, single: float, both: float) -> dict[str, Any]:
        return {"process": {"wall": process}, "local:1": {"wall": single}, "local:2": {"wall": both}}

    rounds = [one(1.0, 1.125, 0.625), one(1.0, 1.125, 0.75), one(1.0, 1.25, 0.625)]
    rows = [row[1:] for row in pages["aims"]._cluster({"walls": {"rounds": rounds}})]
    assert rows == [(">= 1.70", "1.80", "met"), ("<= 10 %", "12 %", "missed")]
    assert {row[3] for row in pages["aims"]._cluster({"rounds": []})} == {"not measured"}


def test_a_turn_is_of_the_checkout_that_is_asked(
    pages: dict[str, ModuleType], monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    asked: list[tuple[Path, dict[str, str], list[str]]] = []

    def run(words: list[str], cwd: Path, env: dict[str, str], check: bool) -> None:
        asked.append((cwd, env, words))
        if "--json" in words:
            row = {"scene": "flake", "queue": "", "threads": 2, "items": 4, "unit": "pixels"}
            row |= {"seconds": [1.5]}
            rows = [{**row, "group": "frame", "name": "picture"}, {**row, "group": "builder", "name": "tree"},
                    {**row, "group": "shading", "name": "shade"}]  # fmt: skip
            Path(words[words.index("--json") + 1]).write_text(json.dumps({"measurements": rows}))

    monkeypatch.setattr(subprocess, "run", run)
    told = pages["turns"].turn((tmp_path, {"A": "b"}), {"a picture": ["showcase"]}, ["--quick"])
    assert told == {"a picture": [pytest.approx(0)], "frame, flake, picture, 4 pixels, 2 threads": [1.5]}
    assert {one[0] for one in asked} == {tmp_path} and asked[0][2][1:4] == ["-m", "clrt", "render"]
    assert all(one[1] == {"A": "b", "PYTHONPATH": str(tmp_path)} for one in asked)
    assert "perf_counter=time.process_time" in asked[1][2][2] and asked[1][2][-1] == "--quick"


def test_a_start_is_timed_with_bytecode(monkeypatch: pytest.MonkeyPatch) -> None:
    """As a user's, whatever this process was told; and not with that of the checkout."""
    seen: list[dict[str, str]] = []
    monkeypatch.setattr(host.subprocess, "run", lambda words, env, **_: seen.append(env))
    monkeypatch.setenv("PYTHONDONTWRITEBYTECODE", "1")
    host.program_times(None, 2)
    assert len(seen) == 3 and not any("PYTHONDONTWRITEBYTECODE" in one for one in seen)
    (place,) = {one["PYTHONPYCACHEPREFIX"] for one in seen}
    assert Path(place).parent == Path(seen[0]["POCL_CACHE_DIR"]).parent
