"""What comes out of a fault: what is noticed, why one is not live, and that no broken program is one."""

from __future__ import annotations

import json
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from clrt.base.errors import ClrtError
from clrt.base.resources import validation_module

outcomes = validation_module("mutants.outcomes")
plant = validation_module("mutants.plant")
planting = validation_module("mutants.generated_run")
snapshot = validation_module("mutants.snapshot")
OracleImage = validation_module("types").OracleImage
PLACE = validation_module("mutants.generated").Place("kernels/a.cl", 1, 1, 0, 1, "+", "-", "")
Lost = plant.Lost
SIDE = 100  # pixels a side: 10 of them are 0.1 %
SOUND = OracleImage(np.zeros((SIDE, SIDE, 3), np.float32), {}, None, None, "", 0.0,
                    layers={"albedo": np.zeros((SIDE, SIDE))})  # fmt: skip


def picture(pixels: int = 0, move: float = 1.0, albedo: int = 0) -> Any:
    """One in which so many pixels have moved, and so many of a layer."""
    made = replace(SOUND, pixels=SOUND.pixels.copy(), layers={"albedo": SOUND.layers["albedo"].copy()})
    made.pixels.reshape(-1, 3)[:pixels] = move
    made.layers["albedo"].flat[:albedo] = 1.0
    return made


