"""The suite itself: it proves every feature twice, notices faults, and never takes silence for a proof."""

from __future__ import annotations

import dataclasses
import json
import os
import signal
import subprocess
import sys
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import pytest

from clrt import layout
from clrt.base.errors import ClrtError
from clrt.base.install import pip_install
from clrt.base.resources import PACKAGE, kernel_folder, validation_module
from clrt.scene.lights import LIGHTS
from clrt.scene.materials import Material

suite = validation_module("suite.run")
mutants = validation_module("mutants.run")
files = validation_module("suite.files")
ROOT = Path(__file__).resolve().parents[2]


@pytest.fixture(scope="module")
def result() -> Any:
    """A run of the fewest cases that have every feature, on this device."""
    return suite.run(suite.Plan(least=True))


def test_independent_programs_agree(result: Any) -> None:
    wrong = [f"{name} ({group}): {why}" for group, name, _, why, _ in files.outcomes(result) if why]
    assert not wrong, "\n".join(wrong)
    assert result.passed and len(result.cases) >= 30


def test_every_feature_is_proven_by_oracles_that_share_no_code(result: Any) -> None:
    assert result.thin == [] and len(result.coverage) > 70
    one = {**result.coverage, "diffuse": {"mitsuba-table", "mitsuba-bsdf"}}
    without = dataclasses.replace(result, coverage=one)
    assert without.thin == ["diffuse"] and not without.passed, "two modes of one program are one oracle"


def test_counts_of_rays(result: Any) -> None:
    scenes = {count.scene for count in result.counts}
    assert {"sphereflake, oracle64", "tetrahedron, oracle64", "mountain, oracle64"} <= scenes
    assert all(count.ours == count.published for count in result.counts if "closed form" in count.scene)


def test_other_programs_can_read_it(result: Any, tmp_path: Path) -> None:
    xml, data = files.write_beside(result, tmp_path / "report.html")
    root = ElementTree.parse(xml).getroot()
    groups = {group.get("name"): group for group in root.iter("testsuite")}
    assert len(groups["oracle64"]) == len(result.cases) and root.find(".//failure") is None
    assert json.loads(data.read_text("utf-8"))["passed"] is True


def test_a_mutant_replaces_what_stands_once() -> None:
    """A kernel that is written anew must not leave its mutants behind."""
    assert len(mutants.MUTANTS) >= 40
    roots = {"kernels": kernel_folder().parent, "clrt": PACKAGE.parent}
    for mutant in mutants.MUTANTS.values():
        text = (roots[mutant.file.partition("/")[0]] / mutant.file).read_text("utf-8")
        assert text.count(mutant.old) == 1, f"{mutant.name}: {mutant.old!r} in {mutant.file}"
        assert mutant.old != mutant.new and mutant.cases


@pytest.mark.parametrize("before", [None, "-w"])
def test_a_fault_in_a_kernel_is_built_in_haste_and_nothing_else(
    before: str | None, monkeypatch: pytest.MonkeyPatch
) -> None:
    name = "PYOPENCL_BUILD_OPTIONS"
    monkeypatch.delenv(name, raising=False)
    if before is not None:
        monkeypatch.setenv(name, before)
    with pytest.raises(RuntimeError), mutants.in_haste():
        assert os.environ[name] == f"{before or ''} -cl-opt-disable".strip()
        raise RuntimeError
    assert os.environ.get(name) == before


@pytest.mark.parametrize("name", ["exponent 36 for 40", "medium forgotten"])
def test_a_fault_is_noticed_and_its_place_told(name: str) -> None:
    """One in a kernel, one in what kernels are given; `clrt validate --mutants` plants all of them."""
    found = mutants.run_mutant(name)
    assert not found.survived and found.caught_by == ("oracle64",)
    assert found.where == mutants.MUTANTS[name].where
    survivor = dataclasses.replace(found, survived=True)
    assert not suite.SuiteResult([], [survivor], [], {}, {}, "", 0.0, None).passed


def validate(*arguments: str, **environment: str) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-m", "clrt", "validate", *arguments]
    given = {**os.environ, **environment}
    return subprocess.run(command, cwd=ROOT, env=given, capture_output=True, text=True)


def test_what_could_not_run_is_not_proven(tmp_path: Path) -> None:
    """A broken LLVM: the float64 oracle agrees, and yet the run fails and says what it lacks."""
    report = tmp_path / "out.html"
    found = validate("--case", "diffuse", "--report", str(report), DRJIT_LIBLLVM_PATH=str(tmp_path / "no.so"))
    assert found.returncode == 1, found.stderr
    assert "NOT PROVEN, 2 comparisons: diffuse (mitsuba-table), diffuse (mitsuba-bsdf)" in found.stdout
    assert "\nnot proven, 1 of " in found.stdout
    assert "Not proven" in report.read_text("utf-8")
    skipped = ElementTree.parse(report.with_suffix(".xml")).getroot().findall(".//skipped")
    assert len(skipped) == 2 and json.loads(report.with_suffix(".json").read_text("utf-8"))["passed"] is False


