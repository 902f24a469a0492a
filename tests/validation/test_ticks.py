"""A tick says that a case depends on a feature: measured by deleting it, and measured again here."""

from __future__ import annotations

import dataclasses
import random
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from clrt.base.resources import validation_module
from clrt.device.device import Device
from tests import rotation

cases = validation_module("cases")
coverage = validation_module("coverage")
deletions = validation_module("deletions")
deletion_run = validation_module("deletion_run")
ticks = validation_module("ticks")
mutants = validation_module("mutants.run")


def test_every_feature_can_be_deleted() -> None:
    named = {feature for group in coverage.FEATURES.values() for feature in group} - set(coverage.COUNTS)
    assert set(deletions.DELETIONS) == named
    faults = {f for way in deletions.DELETIONS.values() if not callable(way) for f in way}
    assert faults <= set(mutants.MUTANTS)


def test_every_case_was_measured_as_it_is() -> None:
    stale = [name for name, case in cases.matrix_cases().items() if not ticks.fits(case)]
    assert not stale, f"python -m validation.deletion_run measures: {', '.join(stale)}"


def test_every_feature_shows_in_a_case() -> None:
    shown = {feature for case in cases.matrix_cases().values() for feature in case.shows}
    assert set(deletions.DELETIONS) - shown == set()


def test_a_case_that_changes_shows_nothing() -> None:
    case = cases.case_named("lens")
    assert "lens" in ticks.shown(case)
    moved = {**case.scene, "camera": {**case.scene["camera"], "aperture": 1e-6}}
    assert ticks.shown(dataclasses.replace(case, scene=moved)) == frozenset()
    assert ticks.shown(dataclasses.replace(case, features=case.features | {"thin"})) == frozenset()


def test_what_stands_in_the_tables_but_out_of_sight_is_no_tick() -> None:
    """A lamp behind a wall, a mirror behind the camera: their tables have them, their pictures do not."""
    case = cases.case_named("diffuse")
    hidden = {"type": "sphere", "center": [0, 0, 40], "radius": 1, "material": {"reflection": 0.9}}
    made = {**case.scene, "shapes": [*case.scene["shapes"], hidden]}
    features = coverage.features_of(cases.loaded(made))
    assert "mirror" in features
    ours = validation_module("oracles").our_picture
    device = Device()
    scene = validation_module("mutants.plant").small("diffuse")
    with_it = scene.replace({"shapes": made["shapes"]})
    assert mutants.judged("diffuse", ours(deletions.DELETIONS["mirror"](with_it), device), "oracle64").passed


@pytest.mark.parametrize("draw", range(2))
def test_a_row_is_what_is_measured(draw: int) -> None:
    """Two cases, others after a change of the code; `make release` measures all of them."""
    drawn = random.Random(f"{rotation.seed()} {draw}").choice(sorted(cases.matrix_cases()))
    assert deletion_run.main([drawn, "--check"]) == 0, drawn


def test_a_row_may_claim_less_than_shows_and_never_more() -> None:
    said = {"scene": "a", "asked": ["fog", "mirror"], "shows": ["mirror"]}
    assert deletion_run.otherwise(said, said) == ""
    assert "does not claim fog" in deletion_run.otherwise(said, {**said, "shows": ["fog", "mirror"]})
    assert "WRONG: ticks.json claims mirror" in deletion_run.otherwise(said, {**said, "shows": []})
    for other in ({**said, "scene": "b"}, {**said, "asked": ["mirror"]}):
        assert "WRONG: ticks.json is of another case" in deletion_run.otherwise(said, other)
    assert "WRONG" in deletion_run.otherwise(None, said)


def test_what_was_measured_is_kept_and_the_row_says_with_which_code(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    suite, kept = validation_module("suite.run"), validation_module("suite.kept")
    monkeypatch.setattr(kept, "user_cache_dir", lambda *_, **__: str(tmp_path))
    matrix = {name: cases.case_named(name) for name in ("diffuse", "lens")}
    done: list[str] = []
    written: dict[str, Any] = {}

    def completed(jobs: Any, *_: Any) -> Iterator[tuple[str, Any]]:
        done.extend(jobs)
        yield from ((name, ["lens"] if name.startswith("edits") else []) for name in jobs)

    monkeypatch.setattr(suite, "completed", completed)
    monkeypatch.setattr(deletion_run, "matrix_cases", lambda: matrix)
    monkeypatch.setattr(deletion_run, "write", lambda rows, _: written.update(rows))
    assert deletion_run.main(["--all"]) == 0
    first = list(done)
    assert {"edits: diffuse", "edits: lens"} < set(first)
    row = written["lens"]
    assert row["shows"] == ["lens"] and row["scene"] == ticks.kept()["lens"]["scene"]
    reliability = validation_module("reliability.kept")
    now = validation_module("reliability.code").digest(*reliability.ticks_of())
    assert row["code"] == now[:16]
    assert deletion_run.main(["--all", "--check"]) == 1, "diffuse has no lens, and the rows claim more"
    assert done == first and f"{len(done)} of {len(done)} results were kept" in capsys.readouterr().out
    assert deletion_run.main(["--all", "--fresh"]) == 0 and done == first * 2


@pytest.mark.parametrize("claim", ["mirror", "lens"])
def test_a_claim_that_is_not_true_is_found(claim: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """The case has no mirror to be seen and no lens: a row that says so is called wrong."""
    case = cases.case_named("diffuse")
    rows = {"diffuse": ticks.row(case, [*ticks.kept()["diffuse"]["shows"], claim])}
    monkeypatch.setattr(deletion_run, "kept", lambda: rows)
    assert deletion_run.main(["diffuse", "--check"]) == 1


def test_what_an_oracle_has_no_words_for_is_said() -> None:
    oracles = validation_module("oracles")
    picture = {"type": "image", "file": "bowl.glb", "part": 0}
    scene = {"shapes": [{"type": "sphere", "center": [0, 0, 0], "radius": 1, "material": {"color": picture}}]}
    case = dataclasses.replace(cases.case_named("diffuse"), scene=scene)
    assert oracles.why_not("mitsuba-table", case) == "pictures within a model's file are not translated"
    assert oracles.why_not("mitsuba-table", cases.case_named("shipped still-life")) is None
    assert "left to the table mode" in oracles.why_not("mitsuba-bsdf", cases.case_named("shipped still-life"))