@pytest.fixture(autouse=True)
def _no_oracles(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(outcomes, "sound", lambda case, device: SOUND)
    monkeypatch.setattr(outcomes, "reference", lambda case: (SOUND, np.zeros((SIDE, SIDE), bool)))
    monkeypatch.setattr(outcomes, "_noticed", lambda place, name, ours, device: None)


@pytest.mark.parametrize(("pictures", "outcome", "why", "by"), [
    ([picture(), picture()], "not live", "changes no bit", "2 pictures"),
    ([picture(10), picture(3, 0.5)], "not live", "moves too little",
     "0.10% of the pixels move by more than 1e-3, the most by 1.0e+00"),
    ([picture(5000, 0.9e-3)], "not live", "moves too little",
     "0.00% of the pixels move by more than 1e-3, the most by 9.0e-04"),
    ([picture(albedo=9)], "not live", "moves too little", "layers change, and no pixel"),
    ([picture(), picture(11)], "survived", None, "case 1"),
    ([picture(11, np.nan)], "survived", None, "case 0"),
])  # fmt: skip
def test_live_is_what_moves_enough_pixels_and_else_there_is_a_reason(
    pictures: list[Any], outcome: str, why: str | None, by: str
) -> None:
    row = outcomes.judged_pictures(PLACE, [(f"case {k}", one) for k, one in enumerate(pictures)], None)
    assert (row["outcome"], row.get("why"), row["by"]) == (outcome, why, by)
    assert why is None or why in outcomes.REASONS


def test_of_pictures_that_hardly_move_those_that_change_most_are_judged(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    looked: list[str] = []
    monkeypatch.setattr(outcomes, "_noticed", lambda place, name, ours, device: looked.append(name))
    pictures = [(f"{changed}", picture(albedo=changed)) for changed in (1, 9, 4, 7, 2, 8, 3, 6)]
    assert outcomes.judged_pictures(PLACE, pictures, None)["outcome"] == "not live"
    assert looked == ["9", "8", "7", "6", "4", "3"]
    looked.clear()
    outcomes.judged_pictures(PLACE, [*pictures, ("live", picture(11))], None)
    assert looked[0] == "live" and len(looked) == 9


class Serving:
    """Stands for the process: what it answers, one by one, with the number of the fault that is chosen."""

    def __init__(self, answers: list[tuple[int, Any]]) -> None:
        self.answers, self.restarts = answers, 0

    def picture(self, fault: int, case: str) -> Any:
        expected, answer = self.answers.pop(0)
        assert fault == expected
        if isinstance(answer, Exception):
            raise answer
        return answer

    def restart(self) -> None:
        self.restarts += 1


CRASH, ERROR = Lost("ended by SIGSEGV", True), Lost("IndexError: index 4 is out of bounds")


@pytest.mark.parametrize(("answers", "outcome", "restarts"), [
    ([(3, ERROR), (0, SOUND)], "no picture", 0),
    ([(3, CRASH), (0, SOUND), (3, CRASH), (0, SOUND)], "no picture", 0),
    ([(3, CRASH), (0, SOUND), (3, SOUND)], "not live", 0),  # it was another fault's trace
    ([(3, picture(11)), (0, picture(2)), (0, SOUND), (3, SOUND)], "not live", 1),
    ([(3, picture(11)), (0, SOUND)], "survived", 0),
    ([(3, ERROR), (0, ERROR), (0, SOUND), (3, ERROR), (0, SOUND)], "no picture", 1),
])  # fmt: skip
def test_no_picture_counts_where_there_is_one_without_the_fault(
    answers: list[tuple[int, Any]], outcome: str, restarts: int
) -> None:
    serving = Serving(list(answers))
    assert outcomes._chosen(serving, 3, PLACE, ["a case"], None)["outcome"] == outcome
    assert not serving.answers and serving.restarts == restarts


def test_a_fault_is_looked_for_on_every_case_that_comes_by(monkeypatch: pytest.MonkeyPatch) -> None:
    """Until one notices it: here the last of many, which no other is like."""
    every = [f"case {k}" for k in range(200)]
    asked: list[str] = []

    class Many:
        unable = frozenset[int]()

        def __init__(self, faults: Any, device: object) -> None:
            pass

        def __enter__(self) -> Many:
            return self

        def __exit__(self, *_: object) -> None:
            pass

        def sound(self, case: str) -> tuple[Any, frozenset[int]]:
            return SOUND, frozenset({1} if case != every[3] else ())

        def picture(self, number: int, case: str) -> Any:
            asked.append(case)
            return picture(5000) if number and case == every[150] else SOUND

    monkeypatch.setattr(outcomes, "Served", Many)
    monkeypatch.setattr(outcomes, "cases_for", lambda file: every)
    monkeypatch.setattr(outcomes, "_noticed", lambda place, name, ours, device: f"{name}: a gate")
    ((_, row),) = outcomes.in_one_copy([PLACE])
    assert row["outcome"] == "noticed" and row["case"] == every[150]
    assert asked[:-1] == [case for case in every[:151] if case != every[3]]  # then the sound one


@pytest.mark.parametrize("without", [Lost("NameError: name 'INSIDE' is not defined"), picture(1)])
def test_a_broken_program_is_no_fault_that_was_caught(without: Any) -> None:
    serving = Serving([(3, ERROR), (0, without), (0, without)])
    with pytest.raises(ClrtError, match=r"a case: no right picture without .* IndexError: index 4"):
        outcomes._chosen(serving, 3, PLACE, ["a case"], None)


@pytest.mark.parametrize("without", [Lost("NameError: name 'INSIDE' is not defined"), picture(1), SOUND])
def test_nor_in_a_copy_of_its_own(monkeypatch: pytest.MonkeyPatch, tmp_path: Path, without: Any) -> None:
    @contextmanager
    def patched(file: str, edit: Any) -> Iterator[Path]:
        yield tmp_path / str(edit("+ or -") == "+ or -")

    def pictures(root: Path, cases: list[str], *_: Any) -> Iterator[tuple[str, Any]]:
        sound = root.name == "True"
        if not sound:
            yield cases[0], SOUND
        answer = without if sound else ERROR
        if isinstance(answer, Exception):
            raise answer
        yield cases[0], answer

    monkeypatch.setattr(outcomes, "cases_for", lambda file: ["one", "two"])
    monkeypatch.setattr(outcomes, "patched", patched)
    monkeypatch.setattr(outcomes, "pictures_by_child", pictures)
    outcomes._prove.cache_clear()
    if without is SOUND:
        assert outcomes.outcome(PLACE)["outcome"] == "no picture"
        assert outcomes.outcome(PLACE)["case"] == "two"
    else:
        with pytest.raises((Lost, AssertionError), match=r"INSIDE|two: a copy without any fault"):
            outcomes.outcome(PLACE)
    outcomes._prove.cache_clear()


@pytest.mark.parametrize(("said", "word"), [
    ('Traceback:\n  File "/a/b/clrt/a.py", line 3, in f\n    g()\nIndexError: index 4\nof size 3\n',
     "IndexError: index 4"),
    ("a.b.PlacedError: /a/b/scene.toml: camera.up: 1/2 is not\n", "a.b.PlacedError: scene.toml: "
     "camera.up: 1/2 is not"),
    ("LimitError: \"/a/b.toml\"\n\nDuring it:\n\nMemoryError\n", "MemoryError"),
    ("python: ./lib/CL/pocl_util.c:779: Assertion `a' failed.", "python: ./lib/CL/pocl_util.c:779: Assertion "
     "`a' failed."),
    ("ended by SIGSEGV", "ended by SIGSEGV"),
    ("ValueError: " + "x" * 300, "ValueError: " + "x" * 148 + "..."),
])  # fmt: skip
def test_an_error_is_a_line_without_folders(said: str, word: str) -> None:
    assert Lost(said).word == word


def checkout(root: Path, text: str) -> None:
    for name in ("kernels", "scenes", "clrt/__pycache__", "validation"):
        (root / name).mkdir(parents=True)
    (root / "clrt" / "__init__.py").write_text("")
    (root / "clrt" / "__pycache__" / "old.pyc").write_text("")
    (root / "validation" / "__init__.py").write_text("")
    (root / "validation" / "some.py").write_text(text)


def test_what_runs_is_a_copy(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    here = tmp_path / "checkout"
    checkout(here, "import json, pathlib, sys\n"
                   "held = {'words': sys.argv[1:], 'at': __file__, 'clrt': __import__('clrt').__file__}\n"
                   "pathlib.Path(sys.argv[1]).write_text(json.dumps(held))\nsys.exit(3)\n")  # fmt: skip
    monkeypatch.setattr(snapshot.code, "ROOT", here)
    monkeypatch.setattr(snapshot.code, "commit", lambda: ("abc", False))
    stamp = {"commit": "abc", "dirty": False}
    out = tmp_path / "out.json"
    assert snapshot.run("validation.some", [str(out)], stamp) == 3
    held = json.loads(out.read_text())
    assert held["words"][1] == "--stamp" and json.loads(held["words"][2]) == stamp
    for file in (held["at"], held["clrt"]):
        assert not Path(file).is_relative_to(here) and not Path(file).exists()  # and it is gone


def test_an_edit_while_it_is_copied_ends_the_run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    here, copied = tmp_path / "checkout", snapshot.copied
    checkout(here, "raise SystemExit(3)\n")
    monkeypatch.setattr(snapshot.code, "ROOT", here)
    monkeypatch.setattr(snapshot.code, "commit", lambda: ("abc", False))
    for stamp in ({"commit": "abc", "dirty": True}, {"commit": "abd", "dirty": False}):
        with pytest.raises(ClrtError, match="changed while they were copied"):
            snapshot.run("validation.some", [], stamp)

    def slow(checkout: Path, root: Path) -> None:
        copied(checkout, root)
        (checkout / "validation" / "some.py").write_text("")

    monkeypatch.setattr(snapshot, "copied", slow)
    with pytest.raises(ClrtError, match="changed while they were copied"):
        snapshot.run("validation.some", [], {"commit": "abc", "dirty": False})


def test_rows_of_changes_that_no_commit_holds_are_planted_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def planted(places: list[Any], device: object) -> Iterator[tuple[str, dict[str, Any]]]:
        yield from ((place.name, {"outcome": "noticed", "by": "a gate"}) for place in places)

    drawn = planting.drawn(3)
    monkeypatch.setattr(planting, "_planted", planted)
    monkeypatch.setattr(planting, "drawn", lambda count, seed: drawn[:count])
    code = planting.code.digest(planting.pages.FILES[planting.NAME])

    def run(commit: str, dirty: bool, *words: str) -> tuple[dict[str, Any], set[str]]:
        stamp = {"commit": commit, "dirty": dirty, "code": code}
        given = ["--count", "3", "--docs", str(tmp_path), "--stamp", json.dumps(stamp)]
        assert planting.main([*words, *given]) == 0
        kept = json.loads((tmp_path / planting.NAME).read_text())
        return kept["stamp"], {row["commit"] for row in kept["faults"].values()}

    assert run("a", True) == ({"commit": "a", "dirty": True, "code": code}, {"a"})
    assert run("b", True)[1] == {"a"}  # it goes on where it was
    assert run("c", False) == ({"commit": "c", "dirty": False, "code": code}, {"c"})
    assert run("d", False)[1] == {"c"}
    assert run("e", True, "--all")[0]["dirty"]
    name = next(iter(planting.kept(tmp_path)))
    stamp, commits = run("f", False, "--only", name)
    assert stamp["dirty"] and commits == {"e", "f"}
    assert run("f", False)[0] == {"commit": "f", "dirty": False, "code": code}
    with pytest.raises(ClrtError, match="is not that of the stamp"):
        planting.main(["--docs", str(tmp_path), "--stamp", json.dumps({"commit": "a", "dirty": False,
                                                                      "code": "another"})])  # fmt: skip


def test_rows_of_other_code_are_planted_again_and_not_certified(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Whatever changed in it, and also where the file with the fault is as it was."""
    planted: list[str] = []

    def all_of(places: list[Any], device: object) -> Iterator[tuple[str, dict[str, Any]]]:
        for place in places:
            planted.append(place.name)
            yield place.name, {"outcome": "noticed", "by": "a gate"}

    def run(code: str, *words: str) -> tuple[str, list[str]]:
        planted.clear()
        monkeypatch.setattr(planting.code, "digest", lambda modules: code)
        stamp = json.dumps({"commit": code, "dirty": False, "code": code})
        assert planting.main([*words, "--count", "3", "--docs", str(tmp_path), "--stamp", stamp]) == 0
        kept = json.loads((tmp_path / planting.NAME).read_text())
        return kept["stamp"]["code"], sorted(kept["faults"][name]["commit"] for name in kept["faults"])

    names = sorted(place.name for place in planting.drawn(3))
    monkeypatch.setattr(planting, "_planted", all_of)
    assert run("old") == ("old", ["old"] * 3) and sorted(planted) == names
    assert run("new", "--only", names[0]) == ("", ["new", "old", "old"]) and planted == names[:1]
    assert run("new") == ("new", ["new"] * 3) and sorted(planted) == names[1:]
    assert run("new") == ("new", ["new"] * 3) and not planted
