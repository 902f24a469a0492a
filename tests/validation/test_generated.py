"""Faults that nobody chose: drawn alike, planted many in one build, and the kernels without them the same."""

from __future__ import annotations

import importlib.util
import itertools
import re
import warnings
from pathlib import Path

import pytest

from clrt.base.resources import kernel_folder, validation_module

generated = validation_module("mutants.generated")
switched = validation_module("mutants.switched")
planting = validation_module("mutants.generated_run")
panel = validation_module("mutants.panel")
outcomes = validation_module("mutants.outcomes")
mutants = validation_module("mutants.run")
DOCS = Path(__file__).resolve().parents[2] / "docs"
FILE = "kernels/some.cl"


def places(text: str) -> list[generated.Place]:
    """All faults of a file of kernels with this text."""
    return [generated.Place(FILE, text.count("\n", 0, start) + 1, 1, start, end, text[start:end], new, "")
            for start, end, new in generated._in_c(text)]  # fmt: skip


def planted(text: str, alone: bool = True) -> list[str]:
    """The text with each fault, or with all of them, as the compiler sees it where they count."""
    numbered = list(enumerate(places(text), 1))
    out = []
    for faults in [[one] for one in numbered] if alone else [numbered]:
        new, left = switched.with_all(text, faults)
        assert not left and new.count("\n") == text.count("\n")
        out.append(re.sub(r"\(\*\(volatile __global uchar \*\)\(.*?\) = 1, \*.*?ul == \d+\)", "ON", new))
    return out


@pytest.mark.parametrize(("text", "expected"), [
    ("x = a - b * c;", ["x = (ON ? a + b * c : a - b * c);", "x = a - (ON ? b / c : b * c);"]),
    ("x = f(a, 2.0f) < d ? 1 : 0;", ["x = f(a, (ON ? (1.01f * 2.0f) : 2.0f)) < d ? 1 : 0;",
                                     "x = (ON ? f(a, 2.0f) >= d : f(a, 2.0f) < d) ? 1 : 0;"]),
    ("if (a == b) c[i] = d;", ["if (!(a == b) == ON) c[i] = d;", "if ((ON ? a != b : a == b)) c[i] = d;",
                               "if (a == b) c[(i) + ON] = d;"]),
    ("x = min(a, b);", ["x = (ON ? max(a, b) : min(a, b));"]),
    ("s += a;", ["s = ON ? s - ( a) : s + ( a);"]),
    ("return a && b || c;", ["return (ON ? a || b : a && b) || c;",
                             "return (ON ? a && b && c : a && b || c);"]),
    ("x = a // one\n    + b;", ["x = (ON ? a      - b : a // one\n    + b);"]),
])  # fmt: skip
def test_each_place_holds_both_texts(text: str, expected: list[str]) -> None:
    assert planted(text) == expected


def test_faults_within_operands_of_others_are_in_both_of_their_texts() -> None:
    expected = "x = (ON ? a + (ON ? b / c : b * c) : a - (ON ? b / c : b * c));"
    assert planted("x = a - b * c;", alone=False) == [expected]


@pytest.mark.parametrize("text", [
    "    float ox[PACKET], oy[3];", "INLINED void keep(VecP v, float (*field)[PACKET])",
    "#define A(x) x + 1.0f\n", "// a + b\n", "__global float *p;",
])  # fmt: skip
def test_what_computes_nothing_has_no_fault(text: str) -> None:
    assert places(text) == []


def test_faults_that_cut_into_each_other_are_left_for_another_build() -> None:
    text = "x = a && b && c;"
    faults = list(enumerate(places(text), 1))
    _, left = switched.with_all(text, faults)
    assert len(faults) == 2 and not left  # one is within the other
    one, two = places("x = a + b;")[0], places("x = a + b;")[0]
    assert switched.with_all("x = a + b;", [(1, one), (2, two)])[1] == {2}


def test_all_of_the_draw_are_in_one_source() -> None:
    """No line moves, for the compiler names lines; and every place can be chosen."""
    drawn = [place for place in generated.drawn(planting.COUNT) if place.file.startswith("kernels/")]
    assert len(drawn) > planting.COUNT / 2
    for file, found in itertools.groupby(enumerate(drawn, 1), key=lambda numbered: numbered[1].file):
        text = (kernel_folder() / file.removeprefix("kernels/")).read_text("utf-8")
        new, left = switched.with_all(text, list(found))
        assert not left and new.count("\n") == text.count("\n")


