"""Faults of the host in one copy: each place computes either, and what cannot be chosen is told."""

from __future__ import annotations

import ast
import itertools
import sys
from functools import cache
from types import ModuleType

import pytest

from clrt.base.resources import PACKAGE, validation_module

generated = validation_module("mutants.generated")
switched = validation_module("mutants.switched_host")
served = validation_module("mutants.served")
outcomes = validation_module("mutants.outcomes")
mutants = validation_module("mutants.run")
FILE = "clrt/some.py"


def planted(text: str) -> tuple[str, set[int]]:
    """The text with all faults that it has."""
    places = [generated.Place(FILE, text.count("\n", 0, start) + 1, 1, start, end, text[start:end], new, "")
              for start, end, new in generated._in_python(text)]  # fmt: skip
    new, left = switched.with_all(text, enumerate(places, 1))
    return new.replace("_fault_counts", "ON").partition("\n")[2], left


@pytest.mark.parametrize(("text", "expected"), [
    ("    return a - b * c", "    return a + b * c if ON(1) else a - (b / c if ON(2) else b * c)"),
    ("    return a and b and c", "    return (a and b) or c if ON(2) else a or (b and c) if ON(1) else "
                                 "a and b and c"),
    ("    return a < b < c", "    return a < b >= c if ON(2) else a >= b < c if ON(1) else a < b < c"),
    ("    a += 0.5", "    if ON(1):\n        a -= 0.5\n    else:\n        a += 1.01 * 0.5 if ON(2) else 0.5"),
    ("    return a[b + 1 :]", "    return a[b - 1 if ON(2) else (b + 1 if ON(1) else b) + 1:]"),
    ("    return a[0][b]['c']", "    return a[0 + 1 if ON(1) else 0][b]['c']"),
    ("    return a[-1, :2]", "    return a[-1 + 1 if ON(1) else -1, :2 + 1 if ON(2) else 2]"),
    ("    return '\u00e9', b if a else c", "    return '\u00e9', b if (not a if ON(1) else a) else c"),
    ("    while a():\n        if b:\n            c()",
     "    while not a() if ON(1) else a():\n        if not b if ON(2) else b:\n            c()"),
    ("    return [x | y for x in a]", "    return [x & y if ON(1) else x | y for x in a]"),
    ("    return lambda x: x / a", "    return lambda x: x * a if ON(1) else x / a"),
])  # fmt: skip
def test_each_place_computes_either(text: str, expected: str) -> None:
    new, left = planted(f"def f(a, b, c):\n{text}\n")
    assert not left
    assert ast.dump(ast.parse(new)) == ast.dump(ast.parse(f"def f(a, b, c):\n{expected}\n"))


@pytest.mark.parametrize("text", [
    "A = B * 2\n", "class A:\n    size = B + 1\n", "F = lambda a=B + 1: a\n",
    "def f(a):\n    match a:\n        case 0.5:\n            return 1\n",
])  # fmt: skip
def test_what_is_computed_once_or_has_to_be_a_constant_is_left(text: str) -> None:
    assert planted(text)[1] == {1}


def test_all_of_the_draw_are_in_one_copy() -> None:
    drawn = [place for place in generated.drawn(300) if place.file.startswith("clrt/")]
    assert len(drawn) > 50
    chosen = 0
    for file, found in itertools.groupby(enumerate(drawn, 1), key=lambda numbered: numbered[1].file):
        numbered = list(found)
        new, left = switched.with_all((PACKAGE.parent / file).read_text("utf-8"), numbered)
        compile(new, file, "exec")
        for number, _ in numbered:
            assert new.count(f"_fault_counts({number})") == (number not in left)
        chosen += len(numbered) - len(left)
    assert chosen > 0.9 * len(drawn)


def test_a_chosen_fault_counts_and_what_was_computed_before_is_forgotten(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    held = ModuleType(switched.MODULE)
    exec(switched.TEXT, vars(held))
    monkeypatch.setitem(sys.modules, switched.MODULE, held)
    text = '"""Doc."""\nfrom __future__ import annotations\n\ndef f(a):\n    return a + 1\n'
    place = generated.Place(FILE, 5, 1, text.index("+"), text.index("+") + 1, "+", "-", "")
    module = ModuleType("clrt.some")
    exec(compile(switched.with_all(text, [(7, place)])[0], FILE, "exec"), vars(module))
    module.f = cache(module.f)  # type: ignore[attr-defined]
    monkeypatch.setitem(sys.modules, "clrt.some", module)
    switch = switched.Switch([])
    assert switch.reached() == frozenset()
    for number, answer in ((0, 4), (7, 2), (8, 4), (0, 4)):
        switch.choose(number)
        assert module.f(3) == answer and switch.reached() == {7}
        switch.choose(number)
        assert switch.reached() == frozenset()


@pytest.mark.slow
def test_a_process_with_faults_of_the_host_is_the_sound_one_until_one_is_chosen() -> None:
    """Among them one that is there when its module is imported, and one that gives no picture."""
    names = ("clrt/scene/camera.py:", "clrt/spectra/indices.py")
    drawn = [place for place in generated.places() if place.name.startswith(names)]
    outside = [place for place in drawn if place.old in generated._TURNED]  # the last is in no function
    chosen = [place for place in drawn if "fov_axis ==" in place.around] + outside[-1:]
    with served.Served(dict(enumerate(chosen, 1))) as serving:
        picture, reached = serving.sound("diffuse")
        assert outcomes.same(picture, mutants.sound("diffuse", None))
        assert len(chosen) in serving.unable and reached - serving.unable
        for number in reached - serving.unable:
            try:
                assert not outcomes.same(serving.picture(number, "diffuse"), picture)
            except served.Lost as error:
                assert not error.crashed and "\n" not in error.word
        assert outcomes.same(serving.picture(0, "diffuse"), picture)
