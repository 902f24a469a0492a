"""The figures of docs/reliability.md: short forms of the long proofs, and whether those still hold."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

import clrt
from clrt.cli import main
from clrt.resources import validation_module
from validation.reliability import __main__ as page
from validation.reliability import accuracy, intel, sameness
from validation.reliability.rows import ROWS

DOCS = Path(__file__).resolve().parents[1] / "docs"


MEASURED = [row for row in ROWS if row.name in page.kept()]  # the page says of the others that they are not


@pytest.mark.parametrize("row", MEASURED, ids=lambda row: row.name)
def test_the_published_figure_is_good_and_not_older_than_the_kernels(row: page.Row) -> None:
    assert page.stands(row, page.kept()) == "", "run: make reliability"


def test_the_page_shows_the_figures_that_are_kept() -> None:
    assert page.table(page.kept()) in (DOCS / "reliability.md").read_text()


def test_the_kept_figures_are_whole() -> None:
    for name, figure in json.loads(page.KEPT.read_text()).items():
        assert name in {row.name for row in ROWS}
        assert figure["commit"] and figure["date"] and figure["device"] and figure["seconds"] > 0


def test_a_figure_that_fell_short_is_noticed() -> None:
    row = ROWS[-1]
    good = {"tried": row.count, "wrong": 0, "kernels": page.kernels()}
    assert page.stands(row, {row.name: good}) == ""
    for worse, said in (({"tried": 1}, "only 1"), ({"wrong": 2}, "2 wrong"), ({"kernels": ""}, "older")):
        assert said in page.stands(row, {row.name: {**good, **worse}})
    assert page.stands(row, {}) == "not measured"


def test_hits_are_within_the_band_of_the_analytic_oracle() -> None:
    figure = accuracy.run(100_000, lambda share: None)
    assert figure.tried >= 100_000 and figure.wrong == 0


def test_a_sphere_a_little_too_large_is_outside_the_band() -> None:
    scene = clrt.load_dict({"shapes": [{"type": "sphere", "center": [0, 0, 0], "radius": 1.00002}]})
    tracer = clrt.Tracer(scene)
    exact = clrt.load_dict({"shapes": [{"type": "sphere", "center": [0, 0, 0], "radius": 1}]})
    tracer._scene = exact  # what the oracle looks at
    o, d = accuracy._rays(1, 2000, 1.0, 0.0)
    met = np.isfinite(tracer.intersect(o, d).t)
    wrong = accuracy.errors(tracer, o, d, accuracy.BAND)
    assert met.sum() > 500 and wrong.sum() > 0.5 * met.sum()


def test_configurations_are_as_many_as_promised() -> None:
    """What they give is looked at in test_bits.py."""
    chosen = list(sameness.configurations())
    assert len(chosen) >= 48
    assert sameness.picture("room", 32, chosen[0]) == sameness.picture("room", 32, {})


def test_the_checks_of_a_self_test_are_read_as_it_prints_them(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    selftest = validation_module("selftest")
    results = [
        selftest.Result("arithmetic", True, "8 operations on 16,384 numbers are the same", 0.1),
        selftest.Result("flat shapes", False, "caller's rays: t (ray 3)", 12.0),
    ]
    monkeypatch.setattr(selftest, "run_selftest", lambda *_: iter(results))
    monkeypatch.setattr(selftest, "names", lambda quick: [result.name for result in results])
    assert main(["selftest"]) == 1
    found = intel.checks_of(capsys.readouterr().out)
    assert found == {result.name: (result.passed, result.detail) for result in results}


def test_a_process_is_shown_one_runtime_only(tmp_path: Path) -> None:
    library = tmp_path / "lib64" / "libintelocl.so"
    library.parent.mkdir()
    library.touch()
    found = intel.environment(tmp_path)
    assert found["LD_LIBRARY_PATH"] == str(library.parent)
    assert Path(found["OCL_ICD_VENDORS"]).read_text() == f"{library}\n"