def test_the_draw_does_not_change_with_other_lines(tmp_path: Path) -> None:
    names = [place.name for place in generated.drawn(40)]
    assert names == [place.name for place in generated.drawn(40)] and len(set(names)) == 40
    assert set(names) <= {place.name for place in generated.drawn(80)}
    assert set(names) != {place.name for place in generated.drawn(40, seed=2)}


def test_cases_of_few_formats_show_what_kernels_can_tell_apart() -> None:
    for file in ("kernels/light.clh", "kernels/tree.cl"):
        cases = panel.cases_for(file)
        assert len({panel._format(case) for case in cases}) <= 7
    assert panel.cases_for("kernels/tree.cl")[0] == "shipped sphereflake"
    assert not any(case.startswith(mutants.CHECK) for case in panel.cases_for("clrt/engine/adaptive.py"))
    refitted = [case for case in panel.cases_for("kernels/refit.cl") if case.startswith(mutants.REFITTED)]
    assert len(refitted) >= 2


def test_what_came_out_is_kept_and_every_live_fault_is_noticed() -> None:
    """Rows of other code are counted; `make release` plants them again."""
    rows = planting.kept()
    assert rows and {row["outcome"] for row in rows.values()} <= set(outcomes.OUTCOMES)
    assert [name for name, row in rows.items() if row["outcome"] == "survived"] == []
    for name, row in rows.items():
        assert row["by"] and "\n" not in row["by"], name
        assert (row["outcome"] == "not live") == (row.get("why") in outcomes.REASONS), name
    stamp = {"code": planting.code.digest(planting.pages.FILES[planting.NAME]), "dirty": False}
    drawn = [place.name for place in generated.drawn(planting.COUNT)]
    old = [name for name in drawn if not planting.current(rows.get(name, {}), stamp)]
    if old:
        warnings.warn(f"docs/{planting.NAME}: {len(old)} faults were not planted in this code", stacklevel=1)


def test_the_page_says_what_the_data_say() -> None:
    """`python docs/make_mutants.py` writes it."""
    spec = importlib.util.spec_from_file_location("make_mutants", DOCS / "make_mutants.py")
    assert spec is not None and spec.loader is not None
    maker = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(maker)
    rows, text = planting.kept(), maker.PAGE.read_text("utf-8")
    assert maker.written(text, rows) == text
    one = {"a.py:1:1: x | y becomes z": {"outcome": "not live", "why": outcomes.SAME, "by": "2 pictures"},
           "b.py:1:1: + becomes -": {"outcome": "noticed", "by": "case: a gate", "case": "case"}}  # fmt: skip
    said = "\n".join(maker.lines(one))
    assert said.startswith("Of 2 faults 1 were noticed, 0 gave no picture, 1 were not live, none survived.")
    assert r"| `a.py:1:1` | `x \| y` becomes `z` | 2 pictures |" in said and said.count("<details>") == 1


@pytest.mark.parametrize("name", [
    "refitted leaves keep their boxes", "the neighbour above not asked", "a hash without its length",
    "a film that holds what is infinite", "alpha of samples that count alike",
])  # fmt: skip
def test_what_no_oracle_renders_is_checked(name: str) -> None:
    """One judged by a new tracer, four by checks that say what is right."""
    found = mutants.run_mutant(name)
    assert not found.survived and found.caught_by in (("a new tracer",), mutants.MUTANTS[name].cases)


@pytest.mark.slow
def test_a_build_with_many_faults_is_the_sound_one_until_one_is_chosen() -> None:
    """On whichever driver the tests run: drivers of CPUs run kernels in the process, and see its memory."""
    file, diffuse = "kernels/light.clh", "material->kd * cosine"
    text = (kernel_folder() / "light.clh").read_text("utf-8")
    here = text.index(diffuse) + diffuse.index("*")
    every = [generated.Place(file, text.count("\n", 0, start) + 1, 1, start, end, text[start:end], new, "")
             for start, end, new in generated._in_c(text)]  # fmt: skip
    shown = next(place for place in every if place.start == here)
    unseen = next(place for place in every if "IS_SEEN(light)" in text[place.start : place.end + 20])
    with validation_module("mutants.served").Served({1: shown, 2: unseen}) as served:
        picture, reached = served.sound("diffuse")
        assert outcomes.same(picture, mutants.sound("diffuse", None)) and 1 in reached
        assert not outcomes.same(served.picture(1, "diffuse"), picture)
        assert outcomes.same(served.picture(0, "diffuse"), picture)
