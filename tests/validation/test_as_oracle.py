"""`clrt validate --against CMD --as-oracle`: somebody else's renderer beside the oracles that ship."""

from __future__ import annotations

import shlex
import sys
from pathlib import Path
from typing import Any

import pytest

from clrt.base.resources import validation_module
from clrt.cli import main

worker = validation_module("suite.worker")
suite = validation_module("suite.run")
programs = validation_module("suite.program")
cases = validation_module("cases")
coverage = validation_module("coverage")
STUDENT = Path(__file__).resolve().parents[1] / "student"
COMMAND = f"{shlex.quote(sys.executable)} {shlex.quote(str(STUDENT / 'tracer.py'))} {{scene.toml}} "
NAME = f"program {Path(sys.executable).name}"


def judged(command: str, case: str = "") -> Any:
    name = case or cases.own_case(str(STUDENT / "scene.toml"))
    return worker.run_case(worker.Task(name, ("oracle64",), program=programs.parse(command)))


@pytest.mark.parametrize("out", ["{out.exr}", "{out.png}"])
def test_a_right_program_agrees_beside_an_oracle(out: str) -> None:
    found = judged(COMMAND + out)
    assert found.passed and set(found.results) == {"oracle64", NAME} and not found.unproven
    gates = {gate.name for gate in found.results[NAME][1].gates}
    assert ("within 1.5 steps of 255" in gates) == (out == "{out.png}")


def test_a_wrong_program_contradicts_and_the_oracles_still_agree() -> None:
    found = judged(COMMAND + "{out.exr} --fault 'no specular'")
    passed = {oracle: comparison.passed for oracle, (_, comparison) in found.results.items()}
    assert passed == {"oracle64": True, NAME: False} and not found.passed


def test_one_that_gives_no_picture_proves_nothing() -> None:
    found = judged(COMMAND + "{out.exr} --no-such-option")
    assert set(found.results) == {"oracle64"} and "exit code 2" in found.unproven[NAME]


def test_what_its_format_has_no_words_for_is_said() -> None:
    program = programs.parse("ls {scene.nff} {out.exr}")
    found = judged(program.text, "diffuse")
    assert set(found.results) == {"oracle64"} and not found.unproven
    said = list(suite.notes(suite.Plan(cases=("diffuse",), program=program), [found]))
    assert any(line.startswith("diffuse: .nff has no words for it: ") for line in said), said


def test_it_is_no_family_for_the_table_of_features() -> None:
    """Nobody knows what it shares with others."""
    found = judged(COMMAND + "{out.exr}", "diffuse")
    assert found.passed and found.case.shows
    table = coverage.coverage([found])
    assert all(table[feature] == {"oracle64"} for feature in found.case.shows)


def test_a_plan_hands_it_to_every_case() -> None:
    program = programs.parse(COMMAND + "{out.exr}")
    tasks = suite.tasks_of(suite.Plan(cases=("diffuse", "mirror"), program=program))
    assert [task.program for task in tasks] == [program, program]


def test_a_program_has_to_be_named(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["validate", "--as-oracle"]) == 2
    assert "--as-oracle: say which program: --against" in capsys.readouterr().err
    assert main(["validate", "--as-oracle", "--against", "no-such {scene.toml} {out.exr}"]) == 2
    assert "there is no such program" in capsys.readouterr().err
