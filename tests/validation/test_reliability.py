"""The figures of docs/reliability.md: short forms of the long proofs, and whether those still hold."""

from __future__ import annotations

import json
import re
import subprocess
import sys
import warnings
from pathlib import Path
from typing import Any

import pytest

from clrt.base.resources import shipped_scenes, validation_module
from clrt.cli import main
from clrt.device.info import DeviceInfo
from validation.reliability import __main__ as page
from validation.reliability import beginnings, code, drivers, intel, kept, rows, sameness
from validation.reliability.figures import Figure
from validation.reliability.rows import ROWS, Row

DOCS = Path(__file__).resolve().parents[2] / "docs"


MEASURED = [row for row in ROWS if row.name in page.kept()]  # the page says of the others that they are not


@pytest.mark.parametrize("row", MEASURED, ids=lambda row: row.name)
def test_nothing_wrong_is_published(row: page.Row) -> None:
    """Figures that are older than the code are named here; `make release` fails on them (--check)."""
    assert page.kept()[row.name]["wrong"] == 0
    state = page.stands(row, page.kept())
    if state:
        warnings.warn(f"docs/reliability.md, {row.name}: {state}; run: make reliability", stacklevel=1)


def test_what_is_not_good_is_an_error_of_a_release(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    good = {row.name: {"tried": row.count, "wrong": 0, "code": row.code, "dirty": False} for row in ROWS}
    monkeypatch.setattr(sys, "argv", ["reliability", "--check"])
    monkeypatch.setattr(page, "measure", lambda row: pytest.fail("nothing is measured"))
    monkeypatch.setattr(kept, "FILES", {})
    for figures, ended in ((good, 0), ({**good, "twin": {**good["twin"], "code": "other"}}, 1)):
        monkeypatch.setattr(page, "kept", lambda figures=figures: figures)
        assert page.main() == ended
        assert (page.STALE in capsys.readouterr().out) == bool(ended)
    monkeypatch.setattr(page, "kept", lambda: good)
    monkeypatch.setattr(kept, "FILES", {"no.json": ()})
    assert page.main() == 1 and "docs/no.json: not measured" in capsys.readouterr().out


def test_a_row_that_cannot_be_run_here_says_so(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    def ran(count: int, tell: Any) -> Figure:
        reasons.append("ran")
        return Figure(count, 0, "all well", 1.0)

    reasons = ["its driver builds nothing"]
    row = Row("odd", "things that fail", 3, "things", ran, ("clrt.version",), lambda: reasons[0])
    old = {"tried": 3, "wrong": 0, "detail": "all well", "seconds": 1, "date": "2026-01-02",
           "commit": "abc1234", "device": "PoCL / a CPU", "code": "other", "dirty": False}  # fmt: skip
    figures_file, shown = tmp_path / "kept.json", tmp_path / "page.md"
    monkeypatch.setattr(kept, "FILES", {})
    for name, value in (("ROWS", (row,)), ("KEPT", figures_file), ("PAGE", shown)):
        monkeypatch.setattr(page, name, value)

    def run(figures: dict[str, Any], *options: str) -> tuple[int, str]:
        figures_file.write_text(json.dumps(figures))
        shown.write_text(f"before {page.START}{page.END} after")
        monkeypatch.setattr(sys, "argv", ["reliability", *options])
        return page.main(), capsys.readouterr().out

    said = "odd          not run here: its driver builds nothing\n"
    for figures in ({}, {"odd": old}):
        for options in ((), ("--check",), ("--only", "odd")):
            code, out = run(figures, *options)
            assert code == 0 and said in out and len(reasons) == 1, (figures, options)
    where = "not run on this processor: its driver builds nothing; last: 2026-01-02, abc1234"
    assert where in shown.read_text()
    code, out = run({"odd": {**old, "wrong": 1}}, "--check")
    assert code == 1 and said not in out, "a wrong figure has no excuse"
    reasons[0] = ""
    assert run({"odd": old}, "--check")[0] == 1
    code, out = run({"odd": {**old, "unable": "no driver"}})
    assert reasons == ["", "ran"] and "not run here" not in out
    assert "not run on" not in shown.read_text() and "**0 of 3**" in shown.read_text()


def test_drivers_are_compared_where_both_work(monkeypatch: pytest.MonkeyPatch) -> None:
    infos = [DeviceInfo(n, "a CPU", "p", f"PoCL {v}", "CPU", 2, 1) for n, v in enumerate(("3.0-rc2", "3.1"))]
    faults = {"PoCL 3.0-rc2": "", "PoCL 3.1": ""}
    for module in (drivers, sameness):
        monkeypatch.setattr(module, "devices", lambda: infos)
        monkeypatch.setattr(module, "verdict", lambda info: (faults[info.version], False))
    assert drivers.unable() == ""
    assert {str(how["device"]) for how in sameness.configurations()} == {info.label for info in infos}
    faults["PoCL 3.0-rc2"] = "it builds nothing"
    assert drivers.unable() == "PoCL 3.0: it builds nothing"
    assert {str(how["device"]) for how in sameness.configurations()} == {infos[1].label}
    del infos[1]
    assert drivers.unable() == "PoCL 3.0: it builds nothing; PoCL 3.1 is not here"


def test_a_release_checks_the_figures_first() -> None:
    """What takes seconds comes before what takes long."""
    command = ["make", "-n", "release"]
    shown = subprocess.run(command, cwd=DOCS.parent, capture_output=True, text=True, check=True)
    order = ("ruff check", "validation.reliability --check", "-m pytest", "clrt validate --full --mutants")
    places = [shown.stdout.find(command) for command in order]
    assert -1 not in places and places == sorted(places)


def test_what_broke_it_once_has_a_test_that_exists() -> None:
    table = (DOCS / "reliability.md").read_text().split("## What broke it once")[1].split("\n## ")[0]
    rows = [line for line in table.splitlines() if re.match(r"\| [HMLD]\d+ \|", line)]
    kinds = {"H": 8, "M": 15, "L": 12, "D": 7}
    expected = [f"{kind}{n}" for kind, most in kinds.items() for n in range(1, most + 1)]
    assert [row.split("|")[1].strip() for row in rows] == expected
    for row in rows:
        named = re.findall(r"`(tests/[\w/]+\.py)(?:::(\w+))?`", row.split("|")[-2])
        assert named and len(named) == row.split("|")[-2].count("tests/"), row
        for file, name in named:
            text = (DOCS.parent / file).read_text()
            assert not name or f"\ndef {name}(" in text, f"{file}::{name}"


def test_the_page_shows_the_figures_that_are_kept() -> None:
    assert page.table(page.kept()) in (DOCS / "reliability.md").read_text()


def test_the_kept_figures_are_whole() -> None:
    for name, figure in json.loads(page.KEPT.read_text()).items():
        assert name in {row.name for row in ROWS}
        assert figure["commit"] and figure["date"] and figure["device"] and figure["seconds"] > 0


def test_a_figure_that_fell_short_is_noticed() -> None:
    row = ROWS[-1]
    good = {"tried": row.count, "wrong": 0, "code": row.code, "dirty": False}
    assert page.stands(row, {row.name: good}) == ""
    faults = (
        ({"tried": 1}, "only 1"),
        ({"wrong": 2}, "2 wrong"),
        ({"code": ""}, "older"),
        ({"dirty": True}, "no commit"),
    )
    for worse, said in faults:
        assert said in page.stands(row, {row.name: {**good, **worse}})
    assert page.stands(row, {}) == "not measured"


def test_a_figure_is_of_the_commit_and_the_code_before_it_was_measured(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    """What is committed or changed while a row runs is not what it measured."""
    state, file = [("before", False)], tmp_path / "module.py"
    file.write_text("x = 1")
    monkeypatch.setattr(code, "commit", lambda: state[-1])
    monkeypatch.setattr(code, "closure", lambda modules, apart: {"module"})
    monkeypatch.setattr(code, "module_file", lambda module: file)
    code.digest.cache_clear()

    def run(change: bool) -> dict[str, Any]:
        def measured(count: int, tell: Any) -> Figure:
            state.append(("after", True))
            file.write_text("x = 2" if change else "x = 1")
            return Figure(count, 0, "", 0.0)

        row = Row("name", "promise", 3, "things", measured, ("module",))
        expected = row.code
        found = page.measure(row)
        assert found["commit"] == "before" and found["code"] == expected
        state.append(("before", False))
        return found

    assert run(change=False)["dirty"] is False
    assert run(change=True)["dirty"] is True
    state.append(("before", True))
    assert run(change=False)["dirty"] is True
    code.digest.cache_clear()


def test_a_row_depends_on_what_it_runs() -> None:
    """Loaders and engine under all, programs under those that start one, and nobody under the page."""
    found = {row.name: code.closure(row.modules) for row in ROWS}
    for name, modules in found.items():
        every = {"clrt.engine.tracer", "clrt.scene.scene", "clrt.flatten.flatten", "clrt.device.device"}
        assert every <= modules, name
        assert "validation.reliability.__main__" not in modules, name
    assert {"clrt.cli.render", "clrt.diagnosis.doctor", "validation.hostile.mutate"} <= found["hostile"]
    assert "clrt.cli.render" in found["interrupts"] and "clrt.cli.render" not in found["leaks"]
    assert "validation.oracle64.batch" in found["accuracy"] and "validation.twin.math" in found["twin"]
    assert len({row.code for row in ROWS}) == len(ROWS) - 1, "leaks and self-hits are of one module"


REACHING = [*beginnings.COMMANDS, ("hash", "cabinet", "--width", "8")]


@pytest.mark.parametrize("words", REACHING, ids=lambda words: "-".join(words[:2]))
def test_a_command_reaches_what_it_imports(words: tuple[str, ...], tmp_path: Path) -> None:
    """What a command has imported when it ends is among what its figures hold for: nothing is found by a name
    that its files do not state."""
    told = (
        "import atexit, sys; sys.argv[0] = 'clrt'; from clrt.cli import program; "
        "atexit.register(lambda: print('modules', *sys.modules)); program()"
    )
    done = subprocess.run(
        [sys.executable, "-c", told, *words], cwd=tmp_path, capture_output=True, text=True, check=True
    )
    (line,) = (line for line in done.stdout.splitlines() if line.startswith("modules "))
    files = {name: code.module_file(name) for name in line.split() if name.startswith("clrt.")}
    imported = {name for name, file in files.items() if file and not code.holds_words(file)}
    assert "clrt.cli.options" in imported
    assert not imported - code.closure(code.program(words[0]))


def test_hostile_inputs_that_failed_are_kept_before_the_run_ends(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    """It takes an hour; one that broke off had nothing to show."""
    row, run = next(row for row in ROWS if row.name == "hostile"), rows.hostile
    outcome = run.Outcome()

    def broken(tasks: object, progress: Any) -> None:
        for name in ("one.toml", "other.toml"):
            outcome.failures.append({"scene": name, "status": "slow"})
            progress(outcome)
        raise RuntimeError("broken off")

    monkeypatch.setattr(run, "run", broken)
    monkeypatch.setattr(run, "FOUND", tmp_path)
    with pytest.raises(RuntimeError, match="broken off"):
        row.run(10, lambda share: None)
    assert sorted(folder.name for folder in tmp_path.iterdir()) == ["one.toml_slow", "other.toml_slow"]


def test_configurations_are_as_many_as_promised() -> None:
    """What they give is looked at in test_bits.py."""
    chosen = list(sameness.configurations())
    assert len(chosen) >= 48
    for name in (*shipped_scenes(), *sameness.VARIED):
        scene = sameness.scene(name)
        assert scene.camera
        rays = sameness.WIDTH * round(sameness.WIDTH * scene.camera.height / scene.camera.width)
        cut = [-(-rays * scene.camera.spp // tile) for tile in sameness.TILES]
        assert cut == sorted(set(cut), reverse=True), f"{name}: {cut} tiles: some are the same"
    varied = next(iter(sameness.VARIED))
    expected = {name: sameness.picture(name, 32, {})[0] for name in ("room", "still-life", varied)}
    assert len(set(expected.values())) == 3, "what is varied shows"
    for name, found in expected.items():
        assert sameness._pictures((name, 32, [chosen[0], chosen[-1]])) == (name, 32, [found] * 2)


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


def test_the_runtime_beside_clrt_is_taken(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(intel.intel, "library", lambda: tmp_path / "libintelocl.so")
    monkeypatch.setattr(intel.importlib.metadata, "version", lambda name: "2026.2.0")
    monkeypatch.setattr(intel, "install", lambda folder: pytest.fail("nothing is installed"))
    found = intel.prepared(tmp_path)
    assert found == ("intel-opencl-rt 2026.2.0, beside clrt", {"CLRT_DRIVER": "intel"})
    monkeypatch.setattr(intel.intel, "library", lambda: None)
    monkeypatch.setattr(intel, "install", lambda folder: "installed")
    monkeypatch.setattr(intel, "environment", lambda folder: {"OCL_ICD_VENDORS": "x"})
    assert intel.prepared(tmp_path) == ("installed", {"OCL_ICD_VENDORS": "x"})
    for machine, says in (("x86_64", ""), ("aarch64", "not for aarch64")):
        monkeypatch.setattr(intel.platform, "machine", lambda machine=machine: machine)
        assert intel.unable().endswith(says) and bool(intel.unable()) == bool(says)


def test_a_process_is_shown_one_runtime_only(tmp_path: Path) -> None:
    library = tmp_path / "lib64" / "libintelocl.so"
    library.parent.mkdir()
    library.touch()
    found = intel.environment(tmp_path)
    assert found["LD_LIBRARY_PATH"] == str(library.parent)
    assert Path(found["OCL_ICD_VENDORS"]).read_text() == f"{library}\n"
