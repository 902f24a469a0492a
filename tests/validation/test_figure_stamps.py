"""Files of figures below docs: each has a stamp of the code that it is of, and is told where that is old."""

from __future__ import annotations

import importlib.util
import json
import subprocess
import sys
import warnings
from dataclasses import replace
from pathlib import Path

import pytest

from clrt.base.resources import validation_module
from tests import report_samples
from validation.reliability import code, kept
from validation.reliability.rows import ROWS

DOCS = Path(__file__).resolve().parents[2] / "docs"


@pytest.mark.parametrize("name", kept.FILES)
def test_the_figures_of_other_pages_are_told_where_they_are_old(name: str) -> None:
    state = kept.stale(name)
    if state:
        warnings.warn(f"docs/{name}: {state}", stacklevel=1)
    elif name == kept.PROCESSORS:
        assert any(kind["stamp"]["commit"] for kind in json.loads((DOCS / name).read_text()).values())
    elif name != kept.TICKS:
        assert json.loads((DOCS / name).read_text())["stamp"]["commit"]


def test_each_file_that_is_stamped_is_watched() -> None:
    there = {f"performance/{file.name}" for file in (DOCS / "performance").glob("*.json")}
    assert len(there) > 7 and there <= kept.FILES.keys()


def test_figures_of_kinds_of_processors_are_of_this_code_where_one_is(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    """No machine has all kinds."""
    monkeypatch.setattr(code, "commit", lambda: ("abc1234", False))
    file = tmp_path / kept.PROCESSORS
    file.parent.mkdir()
    now = kept.stamp(kept.FILES[kept.PROCESSORS])
    old = {"one": {"stamp": {**now, "code": "older"}}, "other": {}}
    both = {**old, "own": {"stamp": now}}
    for kinds, said in (({}, "without a stamp of its code"), (old, kept.STALE), (both, "")):
        file.write_text(json.dumps(kinds))
        assert kept.stale(kept.PROCESSORS, tmp_path) == said


def test_what_a_cluster_s_rounds_do_not_prove() -> None:
    """They are of workers that had something to do, gave the right bits, and did nothing twice."""
    row = {"same": True, "twice": 0, "pieces": 2}
    rows = [{**row, "what": what} for what, least in kept.DISTURBED.items() for _ in range(least)]

    def said(*of_two: dict[str, object], rest: slice = slice(None)) -> str:
        runs = {1: [{**one, "twice": None} for one in rows], 2: [*rows[rest], *of_two], 4: rows}
        faults = [{"workers": count, "rounds": found} for count, found in runs.items()]
        return kept._lacking(kept.CLUSTER, {"faults": faults})

    assert said() == said({**row, "what": "", "pieces": 0}) == ""
    few = "too few kills or pauses with 2 workers"
    assert said(rest=slice(1, None)) == said({**rows[0], "pieces": 0}, rest=slice(1, None)) == few
    assert said({**rows[0], "same": False}) == "1 rounds with 2 workers gave other bits"
    assert said({**rows[0], "twice": 2}) == "2 tasks were done twice with 2 workers"
    assert kept._lacking(kept.CLUSTER, {"faults": []}) == "too few kills or pauses with 1 workers"


def test_what_a_package_does_first_and_what_is_read_beside_are_of_the_code() -> None:
    proofs = dict(code.files(("validation.proofs",)))
    assert "aim.cl" in proofs and "validation.scenes" not in proofs
    assert "validation.oracle_mitsuba" in code.closure(("validation.oracle_mitsuba.hashing",))
    assert not {"validation", "clrt"} & code.closure(("validation.oracle_mitsuba.hashing",))


def test_a_figure_is_as_old_as_its_code(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    name, modules = "figures.json", ("clrt.version",)
    monkeypatch.setattr(kept, "FILES", {name: modules})
    monkeypatch.setattr(code, "commit", lambda: ("abc1234", False))
    assert kept.stale(name, tmp_path) == "not measured"
    (tmp_path / name).write_text("{}")
    assert kept.stale(name, tmp_path) == "without a stamp of its code"
    stamp = kept.stamp(modules)
    assert stamp["commit"] == "abc1234" and stamp["processor"] and stamp["device"]
    (tmp_path / name).write_text(json.dumps({"stamp": stamp}))
    assert kept.stale(name, tmp_path) == ""
    (tmp_path / name).write_text(json.dumps({"stamp": {**stamp, "dirty": True}}))
    assert kept.stale(name, tmp_path) == "measured with changes that no commit holds"
    changed = tmp_path / "changed.py"
    changed.write_text("# of tomorrow\n")
    monkeypatch.setattr(code, "_above", lambda module: ())
    monkeypatch.setattr(code, "module_file", lambda module: changed)
    code.digest.cache_clear()
    code._imports.cache_clear()
    try:
        (tmp_path / name).write_text(json.dumps({"stamp": stamp}))
        assert kept.stale(name, tmp_path) == kept.STALE
    finally:
        code.digest.cache_clear()
        code._imports.cache_clear()


def test_parts_of_one_run_are_of_one_code(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """docs/validation.json: runs of different code have no stamp, and count as stale."""
    spec = importlib.util.spec_from_file_location("make_validation", DOCS / "make_validation.py")
    assert spec and spec.loader
    maker = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(maker)
    monkeypatch.setattr(maker, "PAGE", tmp_path / "validation.md")
    monkeypatch.setattr(maker, "KEPT", tmp_path / "validation.json")
    files = validation_module("suite.files")
    stamp = {"commit": "abc1234", "dirty": False, "code": "one"}
    for stamps, expected in (([stamp, stamp], stamp), ([stamp, {**stamp, "code": "other"}], {}),
                             ([stamp, {}], {}),
                             ([stamp, {**stamp, "dirty": True}], {**stamp, "dirty": True})):  # fmt: skip
        (tmp_path / "validation.md").write_text(f"{maker.BEGIN}{maker.END}")
        names = []
        for number, one in enumerate(stamps):
            names.append(str(tmp_path / f"{number}.json"))
            result = replace(report_samples.result(), stamp=one)
            Path(names[-1]).write_text(json.dumps(files.plain(result), default=str))
        monkeypatch.setattr(sys, "argv", ["make_validation", *names])
        maker.main()
        found = json.loads((tmp_path / "validation.json").read_text())
        assert found["stamp"] == expected and len(found["runs"]) == 2
        assert "| oracle |" in (tmp_path / "validation.md").read_text()


OWN = {
    "bench": "import clrt.bench.suite",
    "scaling": "import clrt.bench.scaling",
    "povray": "import clrt.bench.frames",
    "thesis": "import clrt.formats.thesis, clrt.cli.render",
    "leaks": "from validation import proofs; proofs.leaks(proofs.Prover(), 1000)",
}
DRAWN = """
import sys, clrt
from clrt.bench import scenes
from clrt.formats.shipped import load_scene
made = scenes.terrain_frame(200), scenes.flake_frame(levels=1)
for scene in (*made, load_scene("showcase"), load_scene("room")):
    clrt.render(scene, width=8)
print(*sys.modules)
"""


@pytest.mark.parametrize("name", OWN)
def test_figures_of_own_scenes_read_no_models(name: str) -> None:
    """What is left out of their code (`code.UNREAD`) is not imported as they are measured, nor is more than
    what their code has."""
    told = [sys.executable, "-c", OWN[name] + DRAWN]
    done = subprocess.run(told, capture_output=True, text=True, check=True)
    files = {module: code.module_file(module) for module in done.stdout.split() if module.startswith("clrt.")}
    imported = {module for module, file in files.items() if file and not code.holds_words(file)}
    rows = {row.name: row.modules for row in ROWS}
    modules = rows.get(name) or kept.FILES[f"performance/{name}.json"]
    left_out = {module.removeprefix("-") for module in code.UNREAD}
    assert "clrt.engine.tracer" in imported and not imported & left_out
    assert {f"-{module}" for module in left_out} <= {*modules} and left_out <= code.closure((*left_out,))
    assert not imported - code.closure((*modules, "clrt.bench.scenes", "clrt.formats.native"))


def test_what_modules_read_beside_them_counts() -> None:
    for folder, pattern in code.DATA.values():
        assert list(folder.glob(pattern)), (folder, pattern)
    names = {name for name, _ in code.files(("clrt.spectra.spectrum", "validation.expected"))}
    assert {"gold.csv", "observer.csv", "expected_hashes.json"} <= names
    assert "gold.csv" not in {name for name, _ in code.files(("clrt.base.errors",))}
