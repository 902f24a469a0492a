"""The tables of docs/cluster.md follow from what was measured."""

from __future__ import annotations

import importlib.util
import json
from pathlib import Path
from typing import Any

DOCS = Path(__file__).resolve().parents[2] / "docs"


def make_cluster() -> Any:
    """The script as a module."""
    spec = importlib.util.spec_from_file_location("make_cluster", DOCS / "make_cluster.py")
    assert spec and spec.loader
    made = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(made)
    return made


def test_the_page_s_tables_follow_from_its_raw_values() -> None:
    made = make_cluster()
    tables = made.tables(json.loads((DOCS / "cluster.json").read_text("utf-8")))
    assert f"{made.MARK}\n{tables}\n{made.MARK}" in (DOCS / "cluster.md").read_text("utf-8")


def test_runs_with_other_numbers_of_workers_stand_beside_each_other() -> None:
    made = make_cluster()
    row = {"what": "kill", "kind": "picture", "same": True, "seconds": 2.0}

    def run(workers: int, *twice: int | None) -> dict[str, Any]:
        return {"workers": workers, "rounds": [{**row, "twice": count} for count in twice]}

    runs = made.joined([run(2, 5), run(4, 0)], [run(1, None), run(2, 1, 2)])
    runs[0]["rounds"] += [{**runs[0]["rounds"][0], "pieces": 0}, {**runs[0]["rounds"][0], "what": ""}]
    assert made.faults({"faults": runs})[3:] == [
        "| 1, killed, a picture | 1 | 1 | nobody else | 2.0 s |",
        "| 2, killed, a picture | 2 | 2 | 3 | 2.0 s |",
        "| 4, killed, a picture | 1 | 1 | 0 | 2.0 s |",
    ]
    assert made.twice([row]) == "not counted"  # as in older runs, of validation
    stamp = {"code": "one", "dirty": False}
    assert made.common([stamp, stamp]) == stamp and made.common([stamp, {**stamp, "dirty": True}])["dirty"]
    assert made.common([stamp, {}]) == made.common([stamp, {**stamp, "code": "other"}]) == {}


def test_wall_times_are_held_against_what_was_wanted() -> None:
    def one(process: float, single: float, both: float) -> dict[str, Any]:
        return {"process": {"wall": process}, "local:1": {"wall": single}, "local:2": {"wall": both}}

    rounds = [one(1.0, 1.125, 0.625), one(1.0, 1.125, 0.75), one(1.0, 1.25, 0.625)]
    assert make_cluster().ratios({"pinned": True, "rounds": rounds})[3:] == [
        "| two workers, as fast as one | 1.7 times | 1.80 (1.50 to 2.00) | yes |",
        "| `local:1` over one process | at most 1.10 | 1.12 (1.12 to 1.25) | no |",
    ]


def test_a_task_s_cost_is_that_of_its_own_round() -> None:
    """The first round compiles, so its orders are others than those that are measured."""
    one = {"workers": [6.0], "client": 0.3, "orders": [0.3] * 20}
    told = {"rounds": [{"local:1": one}] * 3, "first": {"local:1": {"setups": [0.4], "orders": [9.0] * 60}}}
    assert make_cluster().costs(told) == (6.0, 0.3, 20, 0.4)