def test_a_missing_package_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    client = validation_module("oracle_mitsuba.client")
    oracles = validation_module("oracles")
    scene = oracles.source_of(validation_module("cases").case_named("diffuse"))
    monkeypatch.setattr(client, "find_llvm", lambda: None)
    with oracles.Oracles() as opened:
        assert opened.unable("mitsuba-table", scene) == (
            f"no LLVM for Mitsuba; install it with: {pip_install('karellen-llvm-core')}"
        )
        assert oracles.able("oracle64", validation_module("cases").case_named("diffuse"))
    monkeypatch.setattr(client.importlib.util, "find_spec", lambda name: None)
    with oracles.Oracles() as opened:
        assert "mitsuba is not installed" in opened.unable("mitsuba-table", scene)


def dies_before(marker: str) -> str:
    """In a process of its own: ends that unless it did so before."""
    if not Path(marker).exists():
        Path(marker).touch()
        os.kill(os.getpid(), signal.SIGKILL)
    return "alive"


def test_a_process_that_dies_takes_no_other_result_with_it(tmp_path: Path) -> None:
    jobs: dict[str, tuple[Any, ...]] = {f"{k}": (abs, -k) for k in range(9)}
    jobs["3"] = (dies_before, str(tmp_path / "died"))
    told: list[tuple[int, int]] = []
    found = dict(suite.completed(jobs, 2, lambda done, of, name: told.append((done, of))))
    assert found == {name: int(name) for name in jobs} | {"3": "alive"}
    assert told == [(done, 9) for done in range(1, 10)]
    jobs["4"] = (os._exit, 1)
    with pytest.raises(ClrtError, match="4: ended the process that ran it, twice"):
        dict(suite.completed(jobs, 2, None))


@pytest.mark.parametrize("arguments, message", [
    (["--case", "difuse"], "case: 'difuse' is not a case; did you mean 'diffuse'?"),
    (["--random", "-1"], "--random: -1 is not allowed"),
    (["--spd", "nowhere"], "nowhere: balls_c_s4.nff"),
    (["--report", "nowhere/out.html"], "nowhere"),
])  # fmt: skip
def test_faults_of_the_user_are_one_line(arguments: list[str], message: str) -> None:
    found = validate(*arguments)
    assert found.returncode == 2 and message in found.stderr and found.stderr.count("\n") == 1


def test_the_cases_can_be_listed() -> None:
    found = validate("--list")
    assert found.returncode == 0 and found.stderr == ""
    rows = dict(line.split("\t") for line in found.stdout.splitlines())
    cases = validation_module("cases")
    assert list(rows) == [*cases.matrix_cases(), *cases.shipped_cases(), "random SEED/NUMBER"]
    assert "fresnel" in " ".join(rows.values())


def test_random_scenes_draw_every_key_and_kind_of_spectrum() -> None:
    drawn = [validation_module("scenes.chance").scene(1, number) for number in range(100)]
    materials = [shape["material"] for scene in drawn for shape in scene["shapes"]]
    # pictures are files, and a drawn scene is tables alone: cases of their own show them
    keys = {key for material in materials for key in material}
    assert keys == {*Material.__struct_fields__} - {"normal_map"}
    text = json.dumps(drawn)
    assert {light["type"] for scene in drawn for light in scene["lights"]} == {*LIGHTS}
    assert {scene["camera"].get("filter", "box") for scene in drawn} == {"box", *layout.REACH}
    assert any(scene["camera"].get("aperture") for scene in drawn)
    assert any(scene["camera"].get("focus") for scene in drawn)
    balls = [light for scene in drawn for light in scene["lights"] if light["type"] == "sphere"]
    assert {ball["visible"] for ball in balls} == {ball["two_sided"] for ball in balls} == {False, True}
    kinds = ("name", "blackbody", "gaussian", "band", "samples", "sellmeier", "cauchy", "eta", "spectrum")
    assert all(f'"{kind}":' in text for kind in kinds)


@pytest.mark.parametrize(("name", "judge"), [
    ("K1: tinted shadows of dispersed rays in the first band", "oracle64"),
    ("rotations clockwise", "mitsuba-table"),
])  # fmt: skip
def test_an_audits_faults_are_noticed_by_who_does_not_reach_them(name: str, judge: str) -> None:
    found = mutants.run_mutant(name)
    assert not found.survived and found.caught_by == (judge,)


def test_the_quick_suite_asks_mitsuba_where_only_it_can_judge() -> None:
    asked = {task.name: task.oracles for task in suite.tasks_of(suite.Plan())}
    wanted = mutants.judged_by_mitsuba()
    assert {"opaque box", "dispersion", "camera from above"} <= set(wanted)
    assert all(any(oracle.startswith("mitsuba") for oracle in asked[name]) for name in wanted)
    # all others are judged by the float64 oracle, on cases that the quick suite gives it
    of_cases = {case for mutant in mutants.MUTANTS.values() for case in mutant.cases
                if not case.startswith((mutants.CHECK, mutants.REFITTED))}  # fmt: skip
    assert of_cases <= set(asked)
