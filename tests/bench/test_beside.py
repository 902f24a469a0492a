"""Devices side by side: each case's time on each, and how many times the first one's it is."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
from rich.console import Console

from clrt.bench import beside
from clrt.bench.report import Report
from clrt.bench.suite import Plan
from clrt.cli import main
from tests.bench_samples import measurement
from tests.cli.test_terminal import fault


def report(name: str, *times: tuple[str, float]) -> Report:
    rows = tuple(measurement((seconds, seconds, seconds), case) for case, seconds in times)
    return Report({"device": name}, rows)


def test_times_stand_beside_each_other() -> None:
    reports = [report("one", ("closest", 0.5), ("light", 0.1)), report("two", ("closest", 0.25)),
               report("three", ("closest", 1.0), ("new", 0.2))]  # fmt: skip
    (table,) = beside.beside(reports)
    console = Console(width=200)
    with console.capture() as said:
        console.print(table)
    lines = [line.split() for line in said.get().splitlines() if "flake" in line]
    rows = {line[1]: line[4:] for line in lines}
    assert rows["closest"] == ["500.00", "250.00", "1000.00", "x", "0.50", "x", "2.00"]
    assert rows["light"] == ["100.00", "-", "-", "-", "-"]
    assert rows["new"] == ["-", "-", "200.00", "-", "-"]


def test_every_device_is_measured(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    asked: list[Any] = []

    def measured(plan: Plan, tell: object) -> Report:
        asked.append(plan.device)
        return report(f"[red]{plan.device}[/]", ("closest", 1.0 + len(asked)))

    monkeypatch.setattr("clrt.bench.suite.run", measured)
    monkeypatch.setattr("clrt.cli.bench._check_devices", lambda options: None)
    file = tmp_path / "both.json"
    assert main(["bench", "--device", "3", "--device", "a name", "--json", str(file)]) == 0
    said = capsys.readouterr().out
    assert asked == [3, "a name"] and "1: [red]3[/]" in said and "x 1.50" in said
    assert [one["machine"]["device"] for one in json.loads(file.read_text())["reports"]] == [
        "[red]3[/]", "[red]a name[/]"
    ]  # fmt: skip
    said = fault(capsys, "bench", "--compare", file)
    assert "not a report of `clrt bench --json`" in said


def test_what_needs_one_device_is_refused(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    chart = tmp_path / "a.svg"
    assert "--chart: is for one --device" in fault(
        capsys, "bench", "--device", "a", "--device", "b", "--chart", chart
    )
    import clrt

    name = next(device.label for device in clrt.devices() if not device.label.startswith("nothing"))
    said = fault(capsys, "bench", "--device", name, "--device", name)
    assert "which was named before" in said


def test_a_trace_is_written_of_a_bench(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "a.json"
    words = ["bench", "--quick", "--rounds", "1", "--only", "launch", "--trace", str(file)]
    assert main(words) == 0
    table = json.loads(file.read_text())
    assert len([event for event in table["traceEvents"] if event.get("cat") == "pass"]) > 100
    assert "launch" in capsys.readouterr().out
