"""Results that are kept from run to run: of other code, or another input, they are made anew."""

from __future__ import annotations

import dataclasses
import json
import os
import pickle
import re
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from clrt.base import interrupts
from clrt.base.resources import validation_module
from clrt.cli import validate

suite, kept = validation_module("suite.run"), validation_module("suite.kept")
worker, types = validation_module("suite.worker"), validation_module("types")
cases, code = validation_module("cases"), validation_module("reliability.code")
mutants, pages = validation_module("mutants.run"), validation_module("reliability.kept")
RIGHT = types.Gate("SSIM", np.float64(0.9999), 0.999, np.bool_(True), "high")
WRONG = types.Gate("SSIM", 0.9, 0.999, False, "high")
CASE = kept.Inputs("validation.suite.worker", cases=("diffuse",), said=("oracle64",))


@pytest.fixture(autouse=True)
def _(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    monkeypatch.setattr(kept, "user_cache_dir", lambda *_, **__: str(tmp_path / "cache"))
    monkeypatch.setattr(code, "forget", code.digest.cache_clear)  # no test here changes what imports what
    yield
    code.digest.cache_clear()


def opened(**more: Any) -> Any:
    return kept.Kept(None, {"numpy": "2"}, **more)


def result(gate: Any = RIGHT, pictures: bool = False, unproven: dict[str, str] | None = None) -> Any:
    noise = np.random.default_rng(0).random((4, 5, 3)).astype(np.float32)
    image = types.OracleImage(noise if pictures else noise[:0, :0], {}, None, None, "an oracle", 1.5)
    maps = {"difference": noise, "mask": noise[:, :, 0]} if pictures else {}
    found = types.Comparison({"SSIM": np.float64(0.9999), "PSNR": np.inf}, (gate,), maps, "camera")
    case = cases.case_named("diffuse")
    return types.CaseResult(case, image, {"oracle64": (image, found)}, unproven or {}, 3.0)


def key(inputs: Any = CASE) -> str:
    return str(opened()._key(inputs)[0])


def test_what_is_kept_is_what_was_found() -> None:
    mutant = types.MutantResult("m", "kernels/light.clh", "how", ("oracle64",), False, "camera")
    counts, twin = [types.CountResult("s", "k", 3, 3, 0.0)], types.CheckResult("twin", True, "all", 1.0)
    found = {"case": result(pictures=True), "mutant": mutant, "counts": counts, "twin": twin, "names": ["a"]}
    inputs = {name: dataclasses.replace(CASE, said=name, pictures=True) for name in found}
    first = opened()
    assert first.fault == "" and first.read(inputs) == {}
    for name, one in found.items():
        first.keep(name, inputs[name], one)
    again = opened().read({**inputs, "never": None})
    case = again.pop("case")
    assert again == {name: one for name, one in found.items() if name != "case"}
    (image, compared), (_, made) = case.results["oracle64"], found["case"].results["oracle64"]
    assert compared.metrics == made.metrics and compared.gates == made.gates and compared.worst == "camera"
    assert image.pixels.tobytes() == case.ours.pixels.tobytes() == found["case"].ours.pixels.tobytes()
    assert {name: one.tobytes() for name, one in compared.maps.items()} == {
        name: one.tobytes() for name, one in made.maps.items()}  # fmt: skip
    assert case.seconds == 3.0 and case.case is cases.case_named("diffuse") and case.passed
    assert opened(fresh=True).read(inputs) == {}


@pytest.mark.parametrize("bad", [result(WRONG), result(unproven={"mitsuba-table": "no LLVM"}),
                                 types.MutantResult("m", "f", "how", (), True),
                                 [types.CountResult("s", "k", 3, 4, -0.25)],
                                 types.CheckResult("twin", False, "1 bit", 1.0)])  # fmt: skip
def test_what_failed_or_lacked_an_oracle_is_not_kept(bad: Any) -> None:
    store = opened()
    store.read({"a": CASE})
    store.keep("a", CASE, bad)
    assert opened().read({"a": CASE}) == {} and list(store.folder.iterdir()) == []


def test_what_is_kept_without_pictures_is_none_for_a_report() -> None:
    store, report = opened(), dataclasses.replace(CASE, pictures=True)
    store.read({"a": CASE})
    store.keep("a", CASE, result())
    assert opened().read({"a": CASE}) and not opened().read({"a": report})
    store = opened()
    store.read({"a": report})
    store.keep("a", report, result(pictures=True))
    assert opened().read({"a": report}) and opened().read({"a": CASE})["a"].ours.pixels.size == 0


def test_a_change_of_code_or_input_is_another_key(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    before = key()
    assert key() == before, "the same question"
    matrix = {name: dataclasses.replace(case, spp=4) for name, case in cases.matrix_cases().items()}
    other = ((kept, "versions", lambda: "scipy 0"), (cases, "matrix_cases", lambda: matrix))
    for target, name, value in other:
        with monkeypatch.context() as patch:
            patch.setattr(target, name, value)
            assert key() != before, name
    assert key(dataclasses.replace(CASE, said=("oracle64", "povray"))) != before
    for variable in ("PYOPENCL_BUILD_OPTIONS", "POCL_EXTRA_BUILD_FLAGS"):
        with monkeypatch.context() as patch:
            patch.setenv(variable, "-cl-fast-relaxed-math")
            assert key() != before, variable
    for module in ("validation.oracle64.radiance", "validation.compare.metrics", "clrt.engine.wavefront"):
        with planted(module, tmp_path):
            assert key() != before, module
    for module in ("validation.scenes.matrix", "validation.mutants.host", "validation.twin.lights",
                   "clrt.view.server"):  # fmt: skip
        with planted(module, tmp_path):
            assert key() == before, f"{module}: no part of this case"
    assert key() == before


@contextmanager
def planted(module: str, folder: Path) -> Iterator[None]:
    """A module's file with a line more."""
    real = code.module_file
    changed = folder / f"{module}.py"
    changed.write_bytes(real(module).read_bytes() + b"\n# more\n")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(code, "module_file", lambda name: changed if name == module else real(name))
        yield


def test_a_fault_is_known_by_its_text_and_by_what_its_cases_read(monkeypatch: pytest.MonkeyPatch) -> None:
    inputs = kept.Inputs("validation.mutants.run", faults=("exponent 36 for 40",))
    before, mutant = key(inputs), mutants.MUTANTS["exponent 36 for 40"]
    for change in ({"new": mutant.new + " "}, {"cases": ("mirror",)}):
        monkeypatch.setitem(mutants.MUTANTS, mutant.name, dataclasses.replace(mutant, **change))
        assert key(inputs) != before, change
    checked = next(name for name, one in mutants.MUTANTS.items() if one.cases[0].startswith("check "))
    assert re.fullmatch("[0-9a-f]{64}", key(kept.Inputs("validation.mutants.run", faults=(checked,))))


def test_a_file_that_a_scene_reads_is_an_input(tmp_path: Path) -> None:
    (tmp_path / "a.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    scene = tmp_path / "own.toml"
    scene.write_text('[camera]\norigin = [0, 0, 5]\ntarget = [0, 0, 0]\nwidth = 8\nheight = 8\n'
                     '[[shapes]]\ntype = "mesh"\nfile = "a.obj"\n')  # fmt: skip
    own = dataclasses.replace(CASE, cases=(cases.own_case(str(scene)),))
    before, store = key(own), opened()
    store.read({"own": own})
    (tmp_path / "a.obj").write_text("v 0 0 0\nv 2 0 0\nv 0 1 0\nf 1 2 3\n")
    assert key(own) != before
    store.keep("own", own, result())
    assert list(store.folder.iterdir()) == [], "it changed while the job ran"


@pytest.mark.parametrize("name", ["colours of vertices", "shipped cabinet"])
def test_what_a_loader_writes_for_a_moment_is_no_input(name: str) -> None:
    states, _ = kept._case(name)
    assert states and all(Path(file).is_file() for file in states)


def test_damaged_and_foreign_files_are_none(tmp_path: Path) -> None:
    store = opened()
    store.read({"a": CASE})
    store.keep("a", CASE, result())
    (file,) = store.folder.iterdir()
    whole = file.read_bytes()
    with np.load(file) as found:
        held = json.loads(found["json"].tobytes())
    texts = [{**held, "key": "0" * 64}, {**held, "kind": "other"}, {**held, "kind": "mutant"}, [], {}]
    texts.append({**held, "result": {**held["result"], "seconds": "1"}})
    for text in texts:
        np.savez(file, json=np.frombuffer(json.dumps(text).encode(), np.uint8))
        assert opened().read({"a": CASE}) == {}, text
    pickled = np.array([{"a": 1}], object)
    np.savez(file, allow_pickle=True, json=pickled)
    assert opened().read({"a": CASE}) == {}
    end = whole.rfind(b"PK\x01\x02")
    bits = [whole[: end + k] + bytes([whole[end + k] ^ bit]) + whole[end + k + 1 :]
            for k in (6, 8, 10) for bit in (1, 64)]  # version, "encrypted", method  # fmt: skip
    for damaged in (whole[:200], whole[:-1], b"", pickle.dumps({}), whole.replace(b"json", b"jsom"), *bits):
        file.write_bytes(damaged)
        assert damaged in bits or opened().read({"a": CASE}) == {}
        opened().read({"a": CASE})
    file.write_bytes(whole)
    assert opened().read({"a": CASE})
    file.unlink()
    os.mkfifo(file)
    assert opened().read({"a": CASE}) == {}, "and nobody waits for a pipe"
    store.folder.chmod(0o777)
    shared = opened()
    assert "others may write" in shared.fault and shared.read({"a": CASE}) == {}


def test_an_interrupted_run_goes_on(monkeypatch: pytest.MonkeyPatch) -> None:
    """What was done before Ctrl-C is not done again, and the run says so."""
    done: list[str] = []
    told: list[tuple[int, int]] = []

    def completed(jobs: dict[str, Any], _: int, progress: Any) -> Iterator[tuple[str, Any]]:
        for number, name in enumerate(jobs, 1):
            progress(number, len(jobs), name)
            done.append(name)
            yield name, dataclasses.replace(result(), case=cases.case_named(name))
            if len(done) == 1:
                raise KeyboardInterrupt

    monkeypatch.setattr(suite, "completed", completed)
    monkeypatch.setattr(interrupts, "saved", [])
    plan = suite.Plan(cases=("diffuse", "mirror", "lens"), keep=True)
    with pytest.raises(KeyboardInterrupt):
        suite.run(plan)
    assert interrupts.saved == [opened().folder], "what Ctrl-C says of it"
    found = suite.run(plan, lambda number, total, _: told.append((number, total)))
    assert len(done) == len(set(done)) == 3 and told == [(2, 3), (3, 3)]
    assert found.kept == (done[0],) and [case.case.name for case in found.cases] == list(plan.cases)
    assert any("1 of 3 results are of earlier runs" in note for note in found.notes)
    plain = validation_module("suite.files").plain(found)
    assert plain["kept"] == [done[0]] and plain["cases"][0]["passed"]
    assert set(suite.run(plan).kept) == set(plan.cases) and len(done) == 3
    assert suite.run(dataclasses.replace(plan, fresh=True)).kept == () and len(done) == 6
    assert suite.run(dataclasses.replace(plan, keep=False)).kept == () and len(done) == 9


def test_of_somebody_elses_program_nothing_is_kept() -> None:
    task = worker.Task("diffuse", ("oracle64",), program=object())
    assert suite._inputs((worker.run_case, task)) is None


def test_what_the_code_of_a_case_reaches_is_named() -> None:
    """`clrt` is left out, since it only offers the names of its rooms: so nobody may use these."""
    reached = code.closure(["validation.suite.worker", "validation.deletion_run"], code.STATED)
    texts = {name: code.module_file(name).read_text() for name in reached}
    bare = {name for name, text in texts.items() if re.search(r"^\s*import clrt$", text, re.M)}
    assert bare == {"validation.mutants.checks"}, "of its faults nothing is left out: they have no cases"
    assert not reached & set(code.STATED) and "validation.oracle_mitsuba.worker" in reached


def test_code_that_changes_while_it_runs_makes_figures_dirty(monkeypatch: pytest.MonkeyPatch) -> None:
    stamps = [{"code": "a", "dirty": False}]
    monkeypatch.setattr(validate, "_stamp", lambda: stamps[-1])
    assert validate._also_after(stamps[0])["dirty"] is False
    for now in ({"code": "b", "dirty": False}, {"code": "a", "dirty": True}):
        stamps.append(now)
        assert validate._also_after(stamps[0]) == {"code": "a", "dirty": True}
    assert validate._also_after({}) == {}


def test_what_proves_less_than_it_says_is_not_good(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """A run that failed or of some cases, faults that survived or too few of them: as old figures are."""
    stamp = {"code": code.digest(("clrt.version",)), "dirty": False}
    monkeypatch.setattr(pages, "FILES", dict.fromkeys(("validation.json", "mutants.json"), ("clrt.version",)))
    whole = {"passed": True, "coverage": {"fog": []}, "mutants": [{}], "checks": [{}]}
    some, failed = {**whole, "coverage": {}}, {**whole, "passed": False}
    quick = {**whole, "checks": []}
    for runs, state in (([whole], ""), ([whole, some], ""), ([some], "part"), ([quick], "part"), ([], "part"),
                        ([failed], "passed"), ([failed, some], "passed")):  # fmt: skip
        (tmp_path / "validation.json").write_text(json.dumps({"stamp": stamp, "runs": runs}))
        found = pages.stale("validation.json", tmp_path)
        assert state in found and bool(found) == bool(state), runs
    rows = {str(number): {"outcome": "noticed"} for number in range(300)}
    survived = {"outcome": validation_module("mutants.outcomes").SURVIVED}
    lives, few = {**rows, "299": survived}, dict([*rows.items()][1:])
    for faults, state in ((rows, ""), (lives, "1 faults survived"), (few, "299")):
        (tmp_path / "mutants.json").write_text(json.dumps({"stamp": stamp, "faults": faults}))
        found = pages.stale("mutants.json", tmp_path)
        assert state in found and bool(found) == bool(state)


def test_a_cluster_is_disturbed_with_each_number_of_workers(tmp_path: Path) -> None:
    stamp = {"code": code.digest(pages.FILES[pages.CLUSTER]), "dirty": False}

    def run(workers: int, kills: int = 50) -> dict[str, Any]:
        right = {"same": True, "twice": 0, "pieces": 1}
        rounds = [{"what": "kill", **right}] * kills + [{"what": "pause", **right}] * 20
        return {"workers": workers, "rounds": rounds}

    for runs, state in (([run(1), run(2), run(4)], ""), ([run(1), run(4)], "with 2 workers"),
                        ([run(1), run(2), run(4, 49)], "with 4 workers")):  # fmt: skip
        (tmp_path / pages.CLUSTER).write_text(json.dumps({"stamp": stamp, "faults": runs}))
        found = pages.stale(pages.CLUSTER, tmp_path)
        assert state in found and bool(found) == bool(state)


def test_ticks_of_other_code_are_told(tmp_path: Path) -> None:
    now = code.digest(*pages.ticks_of())
    (tmp_path / "docs").mkdir()
    (tmp_path / "validation").mkdir()
    for codes, state in (([now[:16]], ""), (["0" * 16, now[:16], ""], f"2 of 3 rows {pages.STALE}")):
        rows = {str(number): {"code": of} for number, of in enumerate(codes)}
        (tmp_path / "validation" / "ticks.json").write_text(json.dumps(rows))
        assert pages.stale(pages.TICKS, tmp_path / "docs") == state
