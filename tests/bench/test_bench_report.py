"""What `clrt bench` reports, compares and draws, and what it refuses before it measures."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

import clrt
from clrt.base.errors import ClrtError
from clrt.bench import report, scaling
from clrt.bench.frames import Frame, frame_times, shares
from clrt.bench.timing import Case, Measurement, measured
from clrt.cli import bench as bench_command
from clrt.cli import main
from tests.bench_samples import measurement


def test_reports_are_saved_and_read(tmp_path: Path):
    made = report.Report({"processor": "x"}, (measurement((1.0, 2.0)),))
    made.save(tmp_path / "a.json")
    assert report.load(tmp_path / "a.json") == made
    for text in (
        "{",
        "[]",
        '{"format": 1}',
        '{"format": 7}',
        '{"format": 1, "measurements": [{}], "machine": {}}',
    ):
        (tmp_path / "b.json").write_text(text)
        with pytest.raises(ClrtError, match=r"b\.json"):
            report.load(tmp_path / "b.json")
    with pytest.raises(ClrtError, match="there is no such file"):
        report.load(tmp_path / "c.json")


@pytest.mark.parametrize(
    "changed",
    [
        {"group": ["a"]}, {"threads": {}}, {"items": "1"}, {"items": 10**400}, {"seconds": []},
        {"seconds": ["1"]}, {"seconds": [0.0]}, {"seconds": [-1.0]}, {"seconds": [float("nan")]},
        {"seconds": [5e-324]}, {"seconds": 1.0}, {"extra": 1},
    ],
)  # fmt: skip
def test_what_a_report_holds_is_checked_before_an_hour_of_measuring(tmp_path: Path, changed: dict[str, Any]):
    row = measurement((1.0,)).to_dict()
    content = {"format": 1, "machine": {"processor": "x"}, "measurements": [row | changed]}
    (tmp_path / "b.json").write_text(json.dumps(content))
    with pytest.raises(ClrtError, match=r"b\.json: not a report of `clrt bench --json`"):
        report.load(tmp_path / "b.json")
    (tmp_path / "b.json").write_text("{}")
    with pytest.raises(ClrtError, match=r"not a report of `clrt bench --json`: it has no 'format'$"):
        report.load(tmp_path / "b.json")
    (tmp_path / "b.json").write_text(json.dumps(content | {"machine": ["x"], "measurements": [row]}))
    with pytest.raises(ClrtError, match=r"b\.json: not a report of `clrt bench --json`"):
        report.load(tmp_path / "b.json")


def test_ratios_take_the_best_call_of_each_mode():
    def embree(name: str, seconds: float) -> Measurement:
        return replace(measurement((seconds,)), group="embree", name=name, extra={"disagree": 0.0})

    calls = [embree("default 1", 4.0), embree("default 8 coherent", 3.0), embree("robust 1", 6.0)]
    calls += [replace(embree("default 1", 0.1), queue="shadow"), embree("default tree", 0.1)]
    (row,) = report.ratios(report.Report({}, (measurement((2.0,)), *calls)))
    assert (row["default"], row["default_single"], row["robust"], row["robust_single"]) == (
        1.5,
        2.0,
        3.0,
        3.0,
    )


@pytest.mark.parametrize(
    ("options", "says"),
    [
        (["--only", "launch", "--chart", "a.svg"], "a roofline chart needs the kernels' measurements"),
        (["--only", "kernels", "--chart", "a.bmp"], "no chart is drawn as .bmp; use one of "),
        (["--json", "a.svg", "--chart", "a.svg"], "a.svg: is the file of --json; give --chart a file of its"),
    ],
)
def test_charts_are_refused_before_anything_is_measured(
    options: list[str], says: str, tmp_path: Path, capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:  # fmt: skip
    from clrt.bench import suite

    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(suite, "run", lambda *_: pytest.fail("it measures"))
    assert main(["bench", "--quick", *options]) == 2
    assert says in capsys.readouterr().err and not list(tmp_path.iterdir())


@pytest.mark.slow
def test_the_command_measures_compares_and_draws(tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    old, new, chart = tmp_path / "old.json", tmp_path / "new.json", tmp_path / "roof.svg"
    quick = ["bench", "--quick", "--only", "kernels,frames,builder,launch,bands", "--rounds", "3"]
    assert main([*quick, "--json", str(old), "--chart", str(chart)]) == 0
    text = capsys.readouterr().out
    assert all(
        word in text for word in ("of the roof", "Mpixel/s", "builder: tree", "launch: queued", "times RGB")
    )
    assert "<svg" in chart.read_text()
    groups = {row["group"] for row in json.loads(old.read_text())["measurements"]}
    assert groups == {"roof", "tracing", "shading", "compaction", "frame", "builder", "launch", "bands"}

    # an old report a hundred times as fast: everything is slower now, on a busy machine too
    table = json.loads(old.read_text())
    for row in table["measurements"]:
        row["seconds"] = [seconds / 100 for seconds in row["seconds"]]
    old.write_text(json.dumps(table))
    launches = ["bench", "--quick", "--only", "launch", "--rounds", "5"]
    assert main([*launches, "--compare", str(old), "--json", str(new)]) == 1
    assert "0 same, 0 faster, 2 slower, 0 unclear" in capsys.readouterr().out
    table["machine"]["processor"] = "another"
    old.write_text(json.dumps(table))
    assert main([*quick, "--compare", str(old)]) == 2
    assert "'another'" in capsys.readouterr().err


def test_faults_come_before_measuring(tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    for options, word in (
        (["--only", "kernls"], "kernls"),
        (["--rounds", "0"], "--rounds"),
        (["--compare", str(tmp_path / "x.json")], "x.json"),
        (["--json", str(tmp_path / "no" / "x.json")], "no/x.json"),
        (["--device", "Cray"], "Cray"),
    ):
        assert main(["bench", "--quick", *options]) == 2
        text, errors = capsys.readouterr()
        assert text == "" and word in errors and errors.count("\n") == 1


def test_every_series_has_a_label_and_grows():
    for quick in (False, True):
        for name, points in scaling.series(quick).items():
            x = [where for where, _ in points]
            assert name in scaling.LABELS and x == sorted(set(x)) and len(x) >= 2


def test_one_round_has_no_spread_and_shares_are_of_one_run(capsys: pytest.CaptureFixture[str]):
    scene = clrt.load_dict(
        {"camera": {"origin": [0, 0, 5], "target": [0, 0, 0], "width": 64, "height": 64},
         "shapes": [{"type": "sphere", "center": [0, 0, 0], "radius": 1}]}
    )  # fmt: skip
    found = frame_times({"ball": (scene, 64)}, (1,), 1, None, clrt.Settings())
    (share,) = map(shares, found)
    assert min(share.values()) >= 0 and sum(share.values()) == pytest.approx(1)
    from rich.console import Console

    made = report.Report({}, tuple(found))
    for table in report.tables(made):
        Console(width=160).print(table)
    text = capsys.readouterr().out
    assert "nan" not in text and "-%" not in text and " - " in text


def test_the_run_of_the_median_time_stands_for_a_frame():
    frame = object.__new__(Frame)
    spent = [(9.0, 8.0), (3.0, 2.9), (1.0, 0.2), (2.0, 1.0)]  # the first run compiles
    frame.runs = [(whole, {"closest": tracing}) for whole, tracing in spent]
    assert frame.middle() == (2.0, {"closest": 1.0})
    frame.runs = frame.runs[:2]
    assert frame.middle() == (3.0, {"closest": 2.9})
    case = Case(group="frame", name="picture", run=lambda: None)
    old = measured(case, [1.0], passes={"closest": 0.5, "light": 0.75})  # as older reports had it
    assert shares(old) == pytest.approx({"tracing": 0.4, "passes": 0.6, "host": 0.0})


def test_a_pipe_gets_a_line_now_and_then(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]):
    clock = iter([0.0, 1.0, 4.9, 5.0, 9.0])
    monkeypatch.setattr(bench_command.time, "monotonic", lambda: next(clock))
    with bench_command._reporting() as tell:
        for text in "abcde":
            tell(text)
    assert capsys.readouterr().err == "clrt: bench: a\nclrt: bench: d\n"
